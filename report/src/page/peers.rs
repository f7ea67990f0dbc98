//! The first screen: which program for which accuracy.

use std::fmt::Write;

use super::plot::{Curve, Look, Marker, Plot, escape, key};
use super::{STYLE, table};
use crate::peers::{Entry, SCENES, Scene, Stored, TARGETS};
use ipopt_contact_scenes::tables::{Table, digits};

const INTRODUCTION: &str = "<p>Each chart has one scene with a known solution, solved by all programs on the same meshes of Gmsh, by one machine in one \
    campaign, one run at a time with one thread. The error is that of the contact pressure in L² over the contact boundary, or of a mean displacement, relative, by one function for all \
    programs. Time is processor time: of this library and CalculiX that of the whole program with its files, of GetFEM and FreeFEM that from reading the mesh to the \
    solution. A line joins the runs of a program that no other run of it beats in both time and error. Programs ran with several settings. \
    This library writes two pressures, a recovered one and that of the multipliers (consistent). FreeFEM has cells with straight sides. GetFEM's multiplier has the degree of the cells, or is linear.</p>\n";

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
        let own = stored.of(scene).filter(|entry| entry.program == program);
        curves.push(curve(&own.collect::<Vec<_>>(), look(place), false));
        let best = stored.best(scene, program);
        curves.push(Curve {
            note: Some(program.to_string()),
            ..curve(&best, look(place), true)
        });
    }
    Plot {
        x: "processor time (s)".into(),
        y: format!("error of the {}", scene.quantity),
        curves,
        front: Vec::new(),
    }
}

/// The chart of a scene as a file of its own.
pub fn picture(stored: &Stored, scene: &Scene) -> String {
    let svg = plot(stored, scene).svg();
    let (head, rest) = svg.split_once('>').unwrap_or((&svg, ""));
    let head = head.replace("<svg ", "<svg xmlns=\"http://www.w3.org/2000/svg\" ");
    format!(
        "{head}>\n<style>\n{STYLE}</style>\n<rect class=\"paper\" width=\"100%\" height=\"100%\"/>{rest}"
    )
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

/// The sentences of a scene.
pub fn sentences(stored: &Stored, scene: &Scene) -> Vec<String> {
    let each = TARGETS.iter();
    each.map(|&target| stored.sentence(scene, target)).collect()
}

/// The section.
pub fn section(stored: &Stored) -> String {
    let mut html = INTRODUCTION.to_string();
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
