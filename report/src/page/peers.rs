//! The first screen: which program for which accuracy.

use std::fmt::Write;

use super::plot::{Curve, Look, Marker, Plot, escape, key};
use super::table;
use crate::peers::{self, Entry, SCENES, Scene, Stored, TARGETS};
use ipopt_contact_scenes::tables::{Table, digits};

const INTRODUCTION: &str = "<p>Eight scenes, solved by four programs on one machine. The table has the cheapest program for an error, its processor time, and the next program with how many times \
    as long it takes. A dash: the scene's reference is not known that well.</p>\n\
    <p>Errors are relative: of the contact pressure in L², of a mean displacement, or of a force. Solid lines join the best runs of a program on given meshes, the same for all programs; dashed lines join \
    runs on meshes that a program refines by itself, with the time of all these meshes. Other points are other settings.</p>\n";

const HOW: &str = "<h2>How was this measured?</h2>\n<p>Gmsh made the meshes. All runs are of one campaign, one at a time, with one thread. The error is relative: that of the contact pressure in L² over \
    the contact boundary, of a mean displacement, or of a force, by one function for all programs. Time is processor time: of this library and CalculiX that of the whole program with its files, of \
    GetFEM and FreeFEM that from reading the mesh to the solution. Short runs are repeated, and the least time counts. Runs beside which other processes worked are left out.</p>\n\
    <p>A solid line joins the best runs of a program: no other run of the program is both faster and more accurate. A dashed line joins runs on meshes that a program refines by itself, from a coarse mesh \
    that knows nothing of the contact, with the time of all its meshes: <code>--accuracy</code> of this library, where the accuracy that is asked for is that of the energy norm, and <code>adaptmesh</code> of FreeFEM.</p>\n\
    <p>Programs ran with several settings. This library, ipopt-contact, writes two pressures, a recovered one and that of the multipliers (consistent), and solves by its default solver and by Ipopt. FreeFEM has cells \
    with straight sides; its pressures are projected or lumped. GetFEM's multiplier has the degree of the cells, or is linear, and r is its augmentation. K is the slope of CalculiX's penalty.</p>\n";

const ENDINGS: &str = "<p>Runs that a program says it solved, of all runs with all settings. Those of this library count only if its certificate holds. The \
    tables below say how each other run ended.</p>\n";

/// What a program looks like: its place among all of them.
fn look(place: usize) -> Look {
    let markers = [
        Marker::Disc,
        Marker::Triangle,
        Marker::Diamond,
        Marker::Star,
    ];
    Look {
        colour: [0, 1, 4, 5][place % 4],
        marker: markers[place % markers.len()],
        dashed: false,
    }
}

fn curve(entries: &[&Entry], look: Look, joined: bool) -> Curve {
    let points = entries
        .iter()
        .filter_map(|entry| Some((entry, entry.point()?)));
    let points: Vec<_> = points
        .filter(|(_, (s, error))| *s > 0.0 && *error > 0.0)
        .collect();
    Curve {
        titles: points
            .iter()
            .map(|(entry, (s, error))| format!("{}: error {error:.2e}, {s:.2} s", entry.title()))
            .collect(),
        look,
        joined: joined && points.len() > 1,
        points: points.into_iter().map(|(_, point)| point).collect(),
        note: None,
    }
}

fn plot(stored: &Stored, scene: &Scene) -> Plot {
    let mut curves = Vec::new();
    for (place, program) in stored.programs().into_iter().enumerate() {
        for is_adaptive in [false, true] {
            let own =
                |entry: &&Entry| entry.program == program && entry.is_adaptive() == is_adaptive;
            let all: Vec<&Entry> = stored.of(scene).filter(own).collect();
            let best = peers::best(all.iter().copied());
            let look = Look {
                dashed: is_adaptive,
                ..look(place)
            };
            let joined = curve(&best, look, true);
            curves.push(curve(&all, look, false));
            curves.push(Curve {
                note: (!joined.points.is_empty())
                    .then(|| program.to_string() + if is_adaptive { ", refining" } else { "" }),
                ..joined
            });
        }
    }
    Plot {
        x: "processor time (s)".into(),
        y: format!("error of the {}", scene.quantity),
        in_percent: true,
        curves,
        front: Vec::new(),
    }
}

/// All runs of a scene.
pub fn runs(stored: &Stored, scene: &Scene) -> Table {
    let columns = [
        "program",
        "cells",
        "mesh",
        "setting",
        "unknowns",
        "error",
        "CPU (s)",
        "most by least",
        "how it ended",
    ];
    let mut all = Table::new("peers", &columns);
    all.quiet = true;
    for entry in stored.of(scene) {
        let ended = match (&entry.failure, entry.is_disturbed) {
            (Some(why), _) => why.clone(),
            (None, true) => "solved; the machine was busy, and the run is not drawn".into(),
            (None, false) => "solved".into(),
        };
        all.push(vec![
            entry.program.clone(),
            format!("P{}", entry.degree),
            entry.mesh.clone(),
            entry.setting.clone(),
            entry.unknowns.map_or("-".into(), |n| n.to_string()),
            digits(entry.error),
            entry.seconds.map_or("-".into(), |s| format!("{s:.2}")),
            entry.scatter.map_or("-".into(), |s| format!("{s:.2}")),
            ended,
        ]);
    }
    all
}

/// The cheapest program for each accuracy, by scene.
pub fn advice(stored: &Stored) -> Table {
    let targets = TARGETS.map(|target| format!("{} %", 100.0 * target));
    let mut columns = vec!["scene"];
    columns.extend(targets.iter().map(String::as_str));
    let mut all = Table::new("advice", &columns);
    all.quiet = true;
    for scene in &SCENES {
        let cell = |target: &f64| {
            if scene.targets().all(|own| own != *target) {
                return "-".to_string();
            }
            let cheapest = stored.cheapest(scene, *target);
            let Some(((first, seconds), others)) = cheapest.split_first() else {
                return "none".to_string();
            };
            let next = others
                .first()
                .map_or("no other".to_string(), |(next, own)| {
                    format!("{} × {:.1}", next.program, own / seconds)
                });
            format!("{} {seconds:.2} s; {next}", first.program)
        };
        let cells = TARGETS.iter().map(cell);
        all.push(
            std::iter::once(scene.title.to_string())
                .chain(cells)
                .collect(),
        );
    }
    all
}

/// How the runs of each program ended, by scene.
pub fn endings(stored: &Stored) -> Table {
    let mut columns = vec!["program"];
    columns.extend(SCENES.iter().map(|scene| scene.title));
    let mut all = Table::new("endings", &columns);
    all.quiet = true;
    for program in stored.programs() {
        let cell = |scene: &Scene| {
            let own = stored.of(scene).filter(|entry| entry.program == program);
            let (good, bad): (Vec<&Entry>, Vec<&Entry>) =
                own.partition(|entry| entry.failure.is_none());
            match good.len() + bad.len() {
                0 => "not run".to_string(),
                count => format!("{} of {count}", good.len()),
            }
        };
        let cells = SCENES.iter().map(cell);
        all.push(std::iter::once(program.to_string()).chain(cells).collect());
    }
    all
}

/// The sentences of a scene, up to the first accuracy that no program reached.
pub fn sentences(stored: &Stored, scene: &Scene) -> Vec<String> {
    let is_reached = |target: &f64| !stored.cheapest(scene, *target).is_empty();
    let count = scene.targets().take_while(is_reached).count() + 1;
    let each = scene.targets().take(count);
    each.map(|target| stored.sentence(scene, target)).collect()
}

/// The section.
pub fn section(stored: &Stored) -> String {
    let mut html = INTRODUCTION.to_string() + &table(&advice(stored));
    html.push_str("<div class=\"legend\">");
    for (place, program) in stored.programs().into_iter().enumerate() {
        let of_program = stored.entries.iter().find(|entry| entry.program == program);
        let version = of_program.map_or(program, |entry| &entry.version);
        let _ = write!(
            html,
            "<span>{}{}</span>",
            key(look(place), true),
            escape(version)
        );
    }
    html.push_str("</div>\n<div class=\"plots two\">\n");
    for scene in &SCENES {
        let _ = write!(
            html,
            "<div><h3>{}</h3>\n{}",
            escape(scene.title),
            plot(stored, scene).svg()
        );
        for sentence in sentences(stored, scene) {
            let _ = writeln!(html, "<p>{}</p>", escape(&sentence));
        }
        let _ = writeln!(html, "<p class=\"about\">{}</p></div>", escape(scene.about));
    }
    html.push_str("</div>\n");
    html.push_str(HOW);
    html.push_str("<h2>How many runs were solved?</h2>\n");
    html.push_str(ENDINGS);
    html.push_str(&table(&endings(stored)));
    for scene in &SCENES {
        let _ = writeln!(
            html,
            "<details><summary>All runs: {}</summary>",
            escape(scene.title)
        );
        html.push_str(&table(&runs(stored, scene)));
        html.push_str("</details>\n");
    }
    let machine = stored.environment.iter();
    let machine: Vec<String> = machine
        .map(|(name, value)| format!("{name} {value}"))
        .collect();
    let _ = writeln!(
        html,
        "<p>Stored results of a campaign (`make report-peers`): {}.</p>",
        escape(&machine.join(", "))
    );
    html
}
