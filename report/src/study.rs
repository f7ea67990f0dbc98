//! What the runs of one family show.

use crate::case::{Case, Setting};
use crate::families::{Bound, Claim, Family, Kind, Quantity};
use crate::fit::Fit;
use crate::record::{Measured, Numbers, Record};

/// What an error may be drawn against.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Axis {
    /// Wall time.
    Wall,
    /// Processor time.
    Cpu,
    /// Free unknowns.
    Dofs,
    /// Numerical factorisations.
    Factorizations,
    /// The mesh size.
    Size,
}

impl Axis {
    /// All, in the order of the page.
    pub const ALL: [Axis; 5] = [
        Axis::Wall,
        Axis::Cpu,
        Axis::Dofs,
        Axis::Factorizations,
        Axis::Size,
    ];

    /// Its label, with the unit.
    pub fn label(self) -> &'static str {
        match self {
            Axis::Wall => "wall time (s)",
            Axis::Cpu => "CPU time (s)",
            Axis::Dofs => "free dofs",
            Axis::Factorizations => "factorisations",
            Axis::Size => "mesh size h (UL)",
        }
    }

    /// The run's value, where it is known.
    pub fn of(self, run: &Measured) -> Option<f64> {
        let value = match self {
            Axis::Wall => run.cost.wall,
            Axis::Cpu => run.cost.cpu?,
            Axis::Dofs => run.dofs as f64,
            Axis::Factorizations => run.cost.factorizations as f64,
            Axis::Size => run.h,
        };
        (value > 0.0).then_some(value)
    }
}

/// A run with all its errors, those against the refined solution included.
pub struct Run<'a> {
    /// What was measured.
    pub record: &'a Record,
    /// By quantity.
    pub errors: Numbers,
}

impl Run<'_> {
    /// Its settings.
    pub fn case(&self) -> &Case {
        &self.record.case
    }

    /// What was measured.
    pub fn result(&self) -> &Measured {
        &self.record.result
    }
}

/// Runs that differ in their mesh alone, the coarsest first.
pub struct Series<'a> {
    /// What they have in common.
    pub setting: Setting,
    /// The runs.
    pub runs: Vec<&'a Run<'a>>,
}

impl Series<'_> {
    /// (value on the axis, error) of the runs that converged.
    pub fn points(&self, axis: Axis, quantity: &str) -> Vec<(f64, f64)> {
        let point = |run: &&Run| {
            let error = run.errors.get(quantity)?;
            Some((axis.of(run.result())?, *error))
        };
        self.runs.iter().filter_map(point).collect()
    }

    /// The order in h.
    pub fn fit(&self, quantity: &str) -> Option<Fit> {
        Fit::new(&self.points(Axis::Size, quantity))
    }

    /// Whether only mesh and degree differ from the default.
    pub fn is_default(&self) -> bool {
        let case = self.setting.case();
        *case == Case::new(&case.family, case.degree, 0)
    }
}

/// A claim and what was found.
pub struct Verdict<'a> {
    /// The claim.
    pub claim: &'a Claim,
    /// The order or error that was found.
    pub found: Option<f64>,
}

impl Verdict<'_> {
    /// Whether the claim holds; it does not if nothing was found.
    pub fn holds(&self) -> bool {
        let Some(found) = self.found else {
            return false;
        };
        match self.claim.bound {
            Bound::Order(least) => found >= least,
            Bound::Finest(most) => found <= most,
        }
    }
}

/// A family and its runs.
pub struct Study<'a> {
    /// The family.
    pub family: &'a Family,
    /// The run that others are compared with.
    pub refined: Option<&'a Record>,
    /// All, that one included, which has no errors against itself.
    pub runs: Vec<Run<'a>>,
}

impl<'a> Study<'a> {
    /// Of all `records` those that belong to the family; `refined` are the settings of its refined run.
    pub fn new(family: &'a Family, records: &'a [Record], refined: Option<&Case>) -> Self {
        let own = || records.iter().filter(|r| r.case.family == family.name);
        let refined = own().find(|record| Some(&record.case) == refined);
        let others = |record: &Record| refined.filter(|refined| refined.case != record.case);
        let runs = own().map(|record| Run {
            record,
            errors: errors(family, record, others(record)),
        });
        Study {
            family,
            refined,
            runs: runs.collect(),
        }
    }

    /// Its runs by setting, P1 first, else in the order of the runs.
    pub fn series(&self) -> Vec<Series<'_>> {
        let mut all: Vec<Series> = Vec::new();
        for run in &self.runs {
            let setting = run.case().setting();
            match all.iter_mut().find(|series| series.setting == setting) {
                Some(series) => series.runs.push(run),
                None => all.push(Series {
                    setting,
                    runs: vec![run],
                }),
            }
        }
        for series in &mut all {
            series.runs.sort_by_key(|run| run.case().level);
        }
        all.sort_by_key(|series| series.setting.case().degree);
        all
    }

    /// The family's claims on the series with default settings; nothing is found where one of its runs failed, so that no
    /// coarser mesh passes for the finest.
    pub fn verdicts(&self) -> Vec<Verdict<'_>> {
        let series = self.series();
        let found = |claim: &Claim| {
            let is_it = |s: &&Series| s.is_default() && s.setting.case().degree == claim.degree;
            let series = series.iter().find(is_it)?;
            if !series.runs.iter().all(|run| run.result().converged()) {
                return None;
            }
            match claim.bound {
                Bound::Order(_) => Some(series.fit(claim.quantity)?.order),
                Bound::Finest(_) => {
                    let points = series.points(Axis::Size, claim.quantity);
                    let finest = points.into_iter().min_by(|a, b| a.0.total_cmp(&b.0))?;
                    Some(finest.1)
                }
            }
        };
        let claims = self.family.claims.iter();
        claims
            .map(|claim| Verdict {
                claim,
                found: found(claim),
            })
            .collect()
    }

    /// What bends or fails, in sentences.
    pub fn remarks(&self) -> Vec<String> {
        let mut remarks = Vec::new();
        for run in self.runs.iter().filter(|run| !run.result().converged()) {
            let (case, status) = (run.case(), &run.result().status);
            remarks.push(format!(
                "{}, level {}: {status}.",
                case.setting(),
                case.level
            ));
        }
        for series in self.series().iter().filter(|series| series.runs.len() > 2) {
            for quantity in self.family.quantities {
                remarks.extend(bend(series, quantity));
            }
        }
        remarks
    }

    /// The cheapest run by wall time whose error of a kind is at most `most`, and not larger on any finer mesh with
    /// the same settings, so that no error counts that only changes its sign. The family's first quantity of a kind
    /// stands for it.
    pub fn cheapest(&self, kind: Kind, most: f64) -> Option<&Run<'_>> {
        let quantity = self.family.quantities.iter().find(|q| q.kind == kind)?;
        let within = |run: &Run| run.errors.get(quantity.name).is_some_and(|e| *e <= most);
        // the refined run has no error against itself
        let speaks =
            |run: &&Run| run.errors.contains_key(quantity.name) || !run.result().converged();
        let stays = |run: &&Run| {
            let finer = |other: &&Run| {
                other.case().setting() == run.case().setting()
                    && other.case().level >= run.case().level
            };
            self.runs.iter().filter(finer).filter(speaks).all(within)
        };
        let found = self.runs.iter().filter(|run| within(run)).filter(stays);
        found.min_by(|a, b| {
            let wall = |run: &Run| run.result().cost.wall;
            wall(a).total_cmp(&wall(b))
        })
    }

    /// Whether the error was taken on a finer mesh with the same settings, too.
    pub fn is_confirmed(&self, run: &Run<'_>, quantity: &str) -> bool {
        let finer = |other: &&Run| {
            other.case().setting() == run.case().setting() && other.case().level > run.case().level
        };
        let mut finer = self.runs.iter().filter(finer);
        finer.any(|other| other.errors.contains_key(quantity))
    }
}

/// The errors that were measured, and those of values against the refined run's.
fn errors(family: &Family, record: &Record, refined: Option<&Record>) -> Numbers {
    let mut errors = record.result.errors.clone();
    for quantity in family.quantities {
        let values = || {
            let name = quantity.refined?;
            let exact = refined?.result.values.get(name)?;
            Some((record.result.values.get(name)?, exact))
        };
        if let Some((value, exact)) = values() {
            errors.insert(quantity.name.into(), (value / exact - 1.0).abs());
        }
    }
    errors
}

/// A sentence if the orders between neighbouring meshes do not agree, or if the fitted one is short of theory's.
fn bend(series: &Series<'_>, quantity: &Quantity) -> Option<String> {
    const SHORT: f64 = 0.15;
    let fit = series.fit(quantity.name)?;
    let expected = quantity.orders[series.setting.case().degree - 1]?;
    let [low, high] = fit.local;
    let name = format!("{}, {}", series.setting, quantity.title);
    if !fit.is_asymptotic() {
        Some(format!(
            "{name}: the curve bends, orders between neighbours go from {low:.2} to {high:.2}."
        ))
    } else if fit.order < expected - SHORT {
        Some(format!(
            "{name}: order {:.2} is short of theory's {expected}.",
            fit.order
        ))
    } else {
        None
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::families::Scope;
    use crate::refined::Place;

    const QUANTITIES: &[Quantity] = &[
        Quantity::new("h1", "displacement, H¹", Kind::Displacement).of_orders(1.0, 2.0),
        Quantity::new("tip", "tip", Kind::Force).against_refined("tip"),
    ];
    const CLAIMS: &[Claim] = &[
        Claim {
            quantity: "h1",
            degree: 1,
            bound: Bound::Order(0.95),
        },
        Claim {
            quantity: "tip",
            degree: 1,
            bound: Bound::Finest(0.1),
        },
    ];

    fn family() -> Family {
        Family {
            name: "any",
            title: "",
            about: "",
            reference: "",
            theory: "",
            causes: "",
            size: "",
            quantities: QUANTITIES,
            claims: CLAIMS,
            cases: |_: Scope| Vec::new(),
            refined: None,
            run: |_: &Case, _: &Place| Ok(Measured::default()),
        }
    }

    /// A run on n cells, with an error of H¹, a value of the tip, and a wall time.
    fn record(level: usize, error: f64, tip: f64, wall: f64) -> Record {
        let mut result = Measured::failed(Measured::CONVERGED);
        result.h = 1.0 / level as f64;
        result.errors.insert("h1".into(), error);
        result.values.insert("tip".into(), tip);
        result.cost.wall = wall;
        Record {
            case: Case::new("any", 1, level),
            revision: String::new(),
            result,
        }
    }

    #[test]
    fn claims_hold_only_where_numbers_do() {
        let family = family();
        let holds = |order: f64, tip: f64| {
            let error = |level: usize| (level as f64).powf(-order);
            let runs = [2, 4, 8].map(|n| record(n, error(n), tip, 1.0));
            let refined = record(16, error(16), 10.0, 1.0);
            let records = [&[refined.clone()][..], &runs].concat();
            let study = Study::new(&family, &records, Some(&refined.case));
            let verdicts: Vec<bool> = study.verdicts().iter().map(Verdict::holds).collect();
            (verdicts, study.remarks())
        };
        let (verdicts, remarks) = holds(1.0, 10.5);
        assert_eq!((verdicts, remarks.len()), (vec![true, true], 0));
        let (verdicts, remarks) = holds(0.8, 12.0);
        assert_eq!((verdicts, remarks.len()), (vec![false, false], 1));
        let mut records = [2, 4, 8, 16].map(|n| record(n, 1.0 / n as f64, 1.0, 1.0));
        records[3].result = Measured::failed("given up");
        let failed = Study::new(&family, &records, None);
        assert!(failed.verdicts().iter().all(|verdict| !verdict.holds()));
        let nothing = Study::new(&family, &[], None);
        assert!(nothing.verdicts().iter().all(|verdict| !verdict.holds()));
    }

    #[test]
    fn the_cheapest_run_stays_accurate_on_finer_meshes() {
        let family = family();
        // the coarsest is accurate by chance
        let runs = [
            (2, 0.001, 1.0),
            (4, 0.1, 2.0),
            (8, 0.008, 9.0),
            (16, 0.004, 5.0),
        ];
        let records = runs.map(|(n, error, wall)| record(n, error, 1.0, wall));
        let study = Study::new(&family, &records, None);
        let found = |most: f64| {
            let run = study.cheapest(Kind::Displacement, most);
            run.map(|run| run.case().level)
        };
        assert_eq!(found(0.01), Some(16));
        assert_eq!(found(0.2), Some(2));
        assert_eq!(found(1e-3), None);
        assert!(
            study.cheapest(Kind::Force, 1.0).is_none(),
            "without a reference"
        );
        // the refined run, of the same settings, has no error and says nothing against coarser ones
        let study = Study::new(&family, &records, Some(&records[3].case));
        let found = study.cheapest(Kind::Force, 1e-3);
        assert_eq!(found.map(|run| run.case().level), Some(2));
    }
}
