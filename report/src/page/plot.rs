//! Log–log plots and bars as SVG. Colours are those of the page's style, so that they follow its light or dark mode.

use std::fmt::Write;

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
    /// The number of its colour in the style.
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
    /// The curves.
    pub curves: Vec<Curve>,
    /// Points that no other beats, by rising x: a line below everything.
    pub front: Vec<(f64, f64)>,
}

const WIDTH: f64 = 400.0;
const HEIGHT: f64 = 300.0;
/// Left, top, right, bottom.
const MARGINS: [f64; 4] = [56.0, 10.0, 14.0, 42.0];

/// A logarithmic axis on a range of pixels.
#[derive(Clone, Copy, Debug)]
struct Scale {
    low: f64,
    high: f64,
    from: f64,
    to: f64,
}

impl Scale {
    /// Around all positive values, with some room; at least a decade.
    fn around(values: impl Iterator<Item = f64>, from: f64, to: f64) -> Self {
        let logs = values.filter(|v| *v > 0.0 && v.is_finite()).map(f64::log10);
        let (low, high) = logs.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), v| {
            (low.min(v), high.max(v))
        });
        if low > high {
            return Scale {
                low: 0.0,
                high: 1.0,
                from,
                to,
            };
        }
        let middle = 0.5 * (low + high);
        let half = (0.5 * (high - low)).max(0.5) * 1.08;
        Scale {
            low: middle - half,
            high: middle + half,
            from,
            to,
        }
    }

    fn at(&self, value: f64) -> f64 {
        let share = (value.log10() - self.low) / (self.high - self.low);
        self.from + share * (self.to - self.from)
    }

    /// Values in range with a line and a label as (mantissa, power of ten): every decade, or every second or third if
    /// there are many, or also their doubles and halves if there are few.
    fn ticks(&self) -> Vec<(f64, i32)> {
        let powers = self.low.floor() as i32..=self.high.floor() as i32;
        let step = ((self.high - self.low) / 6.0).ceil().max(1.0) as i32;
        let mantissas: &[f64] = match self.high - self.low < 2.0 {
            true => &[1.0, 2.0, 5.0],
            false => &[1.0],
        };
        let all = powers.filter(|k| k % step == 0);
        let all = all.flat_map(|k| mantissas.iter().map(move |&m| (m, k)));
        let inside = |(m, k): &(f64, i32)| {
            let log = m.log10() + f64::from(*k);
            (self.low..=self.high).contains(&log)
        };
        all.filter(inside).collect()
    }
}

impl Plot {
    /// Whether it has no point.
    pub fn is_empty(&self) -> bool {
        self.curves.iter().all(|curve| curve.points.is_empty())
    }

    /// As an SVG element.
    pub fn svg(&self) -> String {
        let [left, top, right, bottom] = MARGINS;
        let all = || self.curves.iter().flat_map(|curve| &curve.points);
        let x = Scale::around(all().map(|p| p.0), left, WIDTH - right);
        let y = Scale::around(all().map(|p| p.1), HEIGHT - bottom, top);
        let mut svg = format!(
            "<svg viewBox=\"0 0 {WIDTH} {HEIGHT}\" role=\"img\" aria-label=\"{} against {}\">\n",
            escape(&self.y),
            escape(&self.x)
        );
        self.grid(&x, &y, &mut svg);
        let place = |&(a, b): &(f64, f64)| (x.at(a), y.at(b));
        let front: Vec<_> = self.front.iter().map(place).collect();
        line(&front, "front", &mut svg);
        // from, to and height of what is written
        let mut notes: Vec<[f64; 3]> = Vec::new();
        for curve in &self.curves {
            let points: Vec<_> = curve.points.iter().map(place).collect();
            let Look {
                colour,
                marker,
                dashed,
            } = curve.look;
            if curve.joined {
                let dash = if dashed { " dashed" } else { "" };
                line(&points, &format!("line s{colour}{dash}"), &mut svg);
            }
            for (point, title) in points.iter().zip(&curve.titles) {
                mark(*point, marker, colour, title, &mut svg);
            }
            if let (Some(note), Some((a, b))) = (&curve.note, points.last()) {
                let (anchor, off) = if *a > WIDTH - 90.0 {
                    ("end", -7.0)
                } else {
                    ("start", 7.0)
                };
                let near_bottom = *b > HEIGHT - bottom - 18.0;
                let (mut height, step) = match near_bottom {
                    true => (b - 8.0, -12.0),
                    false => (b + 13.0, 12.0),
                };
                let width = 7.0 * note.chars().count() as f64;
                let from = if anchor == "end" {
                    a + off - width
                } else {
                    a + off
                };
                let to = from + width;
                let is_taken = |[left, right, y]: &[f64; 3], height: f64| {
                    *left < to && from < *right && (y - height).abs() < 12.0
                };
                while notes.iter().any(|note| is_taken(note, height)) {
                    height += step;
                }
                notes.push([from, to, height]);
                let _ = writeln!(
                    svg,
                    "<text class=\"note f{colour}\" x=\"{:.1}\" y=\"{height:.1}\" text-anchor=\"{anchor}\">{}</text>",
                    a + off,
                    escape(note)
                );
            }
        }
        svg + "</svg>\n"
    }

    /// Frame, decades and labels.
    fn grid(&self, x: &Scale, y: &Scale, svg: &mut String) {
        let (left, right, top, bottom) = (x.from, x.to, y.to, y.from);
        for (m, k) in x.ticks() {
            let a = x.at(m * 10f64.powi(k));
            let _ = writeln!(
                svg,
                "<path class=\"grid\" d=\"M{a:.1} {top:.1}V{bottom:.1}\"/>\
                 <text class=\"tick\" x=\"{a:.1}\" y=\"{:.1}\" text-anchor=\"middle\">{}</text>",
                bottom + 14.0,
                power(m, k)
            );
        }
        for (m, k) in y.ticks() {
            let b = y.at(m * 10f64.powi(k));
            let _ = writeln!(
                svg,
                "<path class=\"grid\" d=\"M{left:.1} {b:.1}H{right:.1}\"/>\
                 <text class=\"tick\" x=\"{:.1}\" y=\"{:.1}\" text-anchor=\"end\">{}</text>",
                left - 5.0,
                b + 3.5,
                power(m, k)
            );
        }
        let (cx, cy) = (0.5 * (left + right), 0.5 * (top + bottom));
        let _ = writeln!(
            svg,
            "<rect class=\"frame\" x=\"{left:.1}\" y=\"{top:.1}\" width=\"{:.1}\" height=\"{:.1}\"/>\n\
             <text class=\"label\" x=\"{cx:.1}\" y=\"{:.1}\" text-anchor=\"middle\">{}</text>\n\
             <text class=\"label\" transform=\"translate(12 {cy:.1}) rotate(-90)\" text-anchor=\"middle\">{}</text>",
            right - left,
            bottom - top,
            HEIGHT - 8.0,
            escape(&self.x),
            escape(&self.y)
        );
    }
}

/// m · 10ᵏ, m being left out if it is 1.
fn power(m: f64, k: i32) -> String {
    let factor = if m == 1.0 {
        String::new()
    } else {
        format!("{m}·")
    };
    format!("{factor}10<tspan class=\"power\" dy=\"-4\">{k}</tspan>")
}

fn line(points: &[(f64, f64)], class: &str, svg: &mut String) {
    if points.len() < 2 {
        return;
    }
    let path: Vec<String> = points
        .iter()
        .map(|(a, b)| format!("{a:.1} {b:.1}"))
        .collect();
    let _ = writeln!(svg, "<path class=\"{class}\" d=\"M{}\"/>", path.join("L"));
}

/// A marker with what it is as its title.
fn mark((a, b): (f64, f64), marker: Marker, colour: usize, title: &str, svg: &mut String) {
    let polygon = |corners: &[(f64, f64)]| {
        let corners: Vec<String> = corners
            .iter()
            .map(|(x, y)| format!("{:.1} {:.1}", a + x, b + y))
            .collect();
        format!("M{}Z", corners.join("L"))
    };
    const SQUARE: [(f64, f64); 4] = [(-3.2, -3.2), (3.2, -3.2), (3.2, 3.2), (-3.2, 3.2)];
    let (class, path) = match marker {
        Marker::Disc | Marker::Ring => {
            let circle = format!(
                "M{:.1} {b:.1}a3.5 3.5 0 1 0 7 0a3.5 3.5 0 1 0 -7 0Z",
                a - 3.5
            );
            (
                if marker == Marker::Disc {
                    "fill"
                } else {
                    "open"
                },
                circle,
            )
        }
        Marker::Square => ("fill", polygon(&SQUARE)),
        Marker::Frame => ("open", polygon(&SQUARE)),
        Marker::Triangle => ("fill", polygon(&[(0.0, -4.8), (4.3, 3.2), (-4.3, 3.2)])),
        Marker::Diamond => (
            "fill",
            polygon(&[(0.0, -5.0), (4.2, 0.0), (0.0, 5.0), (-4.2, 0.0)]),
        ),
        Marker::Plus => {
            let (left, top) = (a - 3.5, b - 3.5);
            ("open", format!("M{left:.1} {b:.1}h7M{a:.1} {top:.1}v7"))
        }
        Marker::Star => {
            let corner = |k: usize| {
                let r = if k % 2 == 0 { 6.0 } else { 2.6 };
                let angle = std::f64::consts::PI * (k as f64 / 5.0 - 0.5);
                (r * angle.cos(), r * angle.sin())
            };
            let corners: Vec<_> = (0..10).map(corner).collect();
            ("fill", polygon(&corners))
        }
    };
    let _ = writeln!(
        svg,
        "<path class=\"{class} s{colour} f{colour}\" d=\"{path}\"><title>{}</title></path>",
        escape(title)
    );
}

/// A look's line and marker, for legends.
pub fn key(look: Look, joined: bool) -> String {
    let mut svg = String::from("<svg class=\"key\" viewBox=\"0 0 34 14\">");
    if joined {
        let dash = if look.dashed { " dashed" } else { "" };
        line(
            &[(1.0, 7.0), (33.0, 7.0)],
            &format!("line s{}{dash}", look.colour),
            &mut svg,
        );
    }
    mark((17.0, 7.0), look.marker, look.colour, "", &mut svg);
    svg + "</svg>"
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
        let scale = Scale::around([1e-3, 1.0].into_iter(), 0.0, 100.0);
        assert_eq!(scale.ticks(), [-3, -2, -1, 0].map(|k| (1.0, k)));
        let (a, b, c) = (scale.at(1e-3), scale.at(1e-2), scale.at(1e-1));
        assert!((c - b - (b - a)).abs() < 1e-12 && a > 0.0 && scale.at(1.0) < 100.0);
        let wide = Scale::around([1e-14, 1.0].into_iter(), 0.0, 100.0);
        assert!((4..=7).contains(&wide.ticks().len()));
        let narrow = Scale::around([0.1, 0.3].into_iter(), 0.0, 100.0);
        assert_eq!(narrow.ticks(), [(5.0, -2), (1.0, -1), (2.0, -1), (5.0, -1)]);
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
