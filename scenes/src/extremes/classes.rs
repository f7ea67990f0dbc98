//! The classes of extreme scenes.

mod bodies;
mod rings;
mod slender;
mod unsolvable;

use contact_fem::model::InitialGaps;

use super::Case;
use super::exchange::Law;
use super::stack::Stack;

/// All classes.
pub(super) fn all() -> Vec<Case> {
    let mut all = vec![Stack::default().case("stack", "benign").quick()];
    for part in [
        stiffness(),
        incompressibility(),
        units(),
        redundant(),
        compression(),
        gaps(),
        interference(),
        thickness(),
        meshes(),
        many(),
        bodies::all(),
        rings::all(),
        slender::all(),
        unsolvable::all(),
    ] {
        all.extend(part);
    }
    all
}

const LAWS: [(&str, Law); 2] = [("linear", Law::Linear), ("neo-hookean", Law::NeoHookean)];

/// A word for the dimension and the order of the elements.
fn words(dimension: usize, is_quadratic: bool) -> String {
    format!("{dimension}D P{}", 1 + usize::from(is_quadratic))
}

/// Ratios of Young's moduli to 1e±6, under both laws.
fn stiffness() -> Vec<Case> {
    let mut cases = Vec::new();
    for (dimension, is_quadratic) in [(2, false), (2, true), (3, false), (3, true)] {
        for (law_name, law) in LAWS {
            let name = |ratio: f64| {
                let words = words(dimension, is_quadratic);
                format!("stack {law_name} {words}, E ratio {ratio:e}")
            };
            for ratio in [1.0, 1e-6, 1e-3, 1e3, 1e6] {
                let stack = Stack {
                    dimension,
                    law,
                    is_quadratic,
                    // the blocks do not widen, so that neither stands out over the other
                    nu: 0.0,
                    young: vec![1e3 * ratio, 1e3],
                    cells: if dimension == 2 {
                        vec![[3, 3], [4, 4]]
                    } else {
                        vec![[2, 2], [3, 2]]
                    },
                    ..Stack::default()
                };
                let case = stack.case(name(ratio), "stiffness ratio").twin(name(1.0));
                let is_quick = dimension == 2 && !is_quadratic;
                cases.push(if is_quick { case.quick() } else { case });
            }
        }
    }
    cases
}

/// Poisson's ratio up to 0.4999.
fn incompressibility() -> Vec<Case> {
    let mut cases = Vec::new();
    for (law_name, law) in LAWS {
        for is_quadratic in [false, true] {
            let name = |nu: f64| {
                let words = words(2, is_quadratic);
                format!("stack {law_name} {words}, nu {nu}")
            };
            for nu in [0.3, 0.0, 0.45, 0.49, 0.499, 0.4999] {
                let stack = Stack {
                    law,
                    is_quadratic,
                    nu,
                    press: 0.05,
                    ..Stack::default()
                };
                cases.push(stack.case(name(nu), "incompressibility").twin(name(0.3)));
            }
        }
    }
    cases
}

/// Surfaces that are declared with both faces of all bodies, so that rows repeat what others say, on blocks that widen.
fn redundant() -> Vec<Case> {
    let of = |dimension: usize, both_faces: bool| {
        let faces = if both_faces {
            "both faces"
        } else {
            "the faces between"
        };
        let stack = Stack {
            dimension,
            both_faces,
            press: 0.02,
            cells: vec![
                [if dimension == 2 { 10 } else { 3 }, 2],
                [if dimension == 2 { 13 } else { 4 }, 2],
            ],
            ..Stack::default()
        };
        let name = format!("stack in {dimension}D, {faces} declared");
        stack.case(name, "redundant rows")
    };
    // with one layer of cells, the nodes between the blocks have as many rows as displacements across
    let one_layer = Stack {
        nu: 0.0,
        press: 0.02,
        cells: vec![[10, 1], [13, 1]],
        ..Stack::default()
    };
    let benign = |dimension: usize| format!("stack in {dimension}D, the faces between declared");
    let mut cases = vec![
        one_layer
            .case("one layer of cells in each block", "redundant rows")
            .twin(benign(2)),
    ];
    for dimension in [2, 3] {
        let both = [false, true].map(|both_faces| of(dimension, both_faces));
        cases.extend(both.map(|case| case.twin(benign(dimension))));
    }
    cases
}

/// Lengths and moduli over many decades.
fn units() -> Vec<Case> {
    let mut cases = Vec::new();
    for (law_name, law) in LAWS {
        let name = |length: f64, modulus: f64| {
            format!("stack {law_name}, lengths {length:e}, moduli {modulus:e}")
        };
        for (length, modulus) in [
            (1.0, 1.0),
            (1e-9, 1.0),
            (1e9, 1.0),
            (1.0, 1e-9),
            (1.0, 1e12),
            (1e-6, 1e11),
            (1e6, 1e-6),
        ] {
            let stack = Stack {
                law,
                length,
                young: vec![1e3 * modulus; 2],
                ..Stack::default()
            };
            let case = stack.case(name(length, modulus), "units");
            cases.push(case.twin(name(1.0, 1.0)));
        }
    }
    cases
}

/// Compression until hardly anything is left, in 1 to 100 increments.
fn compression() -> Vec<Case> {
    let mut cases = Vec::new();
    let name = |left: f64, increments: usize| {
        format!("stack compressed to {left}, {increments} increments")
    };
    for (left, increments) in [
        (0.9, 10),
        (0.5, 1),
        (0.5, 10),
        (0.5, 100),
        (0.2, 10),
        (0.2, 40),
        (0.1, 20),
        (0.1, 100),
    ] {
        let stack = Stack {
            press: 2.0 * (1.0 - left),
            ..Stack::default()
        };
        let case = stack.case(name(left, increments), "compression");
        cases.push(case.increments(increments).twin(name(0.9, 10)));
    }
    cases
}

/// Gaps of 1e-6 to 1000 sizes that are closed first.
fn gaps() -> Vec<Case> {
    let mut cases = Vec::new();
    for (law_name, law) in LAWS {
        let name = |gap: f64, increments: usize| {
            format!("stack {law_name}, gap {gap:e}, {increments} increments")
        };
        for (gap, increments) in [
            (0.0, 1),
            (1e-6, 1),
            (1e-3, 1),
            (1e-1, 1),
            (1e-1, 10),
            (1.0, 1),
            (1.0, 10),
            (10.0, 10),
            (100.0, 10),
            (1000.0, 1),
        ] {
            let stack = Stack {
                law,
                gap,
                press: 0.02,
                ..Stack::default()
            };
            let case = stack.case(name(gap, increments), "gap");
            cases.push(case.increments(increments).twin(name(0.0, 1)));
        }
    }
    cases
}

/// Blocks that start inside each other: the fit alone, a push beside it, or an overlap that stays.
fn interference() -> Vec<Case> {
    let mut cases = Vec::new();
    for (dimension, is_quadratic) in [(2, false), (2, true), (3, false), (3, true)] {
        for (law_name, law) in LAWS {
            let stack = |gap: f64, press: f64, initial_gaps: InitialGaps| Stack {
                dimension,
                law,
                is_quadratic,
                nu: 0.0,
                gap,
                press,
                initial_gaps,
                cells: vec![[2, 2], [3, 2]],
                ..Stack::default()
            };
            let name = |what: &str| {
                let words = words(dimension, is_quadratic);
                format!("stack {law_name} {words}, {what}")
            };
            let benign = name("no overlap, pushed");
            let class = "interference";
            let push = stack(0.0, 0.05, InitialGaps::Refuse);
            cases.push(push.case(benign.clone(), class));
            for (what, stack, increments) in [
                ("fit of 0.05", stack(-0.05, 0.05, InitialGaps::Resolve), 1),
                (
                    "fit of 0.05 in 10",
                    stack(-0.05, 0.05, InitialGaps::Resolve),
                    10,
                ),
                ("fit of 1e-6", stack(-1e-6, 1e-6, InitialGaps::Resolve), 1),
                ("fit and push", stack(-0.01, 0.05, InitialGaps::Resolve), 3),
                ("overlap stays", stack(-0.05, 0.05, InitialGaps::Adjust), 1),
            ] {
                let case = stack.case(name(what), class).increments(increments);
                let is_quick = dimension == 2 && increments == 1;
                cases.push(if is_quick { case.quick() } else { case }.twin(benign.clone()));
            }
        }
    }
    cases
}

/// Slabs down to 1e-4 of their width, with both faces of each declared.
fn thickness() -> Vec<Case> {
    let mut cases = Vec::new();
    for (dimension, count) in [(2, 2), (2, 3), (3, 2)] {
        let name = |t: f64| format!("{count} slabs in {dimension}D, thickness {t:e}");
        for t in [0.5, 4e-2, 4e-3, 2e-3, 1e-3, 1e-4] {
            let stack = Stack {
                dimension,
                nu: 0.0,
                young: vec![1e3; count],
                heights: vec![t; count],
                press: 0.02 * t * count as f64,
                cells: (0..count)
                    .map(|k| [if dimension == 2 { 10 + 3 * k } else { 3 + k }, 2])
                    .collect(),
                both_faces: true,
                ..Stack::default()
            };
            let case = stack.case(name(t), "thickness").twin(name(0.5));
            cases.push(if dimension == 2 && count == 2 {
                case.quick()
            } else {
                case
            });
        }
    }
    cases
}

/// Slivers, and meshes of very different fineness.
fn meshes() -> Vec<Case> {
    let mut cases = Vec::new();
    let base = |cells: Vec<[usize; 2]>, is_quadratic: bool| Stack {
        cells,
        is_quadratic,
        nu: 0.0,
        ..Stack::default()
    };
    for is_quadratic in [false, true] {
        let order = 1 + usize::from(is_quadratic);
        let name = |over: usize| format!("slivers P{order} of 1:{over}");
        for over in [1, 10, 100, 1000] {
            let stack = base(vec![[1, over], [2, 2]], is_quadratic);
            cases.push(stack.case(name(over), "slivers").twin(name(1)));
        }
        let name = |ratio: usize, first: bool| {
            format!(
                "meshes P{order} of 1:{ratio}, {} below",
                if first { "fine" } else { "coarse" }
            )
        };
        for ratio in [1, 5, 20, 50] {
            for first in [true, false] {
                let (fine, coarse) = ([2 * ratio, 2], [2, 2]);
                let cells = if first {
                    vec![fine, coarse]
                } else {
                    vec![coarse, fine]
                };
                let case = base(cells, is_quadratic).case(name(ratio, first), "mesh ratio");
                cases.push(case.twin(name(1, first)));
            }
        }
    }
    for (dimension, is_quadratic) in [(2, false), (2, true), (3, false), (3, true)] {
        let stack = Stack {
            dimension,
            is_quadratic,
            cells: vec![[1, 1]; 2],
            ..Stack::default()
        };
        let name = format!("one cell a body, {}", words(dimension, is_quadratic));
        cases.push(stack.case(name, "one element").twin("stack"));
    }
    cases
}

/// Many bodies, held by contact alone between the first and the last.
fn many() -> Vec<Case> {
    let mut cases = Vec::new();
    for (law_name, law) in LAWS {
        let name = |count: usize| format!("{count} blocks, {law_name}");
        for count in [2, 5, 10, 30] {
            let stack = Stack {
                law,
                young: vec![1e3; count],
                heights: vec![1.0; count],
                press: 0.05 * count as f64,
                cells: (0..count).map(|k| [2 + k % 2, 2]).collect(),
                ..Stack::default()
            };
            cases.push(stack.case(name(count), "many bodies").twin(name(2)));
        }
    }
    cases
}
