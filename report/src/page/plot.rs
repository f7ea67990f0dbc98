//! Log–log plots by plotters, which draws the pictures of runs, too; and bars, whose colours are those of the page's style.

use std::fmt::Write;

use plotters::backend::SVGBackend;
use plotters::chart::ChartBuilder;
use plotters::coord::Shift;
use plotters::coord::combinators::{BindKeyPoints, IntoLogRange};
use plotters::drawing::{DrawingArea, DrawingAreaErrorKind, IntoDrawingArea};
use plotters::element::{Circle, PathElement, Polygon, Text};
use plotters::series::{DashedLineSeries, LineSeries};
use plotters::style::text_anchor::{HPos, Pos, VPos};
use plotters::style::{Color, IntoTextStyle, RGBColor, ShapeStyle, WHITE};

/// The shape of a series' points.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Marker {
    /// ●
    Disc,
    /// ○
    Ring,
    /// ■
    Square,
    /// □
    Frame,
    /// ▲
    Triangle,
    /// ◆
    Diamond,
    /// +
    Plus,
    /// ★, of other programs
    Star,
}

/// How a series looks.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Look {
    /// The number of its colour.
    pub colour: usize,
    /// Its points.
    pub marker: Marker,
    /// Whether its line is dashed.
    pub dashed: bool,
}

/// A curve with its points.
#[derive(Clone, Debug)]
pub struct Curve {
    /// What its points show when the mouse is over them, one a point.
    pub titles: Vec<String>,
    /// Its look.
    pub look: Look,
    /// In the order of the line.
    pub points: Vec<(f64, f64)>,
    /// Whether points are joined.
    pub joined: bool,
    /// A word at its last point, such as an order.
    pub note: Option<String>,
}

/// A log–log plot.
#[derive(Clone, Debug)]
pub struct Plot {
    /// Label of the horizontal axis.
    pub x: String,
    /// Label of the vertical axis.
    pub y: String,
    /// Whether the vertical axis is in per cent of its values.
    pub in_percent: bool,
    /// The curves.
    pub curves: Vec<Curve>,
    /// Points that no other beats, by rising x: a line below everything.
    pub front: Vec<(f64, f64)>,
}

/// Pixels of a plot, which the page shows at half the size.
const SIZE: (u32, u32) = (800, 600);
const COLOURS: [RGBColor; 11] = [
    RGBColor(0x1f, 0x6f, 0xd1),
    RGBColor(0xd1, 0x49, 0x1f),
    RGBColor(0x6f, 0xa8, 0xe8),
    RGBColor(0xe8, 0x9a, 0x6f),
    RGBColor(0x2a, 0x9d, 0x5c),
    RGBColor(0x8e, 0x4e, 0xc6),
    RGBColor(0x6b, 0x72, 0x80),
    RGBColor(0x0f, 0x8b, 0x8d),
    RGBColor(0x11, 0x11, 0x11),
    RGBColor(0xc2, 0x18, 0x5b),
    RGBColor(0x79, 0x55, 0x48),
];
const FRONT: RGBColor = RGBColor(0xf0, 0xdf, 0xa0);
const RULE: RGBColor = RGBColor(0xd8, 0xdd, 0xe3);
const FONT: &str = "sans-serif";

type Canvas<'a> = DrawingArea<SVGBackend<'a>, Shift>;
type DrawError<'a> =
    DrawingAreaErrorKind<<SVGBackend<'a> as plotters::backend::DrawingBackend>::ErrorType>;

/// The logarithms of the ends of an axis around all positive values, with some room; at least a decade.
fn around(values: impl Iterator<Item = f64>) -> (f64, f64) {
    let logs = values.filter(|v| *v > 0.0 && v.is_finite()).map(f64::log10);
    let (low, high) = logs.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), v| {
        (low.min(v), high.max(v))
    });
    if low > high {
        return (0.0, 1.0);
    }
    let middle = 0.5 * (low + high);
    let half = (0.5 * (high - low)).max(0.5) * 1.08;
    (middle - half, middle + half)
}

/// Values with a line and a label: every decade, or every second or third if there are many, or also their doubles and halves if there are few.
fn ticks((low, high): (f64, f64)) -> Vec<f64> {
    let powers = low.floor() as i32..=high.floor() as i32;
    let step = ((high - low) / 6.0).ceil().max(1.0) as i32;
    let mantissas: &[f64] = match high - low < 2.0 {
        true => &[1.0, 2.0, 5.0],
        false => &[1.0],
    };
    let all = powers.filter(|k| k % step == 0);
    let all = all.flat_map(|k| mantissas.iter().map(move |m| m * 10f64.powi(k)));
    all.filter(|v| (low..=high).contains(&v.log10())).collect()
}

/// A value as a decimal number, or as m · 10ᵏ where that is shorter.
fn number(value: f64) -> String {
    let k = (value.log10() + 1e-9).floor() as i32;
    if (-3..=3).contains(&k) {
        return format!("{value:.*}", (-k).max(0) as usize);
    }
    let m = (value / 10f64.powi(k)).round();
    let digits = "⁰¹²³⁴⁵⁶⁷⁸⁹".chars().collect::<Vec<_>>();
    let superscript = |c: char| c.to_digit(10).map_or('⁻', |d| digits[d as usize]);
    let power: String = k.to_string().chars().map(superscript).collect();
    match m as i32 {
        1 => format!("10{power}"),
        m => format!("{m}·10{power}"),
    }
}

impl Plot {
    /// Whether it has no point.
    pub fn is_empty(&self) -> bool {
        self.curves.iter().all(|curve| curve.points.is_empty())
    }

    /// As an SVG element.
    pub fn svg(&self) -> String {
        let mut svg = String::new();
        let mut titles = String::new();
        let canvas = SVGBackend::with_string(&mut svg, SIZE).into_drawing_area();
        if let Err(error) = self
            .draw(&canvas, &mut titles)
            .and_then(|()| canvas.present())
        {
            unreachable!("drawing into a string failed: {error}");
        }
        drop(canvas);
        let label = format!("{} against {}", escape(&self.y), escape(&self.x));
        let svg = svg.replacen(
            "<svg ",
            &format!("<svg role=\"img\" aria-label=\"{label}\" "),
            1,
        );
        svg.replace("</svg>", &format!("{titles}</svg>"))
    }

    /// Draws everything, and writes what points show when the mouse is over them.
    fn draw<'a>(&self, canvas: &Canvas<'a>, titles: &mut String) -> Result<(), DrawError<'a>> {
        canvas.fill(&WHITE)?;
        let all = || self.curves.iter().flat_map(|curve| &curve.points);
        let (x, y) = (around(all().map(|p| p.0)), around(all().map(|p| p.1)));
        let ends = |(low, high): (f64, f64)| 10f64.powf(low)..10f64.powf(high);
        let mut chart = ChartBuilder::on(canvas)
            .margin(20)
            .x_label_area_size(64)
            .y_label_area_size(104)
            .build_cartesian_2d(
                ends(x).log_scale().with_key_points(ticks(x)),
                ends(y).log_scale().with_key_points(ticks(y)),
            )?;
        let of_y = |value: &f64| match self.in_percent {
            true => number(100.0 * value) + " %",
            false => number(*value),
        };
        chart
            .configure_mesh()
            .x_desc(&self.x)
            .y_desc(&self.y)
            .x_label_formatter(&|value| number(*value))
            .y_label_formatter(&of_y)
            .label_style((FONT, 21))
            .axis_desc_style((FONT, 23))
            .bold_line_style(RULE)
            .light_line_style(RULE.mix(0.0))
            .draw()?;
        chart.draw_series(LineSeries::new(
            self.front.iter().copied(),
            FRONT.stroke_width(14),
        ))?;
        for curve in &self.curves {
            let colour = COLOURS[curve.look.colour % COLOURS.len()];
            let points = curve.points.iter().copied();
            let style = colour.stroke_width(3);
            if curve.joined && curve.look.dashed {
                chart.draw_series(DashedLineSeries::new(points, 10, 7, style))?;
            } else if curve.joined {
                chart.draw_series(LineSeries::new(points, style))?;
            }
            for (&point, title) in curve.points.iter().zip(&curve.titles) {
                let at = chart.backend_coord(&point);
                mark(canvas, at, curve.look)?;
                let _ = writeln!(
                    titles,
                    "<circle cx=\"{}\" cy=\"{}\" r=\"12\" fill=\"transparent\"><title>{}</title></circle>",
                    at.0,
                    at.1,
                    escape(title)
                );
            }
        }
        // words lie above everything, where least is below them
        let at = |point: &(f64, f64)| chart.backend_coord(point);
        let mut taken: Vec<(i32, i32)> = Vec::new();
        for curve in &self.curves {
            taken.extend(curve.points.iter().map(at));
            for ends in curve.points.windows(2).filter(|_| curve.joined) {
                taken.extend(between(at(&ends[0]), at(&ends[1])));
            }
        }
        for curve in &self.curves {
            if let (Some(word), Some(point)) = (&curve.note, curve.points.last()) {
                let colour = COLOURS[curve.look.colour % COLOURS.len()];
                let place = Place::of(word, at(point), &taken);
                let style = (FONT, 23).into_text_style(canvas).color(&colour);
                let style = style.pos(Pos::new(HPos::Left, VPos::Center));
                let left = (place.left, place.height);
                canvas.draw(&Text::new(word.to_string(), left, style))?;
                taken.extend(place.all());
            }
        }
        Ok(())
    }
}

/// Points along a line, some pixels apart.
fn between(a: (i32, i32), b: (i32, i32)) -> impl Iterator<Item = (i32, i32)> {
    let (dx, dy) = (b.0 - a.0, b.1 - a.1);
    let count = dx.abs().max(dy.abs()) / 8;
    (1..count).map(move |k| (a.0 + dx * k / count, a.1 + dy * k / count))
}

/// Where a word is.
#[derive(Clone, Copy, Debug)]
struct Place {
    left: i32,
    width: i32,
    /// Of its middle.
    height: i32,
}

impl Place {
    /// A place near a point, that covers as few as may be of the `taken` points and is as near as may be.
    fn of(word: &str, (a, b): (i32, i32), taken: &[(i32, i32)]) -> Self {
        let width = 12 * word.chars().count() as i32;
        let [left, top] = [130, 30];
        let [right, bottom] = [SIZE.0 as i32 - 24 - width, SIZE.1 as i32 - 100];
        let sides = [a + 16, a - 16 - width, a - width / 2];
        let heights = (0..10).flat_map(|k| [b + 22 * k, b - 22 * k]);
        let places = heights.flat_map(|height| {
            sides.map(|left| Place {
                left,
                width,
                height,
            })
        });
        let inside = places.filter(|place| {
            (left..=right.max(left)).contains(&place.left) && (top..=bottom).contains(&place.height)
        });
        let cost = |place: &Place| {
            let covered = taken.iter().filter(|point| place.covers(**point)).count() as i32;
            let away = (place.left + width / 2 - a).abs() / 2 + (place.height - b).abs();
            40 * covered + away
        };
        let here = Place {
            left: a.clamp(left, right.max(left)),
            width,
            height: b,
        };
        inside.min_by_key(cost).unwrap_or(here)
    }

    /// Whether a marker there would be below the word.
    fn covers(&self, (x, y): (i32, i32)) -> bool {
        (self.left - 8..self.left + self.width + 8).contains(&x) && (y - self.height).abs() < 20
    }

    /// Points all over it.
    fn all(&self) -> impl Iterator<Item = (i32, i32)> + use<> {
        let height = self.height;
        (self.left..self.left + self.width)
            .step_by(8)
            .map(move |x| (x, height))
    }
}

/// A marker.
fn mark<'a>(canvas: &Canvas<'a>, (a, b): (i32, i32), look: Look) -> Result<(), DrawError<'a>> {
    let colour = COLOURS[look.colour % COLOURS.len()];
    let full = colour.filled();
    let open = colour.stroke_width(3);
    let ring = |style: ShapeStyle| Circle::new((a, b), 7, style);
    let corners = |own: &[(i32, i32)]| own.iter().map(|(x, y)| (a + x, b + y)).collect::<Vec<_>>();
    let polygon = |own: &[(i32, i32)]| Polygon::new(corners(own), full);
    const SQUARE: [(i32, i32); 5] = [(-6, -6), (6, -6), (6, 6), (-6, 6), (-6, -6)];
    match look.marker {
        Marker::Disc => canvas.draw(&ring(full)),
        Marker::Ring => {
            canvas.draw(&ring(WHITE.filled()))?;
            canvas.draw(&ring(open))
        }
        Marker::Square => canvas.draw(&polygon(&SQUARE)),
        Marker::Frame => {
            canvas.draw(&Polygon::new(corners(&SQUARE), WHITE.filled()))?;
            canvas.draw(&PathElement::new(corners(&SQUARE), open))
        }
        Marker::Triangle => canvas.draw(&polygon(&[(0, -10), (9, 6), (-9, 6)])),
        Marker::Diamond => canvas.draw(&polygon(&[(0, -10), (8, 0), (0, 10), (-8, 0)])),
        Marker::Plus => {
            canvas.draw(&PathElement::new(corners(&[(-7, 0), (7, 0)]), open))?;
            canvas.draw(&PathElement::new(corners(&[(0, -7), (0, 7)]), open))
        }
        Marker::Star => {
            let corner = |k: usize| {
                let r = if k % 2 == 0 { 12.0 } else { 5.0 };
                let angle = std::f64::consts::PI * (k as f64 / 5.0 - 0.5);
                (
                    (r * angle.cos()).round() as i32,
                    (r * angle.sin()).round() as i32,
                )
            };
            canvas.draw(&polygon(&(0..10).map(corner).collect::<Vec<_>>()))
        }
    }
}

/// A look's line and marker, for legends.
pub fn key(look: Look, joined: bool) -> String {
    let mut svg = String::new();
    let canvas = SVGBackend::with_string(&mut svg, (68, 28)).into_drawing_area();
    let style = COLOURS[look.colour % COLOURS.len()].stroke_width(3);
    let pieces: &[(i32, i32)] = match (joined, look.dashed) {
        (false, _) => &[],
        (true, false) => &[(2, 66)],
        (true, true) => &[(2, 14), (20, 32), (38, 50), (56, 66)],
    };
    let line = |&(from, to): &(i32, i32)| {
        canvas.draw(&PathElement::new(vec![(from, 14), (to, 14)], style))
    };
    let drawn = pieces
        .iter()
        .try_for_each(line)
        .and_then(|()| mark(&canvas, (34, 14), look));
    if let Err(error) = drawn.and_then(|()| canvas.present()) {
        unreachable!("drawing into a string failed: {error}");
    }
    drop(canvas);
    svg.replacen("<svg ", "<svg class=\"key\" ", 1)
}

/// Shares of a whole as one stacked bar: (number of the colour, share, title).
pub fn bar(shares: &[(usize, f64, String)]) -> String {
    let whole: f64 = shares.iter().map(|(_, share, _)| share).sum();
    let mut svg =
        String::from("<svg class=\"bar\" viewBox=\"0 0 400 14\" preserveAspectRatio=\"none\">");
    let mut from = 0.0;
    for (colour, share, title) in shares {
        let width = if whole > 0.0 {
            400.0 * share / whole
        } else {
            0.0
        };
        let _ = write!(
            svg,
            "<rect class=\"p{colour}\" x=\"{from:.2}\" y=\"0\" width=\"{width:.2}\" height=\"14\"><title>{}</title></rect>",
            escape(title)
        );
        from += width;
    }
    svg + "</svg>"
}

/// Text for HTML and SVG.
pub fn escape(text: &str) -> String {
    text.replace('&', "&amp;")
        .replace('<', "&lt;")
        .replace('>', "&gt;")
        .replace('"', "&quot;")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn decades_are_where_they_belong() {
        let range = around([1e-3, 1.0].into_iter());
        assert!(range.0 < -3.0 && range.1 > 0.0);
        let names = |range| ticks(range).into_iter().map(number).collect::<Vec<_>>();
        assert_eq!(names(range), ["0.001", "0.01", "0.1", "1"]);
        assert!((4..=7).contains(&ticks(around([1e-14, 1.0].into_iter())).len()));
        assert_eq!(
            names(around([0.1, 0.3].into_iter())),
            ["0.05", "0.1", "0.2", "0.5"]
        );
        assert_eq!([1e-12, 5e-6, 1e4].map(number), ["10⁻¹²", "5·10⁻⁶", "10⁴"]);
    }

    #[test]
    fn words_lie_beside_points_and_lines() {
        let all: Vec<(i32, i32)> = between((200, 200), (600, 200)).collect();
        assert!(all.len() > 30 && all.iter().all(|p| p.1 == 200));
        let place = Place::of("GetFEM", (600, 200), &all);
        assert!(!all.iter().any(|point| place.covers(*point)), "{place:?}");
        // at the edge it is on the other side of the point, and of the line
        let all: Vec<(i32, i32)> = between((300, 300), (770, 300)).collect();
        let place = Place::of("CalculiX", (770, 300), &all);
        assert!(place.left + place.width <= SIZE.0 as i32);
        assert!(!all.iter().any(|point| place.covers(*point)), "{place:?}");
        // one word does not lie on another
        let first = Place::of("FreeFEM", (400, 100), &[]);
        let words: Vec<(i32, i32)> = first.all().collect();
        let second = Place::of("GetFEM", (400, 100), &words);
        assert!(
            !words.iter().any(|point| second.covers(*point)),
            "{second:?}"
        );
    }

    #[test]
    fn nothing_and_zeros_make_a_plot_too() {
        let look = Look {
            colour: 0,
            marker: Marker::Disc,
            dashed: false,
        };
        let mut plot = Plot {
            x: "h".into(),
            y: "a < b".into(),
            in_percent: true,
            curves: Vec::new(),
            front: Vec::new(),
        };
        assert!(plot.svg().contains("a &lt; b"));
        plot.curves.push(Curve {
            titles: vec!["a".into()],
            look,
            points: vec![(1.0, 1.0)],
            joined: true,
            note: None,
        });
        let svg = plot.svg();
        assert!(!svg.contains("NaN") && !svg.contains("inf"), "{svg}");
    }
}
