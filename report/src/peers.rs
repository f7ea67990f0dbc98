//! Other programs on the same meshes: errors of the pressures and displacements that `report/peers/campaign.py` writes, all by one function, and what a reader
//! learns from them.
//!
//! `report/peers/results.json` keeps the errors and processor times of one campaign on one machine, so that the page shows them anywhere.

use std::collections::BTreeMap;
use std::f64::consts::PI;
use std::fs;
use std::path::Path;

use ipopt_contact::contact_fem::element::{Facet, FacetRule, Order, facet_shapes};
use ipopt_contact::contact_fem::tensor::Vector;
use serde::{Deserialize, Serialize};

use crate::Failure;
use crate::pareto::front;

/// What a run wrote. Lengths and forces are in the scene's units.
#[derive(Debug, Deserialize)]
struct Field {
    scene: String,
    program: String,
    version: String,
    setting: String,
    mesh: String,
    degree: usize,
    unknowns: Option<usize>,
    /// Processor time of each repetition.
    seconds: Vec<f64>,
    /// What other processes took meanwhile, in processors.
    others: f64,
    failure: Option<String>,
    /// What a scene measures that has one number.
    scalar: Option<f64>,
    nodes: Vec<Vec<f64>>,
    /// The nodes of each facet: corners, then middles of the sides 01, 12, 20.
    facets: Vec<Vec<usize>>,
    /// A pressure, or how far a node comes down, at each node.
    values: Vec<f64>,
}

/// A run: what it was, what it cost, and its error.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Entry {
    pub scene: String,
    pub program: String,
    pub version: String,
    pub setting: String,
    /// The size of facets, as a share of the radius a of the contact zone, the radius R of a fit or the thickness H of beams: `a/4`; or what was asked of
    /// a program that refines: `asked 1 %`.
    pub mesh: String,
    pub degree: usize,
    pub unknowns: Option<usize>,
    /// The least processor time (s), and the largest by it.
    pub seconds: Option<f64>,
    pub scatter: Option<f64>,
    /// Whether other processes took more than a fifth of a processor meanwhile.
    pub is_disturbed: bool,
    pub failure: Option<String>,
    /// Of what the scene measures, relative; of failed runs, too, where they left one.
    pub error: Option<f64>,
}

impl Entry {
    /// (s, error) of a run that ended well and alone.
    pub fn point(&self) -> Option<(f64, f64)> {
        let counts = self.failure.is_none() && !self.is_disturbed;
        self.seconds.zip(self.error).filter(|_| counts)
    }

    /// What it is in words.
    pub fn title(&self) -> String {
        let unknowns = self
            .unknowns
            .map_or(String::new(), |n| format!(", {n} unknowns"));
        format!(
            "{}, P{}, {}, {}{unknowns}",
            self.program, self.degree, self.mesh, self.setting
        )
    }

    /// Whether the program chose the mesh.
    pub fn is_adaptive(&self) -> bool {
        self.mesh.starts_with("asked ")
    }

    /// Mesh and settings in words.
    fn way(&self) -> String {
        match self.mesh.strip_prefix("asked ") {
            Some(asked) => format!(
                "P{} cells of its own ({}: {asked})",
                self.degree, self.setting
            ),
            None => format!("P{} cells of {} ({})", self.degree, self.mesh, self.setting),
        }
    }
}

/// The best of some runs, by rising time: no other one is both faster and more accurate.
pub fn best<'a>(runs: impl Iterator<Item = &'a Entry>) -> Vec<&'a Entry> {
    let own: Vec<(&Entry, (f64, f64))> = runs
        .filter_map(|entry| Some((entry, entry.point()?)))
        .collect();
    let points: Vec<(f64, f64)> = own.iter().map(|(_, point)| *point).collect();
    front(&points).into_iter().map(|k| own[k].0).collect()
}

/// The results of one campaign.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Stored {
    /// The machine and the day.
    pub environment: BTreeMap<String, String>,
    pub entries: Vec<Entry>,
}

/// A scene with a known solution.
pub struct Scene {
    /// As in the files.
    pub name: &'static str,
    /// For a reader.
    pub title: &'static str,
    pub about: &'static str,
    /// What is compared, in words.
    pub quantity: &'static str,
    /// The share to which the reference is known: smaller errors say nothing.
    known: f64,
    measure: Measure,
}

impl Scene {
    /// The errors that sentences are about.
    pub fn targets(&self) -> impl Iterator<Item = f64> {
        TARGETS.into_iter().filter(|target| *target >= self.known)
    }
}

/// What is compared.
enum Measure {
    /// The contact pressure in L² over the boundary, relative: at a distance from the middle, by the force on the whole plane.
    Pressure(fn(f64, f64) -> f64, Force),
    /// The mean of the values over the boundary.
    Mean(f64),
    /// One number.
    Scalar(f64),
}

enum Force {
    /// The pressure does not depend on it.
    None,
    /// In UF.
    Given(f64),
    /// So many times the force on the part that is meshed, as far as the pressure tells.
    OfParts(f64),
}

const MODULUS: f64 = 1000.0 / (1.0 - 0.3 * 0.3);
const ZONE: f64 = 0.05;

pub const SCENES: [Scene; 8] = [
    Scene {
        name: "half_disc",
        title: "Half a disc on a rigid line",
        about: "Plane strain, small strains, E = 1000, ν = 0.3, R = 1, pressed to a half-width of contact a = R/20 by a traction on its flat top. \
            Hertz's pressure is that of half-planes, from which it differs by a share of the order of (a/R)², 0.3 %.",
        quantity: "contact pressure",
        known: 3e-3,
        measure: Measure::Pressure(half_disc, Force::Given(PI * MODULUS * ZONE * ZONE / 4.0)),
    },
    Scene {
        name: "ball",
        title: "A ball on a rigid plane",
        about: "An eighth of a ball, small strains, E = 20 000, ν = 0.3, R = 50, whose flat top comes down by 2: the radius of contact is about 10, a fifth of R. \
            The reference is Hertz's pressure for the force that each program found, from which the exact pressure differs by a share of the order of (a/R)², 4 %: hardly any mesh brings \
            the error below that.",
        quantity: "contact pressure",
        known: 4e-2,
        measure: Measure::Pressure(ball, Force::OfParts(4.0)),
    },
    Scene {
        name: "press_fit",
        title: "A press fit of two rings",
        about: "Plane strain, small strains, E = 1000, ν = 0.3, a quarter of rings of radii 0.5, 1 and 1.5, the inner one larger by a thousandth of its radius; facets do not \
            match. Lamé's pressure is constant. It is exact to a share of the order of the interference, 0.1 %. Chords of linear cells leave gaps and overlaps that are larger than the interference \
            until they are shorter than a tenth of the radius. FreeFEM's settings with the gap of the circles, and `adaptmesh`, know that the rings are circles.",
        quantity: "contact pressure",
        known: 1e-3,
        measure: Measure::Pressure(|_, _| LAME, Force::None),
    },
    Scene {
        name: "blocks",
        title: "Blocks on blocks",
        about: "Plane strain, small strains, E = 1000, ν = 0.3: three blocks of height 1 and half-widths 3, 2.5 and 0.5 from below, free of friction, the upper one under a traction of 1. Corners \
            press into flat sides, where pressures have no bound, and the block in the middle lifts off beyond 1.3. Measured is the mean descent of the loaded face, which the work of the load is proportional to. The reference is extrapolated from quadratic \
            cells of H/8 to H/48 of this library, and its refined meshes end there.",
        quantity: "descent of the loaded face",
        known: 1e-5,
        measure: Measure::Mean(BLOCKS_DESCENT),
    },
    Scene {
        name: "beams",
        title: "Three beams in a stack",
        about: "Section 6.2 of the paper, linear: cantilevers of 200 × 25 × 25, E = 200 000, ν = 0, clamped at one end, the upper one under a traction of 100; they slide on each other, and \
            cells of the middle one do not match. Measured is the mean descent of the loaded face, which the work of the load is proportional to. The reference is extrapolated from quadratic cells of \
            H/6 to H/9 of this library; GetFEM and this library differ by less than 1e-5 on the same meshes. The softness of \
            CalculiX's penalty and the stiffness of coarse cells cancel in its smallest errors.",
        quantity: "descent of the loaded face",
        known: 1e-5,
        measure: Measure::Mean(DESCENT),
    },
    Scene {
        name: "finite_beams",
        title: "Three beams, neo-Hookean",
        about: "The same beams at large strains: ψ = μ/2 (tr C − 3 − 2 ln J), since ν = 0, and contact at the current positions. CalculiX has this law as that of Ciarlet. The reference is \
            extrapolated from quadratic cells of H/4 to H/7 of this library. FreeFEM's script for bodies in space has linear cells only.",
        quantity: "descent of the loaded face",
        known: 1e-5,
        measure: Measure::Mean(FINITE_DESCENT),
    },
    Scene {
        name: "discs",
        title: "A disc in a ring",
        about: "Section 6.1 of the paper: a rigid disc of radius 0.6 comes down by 1.125 inside a neo-Hookean ring (E = 1000, ν = 0) of radii 0.7 and 2, plane strain. Measured is the force \
            that presses it down, at the end. The reference is that of fine quadratic cells of this library. Each program takes as few increments as it can. FreeFEM's two scripts are a tuned one and the paper's; \
            the latter is stopped at changes of 0.1 %, since its plain fixed point ends in cycles. FreeFEM's cells have straight sides; contact of its quadratic cells knows the circles.",
        quantity: "force on the disc",
        known: 2e-5,
        measure: Measure::Scalar(DISC_FORCE),
    },
    Scene {
        name: "ironing",
        title: "Ironing",
        about: "A stiff die (E = 1000) with a round bottom of radius 3 is pressed by 0.75 into a soft slab (E = 1) of 9 × 3 and slid along it by 2; both neo-Hookean, ν = 0, plane strain. Measured is \
            the force that presses the die down, as the mean of ten places of its way. The reference is that of fine quadratic cells of this library, known to 0.005 %. FreeFEM's cells have straight sides; contact of its quadratic cells knows the circle.",
        quantity: "force on the die",
        known: 5e-5,
        measure: Measure::Scalar(DIE_FORCE),
    },
];

/// Hertz's pressure of half-planes.
fn half_disc(force: f64, r: f64) -> f64 {
    let peak = 2.0 * force / (PI * ZONE);
    peak * (1.0 - (r / ZONE).powi(2)).max(0.0).sqrt()
}

/// That of a ball.
fn ball(force: f64, r: f64) -> f64 {
    // a rigid plane counts as a ball of the same stiffness at half the approach
    let (radius, modulus) = (25.0, 20000.0 / 2.0 / (1.0 - 0.3 * 0.3));
    let a = (3.0 * force * radius / (4.0 * modulus)).cbrt();
    let peak = 3.0 * force / (2.0 * PI * a * a);
    peak * (1.0 - (r / a).powi(2)).max(0.0).sqrt()
}

/// The mean descent of the loaded face of three beams (UL). Quadratic cells of H/6, H/7, H/8 and H/9 give 10.46305, 10.46345, 10.46367 and 10.46380; their differences
/// from it fall with the power 3.1 of the size.
const DESCENT: f64 = 10.46409;

/// The same of neo-Hookean beams (UL). Quadratic cells of H/4, H/5, H/6 and H/7 give 9.996465, 9.998297, 9.999082 and 9.999470, by `report/peers/references.py`, as all
/// references below; their differences from it fall with the power 3.2 of the size.
const FINITE_DESCENT: f64 = 10.00009;

/// The mean descent of the loaded face of three blocks (UL). Quadratic cells of H/8, H/16, H/32 and H/48 give 2.064640e-3, 2.067206e-3, 2.068102e-3 and 2.068321e-3; their
/// differences from it fall with the power 1.5 of the size. Meshes that are refined to an estimated error of 0.1 % give 2.068573e-3.
const BLOCKS_DESCENT: f64 = 2.06858e-3;

/// The force on the disc (UF): the mean of quadratic cells of R/40 and of meshes that are refined to an estimated error of 0.1 %, 2329.475 and 2329.428. Cells of R/16,
/// R/24 and R/32 give 2329.897, 2329.541 and 2329.576.
const DISC_FORCE: f64 = 2329.45;

/// The mean force on the die (UF): the mean of quadratic cells of H/40 and of meshes that are refined to an estimated error of 0.2 %, 0.9113507 and 0.9113594. Cells of
/// H/14, H/20 and H/28 give 0.9113903, 0.9113902 and 0.9113895.
const DIE_FORCE: f64 = 0.911355;

/// Lamé's pressure of two rings of one material and radii 0.5, 1 and 1.5 in plane strain (UF/UL²): each ring's displacement of the fit is
/// (1 + ν)/E p b ((1 − 2ν) b² + r²)/|b² − r²| with its other radius r, and both add up to the interference.
const LAME: f64 = {
    let (modulus, poisson, interference) = (1000.0, 0.3, 1e-3);
    let stiff = 1.0 - 2.0 * poisson;
    let inner = (stiff + 0.25) / (1.0 - 0.25);
    let outer = (stiff + 2.25) / (2.25 - 1.0);
    interference * modulus / ((1.0 + poisson) * (inner + outer))
};

/// A point of integration on a facet: weight (UL or UL²), distance from the middle (UL), value.
struct Sample {
    weight: f64,
    distance: f64,
    value: f64,
}

/// The Gauss points of a segment, or in each direction of a triangle.
const POINTS: usize = 16;

/// The points of all facets, by the shape functions of their nodes.
fn samples(field: &Field) -> Vec<Sample> {
    match field.nodes.first().map(Vec::len) {
        Some(2) => samples_in::<2>(field),
        Some(_) => samples_in::<3>(field),
        None => Vec::new(),
    }
}

fn samples_in<const D: usize>(field: &Field) -> Vec<Sample> {
    let rule = FacetRule::<D>::gauss(POINTS);
    let nodes = field.nodes.iter();
    let X: Vec<Vector<D>> = nodes.map(|x| Vector::from_fn(|i, _| x[i])).collect();
    let mut samples = Vec::new();
    for nodes in &field.facets {
        let order = match nodes.len() == D {
            true => Order::Linear,
            false => Order::Quadratic,
        };
        let facet = Facet::gather(order, nodes, &X);
        samples.extend(rule.points().iter().map(|(weight, lambda)| {
            let N = facet_shapes(order, lambda);
            Sample {
                weight: weight * facet.normal(lambda).norm(),
                distance: facet.point(lambda).rows(0, D - 1).norm(),
                value: nodes.iter().zip(N).map(|(&a, N)| N * field.values[a]).sum(),
            }
        }));
    }
    samples
}

/// Whether all nodes are in the plane or all in space, each with a value, and facets are segments or triangles of these.
fn is_whole(field: &Field) -> bool {
    let D = field.nodes.first().map_or(2, Vec::len);
    let nodes = field.nodes.iter().all(|x| x.len() == D);
    let known = |nodes: &Vec<usize>| {
        let counts = [D, D * (D + 1) / 2].contains(&nodes.len());
        counts && nodes.iter().all(|&a| a < field.nodes.len())
    };
    let facets = field.facets.iter().all(known);
    (2..=3).contains(&D) && nodes && facets && field.values.len() == field.nodes.len()
}

/// The relative error of a field against what the scene measures.
fn error(scene: &Scene, field: &Field) -> f64 {
    let samples = samples(field);
    let sum = || {
        samples
            .iter()
            .map(|own| own.weight * own.value)
            .sum::<f64>()
    };
    let (exact, force) = match &scene.measure {
        Measure::Pressure(exact, Force::None) => (exact, 0.0),
        Measure::Pressure(exact, Force::Given(force)) => (exact, *force),
        Measure::Pressure(exact, Force::OfParts(parts)) => (exact, parts * sum()),
        Measure::Mean(reference) => {
            let area: f64 = samples.iter().map(|own| own.weight).sum();
            return (sum() / area / reference - 1.0).abs();
        }
        Measure::Scalar(reference) => {
            return field
                .scalar
                .map_or(f64::NAN, |own| (own / reference - 1.0).abs());
        }
    };
    let (mut off, mut whole) = (0.0, 0.0);
    for own in &samples {
        let exact = exact(force, own.distance);
        off += own.weight * (own.value - exact).powi(2);
        whole += own.weight * exact.powi(2);
    }
    (off / whole).sqrt()
}

fn entry(field: &Field) -> Result<Entry, Failure> {
    let scene = SCENES.iter().find(|scene| scene.name == field.scene);
    let scene = scene.ok_or_else(|| format!("there is no scene `{}`", field.scene))?;
    if !is_whole(field) {
        return Err("facets, nodes and values do not belong together".into());
    }
    let least = field.seconds.iter().copied().reduce(f64::min);
    let most = field.seconds.iter().copied().reduce(f64::max);
    let is_there = !field.facets.is_empty() || field.scalar.is_some();
    let error = is_there.then(|| error(scene, field));
    Ok(Entry {
        scene: field.scene.clone(),
        program: field.program.clone(),
        version: field.version.clone(),
        setting: field.setting.clone(),
        mesh: field.mesh.clone(),
        degree: field.degree,
        unknowns: field.unknowns,
        seconds: least,
        scatter: least.zip(most).map(|(least, most)| most / least),
        is_disturbed: field.others > 0.2,
        failure: field.failure.clone(),
        error: error.filter(|error| error.is_finite()),
    })
}

/// Computes the errors of all runs in a folder of a campaign, and stores them.
pub fn store(
    folder: &Path,
    environment: &[(&'static str, String)],
    results: &Path,
) -> Result<Stored, Failure> {
    let mut entries = Vec::new();
    for file in fs::read_dir(folder)? {
        let path = file?.path();
        if path.extension().is_none_or(|own| own != "json") {
            continue;
        }
        let field: Result<Field, _> = serde_json::from_str(&fs::read_to_string(&path)?);
        let own = field.map_err(Failure::from).and_then(|field| entry(&field));
        entries.push(own.map_err(|error| format!("{}: {error}", path.display()))?);
    }
    let finer = |entry: &Entry| {
        let finest = entry.mesh.split('/').nth(1);
        let counted = finest.and_then(|count| count.parse().ok());
        counted.or(entry.unknowns).unwrap_or(0)
    };
    let key = |entry: &Entry| {
        let place = SCENES.iter().position(|scene| scene.name == entry.scene);
        let (program, setting) = (entry.program.clone(), entry.setting.clone());
        (place, program, entry.degree, setting, finer(entry))
    };
    entries.sort_by_key(|entry| -> (Option<usize>, String, usize, String, usize) { key(entry) });
    let kept = ["processor", "cores", "system", "date", "revision"];
    let environment = environment.iter();
    let environment = environment.filter(|(name, _)| kept.contains(name));
    let stored = Stored {
        environment: environment
            .map(|(name, value)| (name.to_string(), value.clone()))
            .collect(),
        entries,
    };
    fs::write(results, serde_json::to_string_pretty(&stored)? + "\n")?;
    Ok(stored)
}

/// The stored results.
pub fn load(results: &Path) -> Result<Stored, Failure> {
    Ok(serde_json::from_str(&fs::read_to_string(results)?)?)
}

impl Stored {
    /// The runs of a scene.
    pub fn of<'a>(&'a self, scene: &'a Scene) -> impl Iterator<Item = &'a Entry> {
        let own = self.entries.iter();
        own.filter(move |entry| entry.scene == scene.name)
    }

    /// The programs, this library first.
    pub fn programs(&self) -> Vec<&str> {
        let mut programs: Vec<&str> = self.entries.iter().map(|own| &own.program[..]).collect();
        programs.sort_by_key(|name| (*name != OURS, *name));
        programs.dedup();
        programs
    }

    /// The best runs of a program, see [`best`].
    pub fn best<'a>(&'a self, scene: &'a Scene, program: &str) -> Vec<&'a Entry> {
        best(self.of(scene).filter(|entry| entry.program == program))
    }

    /// For each target the cheapest run of each program whose error is at most that, the cheapest first; none where no program has one.
    pub fn cheapest<'a>(&'a self, scene: &'a Scene, target: f64) -> Vec<(&'a Entry, f64)> {
        let programs = self.programs().into_iter();
        let cheapest = programs.filter_map(|program| {
            let best = self.best(scene, program).into_iter();
            let mut reached = best.filter_map(|entry| Some((entry, entry.point()?)));
            let (entry, (seconds, _)) = reached.find(|(_, (_, error))| *error <= target)?;
            Some((entry, seconds))
        });
        let mut all: Vec<_> = cheapest.collect();
        all.sort_by(|a, b| a.1.total_cmp(&b.1));
        all
    }

    /// One sentence for a scene and a target.
    pub fn sentence(&self, scene: &Scene, target: f64) -> String {
        let percent = format!("{} %", 100.0 * target);
        let all = self.cheapest(scene, target);
        let Some(((first, seconds), others)) = all.split_first() else {
            return format!("No program reached {percent} here.");
        };
        let mut text = format!(
            "For {percent}, {} is the cheapest: {seconds:.2} s with {}.",
            first.program,
            first.way()
        );
        for (other, own) in others {
            text += &format!(
                " {} takes {:.1} times as long.",
                other.program,
                own / seconds
            );
        }
        for program in self.programs() {
            if all.iter().all(|(entry, _)| entry.program != program) {
                let was_run = self.of(scene).any(|entry| entry.program == program);
                text += &match was_run {
                    true => format!(" {program} did not reach it."),
                    false => format!(" {program} was not run."),
                };
            }
        }
        text
    }
}

/// The program of this library.
pub const OURS: &str = "ipopt-contact";
/// The errors that sentences are about, where references are known as well as that.
pub const TARGETS: [f64; 4] = [0.05, 0.01, 1e-3, 1e-4];

#[cfg(test)]
mod tests {
    use super::*;

    /// A straight line of facets of the half disc's zone with these pressures at the nodes.
    fn field(scene: &str, pressure: impl Fn(f64) -> f64, count: usize) -> Field {
        let nodes = (0..=count).map(|k| vec![4.0 * ZONE * (k as f64 / count as f64 - 0.5), 0.0]);
        let nodes: Vec<Vec<f64>> = nodes.collect();
        Field {
            scene: scene.into(),
            program: OURS.into(),
            version: String::new(),
            setting: String::new(),
            mesh: "a/1".into(),
            degree: 1,
            unknowns: Some(1),
            seconds: vec![2.0, 1.0, 3.0],
            others: 0.0,
            failure: None,
            scalar: None,
            values: nodes.iter().map(|x| pressure(x[0])).collect(),
            facets: (0..count).map(|k| vec![k, k + 1]).collect(),
            nodes,
        }
    }

    /// No pressure is off by all of it, 1.1 times the pressure by a tenth, and a shift of a constant by its own norm.
    #[test]
    fn errors_are_shares_of_the_pressure() {
        let scene = &SCENES[0];
        let Measure::Pressure(exact, Force::Given(force)) = scene.measure else {
            panic!("the force is given");
        };
        let exact = |x: f64| exact(force, x.abs());
        let none = error(scene, &field("half_disc", |_| 0.0, 400));
        assert!((none - 1.0).abs() < 1e-12, "{none}");
        let more = error(scene, &field("half_disc", |x| 1.1 * exact(x), 4000));
        assert!((more - 0.1).abs() < 1e-3, "{more}");
        // ∫ p² = 4/3 a p0² of a half-circle; c over the length 4 a has the norm 2 c √a
        let peak = exact(0.0);
        let shifted = error(scene, &field("half_disc", |x| exact(x) + 0.2 * peak, 4000));
        assert!((shifted - 0.2 * (3.0_f64).sqrt()).abs() < 1e-3, "{shifted}");
    }

    /// Hertz's pressure on a flat disc of triangles has no error, and its force is found again.
    #[test]
    fn the_force_of_a_ball_is_that_of_its_pressure() {
        let scene = &SCENES[1];
        let (force, radius, count) = (5e5, 14.0, 60);
        // the square (r, φ) of a quarter of a disc
        let place = |i: usize, j: usize| {
            let r = radius * i as f64 / count as f64;
            let angle = 0.5 * PI * j as f64 / count as f64;
            vec![r * angle.cos(), r * angle.sin(), 0.0]
        };
        let number = |i: usize, j: usize| i * (count + 1) + j;
        let grid = (0..=count).flat_map(|i| (0..=count).map(move |j| (i, j)));
        let nodes: Vec<Vec<f64>> = grid.map(|(i, j)| place(i, j)).collect();
        let cells = (0..count).flat_map(|i| (0..count).map(move |j| (i, j)));
        let facets = cells.flat_map(|(i, j)| {
            let [a, b, c, d] =
                [(i, j), (i + 1, j), (i + 1, j + 1), (i, j + 1)].map(|(i, j)| number(i, j));
            [vec![a, b, c], vec![a, c, d]]
        });
        let r = |x: &Vec<f64>| x[0].hypot(x[1]);
        let own = Field {
            facets: facets.collect(),
            values: nodes.iter().map(|x| ball(force, r(x))).collect(),
            nodes,
            ..field("ball", |_| 0.0, 1)
        };
        let sum: f64 = samples(&own).iter().map(|own| own.weight * own.value).sum();
        assert!((4.0 * sum / force - 1.0).abs() < 5e-3, "{}", 4.0 * sum);
        assert!(error(scene, &own) < 0.02, "{}", error(scene, &own));
    }

    /// Lamé's pressure against the rings' displacements by his formulas of the hoop and radial stress; a mean against itself and a tenth more.
    #[test]
    fn the_press_fit_and_the_mean() {
        // σ_r = A − B/r², σ_θ = A + B/r², u = (1 + ν)/E ((1 − 2ν) A r + B/r)
        let displacement = |[a, b]: [f64; 2]| 1.3 / 1000.0 * (0.4 * a + b);
        // inside and outside pressed by p at r = 1: σ_r(1) = −p, and 0 at the other radius
        let ring = |free: f64| {
            let b = LAME / (1.0 - 1.0 / (free * free));
            [b / (free * free), b]
        };
        let gained = displacement(ring(1.5)) - displacement(ring(0.5));
        assert!((gained / 1e-3 - 1.0).abs() < 1e-12, "{gained}");
        let scene = |name| {
            SCENES
                .iter()
                .find(|scene| scene.name == name)
                .expect("a scene")
        };
        let beams = scene("beams");
        let plane = |value: f64| Field {
            nodes: vec![
                vec![0.0, 0.0, 1.0],
                vec![2.0, 0.0, 1.0],
                vec![0.0, 3.0, 1.0],
            ],
            facets: vec![vec![0, 1, 2]],
            values: vec![0.5 * value, value, 1.5 * value],
            ..field("beams", |_| 0.0, 1)
        };
        assert!(error(beams, &plane(DESCENT)) < 1e-12);
        assert!((error(beams, &plane(1.1 * DESCENT)) - 0.1).abs() < 1e-12);
        let force = Field {
            scalar: Some(0.9 * DISC_FORCE),
            ..field("discs", |_| 0.0, 0)
        };
        assert!((error(scene("discs"), &force) - 0.1).abs() < 1e-12);
    }

    #[test]
    fn the_cheapest_is_told_and_failures_are_not() {
        let with = |program: &str, seconds: f64, error: f64| Entry {
            program: program.into(),
            seconds: Some(seconds),
            error: Some(error),
            ..entry(&field("half_disc", |_| 1.0, 3)).expect("an entry")
        };
        let failed = Entry {
            failure: Some("none".into()),
            ..with("a", 0.1, 0.001)
        };
        let disturbed = Entry {
            is_disturbed: true,
            ..with("a", 0.1, 0.001)
        };
        let entries = vec![
            with(OURS, 2.0, 0.04),
            with("a", 1.0, 0.09),
            with("a", 5.0, 0.03),
            with("b", 0.5, 0.5),
            failed,
            disturbed,
        ];
        let stored = Stored {
            environment: BTreeMap::new(),
            entries,
        };
        let scene = &SCENES[0];
        assert_eq!(stored.programs(), [OURS, "a", "b"]);
        let sentence = stored.sentence(scene, 0.05);
        assert!(
            sentence.starts_with("For 5 %, ipopt-contact is the cheapest: 2.00 s"),
            "{sentence}"
        );
        assert!(
            sentence.contains("a takes 2.5 times as long. b did not reach it."),
            "{sentence}"
        );
        assert!(stored.sentence(scene, 0.1).starts_with("For 10 %, a is"));
        assert_eq!(stored.sentence(scene, 0.01), "No program reached 1 % here.");
        let ball = SCENES.iter().find(|scene| scene.name == "ball");
        let ball = ball.expect("a scene");
        // its reference is known to 4 %
        assert_eq!(ball.targets().collect::<Vec<_>>(), [0.05]);
        let mut one = stored.clone();
        one.entries.push(Entry {
            scene: "ball".into(),
            mesh: "asked 3 %".into(),
            setting: "accuracy asked".into(),
            ..with("a", 1.0, 0.02)
        });
        let sentence = one.sentence(ball, 0.05);
        assert!(
            sentence.contains("of its own (accuracy asked: 3 %)"),
            "{sentence}"
        );
        assert!(sentence.ends_with("b was not run."), "{sentence}");
        let own = entry(&field("half_disc", |_| 1.0, 3)).expect("an entry");
        assert_eq!((own.seconds, own.scatter), (Some(1.0), Some(3.0)));
    }

    #[test]
    fn the_readme_says_what_is_stored() {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR"));
        let stored = load(&folder.join("peers/results.json")).expect("results");
        let readme = fs::read_to_string(folder.join("../README.md")).expect("a README");
        let told = [
            ("half_disc", 0.01),
            ("ball", 0.05),
            ("press_fit", 0.01),
            ("press_fit", 0.001),
            ("blocks", 0.001),
            ("beams", 0.001),
            ("finite_beams", 0.001),
            ("discs", 0.001),
            ("ironing", 0.001),
        ];
        for (name, target) in told {
            let scene = SCENES.iter().find(|scene| scene.name == name);
            let sentence = stored.sentence(scene.expect(name), target);
            assert!(readme.contains(&sentence), "{name}: {sentence}");
        }
    }

    #[test]
    fn what_does_not_belong_together_is_refused() {
        assert!(entry(&field("another", |_| 1.0, 3)).is_err());
        let mut short = field("half_disc", |_| 1.0, 3);
        short.values.pop();
        assert!(entry(&short).is_err());
        let mut beyond = field("half_disc", |_| 1.0, 3);
        beyond.facets[0][0] = 4;
        assert!(entry(&beyond).is_err());
        let mut bent = field("half_disc", |_| 1.0, 3);
        bent.nodes[1].push(0.0);
        assert!(entry(&bent).is_err());
    }
}
