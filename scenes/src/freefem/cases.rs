//! The scenes of the comparison with FreeFEM, and their sizes.

use std::path::Path;

use contact_fem::element::Order;
use contact_fem::{Error, Scene};

use crate::arch;
use crate::beams::{Beams, Law};
use crate::disc_in_disc::{self, Roles};
use crate::hertz::{self, Hertz};

/// The fineness of the meshes.
#[derive(clap::ValueEnum, Clone, Copy, Debug, PartialEq, Eq, PartialOrd)]
pub enum Size {
    /// Seconds of run time with either program; used in tests.
    Tiny,
    /// About 1 000 cells.
    Small,
    /// About 5 000 cells.
    Medium,
    /// About 20 000 cells.
    Large,
}

/// A scene that both programs solve.
pub struct Case {
    /// The name of the scene; FreeFEM's script is `freefem/NAME.edp` if `scripts` has no others.
    pub name: &'static str,
    /// FreeFEM's scripts and their arguments in addition to `-meshes`, `-out`, `-increments` and
    /// `-tolerance`.
    pub scripts: &'static [Script],
    /// The names of the bodies and of their mesh files.
    pub bodies: &'static [&'static str],
    /// The bodies whose reactions, summed, are the scene's reaction.
    pub supports: &'static [usize],
    /// The number of load increments for each size.
    pub increments: [usize; 4],
    /// The convergence tolerance of the fixed-point iterations: the relative change of the
    /// displacement.
    pub tolerance: f64,
    /// The scene with default settings.
    build: fn(Size) -> Result<Built, Error>,
}

/// One of FreeFEM's scripts for a scene.
pub struct Script {
    /// `freefem/FILE.edp`.
    pub file: &'static str,
    /// `tuned` or `literal`.
    pub style: &'static str,
    /// Additional arguments.
    pub arguments: &'static [&'static str],
    /// The largest size for which the script is meant.
    pub up_to: Size,
}

/// A scene in the plane or in space.
pub enum Built {
    /// D = 2.
    Plane(Scene<2>),
    /// D = 3.
    Space(Scene<3>),
}

const fn tuned(file: &'static str, arguments: &'static [&'static str]) -> Script {
    Script {
        file,
        style: "tuned",
        arguments,
        up_to: Size::Large,
    }
}

const fn literal(file: &'static str, arguments: &'static [&'static str], up_to: Size) -> Script {
    Script {
        file,
        style: "literal",
        arguments,
        up_to,
    }
}

/// All cases.
pub static CASES: [Case; 6] = [
    Case {
        name: "disc_in_disc",
        scripts: &[
            tuned("disc_in_disc", &[]),
            literal("disc_in_disc_literal", &[], Size::Small),
        ],
        bodies: &["ring", "disc"],
        supports: &[0],
        increments: [20, 100, 100, 100],
        tolerance: 1e-8,
        build: disc_in_disc,
    },
    Case {
        name: "beams_small_strain",
        scripts: &[
            tuned("three_beams", &["-law", "small_strain"]),
            literal("three_beams_literal", &["-law", "small_strain"], Size::Tiny),
        ],
        bodies: &["beam1", "beam2", "beam3"],
        supports: &[0, 1, 2],
        increments: [1; 4],
        tolerance: 1e-8,
        build: |size| beams(Law::SmallStrain, 0.0, size),
    },
    Case {
        name: "beams_neo_hookean",
        scripts: &[
            tuned("three_beams", &["-law", "neo_hookean"]),
            literal("three_beams_literal", &["-law", "neo_hookean"], Size::Tiny),
        ],
        bodies: &["beam1", "beam2", "beam3"],
        supports: &[0, 1, 2],
        increments: [4; 4],
        tolerance: 1e-8,
        build: |size| beams(Law::NeoHookean, 0.0, size),
    },
    // only this scene has λ ≠ 0, so that only here an error in the scripts' terms with λ would show
    Case {
        name: "beams_poisson",
        scripts: &[tuned("three_beams", &["-law", "neo_hookean", "-nu", "0.3"])],
        bodies: &["beam1", "beam2", "beam3"],
        supports: &[0, 1, 2],
        increments: [4; 4],
        tolerance: 1e-8,
        build: |size| beams(Law::NeoHookean, 0.3, size),
    },
    Case {
        name: "hertz",
        scripts: &[tuned("hertz", &[])],
        bodies: &["cylinder", "block"],
        supports: &[1],
        increments: [1; 4],
        tolerance: 1e-8,
        build: half_cylinder,
    },
    Case {
        name: "arch",
        scripts: &[tuned("arch", &[])],
        bodies: &["arch"],
        supports: &[0],
        increments: [1; 4],
        tolerance: 1e-8,
        build: |size| Ok(Built::Plane(arch::scene(size.of([2, 4, 9, 18]))?)),
    },
];

impl Case {
    /// The case with this name.
    pub fn named(name: &str) -> Result<&'static Case, String> {
        let known = || CASES.each_ref().map(|case| case.name).join(", ");
        let found = CASES.iter().find(|case| case.name == name);
        found.ok_or_else(|| format!("there is no scene `{name}`; there are {}", known()))
    }
}

impl Size {
    /// The one of four values for this size.
    pub fn of<T: Copy>(self, all: [T; 4]) -> T {
        all[self as usize]
    }

    /// The name on the command line.
    pub fn name(self) -> &'static str {
        self.of(["tiny", "small", "medium", "large"])
    }
}

/// 1 588, 4 880 and 20 053 triangles.
fn disc_in_disc(size: Size) -> Result<Built, Error> {
    let fineness = disc_in_disc::Fineness::scaled(size.of([24, 64, 114, 231]));
    Ok(Built::Plane(disc_in_disc::scene(
        fineness,
        Roles::default(),
    )?))
}

fn beams(law: Law, poisson: f64, size: Size) -> Result<Built, Error> {
    let [across, along] = size.of(match law {
        Law::SmallStrain => [[2, 8], [3, 24], [6, 48], [10, 80]],
        Law::NeoHookean => [[2, 8], [3, 24], [5, 40], [8, 64]],
    });
    let beams = Beams {
        along,
        poisson,
        ..Beams::new(across, Order::Linear, law)
    };
    Ok(Built::Space(beams.scene()?))
}

fn half_cylinder(size: Size) -> Result<Built, Error> {
    let fineness = hertz::Fineness::family(size.of([4, 8, 16, 32]));
    Ok(Built::Plane(Hertz::new(fineness, Order::Linear).scene()?))
}

impl Case {
    /// The scene, integrated as the scripts do.
    ///
    /// # Errors
    /// Those of the scene.
    pub fn scene(&self, size: Size) -> Result<Built, Error> {
        let mut built = (self.build)(size)?;
        match &mut built {
            Built::Plane(scene) => scene.points_as_in_the_paper(),
            Built::Space(scene) => scene.points_as_in_the_paper(),
        }
        Ok(built)
    }
}

impl Built {
    /// Writes the meshes for FreeFEM, one for each body, to `folder`, which must exist.
    pub fn export(&self, names: &[&str], folder: &Path) -> Result<(), Error> {
        match self {
            Built::Plane(scene) => export(scene, names, folder, "msh"),
            Built::Space(scene) => export(scene, names, folder, "mesh"),
        }
    }
}

fn export<const D: usize>(
    scene: &Scene<D>,
    names: &[&str],
    folder: &Path,
    ending: &str,
) -> Result<(), Error> {
    for (body, name) in scene.bodies().iter().zip(names) {
        let path = folder.join(format!("{name}.{ending}"));
        body.mesh().save_freefem(path)?;
    }
    Ok(())
}
