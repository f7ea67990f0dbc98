//! Pictures as SVG: deformed meshes, contact pressures and curves.

mod colours;
mod curves;
mod layout;
mod meshes;
mod pressures;
mod trails;
mod view;

pub use curves::{Curve, Curves};
pub use meshes::{MeshPicture, Panel};
pub use pressures::PressurePicture;

use std::path::Path;

use plotters::backend::SVGBackend;
use plotters::coord::Shift;
use plotters::drawing::{DrawingArea, IntoDrawingArea};
use plotters::style::WHITE;

use super::file;
use crate::error::Error;

/// The drawing area; coordinates in pixels, y downwards.
type Canvas<'a> = DrawingArea<SVGBackend<'a>, Shift>;
/// The error of drawing, which does not occur with text in memory.
type DrawError = plotters::drawing::DrawingAreaErrorKind<std::io::Error>;

/// Draws with `draw` on a white canvas of `size` pixels and puts the picture at `path`.
fn save(
    path: &Path,
    size: (u32, u32),
    draw: impl FnOnce(&Canvas<'_>) -> Result<(), DrawError>,
) -> Result<(), Error> {
    let mut text = String::new();
    {
        let canvas = SVGBackend::with_string(&mut text, size).into_drawing_area();
        canvas
            .fill(&WHITE)
            .and_then(|()| draw(&canvas))
            .and_then(|()| canvas.present())
            .map_err(|source| file::failed(path, source))?;
    }
    // full opacity is the default of SVG; thousands of polygons do not repeat it
    let text = text.replace(" opacity=\"1\"", "");
    file::replace(path, file::in_xml(&text).as_bytes())
}

/// A number with at most six significant digits, without trailing zeros.
fn short(value: f64) -> String {
    let rounded: f64 = format!("{value:.5e}").parse().unwrap_or(value);
    if rounded == 0.0 || (1e-3..1e6).contains(&rounded.abs()) {
        rounded.to_string()
    } else {
        format!("{rounded:e}")
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::output::Snapshot;
    use crate::output::snapshot::tests::{displaced, squares};

    fn written(name: &str, save: impl FnOnce(&Path) -> Result<(), Error>) -> String {
        let file = format!("contact-fem-{name}-{}.svg", std::process::id());
        let path = std::env::temp_dir().join(file);
        save(&path).expect("written");
        let text = std::fs::read_to_string(&path).expect("a picture");
        std::fs::remove_file(&path).expect("removed");
        assert!(
            text.starts_with("<svg") && text.ends_with("</svg>\n"),
            "{text}"
        );
        text
    }

    #[test]
    fn every_cell_of_every_panel_is_drawn() {
        let problem = squares();
        let rest = Snapshot::at_rest(&problem).expect("a snapshot");
        let pushed = displaced(&problem);
        let panel = |title: &str, snapshot| Panel {
            title: title.into(),
            snapshot,
        };
        let panels = vec![panel("a < b", &rest), panel("pushed", &pushed)];
        let picture = MeshPicture::von_mises(panels);
        let text = written("meshes", |path| picture.save(path, &problem));
        assert_eq!(text.matches("<polygon").count(), 2 * 4);
        assert!(text.contains("a &lt; b") && text.contains("von Mises stress (UF/UL²)"));
        let none = MeshPicture::von_mises(Vec::new());
        written("none", |path| none.save(path, &problem));
    }

    #[test]
    fn curves_survive_any_points() {
        for points in [
            vec![],
            vec![(1.0, 2.0)],
            vec![(0.0, 0.0), (1.0, f64::NAN), (2.0, 1e4)],
        ] {
            let curve = |name: &str| Curve {
                name: name.into(),
                points: points.clone(),
            };
            let curves = Curves {
                title: "title".into(),
                x_label: "x (UL)".into(),
                y_label: "y (UF)".into(),
                curves: vec![curve("one"), curve("two")],
            };
            let text = written("curves", |path| curves.save(path));
            assert!(text.contains("x (UL)") && text.contains("two"));
        }
    }

    #[test]
    fn titles_are_valid_in_xml() {
        let curves = Curves {
            title: "a\u{0}b\u{1b}[1m\u{ffff}\t& <".into(),
            x_label: "\u{8}".into(),
            y_label: String::new(),
            curves: Vec::new(),
        };
        let text = written("titles", |path| curves.save(path));
        let is_valid = |c: char| c >= ' ' && c != '\u{ffff}' || "\t\n\r".contains(c);
        assert!(text.chars().all(is_valid), "{text:?}");
        assert!(text.contains("a\u{fffd}b\u{fffd}[1m\u{fffd}") && text.contains("&amp; &lt;"));
    }

    #[test]
    fn numbers_are_short() {
        for (value, text) in [
            (0.0, "0"),
            (0.1 + 0.2, "0.3"),
            (1200.0, "1200"),
            (2e-9, "2e-9"),
        ] {
            assert_eq!(short(value), text);
        }
    }

    #[test]
    fn a_folder_that_is_not_there_is_an_error() {
        let nowhere = Path::new("/does/not/exist/picture.svg");
        let failed = save(nowhere, (10, 10), |_| Ok(()));
        assert!(matches!(failed, Err(Error::Write { path, .. }) if path == nowhere));
    }
}
