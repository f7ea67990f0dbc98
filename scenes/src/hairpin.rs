//! A hairpin: a folded band whose arms are pressed together until they touch.

use contact_fem::element::{Element, P1, P2};
use contact_fem::mesh::generators::{Diagonals, extrude, linspace, rectangle};
use contact_fem::tensor::Vector;
use contact_fem::{Body, Error, Mesh, NeoHookean, Scene};

/// The outer and inner radius of the fold (UL).
const RADII: [f64; 2] = [0.3, 0.2];
/// The length of the arms (UL).
const ARM: f64 = 1.0;
/// The position of the pressed nodes on the arms (UL from the fold).
const PRESSED: f64 = 0.7;
/// The displacement of each pressed node at full load (UL).
pub const PRESS: f64 = 0.19;
/// Poisson's ratio.
pub const NU: f64 = 0.3;

/// Maps a flat band to the hairpin: x runs along the middle line of the upper arm to the fold and
/// back along the lower one, y from 0 on the outside to 1 on the inside.
fn fold<const D: usize>(X: &Vector<D>) -> Vector<D> {
    let radius = RADII[0] + X[1] * (RADII[1] - RADII[0]);
    let around = X[0] - ARM;
    let mut folded = *X;
    (folded[0], folded[1]) = if around <= 0.0 {
        (-around, radius)
    } else if around < FOLD {
        let angle = std::f64::consts::FRAC_PI_2 + around * std::f64::consts::PI / FOLD;
        (radius * angle.cos(), radius * angle.sin())
    } else {
        (around - FOLD, -radius)
    };
    folded
}

/// The length of the fold's middle line.
const FOLD: f64 = std::f64::consts::PI * 0.5 * (RADII[0] + RADII[1]);

/// The flat band with 10 `fine` cells along each arm and `fine` through its thickness.
fn band(fine: usize) -> Result<Mesh<2>, Error> {
    band_of(
        &[
            (0.0, ARM, 10 * fine),
            (ARM, ARM + FOLD, 8 * fine),
            (ARM + FOLD, 2.0 * ARM + FOLD, 10 * fine),
        ],
        fine,
    )
}

/// The flat band from parts with their ends and cells, with this number of cells through its thickness.
fn band_of(parts: &[(f64, f64, usize)], through: usize) -> Result<Mesh<2>, Error> {
    let mut along = vec![0.0];
    for &(from, to, cells) in parts {
        along.extend(&linspace(from, to, cells)[1..]);
    }
    let through = linspace(0.0, 1.0, through);
    let mut mesh = rectangle(&along, &through, Diagonals::Alternating)?;
    mesh.name_boundary("skin", |X| X[1] == 0.0 || X[1] == 1.0);
    Ok(mesh)
}

/// The hairpin, supported at the back of the fold and pressed together at both arms.
fn body<const D: usize>(mesh: Mesh<D>, press: f64, nu: f64) -> Result<Body<D>, Error>
where
    P1: Element<D>,
    P2: Element<D>,
{
    let nodes_at = |x: f64, y: f64| -> Vec<usize> {
        let is_there = |X: &Vector<D>| (X[0] - x).hypot(X[1] - y) < 1e-9;
        let all = mesh.nodes().iter().enumerate();
        all.filter(|(_, X)| is_there(X)).map(|(a, _)| a).collect()
    };
    let back = nodes_at(-RADII[0], 0.0);
    let arms = [
        (1.0, nodes_at(PRESSED, RADII[0])),
        (-1.0, nodes_at(PRESSED, -RADII[0])),
    ];
    let mut body = Body::new(mesh, NeoHookean::new(1e3, nu)?);
    body.prescribe_nodes(&back, [Some(0.0); D])?;
    for (side, nodes) in arms {
        let mut pressed = [None; D];
        pressed[1] = Some(-side * press);
        body.prescribe_nodes(&nodes, pressed)?;
    }
    Ok(body)
}

/// The plane hairpin, with self-contact on its whole boundary if `self_contact` is set.
pub fn scene(fine: usize, self_contact: bool) -> Result<Scene<2>, Error> {
    let mut scene = Scene::new();
    let hairpin = scene.add("hairpin", body(band(fine)?.mapped(fold)?, PRESS, NU)?);
    if self_contact {
        scene.self_contact(hairpin.on("skin"))?;
    }
    Ok(scene)
}

/// A plane hairpin whose arms may have other cells than each other.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hairpin {
    /// The number of cells on each arm: from its end to the pressed nodes, and from there to the fold.
    pub arms: [[usize; 2]; 2],
    /// The number of cells on each half of the fold.
    pub fold: usize,
    /// The number of cells through the thickness.
    pub through: usize,
    /// The displacement of each pressed node at full load (UL).
    pub press: f64,
    /// Poisson's ratio.
    pub poisson: f64,
}

impl Hairpin {
    /// The scene with self-contact on the whole boundary.
    pub fn scene(&self) -> Result<Scene<2>, Error> {
        let ([first, second], end) = (self.arms, 2.0 * ARM + FOLD);
        let mesh = band_of(
            &[
                (0.0, ARM - PRESSED, first[0]),
                (ARM - PRESSED, ARM, first[1]),
                (ARM, ARM + FOLD, 2 * self.fold),
                (ARM + FOLD, ARM + FOLD + PRESSED, second[1]),
                (ARM + FOLD + PRESSED, end, second[0]),
            ],
            self.through,
        )?;
        let mut scene = Scene::new();
        let body = body(mesh.mapped(fold)?, self.press, self.poisson)?;
        let hairpin = scene.add("hairpin", body);
        scene.self_contact(hairpin.on("skin"))?;
        Ok(scene)
    }
}

/// The hairpin of width 0.2 in space, with `deep` layers of tetrahedra and no displacement across
/// the band.
pub fn scene_in_space(fine: usize, deep: usize) -> Result<Scene<3>, Error> {
    let across = linspace(0.0, 0.2, deep);
    let mesh = extrude(&band(fine)?, &across, ["behind", "before"])?;
    let mut body = body(mesh.mapped(fold)?, PRESS, NU)?;
    for side in ["behind", "before"] {
        let nodes = body.mesh().boundary_nodes(side)?;
        let back_or_free = |a: &usize| body.prescribed()[3 * a + 2].is_none();
        let nodes: Vec<usize> = nodes.into_iter().filter(back_or_free).collect();
        body.prescribe_nodes(&nodes, [None, None, Some(0.0)])?;
    }
    let mut scene = Scene::new();
    let hairpin = scene.add("hairpin", body);
    scene.self_contact(hairpin.on("skin"))?;
    Ok(scene)
}

/// Whether a point of the reference configuration is on the inside of the upper arm.
pub fn is_inside_of_upper_arm<const D: usize>(X: &Vector<D>) -> bool {
    X[0] >= 0.0 && (X[1] - RADII[1]).abs() < 1e-9
}
