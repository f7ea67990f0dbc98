//! Faults that are compiled in for `make planted` alone, one of which is present at a time.

use std::sync::LazyLock;
use std::sync::atomic::{AtomicUsize, Ordering};

/// The faults by area and name. The first of each area are the cheapest to run.
pub const FAULTS: &[[&str; 2]] = &[
    ["normals", "normals are turned by 0.05"],
    ["normals", "every seventh normal is reversed"],
    ["normals", "normals are those at rest"],
    ["normals", "every fifth facet is left out of averages"],
    ["normals", "the normal is that of the nearest node"],
    ["normals", "normals are a tenth those of the next node"],
    ["normals", "the last normal is that of the first node"],
    ["feet", "coordinates of feet are permuted"],
    ["feet", "feet are in the middle of facets"],
    ["feet", "feet are shifted by 0.05"],
    ["feet", "feet are on the next facet"],
    ["feet", "points beyond the end count"],
    ["feet", "feet are at the nearest corner"],
    ["feet", "the feet on every third facet are in its middle"],
    ["feet", "feet are shifted by 0.005"],
    ["search", "every fifth point is lost"],
    ["search", "every sixth facet is lost"],
    ["search", "reach is a hundredth"],
    ["search", "points of any side count"],
    ["search", "what is seen through material counts"],
    ["search", "every fourth facet is no master"],
    ["search", "every sixteenth facet is no master"],
    ["search", "points near corners are lost"],
    ["tree", "the tree is that at rest"],
    ["weights", "weights leave out the measure"],
    ["weights", "every third facet weighs twice"],
    ["weights", "shares of points are left out"],
    ["weights", "test functions are constant"],
    ["weights", "test functions are exchanged"],
    ["weights", "test functions are a tenth constant"],
    ["weights", "every twentieth point weighs twice"],
    ["weights", "points near the rim weigh in full"],
    ["rows", "the master's part is halved"],
    ["rows", "the master's part is left out"],
    ["rows", "the slave is in the middle of its facet"],
    ["rows", "rows are a hundredth of a facet open"],
    ["rows", "every fifth row is left out"],
    ["rows", "rows do not lean"],
    ["rows", "rows are not divided by their area"],
    ["rows", "rows are a thousandth of a facet open"],
    ["rows", "every fifth row is a hundredth of a facet closed"],
    ["rows", "rows have the names of the next nodes"],
    ["rows", "rows take places at rest a thousandth off"],
    ["rows", "the first component of rows is a hundredth larger"],
    ["signs", "the master's part has the sign of the slave's"],
    ["signs", "components of normals are exchanged"],
    ["signs", "every ninth point pushes the other way"],
    ["roles", "the second pass is left out"],
    ["roles", "the first pass is left out"],
    ["reactions", "contact forces are a hundredth larger"],
    ["reactions", "reactions leave out contact"],
    ["reactions", "reactions have the other sign"],
    ["reactions", "reactions leave out a hundredth"],
    ["affine map", "positions are a thousandth off"],
    ["affine map", "every fifth node is where it was at rest"],
    [
        "affine map",
        "prescribed displacements are a hundredth short",
    ],
    ["multipliers", "every ninth multiplier is lost"],
    ["multipliers", "multipliers are those of the next row"],
    [
        "multipliers",
        "the largest multiplier is a hundredth larger",
    ],
    ["multipliers", "small multipliers are lost"],
    ["restart", "the state is a thousandth off"],
    ["restart", "one unknown is lost"],
    ["restart", "the state is that of the next unknown"],
    [
        "energies",
        "forces are a hundredth larger than the energy's slope",
    ],
    ["energies", "forces leave out every ninth cell"],
    [
        "energies",
        "the first component of forces is a hundredth larger",
    ],
    ["pressures", "pressures are doubled"],
];

/// The environment variable with the name of a fault that is present from the start, for programs that do not plant one themselves.
pub const VARIABLE: &str = "PLANTED_FAULT";

static PRESENT: LazyLock<AtomicUsize> = LazyLock::new(|| {
    let given = std::env::var(VARIABLE).ok();
    let fault = given.and_then(|given| FAULTS.iter().position(|[_, name]| *name == given));
    AtomicUsize::new(fault.unwrap_or(usize::MAX))
});

/// Plants the fault of this number, or none.
pub fn plant(fault: Option<usize>) {
    PRESENT.store(fault.unwrap_or(usize::MAX), Ordering::Relaxed);
}

/// Whether the fault of this number is present.
pub fn is_present(fault: usize) -> bool {
    PRESENT.load(Ordering::Relaxed) == fault
}

/// The number of a fault by its name.
///
/// # Panics
/// If there is none; where it is evaluated in a constant, that does not compile.
pub const fn number(name: &str) -> usize {
    let mut number = 0;
    while number < FAULTS.len() {
        let own = FAULTS[number][1].as_bytes();
        let name = name.as_bytes();
        let mut k = 0;
        while k < own.len() && k < name.len() && own[k] == name[k] {
            k += 1;
        }
        if k == own.len() && k == name.len() {
            return number;
        }
        number += 1;
    }
    panic!("no fault has this name")
}

/// Whether the fault of this name is present.
#[macro_export]
macro_rules! planted {
    ($name:literal) => {{
        const NUMBER: usize = $crate::planted::number($name);
        $crate::planted::is_present(NUMBER)
    }};
}
