//! The report as HTML pages without anything from elsewhere: the first one compares programs, each other answers one question.

pub mod peers;
mod plot;
pub mod site;

use std::fmt::Write;

use self::plot::{Curve, Look, Marker, Plot, bar, escape, key};
use crate::case::{Case, Formulation, Points};
use crate::families::Quantity;
use crate::freefem::Point;
use crate::overview;
use crate::pareto::front;
use crate::peers::Stored;
use crate::study::{Axis, Run, Series, Study};
use ipopt_contact_scenes::tables::Table;
use site::Sheet;

const STYLE: &str = include_str!("style.css");

/// What the page is made of.
pub struct Page<'a> {
    /// The families and their runs.
    pub studies: &'a [Study<'a>],
    /// The machine and the programs.
    pub environment: &'a [(&'static str, String)],
    /// What other programs need on the same meshes.
    pub peers: &'a Stored,
    /// Results of FreeFEM.
    pub freefem: &'a [Point],
    /// What there is to say on FreeFEM's results.
    pub freefem_remarks: &'a [String],
}

/// What stands above the table of advice.
pub const ADVICE: &str = "The cheapest run by wall time whose error was at most the target, and stayed there on finer \
    meshes with the same settings. A star marks runs whose certificate does not hold, † those without a finer one to confirm it. “Not reached” means by none of \
    the runs of this report.";

impl Page<'_> {
    /// The pages that this report computes, the first one first.
    pub fn sheets(&self) -> Vec<Sheet> {
        let sheet = |name: &str, question: String, body: String| Sheet {
            name: name.into(),
            question,
            body,
        };
        let mut advice = format!("{INTRODUCTION}<p>{ADVICE}</p>\n");
        advice.push_str(&table(&overview::advice(self.studies)));
        let mut sheets = vec![
            sheet(
                "index",
                "Which program for which accuracy?".into(),
                peers::section(self.peers),
            ),
            sheet(
                "accuracy",
                "What does accuracy cost with this library?".into(),
                advice,
            ),
            sheet(
                "claims",
                "Do errors fall as theory says?".into(),
                INTRODUCTION.to_string() + &table(&overview::claims(self.studies)),
            ),
        ];
        for study in self.studies {
            let mut body = INTRODUCTION.to_string();
            self.family(study, &mut body);
            let question = format!("{}: how do errors fall with time?", study.family.title);
            sheets.push(sheet(study.family.name, question, body));
        }
        let mut machine = String::new();
        self.machine(&mut machine);
        sheets.push(sheet(
            "machine",
            "On which machine was this measured?".into(),
            machine,
        ));
        sheets
    }

    fn machine(&self, html: &mut String) {
        html.push_str("<dl>\n");
        for (name, value) in self.environment {
            let _ = writeln!(html, "<dt>{name}</dt><dd>{}</dd>", escape(value));
        }
        let freefem = match self.freefem.len() {
            0 => "no stored results".to_string(),
            n => format!(
                "{n} stored results, seconds of the machine that they were stored on; {} on meshes about as fine as the \
                 refined one, and not shown",
                self.studies
                    .iter()
                    .map(|study| self.too_fine(study))
                    .sum::<usize>()
            ),
        };
        let _ = writeln!(html, "<dt>FreeFEM</dt><dd>{freefem}</dd>\n</dl>");
        for remark in self.freefem_remarks {
            let _ = writeln!(html, "<p class=\"bad\">{}</p>", escape(remark));
        }
    }

    fn family(&self, study: &Study<'_>, html: &mut String) {
        let family = study.family;
        let _ = write!(
            html,
            "<dl>\n<dt>what</dt><dd>{}</dd>\n<dt>reference</dt><dd>{}</dd>\n\
             <dt>theory</dt><dd>{}</dd>\n<dt>h</dt><dd>{}</dd>\n</dl>\n",
            escape(family.about),
            escape(family.reference),
            escape(family.theory),
            escape(family.size)
        );
        html.push_str(&legend(study, self.own_freefem(study).next().is_some()));
        for (k, quantity) in family.quantities.iter().enumerate() {
            let title = escape(quantity.title);
            let plots = Axis::ALL.map(|axis| self.plot(study, quantity, axis));
            if plots.iter().all(Plot::is_empty) {
                let _ = writeln!(html, "<p>{title}: no run has such an error.</p>");
                continue;
            }
            let (open, close) = match k < 2 || self.has_freefem(study, quantity) {
                true => (format!("<section><h3>{title}</h3>"), "</section>"),
                false => (format!("<details><summary>{title}</summary>"), "</details>"),
            };
            let _ = write!(html, "{open}\n<div class=\"plots\">\n");
            for plot in plots.iter().filter(|plot| !plot.is_empty()) {
                html.push_str(&plot.svg());
            }
            let _ = writeln!(html, "</div>{close}");
        }
        html.push_str("<h3>Observed orders</h3>\n");
        html.push_str(&table(&overview::orders(study)));
        html.push_str("<h3>What bends or fails</h3>\n<ul>\n");
        for remark in study.remarks() {
            let _ = writeln!(html, "<li>{}</li>", escape(&remark));
        }
        let _ = write!(html, "</ul>\n<p>{}</p>\n", escape(family.causes));
        html.push_str(&phases(study));
        html.push_str("<details><summary>All runs</summary>\n");
        html.push_str(&table(&overview::runs(study)));
        html.push_str("</details>\n");
    }

    fn own_freefem<'b>(&'b self, study: &'b Study<'_>) -> impl Iterator<Item = &'b Point> {
        let is_own = |point: &&Point| point.family == study.family.name;
        self.freefem.iter().filter(is_own)
    }

    /// How many of FreeFEM's results are on meshes too fine to have an error.
    fn too_fine(&self, study: &Study<'_>) -> usize {
        let refined = study.refined.map(|record| &record.result);
        let own = self.own_freefem(study);
        own.filter(|point| refined.is_some() && !point.is_coarser(refined))
            .count()
    }

    /// Whether one of FreeFEM's results is in the plots of a quantity.
    fn has_freefem(&self, study: &Study<'_>, quantity: &Quantity) -> bool {
        let refined = study.refined.map(|record| &record.result);
        let error = |point: &Point| point.error(study.family, quantity.name, refined);
        self.own_freefem(study).any(|point| error(point).is_some())
    }

    fn plot(&self, study: &Study<'_>, quantity: &Quantity, axis: Axis) -> Plot {
        let series = study.series();
        let mut curves: Vec<Curve> = series.iter().map(|s| curve(s, quantity, axis)).collect();
        let all: Vec<(f64, f64)> = curves.iter().flat_map(|c| c.points.clone()).collect();
        let refined = study.refined.map(|record| &record.result);
        for point in self.own_freefem(study) {
            let error = point.error(study.family, quantity.name, refined);
            curves.extend(point.at(axis).zip(error).map(|place| Curve {
                titles: vec![point.label.clone()],
                look: FREEFEM,
                points: vec![place],
                joined: false,
                note: None,
            }));
        }
        let is_cost = axis != Axis::Size;
        Plot {
            x: axis.label().into(),
            y: format!("error: {}", quantity.title),
            in_percent: false,
            front: match is_cost {
                true => front(&all).into_iter().map(|k| all[k]).collect(),
                false => Vec::new(),
            },
            curves,
        }
    }
}

const INTRODUCTION: &str = "<p>What accuracy costs with this library: benchmark families over meshes, orders, \
    integration, the paper's methods (7), (37) and (39), the library's default solver, fixed-point variants and tolerances. Every result on this \
    page is computed anew by the command that writes it, except FreeFEM's results, which are stored; every run is a process of its own with one thread, one at a \
    time, and time counts from building the mesh to the last converged load step. Errors are relative. The broad line \
    joins the best runs: every other run costs more than one of them or has a larger error.</p>\n";

const FREEFEM: Look = Look {
    colour: 8,
    marker: Marker::Star,
    dashed: false,
};

/// Default settings, exact integration and the other methods have looks of their own; the rest is `other settings`.
fn look(series: &Series<'_>) -> (Look, String) {
    let case = series.setting.case();
    let quadratic = case.degree == 2;
    let default = Case::new(&case.family, case.degree, 0);
    let (colour, marker, dashed, name) = match (case.method, case.points) {
        (Formulation::PenalizedSlack, _) => (4, Marker::Triangle, true, "(37)".to_string()),
        (Formulation::Penalty, _) => (5, Marker::Diamond, true, "(39)".to_string()),
        (Formulation::Automatic, _) if quadratic => {
            (10, Marker::Square, false, "P2, default solver".to_string())
        }
        (Formulation::Automatic, _) => (9, Marker::Disc, false, "P1, default solver".to_string()),
        (_, Points::Exact) if case.complementarity != default.complementarity => {
            let name = "exact, (7), other gap × force";
            (7, Marker::Plus, true, name.into())
        }
        (_, Points::Exact) if quadratic => (3, Marker::Frame, true, "P2, exact, (7)".into()),
        (_, Points::Exact) => (2, Marker::Ring, true, "P1, exact, (7)".into()),
        _ if !series.is_default() => {
            let name = "(7), other tolerances or plain fixed point";
            (6, Marker::Plus, true, name.into())
        }
        _ if quadratic => (1, Marker::Square, false, "P2, Gauss, (7)".into()),
        _ => (0, Marker::Disc, false, "P1, Gauss, (7)".into()),
    };
    let look = Look {
        colour,
        marker,
        dashed,
    };
    (look, name)
}

fn curve(series: &Series<'_>, quantity: &Quantity, axis: Axis) -> Curve {
    let mut points: Vec<(String, (f64, f64))> = Vec::new();
    for run in &series.runs {
        let place = axis
            .of(run.result())
            .zip(run.errors.get(quantity.name).copied());
        points.extend(
            place
                .filter(|p| p.1 > 0.0)
                .map(|place| (title(run, place.1), place)),
        );
    }
    let fit = series.fit(quantity.name).filter(|_| axis == Axis::Size);
    Curve {
        look: look(series).0,
        joined: points.len() > 1,
        note: fit
            .filter(|_| series.is_default())
            .map(|fit| format!("{:.2}", fit.order)),
        titles: points.iter().map(|(title, _)| title.clone()).collect(),
        points: points.into_iter().map(|(_, place)| place).collect(),
    }
}

fn title(run: &Run<'_>, error: f64) -> String {
    let (case, result) = (run.case(), run.result());
    format!(
        "{}, level {}: error {error:.2e}, {:.2} s, {} dofs",
        case.setting(),
        case.level,
        result.cost.wall,
        result.dofs
    )
}

fn legend(study: &Study<'_>, with_freefem: bool) -> String {
    let mut looks: Vec<(Look, String, bool)> = Vec::new();
    for series in study.series() {
        let ((look, name), joined) = (look(&series), series.runs.len() > 1);
        match looks.iter_mut().find(|(other, ..)| *other == look) {
            Some(found) => found.2 |= joined,
            None => looks.push((look, name, joined)),
        }
    }
    if with_freefem {
        looks.push((FREEFEM, "FreeFEM".into(), false));
    }
    let mut html = String::from("<div class=\"legend\">");
    for (look, name, joined) in looks {
        let _ = write!(html, "<span>{}{}</span>", key(look, joined), escape(&name));
    }
    html + "</div>\n"
}

/// The split of wall time in the series with default settings.
fn phases(study: &Study<'_>) -> String {
    let mut html = String::from("<h3>Where the time goes</h3>\n<div class=\"legend\">");
    let names = crate::record::Phases::default().entries();
    for (k, (name, _)) in names.iter().enumerate() {
        let _ = write!(html, "<span><i class=\"swatch p{k}\"></i>{name}</span>");
    }
    html.push_str("</div>\n<div class=\"phases\">\n");
    for series in study.series().iter().filter(|series| series.is_default()) {
        for run in series.runs.iter().filter(|run| run.result().converged()) {
            let (case, cost) = (run.case(), &run.result().cost);
            let entries = cost.phases.entries().into_iter().enumerate();
            let shares = entries.map(|(k, (name, s))| (k, s, format!("{name}: {s:.3} s")));
            let _ = writeln!(
                html,
                "<span>P{}, level {}</span>{}<span>{:.2} s</span>",
                case.degree,
                case.level,
                bar(&shares.collect::<Vec<_>>()),
                cost.wall
            );
        }
    }
    html + "</div>\n"
}

/// A table as HTML; verdicts are coloured.
fn table(table: &Table) -> String {
    let mut html = String::from("<div class=\"scroll\"><table>\n");
    for (k, row) in table.rows().iter().enumerate() {
        let tag = if k == 0 { "th" } else { "td" };
        html.push_str("<tr>");
        for cell in row {
            let class = match cell.as_str() {
                "holds" => " class=\"good\"",
                "DOES NOT HOLD" => " class=\"bad\"",
                _ => "",
            };
            let _ = write!(html, "<{tag}{class}>{}</{tag}>", escape(cell));
        }
        html.push_str("</tr>\n");
    }
    html + "</table></div>\n"
}
