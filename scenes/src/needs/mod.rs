//! What a run costs beside what its scene needs: scenes in which little has to be computed, each with its [`floor`].

pub mod floor;
pub mod kept;

use contact_fem::mesh::generators::{
    Diagonals, annulus, cuboid, disc, graded, linspace, quarter_disc, rectangle,
};
use contact_fem::{Body, Error, LinearElastic, Material, NeoHookean, Scene};
use std::f64::consts::{PI, TAU};
use std::ops::Range;

/// How a floor is found.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Way {
    /// [`floor::linear`].
    Linear,
    /// [`floor::newton`].
    Newton,
    /// The first two bodies alone, by the library, and [`floor::Newton`] for each of the others.
    Pair,
}

/// The scene of a case, in the plane or in space.
pub enum Build {
    /// In the plane.
    Plane(Box<dyn Fn() -> Result<Scene<2>, Error>>),
    /// In space.
    Space(Box<dyn Fn() -> Result<Scene<3>, Error>>),
}

/// A scene, its increments and its floor.
pub struct Case {
    /// Its short name.
    pub name: &'static str,
    /// What it is.
    pub what: &'static str,
    /// The number of load increments.
    pub increments: usize,
    /// How its floor is found.
    pub way: Way,
    /// The ratio of cost and floor that it must reach.
    pub must: f64,
    /// The scene.
    pub scene: Build,
}

/// The stiffness of all bodies (UF/UL²).
const YOUNG: f64 = 1000.0;
const NU: f64 = 0.3;

/// All cases. Meshes have one `coarseness`-th of the cells in each direction.
pub fn all(coarseness: usize) -> Vec<Case> {
    let n = move |cells: usize| (cells / coarseness).max(2);
    let plane =
        |name, what, increments, way, must, scene: Box<dyn Fn() -> Result<Scene<2>, Error>>| Case {
            name,
            what,
            increments,
            way,
            must,
            scene: Build::Plane(scene),
        };
    let space =
        |name, what, increments, way, must, scene: Box<dyn Fn() -> Result<Scene<3>, Error>>| Case {
            name,
            what,
            increments,
            way,
            must,
            scene: Build::Space(scene),
        };
    use Law::{Linear as L, NeoHookean as H};
    use Way::{Linear, Newton, Pair};
    vec![
        plane(
            "1a",
            "one linear body",
            1,
            Linear,
            1.3,
            Box::new(move || one(L, n(100))),
        ),
        space(
            "1b",
            "the same in space, quadratic",
            1,
            Linear,
            1.3,
            Box::new(move || tower(L, n(13), n(6), Some(0.1), None)),
        ),
        space(
            "1p",
            "the same, its top displaced",
            1,
            Linear,
            1.3,
            Box::new(move || tower(L, n(13), n(6), None, Some(0.05))),
        ),
        space(
            "1pn",
            "the same, neo-Hookean, 10 increments",
            10,
            Newton,
            1.5,
            Box::new(move || tower(H, n(13), n(6), None, Some(0.05))),
        ),
        plane(
            "2a",
            "one neo-Hookean body",
            1,
            Newton,
            1.3,
            Box::new(move || one(H, n(100))),
        ),
        space(
            "2b",
            "the same in space, quadratic",
            1,
            Newton,
            1.3,
            Box::new(move || tower(H, n(13), n(6), Some(0.1), None)),
        ),
        plane(
            "3a",
            "two linear bodies that never touch",
            1,
            Linear,
            1.5,
            Box::new(move || two([L, L], n(70), 1.0, 0.1)),
        ),
        space(
            "3d",
            "two beams in space, likewise",
            1,
            Linear,
            1.5,
            Box::new(move || beams(n(6), n(15))),
        ),
        plane(
            "3n",
            "two neo-Hookean bodies out of reach, 20 increments",
            20,
            Newton,
            1.5,
            Box::new(move || two([H, H], n(70), 1.0, 20.0)),
        ),
        plane(
            "3m",
            "the same in reach, one increment",
            1,
            Newton,
            1.5,
            Box::new(move || {
                let mut scene = two([H, H], n(70), 1.0, 20.0)?;
                scene.reach = Some(2.0);
                Ok(scene)
            }),
        ),
        plane(
            "4",
            "a disc whose nodes are all prescribed, on a linear block",
            1,
            Linear,
            3.0,
            Box::new(move || punch(n(140), n(70))),
        ),
        plane(
            "5",
            "ten linear blocks, nine pairs, two touch",
            1,
            Linear,
            3.0,
            Box::new(move || row(L, 0..10, n(30), false, 1.0)),
        ),
        plane(
            "5a",
            "the same, all surfaces declared",
            1,
            Linear,
            4.0,
            Box::new(move || row(L, 0..10, n(30), true, 1.0)),
        ),
        plane(
            "5n",
            "ten neo-Hookean blocks, two touch",
            1,
            Pair,
            1.3,
            Box::new(move || row(H, 0..10, n(30), false, 20.0)),
        ),
        plane(
            "6",
            "skins declared, few rows act",
            1,
            Linear,
            3.0,
            Box::new(move || skins(n(74))),
        ),
        plane(
            "7",
            "a linear ring, 1e6 times stiffer inside",
            1,
            Linear,
            3.0,
            Box::new(move || rings(n(256))),
        ),
        plane(
            "8a",
            "as 1a, 100 increments",
            100,
            Linear,
            1.5,
            Box::new(move || one(L, n(100))),
        ),
        plane(
            "8b",
            "two linear bodies in contact, 100 increments",
            100,
            Linear,
            3.0,
            Box::new(move || two([L, L], n(70), 0.0, 1.0)),
        ),
        plane(
            "9ll",
            "the same, one increment",
            1,
            Linear,
            3.0,
            Box::new(move || two([L, L], n(70), 0.0, 1.0)),
        ),
        plane(
            "10",
            "a quarter of a disc on a block",
            1,
            Linear,
            3.0,
            Box::new(move || quarter(n(80))),
        ),
        plane(
            "10b",
            "ten linear bodies, one pair acts",
            1,
            Linear,
            3.0,
            Box::new(move || row(L, 0..10, n(30), true, 1.0)),
        ),
        plane(
            "30b",
            "thirty linear bodies, one pair acts",
            1,
            Linear,
            3.0,
            Box::new(move || row(L, 0..30, n(30), true, 1.0)),
        ),
    ]
}

/// Some blocks of the case `5n` alone.
///
/// # Errors
/// As [`Scene::contact`].
pub fn blocks_alone(blocks: Range<usize>, coarseness: usize) -> Result<Scene<2>, Error> {
    let cells = (30 / coarseness).max(2);
    row(Law::NeoHookean, blocks, cells, false, 20.0)
}

#[derive(Clone, Copy, PartialEq)]
enum Law {
    Linear,
    NeoHookean,
}

fn body<const D: usize>(law: Law, mesh: contact_fem::Mesh<D>) -> Result<Body<D>, Error>
where
    contact_fem::element::P1: contact_fem::element::Element<D>,
    contact_fem::element::P2: contact_fem::element::Element<D>,
    LinearElastic: Material<D>,
    NeoHookean: Material<D>,
{
    Ok(match law {
        Law::Linear => Body::new(mesh, LinearElastic::new(YOUNG, NU)?),
        Law::NeoHookean => Body::new(mesh, NeoHookean::new(YOUNG, NU)?),
    })
}

fn block(law: Law, low: [f64; 2], size: [f64; 2], cells: [usize; 2]) -> Result<Body<2>, Error> {
    let [xs, ys] = [0, 1].map(|i| linspace(low[i], low[i] + size[i], cells[i]));
    body(law, rectangle(&xs, &ys, Diagonals::Rising)?)
}

/// A square held on one side, drawn by a load on the opposite one.
fn one(law: Law, cells: usize) -> Result<Scene<2>, Error> {
    let mut square = block(law, [0.0, 0.0], [1.0, 1.0], [cells; 2])?;
    square.prescribe("bottom", [Some(0.0); 2])?;
    square.traction("top", [20.0, 0.0])?;
    Ok(crate::alone(square))
}

/// A cuboid of quadratic cells that stands on its bottom, with a load on its top, or with its top displaced.
fn tower(
    law: Law,
    across: usize,
    up: usize,
    load: Option<f64>,
    moved: Option<f64>,
) -> Result<Scene<3>, Error> {
    let mesh = cuboid([0.0; 3], [2.0, 2.0, 1.0], [across, across, up])?;
    let mut tower = body(law, mesh.quadratic())?;
    tower.prescribe("bottom", [Some(0.0); 3])?;
    if let Some(load) = load {
        tower.traction("top", [load * YOUNG, 0.0, 0.0])?;
    }
    if let Some(moved) = moved {
        tower.prescribe("top", [Some(moved), Some(0.0), Some(moved)])?;
    }
    Ok(crate::alone(tower))
}

/// Two squares with a gap between them, the upper one pressed down and aside.
fn two(laws: [Law; 2], cells: usize, gap: f64, load: f64) -> Result<Scene<2>, Error> {
    let mut lower = block(laws[0], [0.0, 0.0], [1.0, 1.0], [cells, cells])?;
    let mut upper = block(
        laws[1],
        [0.0, 1.0 + gap],
        [1.0, 1.0],
        [cells + 1, cells - 1],
    )?;
    lower.prescribe("bottom", [Some(0.0); 2])?;
    lower.traction("right", [0.0, 0.1 * load])?;
    upper.prescribe("top", [Some(0.0); 2])?;
    upper.traction("left", [0.0, -load])?;
    crate::pair((lower, "top"), (upper, "bottom"))
}

/// Two cantilevers of quadratic cells with a gap of their height between them.
fn beams(across: usize, along: usize) -> Result<Scene<3>, Error> {
    let beam = |low: f64, load: f64| -> Result<Body<3>, Error> {
        let mesh = cuboid([0.0, 0.0, low], [4.0, 1.0, 1.0], [along, across, across])?;
        let mut beam = body(Law::Linear, mesh.quadratic())?;
        beam.prescribe("left", [Some(0.0); 3])?;
        beam.traction("right", [0.0, 0.0, load])?;
        Ok(beam)
    };
    crate::pair((beam(0.0, 0.1)?, "top"), (beam(2.0, -0.1)?, "bottom"))
}

/// A disc whose nodes are all prescribed goes into a block by a little.
fn punch(along: usize, up: usize) -> Result<Scene<2>, Error> {
    let mut block = block(Law::Linear, [-1.0, -1.0], [2.0, 1.0], [along, up])?;
    block.prescribe("bottom", [Some(0.0); 2])?;
    let mesh = disc(0.5, up, 2, 0.0)?.translated([0.0, 0.501])?;
    let mut disc = body(Law::Linear, mesh)?;
    disc.prescribe_all([Some(0.0), Some(-0.003)])?;
    crate::pair((block, "top"), (disc, "boundary"))
}

/// Blocks side by side. The first is pushed against the second; a gap is between the others, which are bent by loads of
/// their own. Their sides are declared pair by pair, or all.
fn row(
    law: Law,
    blocks: Range<usize>,
    cells: usize,
    is_general: bool,
    load: f64,
) -> Result<Scene<2>, Error> {
    let mut scene = Scene::new();
    let mut ids = Vec::new();
    for k in blocks {
        let low = if k == 0 { 0.5 } else { 1.5 * k as f64 };
        let mut block = block(law, [low, 0.0], [1.0, 1.0], [cells, cells - k % 2])?;
        block.prescribe("bottom", [Some(0.0); 2])?;
        let push = if k == 0 { load } else { 0.02 * load };
        block.traction("left", [push, 0.0])?;
        ids.push(scene.add(format!("block {k}"), block));
    }
    for (k, id) in ids.iter().enumerate() {
        if is_general {
            for side in ["left", "right", "top"] {
                scene.contact_surface(id.on(side))?;
            }
        } else if k > 0 {
            scene.contact(ids[k - 1].on("right"), id.on("left"))?;
        }
    }
    Ok(scene)
}

/// Two blocks, the upper one turned by 0.02 and shifted, so that a corner touches first. All of their boundaries are declared.
fn skins(cells: usize) -> Result<Scene<2>, Error> {
    let skin = |mesh: contact_fem::Mesh<2>| {
        let mut mesh = mesh;
        mesh.name_boundary("skin", |_| true);
        mesh
    };
    let grid = linspace(0.0, 1.0, cells);
    let lower = rectangle(&grid, &grid, Diagonals::Rising)?;
    let mut lower = body(Law::Linear, skin(lower))?;
    lower.prescribe("bottom", [Some(0.0); 2])?;
    let (sin, cos) = 0.02f64.sin_cos();
    let upper = rectangle(&grid, &grid, Diagonals::Falling)?;
    let upper = upper.mapped(|X| {
        [
            0.3 + cos * X[0] - sin * X[1],
            1.0005 + sin * X[0] + cos * X[1],
        ]
        .into()
    })?;
    let mut upper = body(Law::Linear, skin(upper))?;
    upper.prescribe("top", [Some(0.0), Some(-0.001)])?;
    crate::pair((lower, "skin"), (upper, "skin"))
}

/// A stiff ring within a soft one, pushed against it from its hole.
fn rings(segments: usize) -> Result<Scene<2>, Error> {
    let layers = (segments / 8).max(2);
    let outer = annulus(
        &linspace(0.7, 1.7, layers),
        segments,
        Diagonals::Alternating,
    )?;
    let inner = annulus(
        &linspace(0.2, 0.69, layers * 3 / 4),
        segments * 7 / 8,
        Diagonals::Alternating,
    )?;
    let mut outer = body(Law::Linear, outer)?;
    outer.prescribe("outer", [Some(0.0), Some(0.03)])?;
    // held where it is: what its stiffness stores would carry its round-off into the energy
    let mut inner = Body::new(inner, LinearElastic::new(1e6 * YOUNG, NU)?);
    inner.prescribe("inner", [Some(0.0); 2])?;
    crate::pair((outer, "inner"), (inner, "outer"))
}

/// A quarter of a disc is pressed on a block, with symmetry about x = 0.
fn quarter(cells: usize) -> Result<Scene<2>, Error> {
    let angles = graded(1.5 * PI, TAU, 0.3 / cells as f64, cells)?;
    let depths = graded(0.0, 1.0, 0.3 / cells as f64, cells * 52 / 90)?;
    let radii: Vec<f64> = depths.iter().rev().map(|d| 1.0 - d).collect();
    let mesh = quarter_disc(&radii, &angles, Diagonals::Falling)?.translated([0.0, 1.0])?;
    let mut cylinder = body(Law::Linear, mesh)?;
    cylinder.prescribe("axis", [Some(0.0), None])?;
    cylinder.prescribe("flat", [None, Some(-0.01)])?;
    let xs = graded(0.0, 2.0, 0.32 / cells as f64, cells)?;
    let depths = graded(0.0, 2.0, 0.3 / cells as f64, cells * 2 / 3)?;
    let ys: Vec<f64> = depths.iter().rev().map(|d| -d).collect();
    let mut block = body(Law::Linear, rectangle(&xs, &ys, Diagonals::Rising)?)?;
    block.prescribe("left", [Some(0.0), None])?;
    block.prescribe("bottom", [Some(0.0); 2])?;
    crate::pair((cylinder, "arc"), (block, "top"))
}
