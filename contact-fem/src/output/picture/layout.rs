//! Panels in a row with a colour bar to their right.

use plotters::element::{PathElement, Rectangle};
use plotters::prelude::Text;
use plotters::style::text_anchor::{HPos, Pos, VPos};
use plotters::style::{BLACK, Color, FontTransform, IntoFont, IntoTextStyle, TextStyle};

use super::colours::Colours;
use super::{Canvas, DrawError};
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
}

impl Layout {
    const PANEL: u32 = 760;
    const GAP: u32 = 30;
    const TOP: u32 = 80;
    const BAR: u32 = 34;
    /// The width of the colour bar, its numbers and its label.
    const RIGHT: u32 = 210;

    /// So many panels, in each of which all of these points have room.
    pub fn new(panels: usize, points: impl Iterator<Item = Vector<2>>) -> Self {
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
        }
    }

    pub fn size(&self) -> (u32, u32) {
        let width = Self::GAP + self.panels * (Self::PANEL + Self::GAP) + Self::RIGHT;
        (width, Self::TOP + self.height + Self::GAP)
    }

    fn left(&self, panel: usize) -> u32 {
        Self::GAP + panel as u32 * (Self::PANEL + Self::GAP)
    }

    fn title(&self, panel: usize) -> (i32, i32) {
        let middle = self.left(panel) + Self::PANEL / 2;
        (middle as i32, Self::TOP as i32 / 2)
    }

    /// The pixel of a point in a panel.
    pub fn pixel(&self, panel: usize, point: &Vector<2>) -> (i32, i32) {
        let from_corner = (point - self.corner) * self.scale;
        let x = f64::from(self.left(panel)) + from_corner[0];
        let y = f64::from(Self::TOP) - from_corner[1];
        (x.round() as i32, y.round() as i32)
    }
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
    for (value, label) in colours.ticks() {
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
