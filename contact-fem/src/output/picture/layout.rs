//! Panels in a row with a colour bar to their right.

use plotters::element::{PathElement, Rectangle};
use plotters::prelude::Text;
use plotters::style::text_anchor::{HPos, Pos, VPos};
use plotters::style::{BLACK, Color, FontTransform, IntoFont, IntoTextStyle, TextStyle, WHITE};

use super::colours::Colours;
use super::{Canvas, DrawError, short};
use crate::tensor::Vector;

const TITLE: u32 = 40;
const LABEL: u32 = 32;

/// The layout, with lengths in pixels: panels in a row, the colour bar to their right.
pub(super) struct Layout {
    panels: u32,
    /// The point of the scene that is drawn at the upper left of every panel (UL).
    corner: Vector<2>,
    /// The scale (pixels per UL).
    scale: f64,
    height: u32,
    /// The height of the strip below the panels.
    bottom: u32,
}

impl Layout {
    const PANEL: u32 = 760;
    const GAP: u32 = 30;
    const TOP: u32 = 80;
    const BAR: u32 = 34;
    /// The width of the colour bar, its numbers and its label.
    const RIGHT: u32 = 210;

    /// The room below the panels for a scale of lengths and axes.
    pub const BOTTOM: u32 = 90;

    /// So many panels, in each of which all of these points have room, with room `bottom` below.
    pub fn new(panels: usize, points: impl Iterator<Item = Vector<2>>, bottom: u32) -> Self {
        let start: (Vector<2>, Vector<2>) = (
            Vector::repeat(f64::INFINITY),
            Vector::repeat(f64::NEG_INFINITY),
        );
        let (low, high) = points.fold(start, |(low, high), x| (low.inf(&x), high.sup(&x)));
        let extent = if panels == 0 {
            Vector::repeat(1.0)
        } else {
            high - low
        };
        let scale = f64::from(Self::PANEL) / extent[0].max(extent[1] / 2.0);
        Layout {
            panels: panels as u32,
            corner: Vector::<2>::new(low[0], high[1]),
            scale,
            height: ((scale * extent[1]).ceil() as u32).max(300),
            bottom,
        }
    }

    pub fn size(&self) -> (u32, u32) {
        let width = Self::GAP + self.panels * (Self::PANEL + Self::GAP) + Self::RIGHT;
        (width, Self::TOP + self.height + Self::GAP + self.bottom)
    }

    fn left(&self, panel: usize) -> u32 {
        Self::GAP + panel as u32 * (Self::PANEL + Self::GAP)
    }

    fn title(&self, panel: usize) -> (i32, i32) {
        let middle = self.left(panel) + Self::PANEL / 2;
        (middle as i32, Self::TOP as i32 / 2)
    }

    /// The place of a point in a panel (pixels, y downwards).
    pub fn place(&self, panel: usize, point: &Vector<2>) -> Vector<2> {
        let from_corner = (point - self.corner) * self.scale;
        let x = f64::from(self.left(panel)) + from_corner[0];
        let y = f64::from(Self::TOP) - from_corner[1];
        Vector::<2>::new(x, y)
    }

    /// The pixel of a point in a panel.
    pub fn pixel(&self, panel: usize, point: &Vector<2>) -> (i32, i32) {
        let place = self.place(panel, point);
        (place[0].round() as i32, place[1].round() as i32)
    }

    /// The corners of a panel: upper left, lower right.
    fn panel(&self, panel: usize) -> [(i32, i32); 2] {
        let (left, top) = (self.left(panel) as i32, Self::TOP as i32);
        [
            (left, top),
            (left + Self::PANEL as i32, top + self.height as i32),
        ]
    }

    /// A round length (UL) that is drawn with at most this many pixels, and its pixels.
    fn length(&self, most: f64) -> Option<(f64, i32)> {
        let power = 10f64.powf((most / self.scale).log10().floor());
        let digits = [5.0, 2.0, 1.0].map(|digit| digit * power);
        let length = digits
            .into_iter()
            .find(|length| length * self.scale <= most)?;
        Some((length, (length * self.scale).round() as i32))
    }
}

/// Draws below the first panel how long a length is, and the axes: their names, and their directions in the picture.
pub(super) fn scale<'a>(
    canvas: &Canvas<'_>,
    layout: &Layout,
    axes: impl Iterator<Item = (&'a str, [f64; 2])>,
) -> Result<(), DrawError> {
    const AXIS: f64 = 55.0;
    let line = BLACK.stroke_width(3);
    let (left, y) = (Layout::GAP as i32, layout.size().1 as i32 - 40);
    if let Some((length, pixels)) = layout.length(240.0) {
        let right = left + pixels;
        canvas.draw(&PathElement::new(vec![(left, y), (right, y)], line))?;
        for x in [left, right] {
            canvas.draw(&PathElement::new(vec![(x, y - 8), (x, y + 8)], line))?;
        }
        let label = format!("{} UL", short(length));
        canvas.draw(&Text::new(label, (right + 14, y), text(LABEL, HPos::Left)))?;
    }
    let origin = (left + 520, y + 10);
    for (name, direction) in axes {
        let at = |length: f64| {
            let [x, y] = direction.map(|along| (along * length).round() as i32);
            (origin.0 + x, origin.1 - y)
        };
        canvas.draw(&PathElement::new(vec![origin, at(AXIS)], line))?;
        let end = at(AXIS + 16.0);
        canvas.draw(&Text::new(name, end, text(LABEL, HPos::Center)))?;
    }
    Ok(())
}

/// A name in a panel, and where it should be.
pub(super) struct Label {
    pub name: String,
    /// The point of the scene that it names (UL).
    pub at: Vector<2>,
    /// The side of the point on which it is (y upwards); zero for on the point itself.
    pub side: Vector<2>,
}

/// Draws names in a panel with a white border, beside each other and within the panel.
pub(super) fn labels(
    canvas: &Canvas<'_>,
    layout: &Layout,
    panel: usize,
    labels: &[Label],
) -> Result<(), DrawError> {
    const SIZE: i32 = 28;
    let [(left, top), (right, bottom)] = layout.panel(panel);
    let mut taken: Vec<[i32; 4]> = Vec::new();
    for label in labels {
        let half = label.name.chars().count() as i32 * SIZE * 11 / 40;
        let (x, y) = layout.pixel(panel, &label.at);
        let away =
            f64::from(half) * label.side[0].abs() + f64::from(SIZE / 2) * label.side[1].abs();
        let away = match label.side.norm() > 0.0 {
            true => label.side * (away + 16.0),
            false => Vector::zeros(),
        };
        let x = x
            .saturating_add(away[0].round() as i32)
            .min(right - half)
            .max(left + half);
        let y = y.saturating_sub(away[1].round() as i32);
        let lines = [0, 1, -1, 2, -2, 3, -3].map(|line| {
            let y = y
                .saturating_add(line * SIZE)
                .min(bottom - SIZE / 2)
                .max(top + SIZE / 2);
            [x - half, x + half, y - SIZE / 2, y + SIZE / 2]
        });
        let is_free = |own: &[i32; 4]| {
            let meets = |other: &[i32; 4]| {
                own[0] < other[1] && other[0] < own[1] && own[2] < other[3] && other[2] < own[3]
            };
            !taken.iter().any(meets)
        };
        let place = *lines.iter().find(|own| is_free(own)).unwrap_or(&lines[0]);
        taken.push(place);
        let middle = (x, (place[2] + place[3]) / 2);
        let style = text(SIZE as u32, HPos::Center);
        let around = [
            (-2, 0),
            (2, 0),
            (0, -2),
            (0, 2),
            (-1, -1),
            (1, 1),
            (-1, 1),
            (1, -1),
        ];
        for (dx, dy) in around {
            let white = style.clone().color(&WHITE);
            let at = (middle.0 + dx, middle.1 + dy);
            canvas.draw(&Text::new(label.name.as_str(), at, white))?;
        }
        canvas.draw(&Text::new(label.name.as_str(), middle, style))?;
    }
    Ok(())
}

/// Draws the title of a panel.
pub(super) fn title(
    canvas: &Canvas<'_>,
    layout: &Layout,
    panel: usize,
    title: &str,
) -> Result<(), DrawError> {
    canvas.draw(&Text::new(
        title,
        layout.title(panel),
        text(TITLE, HPos::Center),
    ))
}

/// Draws the scale of the colours, with the name of the field.
pub(super) fn colour_bar(
    canvas: &Canvas<'_>,
    layout: &Layout,
    colours: &Colours,
    label: &str,
) -> Result<(), DrawError> {
    const STRIPES: i32 = 128;
    let left = (layout.size().0 - Layout::RIGHT) as i32;
    let right = left + Layout::BAR as i32;
    let (top, height) = (Layout::TOP as i32, layout.height as i32);
    let y = |share: f64| top + (f64::from(height) * (1.0 - share)).round() as i32;
    let span = colours.high - colours.low;
    for k in (0..STRIPES).rev() {
        // each stripe extends to the bottom, so that there are no seams
        let (from, to) = (f64::from(k), f64::from(k + 1));
        let (from, to) = (from / f64::from(STRIPES), to / f64::from(STRIPES));
        let value = colours.low + 0.5 * (from + to) * span;
        let stripe = [(left, y(to)), (right, y(0.0))];
        canvas.draw(&Rectangle::new(stripe, colours.of(value).filled()))?;
    }
    let frame = [(left, top), (right, top + height)];
    canvas.draw(&Rectangle::new(frame, BLACK.stroke_width(2)))?;
    if let Some(beyond) = colours.beyond() {
        canvas.draw(&Text::new(
            beyond,
            (left, top - 36),
            text(LABEL, HPos::Left),
        ))?;
    }
    for (value, label) in colours.ticks(f64::from(LABEL) / f64::from(height)) {
        let at = y((value - colours.low) / span.max(f64::MIN_POSITIVE));
        let mark = vec![(right, at), (right + 8, at)];
        canvas.draw(&PathElement::new(mark, BLACK.stroke_width(2)))?;
        let beside = text(LABEL, HPos::Left);
        canvas.draw(&Text::new(label, (right + 14, at), beside))?;
    }
    let upright = ("sans-serif", LABEL)
        .into_font()
        .transform(FontTransform::Rotate270)
        .into_text_style(canvas)
        .pos(Pos::new(HPos::Center, VPos::Center));
    let middle = (right + 135, top + height / 2);
    canvas.draw(&Text::new(label.to_string(), middle, upright))
}

fn text(size: u32, side: HPos) -> TextStyle<'static> {
    let style = TextStyle::from(("sans-serif", size).into_font());
    style.pos(Pos::new(side, VPos::Center))
}
