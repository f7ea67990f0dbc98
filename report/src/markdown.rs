//! The report as Markdown: everything but the plots.

use std::fmt::Write;

use crate::overview;
use crate::page::{ADVICE, Page, peers};
use crate::peers::SCENES;

/// The whole text.
pub fn markdown(page: &Page<'_>) -> String {
    let mut text =
        String::from("# Error against run time\n\n## Which program for which accuracy\n");
    for scene in &SCENES {
        let _ = write!(text, "\n### {}\n\n{}\n\n", scene.title, scene.about);
        for sentence in peers::sentences(page.peers, scene) {
            let _ = writeln!(text, "- {sentence}");
        }
        text.push('\n');
        text += &peers::runs(page.peers, scene).markdown();
    }
    text += "\n## What must hold\n\n";
    text += &overview::claims(page.studies).markdown();
    let _ = write!(text, "\n## What accuracy costs\n\n{ADVICE}\n\n");
    text += &overview::advice(page.studies).markdown();
    text += "\n## Machine and programs\n\n";
    for (name, value) in page.environment {
        let _ = writeln!(text, "- {name}: {value}");
    }
    for study in page.studies {
        let family = study.family;
        let _ = write!(
            text,
            "\n## {}\n\n{}\n\nReference: {}\n\nTheory: {}\n\nh: {}.\n\n",
            family.title, family.about, family.reference, family.theory, family.size
        );
        text += &overview::orders(study).markdown();
        text.push('\n');
        for remark in study.remarks() {
            let _ = writeln!(text, "- {remark}");
        }
        let _ = write!(text, "\n{}\n", family.causes);
        text.push('\n');
        text += &overview::runs(study).markdown();
    }
    text
}
