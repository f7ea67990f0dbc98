//! Pictures as SVG: deformed meshes, contact pressures and curves.

mod colours;
mod curves;
mod depth;
mod layout;
mod meshes;
mod obstacles;
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
    use plotters::style::RGBColor;

    use super::*;
    use crate::element::{Element, P1, P2};
    use crate::mesh::generators::{Diagonals, cuboid, linspace, rectangle};
    use crate::model::Problem;
    use crate::output::Snapshot;
    use crate::output::snapshot::tests::{displaced, squares};
    use crate::tensor::Vector;
    use crate::{Body, Mesh, Motion, NeoHookean, Obstacle, Scene};

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

    /// A square of side 1 on a floor, under a disc that has come down by ½ to y = 1: the frame is from −0.08 to 1.08, 760 pixels wide, so
    /// that the floor is a line of that width. The frame's upper end is that of the picture.
    #[test]
    fn obstacles_are_drawn_where_they_are() {
        let square = rectangle(&[0.0, 1.0], &[0.0, 1.0], Diagonals::Rising).expect("a square");
        let mut body = Body::new(square, NeoHookean::new(10.0, 0.3).expect("a law"));
        body.prescribe("bottom", [Some(0.0); 2]).expect("held");
        let mut scene = Scene::new();
        let square = scene.add("square", body);
        let floor = Obstacle::half_space([0.0; 2], [0.0, 1.0]).expect("a floor");
        scene
            .obstacle("floor", square.on("bottom"), floor)
            .expect("an obstacle");
        let down = Motion::translation([0.0, -0.5]).expect("a motion");
        let disc = Obstacle::ball([0.5, 1.55], 0.05)
            .expect("a disc")
            .moving(down);
        scene
            .obstacle("disc", square.on("top"), disc)
            .expect("an obstacle");
        let problem = scene.problem().expect("a problem");
        let mut snapshot = Snapshot::at_rest(&problem).expect("a snapshot");
        for (time, names) in [(0.0, vec!["floor"]), (1.0, vec!["floor", "disc"])] {
            snapshot.load_factor = time;
            let panel = Panel {
                title: "one".into(),
                snapshot: &snapshot,
            };
            let picture = MeshPicture::von_mises(vec![panel]);
            let text = written("obstacles", |path| picture.save(path, &problem));
            let lines = text
                .lines()
                .filter(|line| line.contains("stroke=\"#6E6E6E\" stroke-width=\"3\""));
            let places: Vec<(f64, f64)> = lines.flat_map(places).collect();
            for name in ["square", "floor", "disc", "x", "y", "0.2 UL"] {
                let is_named = text.contains(&format!("\n{name}\n"));
                assert_eq!(
                    is_named,
                    name != "disc" || names.contains(&name),
                    "{name}: {text}"
                );
            }
            let floor = 80.0 + 760.0 / 1.16 * 1.08;
            let bottom = places.iter().filter(|(_, y)| (*y - floor).abs() < 1.0);
            let mut ends: Vec<f64> = bottom.map(|(x, _)| *x).collect();
            ends.sort_by(f64::total_cmp);
            assert_eq!(ends, [30.0, 790.0], "{places:?}");
            let middle = (30.0 + 760.0 * 0.58 / 1.16, 80.0 + 760.0 * 0.03 / 1.16);
            let (near, others): (Vec<_>, Vec<_>) = places.iter().copied().partition(|(x, y)| {
                ((x - middle.0).hypot(y - middle.1) - 760.0 * 0.05 / 1.16).abs() < 1.5
            });
            assert_eq!(others.len(), 2, "{others:?}");
            assert_eq!(near.is_empty(), time == 0.0);
        }
    }

    /// A small cube on a large one: nothing is before it, so that it is seen in the middle of all of its faces. The front half of
    /// the large one's top has a centre that is nearer than those.
    #[test]
    fn nothing_behind_is_painted_over_what_is_before_it() {
        let mut scene = Scene::new();
        for (name, low, size) in [
            ("large", [-1.0, -1.0, 0.0], [2.0, 2.0, 1.0]),
            ("small", [-0.2, -0.2, 1.0], [0.4; 3]),
        ] {
            let mesh = cuboid(low, size, [1; 3]).expect("a mesh");
            let mut body = Body::new(mesh, NeoHookean::new(10.0, 0.3).expect("a law"));
            body.prescribe("bottom", [Some(0.0); 3]).expect("held");
            scene.add(name, body);
        }
        let problem = scene.problem().expect("a problem");
        let mut snapshot = Snapshot::at_rest(&problem).expect("a snapshot");
        let of_large = problem.scene().bodies()[0].mesh().len();
        for cell in &mut snapshot.cells[of_large..] {
            cell.sigma.fill_diagonal(0.0);
            cell.sigma[(0, 1)] = 1.0;
            cell.sigma[(1, 0)] = 1.0;
        }
        let panel = Panel {
            title: "one".into(),
            snapshot: &snapshot,
        };
        let picture = MeshPicture::von_mises(vec![panel]);
        let text = written("depth", |path| picture.save(path, &problem));
        let polygons: Vec<&str> = text
            .lines()
            .filter(|line| line.contains("<polygon"))
            .collect();
        let RGBColor(r, g, b) = colours::Colours::default().of(1.0);
        let top = format!("fill=\"#{r:02X}{g:02X}{b:02X}\"");
        let is_small = |line: &&str| line.contains(&top);
        let small = polygons.iter().filter(|line| is_small(line));
        let middles: Vec<(f64, f64)> = small.map(|line| middle(&places(line))).collect();
        assert_eq!((middles.len(), polygons.len()), (6, 12));
        for at in middles {
            let covers = |line: &&&str| is_inside(&places(line), at);
            let seen = polygons.iter().rev().find(covers).expect("itself");
            assert!(is_small(seen), "{at:?}");
        }
    }

    fn middle(corners: &[(f64, f64)]) -> (f64, f64) {
        let count = corners.len() as f64;
        let sum = corners
            .iter()
            .fold((0.0, 0.0), |sum, x| (sum.0 + x.0, sum.1 + x.1));
        (sum.0 / count, sum.1 / count)
    }

    fn is_inside(corners: &[(f64, f64)], at: (f64, f64)) -> bool {
        let sides = corners.iter().zip(corners.iter().cycle().skip(1));
        let turn = |(a, b): (&(f64, f64), &(f64, f64))| {
            (b.0 - a.0) * (at.1 - a.1) - (b.1 - a.1) * (at.0 - a.0)
        };
        let turns: Vec<f64> = sides.map(turn).collect();
        turns.iter().all(|t| *t >= 0.0) || turns.iter().all(|t| *t <= 0.0)
    }

    /// One boundary on two obstacles: two curves, each with the name of its place and 0 in its own middle.
    #[test]
    fn each_place_of_contact_has_a_curve() {
        let xs = linspace(0.0, 12.0, 12);
        let block = rectangle(&xs, &[0.0, 1.0], Diagonals::Rising).expect("a mesh");
        let mut body = Body::new(block, NeoHookean::new(10.0, 0.3).expect("a law"));
        body.prescribe("top", [Some(0.0); 2]).expect("held");
        let mut scene = Scene::new();
        let block = scene.add("block", body);
        for (name, x) in [("left pin", 2.0), ("right pin", 9.0)] {
            let pin = Obstacle::ball([x, -1.0], 1.0).expect("a pin");
            scene
                .obstacle(name, block.on("bottom"), pin)
                .expect("an obstacle");
        }
        let problem = scene.problem().expect("a problem");
        let mut snapshot = Snapshot::at_rest(&problem).expect("a snapshot");
        assert!(
            PressurePicture::new(&problem, &snapshot)
                .expect("a snapshot")
                .is_none()
        );
        for (place, (x, p)) in snapshot.places.iter_mut().zip([(2.0, 5.0), (9.0, 4.0)]) {
            let nodes = problem.surfaces()[place.surface].nodes().iter();
            for (own, &node) in place.pressures.iter_mut().zip(nodes) {
                let is_near = (problem.reference()[node][0] - x).abs() < 0.5;
                *own = if is_near { p } else { 0.0 };
            }
        }
        let picture = PressurePicture::new(&problem, &snapshot);
        let picture = picture.expect("a snapshot").expect("a pressure");
        let text = written("places", |path| picture.save(path));
        for name in [
            "block bottom on left pin",
            "block bottom on right pin",
            "(UF/UL²)",
        ] {
            assert!(text.contains(name), "{name}: {text}");
        }
        let peaks = ["#0072B2", "#D55E00"].map(|colour| {
            let curves = drawn(&text, "<polyline", colour);
            assert_eq!((curves.len(), curves[0].len()), (1, 5), "{colour}");
            let higher = |a: &&(f64, f64), b: &&(f64, f64)| b.1.total_cmp(&a.1);
            *curves[0].iter().max_by(higher).expect("a peak")
        });
        assert!(
            peaks[0].0 == peaks[1].0 && peaks[0].1 < peaks[1].1,
            "{peaks:?}"
        );
    }

    /// Beyond the values that the colours resolve, the bar tells the largest one: 100 cells of equal area, one of which has 11 796.
    #[test]
    fn the_largest_value_is_told() {
        let colours = colours::Colours {
            low: 0.0,
            high: 3580.0,
            highest: 11796.34,
        };
        assert_eq!(colours.beyond().as_deref(), Some("max 11796"));
        assert_eq!(
            colours.ticks(0.1).last().map(|(_, label)| label.clone()),
            Some("≥ 3580".into())
        );
        let whole = colours::Colours {
            highest: 3580.0,
            ..colours
        };
        assert_eq!(whole.beyond(), None);
    }

    /// Values that are no numbers, or too large to draw, leave a picture all the same.
    #[test]
    fn numbers_beyond_all_pictures() {
        let problem = squares();
        for value in [f64::NAN, f64::INFINITY, 1e308, -1e308] {
            let mut snapshot = displaced(&problem);
            snapshot.cells[0].sigma.fill(value);
            let panel = Panel {
                title: "odd".into(),
                snapshot: &snapshot,
            };
            let picture = MeshPicture::von_mises(vec![panel]);
            let text = written("odd", |path| picture.save(path, &problem));
            assert_eq!(text.matches("<polygon").count(), 4, "{value}");
            let curves = Curves {
                title: String::new(),
                x_label: String::new(),
                y_label: String::new(),
                curves: vec![Curve {
                    name: "odd".into(),
                    points: vec![(0.0, value), (1.0, -value), (-value, value)],
                }],
            };
            written("odd-curves", |path| curves.save(path));
        }
    }

    /// Two held blocks, each with the pressures of `of` on its contact surface.
    fn pressed<const D: usize>(
        meshes: [Mesh<D>; 2],
        of: impl Fn(&str, &Vector<D>) -> f64,
    ) -> (Problem<D>, Snapshot<D>)
    where
        P1: Element<D>,
        P2: Element<D>,
    {
        let mut scene = Scene::new();
        let names = ["lower", "upper"];
        let sides = names.into_iter().zip(meshes).map(|(name, mesh)| {
            let mut body = Body::new(mesh, NeoHookean::new(10.0, 0.3).expect("a law"));
            body.prescribe_nodes(&[0, 1, 2], [Some(0.0); D])
                .expect("held");
            let side = if name == "lower" { "top" } else { "bottom" };
            scene.add(name, body).on(side)
        });
        let sides: Vec<_> = sides.collect();
        let [lower, upper] = [0, 1].map(|k| sides[k].clone());
        scene.contact(lower, upper).expect("a pair");
        let problem = scene.problem().expect("a problem");
        let mut snapshot = Snapshot::at_rest(&problem).expect("a snapshot");
        for place in &mut snapshot.places {
            let surface = &problem.surfaces()[place.surface];
            for (p, &node) in place.pressures.iter_mut().zip(surface.nodes()) {
                *p = of(names[surface.body()], &problem.reference()[node]);
            }
        }
        (problem, snapshot)
    }

    /// The corners of a polygon or a polyline.
    fn places(line: &str) -> Vec<(f64, f64)> {
        let list = line.split("points=\"").nth(1).expect("places");
        let list = list.split('"').next().unwrap_or_default();
        let place = |place: &str| {
            let (x, y) = place.split_once(',').expect("two");
            let number = |text: &str| text.parse().expect("a number");
            (number(x), number(y))
        };
        list.split_whitespace().map(place).collect()
    }

    /// The places of all polylines of more than two points with this colour, or of all polygons.
    fn drawn(text: &str, element: &str, with: &str) -> Vec<Vec<(f64, f64)>> {
        let lines = text.lines().filter(|line| line.contains(element));
        let places = lines.filter(|line| line.contains(with)).map(places);
        places.filter(|places| places.len() > 2).collect()
    }

    /// On a bottom of four facets and a top of five, both pressed at their left: by hand, centres of pressure are at 1.25 and 1, and
    /// curves end at the second unloaded node.
    #[test]
    fn pressures_in_the_plane_are_curves() {
        let block = |y: f64, cells: usize| {
            let xs = linspace(0.0, 4.0, cells);
            rectangle(&xs, &[y, y + 1.0], Diagonals::Rising).expect("a mesh")
        };
        let of = |name: &str, X: &Vector<2>| {
            let spacing = if name == "lower" { 1.0 } else { 0.8 };
            match (X[0] / spacing).round() as usize {
                1 => 3.0,
                2 => 1.0,
                _ => 0.0,
            }
        };
        let (problem, snapshot) = pressed([block(0.0, 4), block(1.1, 5)], of);
        let picture = PressurePicture::new(&problem, &snapshot);
        let picture = picture.expect("a snapshot").expect("a pressure");
        let text = written("pressure-2d", |path| picture.save(path));
        for name in ["lower top on upper", "upper bottom on lower"] {
            assert!(text.contains(name), "{text}");
        }
        let expected = [
            ("#0072B2", [-1.25, -0.25, 0.75, 1.75, 2.75]),
            ("#D55E00", [-1.0, -0.2, 0.6, 1.4, 2.2]),
        ];
        let curves = expected.map(|(colour, _)| {
            let mut found = drawn(&text, "<polyline", colour);
            assert_eq!(found.len(), 1, "{colour}: {text}");
            let mut curve = found.remove(0);
            curve.sort_by(|a, b| a.0.total_cmp(&b.0));
            curve
        });
        // the axes from the ends and the peak of the first curve
        let [first, last, peak] = [0, 4, 1].map(|k| curves[0][k]);
        let along = (last.0 - first.0) / 4.0;
        let up = (peak.1 - first.1) / 3.0;
        assert!(along > 50.0 && up < -50.0, "{first:?} {last:?} {peak:?}");
        for (curve, (_, lengths)) in curves.iter().zip(expected) {
            assert_eq!(curve.len(), 5);
            let points = lengths.into_iter().zip([0.0, 3.0, 1.0, 0.0, 0.0]);
            for ((x, y), (length, p)) in curve.iter().zip(points) {
                let place = (first.0 + along * (length + 1.25), first.1 + up * p);
                let off = (x - place.0).hypot(y - place.1);
                assert!(off < 2.0, "({x}, {y}) for {place:?}");
            }
        }
    }

    /// A pressure that is constant up to round-off is a level line at a height above zero.
    #[test]
    fn a_constant_pressure_is_a_level_line() {
        let block = |y: f64| rectangle(&[0.0, 1.0, 2.0, 3.0], &[y, y + 1.0], Diagonals::Rising);
        let of = |_: &str, X: &Vector<2>| 2.0 * (1.0 + 1e-13 * X[0]);
        let (problem, snapshot) = pressed([block(0.0), block(1.0)].map(|m| m.expect("mesh")), of);
        let picture = PressurePicture::new(&problem, &snapshot);
        let picture = picture.expect("a snapshot").expect("a pressure");
        let text = written("pressure-level", |path| picture.save(path));
        for colour in ["#0072B2", "#D55E00"] {
            let curve = drawn(&text, "<polyline", colour).remove(0);
            let heights = curve.iter().map(|(_, y)| *y);
            assert_eq!(curve.len(), 4);
            assert_eq!(heights.clone().reduce(f64::max), heights.reduce(f64::min));
        }
    }

    /// A top of two by two squares, loaded at x ≤ ½ alone: whichever way the squares are cut, four triangles have the whole pressure,
    /// two of them two thirds and two a third, and x is to the right. The other surface has none, and no panel.
    #[test]
    fn pressures_in_space_are_on_the_surface() {
        let cuboid = |z: f64| cuboid([0.0, 0.0, z], [1.0, 1.0, 0.5], [2, 2, 1]).expect("a mesh");
        let of = |name: &str, X: &Vector<3>| match name == "lower" && X[0] < 0.75 {
            true => 6.0,
            false => 0.0,
        };
        let (problem, snapshot) = pressed([cuboid(0.0), cuboid(0.6)], of);
        let picture = PressurePicture::new(&problem, &snapshot);
        let picture = picture.expect("a snapshot").expect("a pressure");
        let text = written("pressure-3d", |path| picture.save(path));
        assert!(
            text.contains("lower top on upper") && !text.contains("upper bottom"),
            "{text}"
        );
        assert!(text.contains("contact pressure (UF/UL²)"));
        let colours = colours::Colours {
            high: 6.0,
            ..colours::Colours::default()
        };
        let tiles = |p: f64| {
            let RGBColor(r, g, b) = colours.of(p);
            let tiles = drawn(
                &text,
                "<polygon",
                &format!("fill=\"#{r:02X}{g:02X}{b:02X}\""),
            );
            let x = tiles.iter().flatten().map(|(x, _)| *x);
            (tiles.len(), x.fold(f64::NEG_INFINITY, f64::max))
        };
        let [(whole, middle), (most, _), (least, right)] = [6.0, 4.0, 2.0].map(tiles);
        assert_eq!([whole, most, least], [4, 2, 2]);
        assert_eq!(text.matches("<polygon").count(), 8);
        assert!(right > middle + 100.0, "{right} {middle}");
    }

    #[test]
    fn nothing_is_drawn_where_nothing_presses() {
        let problem = squares();
        let rest = Snapshot::at_rest(&problem).expect("a snapshot");
        let picture = PressurePicture::new(&problem, &rest);
        assert!(picture.expect("a snapshot").is_none());
        let mut of_another = rest;
        of_another.pressures.push(1.0);
        assert!(PressurePicture::new(&problem, &of_another).is_err());
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
