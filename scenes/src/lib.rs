//! The scenes that tests, examples, benches and the report share, with the utilities of programs
//! about them.
//!
//! | module | what |
//! |---|---|
//! | [`disc_in_disc`], [`beams`] | sections 6.1 and 6.2 of the paper |
//! | [`hertz`], [`arch`], [`blocks`], [`hairpin`], [`ironing`] | Hertz's contact, Signorini's problem, the patch test, self-contact, a die on a slab |
//! | [`sliding_disc`] | a disc that is pressed on a block and moved along it |
//! | [`wheel`] | a soft wheel that rolls on a soft slab |
//! | [`cantilevers`] | rows of both passes that are one |
//! | [`extremes`] | scenes at the limits, with their truths and benign twins |
//! | [`needs`] | scenes in which little has to be computed, with the cheapest ways to their results |
//! | [`random`] | random scenes, sound and wrong ones |
//! | [`studies`] | methods and passes side by side |
//! | [`freefem`] | the same scenes solved by FreeFEM's scripts |
//! | [`cli`], [`files`], [`tables`] | options of the examples, files, tables |
#![forbid(unsafe_code)]
#![allow(non_snake_case)] // the symbols of the field

pub mod arch;
pub mod ball;
pub mod beams;
pub mod blocks;
pub mod cantilevers;
pub mod cli;
pub mod die;
pub mod disc_in_disc;
pub mod extremes;
pub mod files;
pub mod freefem;
pub mod hairpin;
pub mod hertz;
pub mod ironing;
pub mod needs;
pub mod pressure;
pub mod random;
pub mod sliding_disc;
pub mod studies;
pub mod tables;
pub mod wheel;

use contact_fem::certificate::{Condition, Limits};
use contact_fem::model::Passes;
use contact_fem::{Body, Error, Scene};

/// The error of a program about scenes, which `main` prints.
pub type Failure = Box<dyn std::error::Error>;

/// A scene with one body, called `body`.
pub fn alone<const D: usize>(body: Body<D>) -> Scene<D> {
    let mut scene = Scene::new();
    scene.add("body", body);
    scene
}

/// A scene with two bodies, called `first` and `second`, each with the name of its contact
/// boundary.
///
/// # Errors
/// As [`Scene::contact`].
pub fn pair<const D: usize>(
    (first, on_first): (Body<D>, &str),
    (second, on_second): (Body<D>, &str),
) -> Result<Scene<D>, Error> {
    let mut scene = Scene::new();
    let first = scene.add("first", first);
    let second = scene.add("second", second);
    scene.contact(first.on(on_first), second.on(on_second))?;
    Ok(scene)
}

/// The limits of the certificate, those on what a solver leaves ten times tighter.
pub fn tight() -> Limits {
    let left = [
        Condition::WeakPenetration,
        Condition::Adhesion,
        Condition::Complementarity,
        Condition::Stationarity,
        Condition::ActionReaction,
        Condition::Balance,
    ];
    let limits = Limits::default();
    left.into_iter().fold(limits, |limits, condition| {
        limits.with(condition, 0.1 * Limits::default().of(condition))
    })
}

/// The same roles for the pair in reverse order.
fn mirrored(passes: Passes) -> Passes {
    match passes {
        Passes::Both => Passes::Both,
        Passes::FirstIsSlave => Passes::SecondIsSlave,
        Passes::SecondIsSlave => Passes::FirstIsSlave,
    }
}
