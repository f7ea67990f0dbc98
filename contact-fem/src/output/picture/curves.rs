//! Pictures of curves over labelled axes.

use std::path::Path;

use plotters::chart::{ChartBuilder, SeriesLabelPosition};
use plotters::element::{Circle, PathElement};
use plotters::series::LineSeries;
use plotters::style::{BLACK, Color, RGBColor, ShapeStyle, WHITE};

use super::{Canvas, DrawError, save, short};
use crate::error::Error;

/// One curve.
#[derive(Clone, Debug, PartialEq)]
pub struct Curve {
    /// The name in the legend, which is shown for more than one curve.
    pub name: String,
    /// (x, y) in order.
    pub points: Vec<(f64, f64)>,
}

/// Curves in one pair of axes.
#[derive(Clone, Debug, PartialEq)]
pub struct Curves {
    /// The title.
    pub title: String,
    /// The quantity on the x axis, with units.
    pub x_label: String,
    /// The quantity on the y axis, with units.
    pub y_label: String,
    /// The curves.
    pub curves: Vec<Curve>,
}

impl Curves {
    const SIZE: (u32, u32) = (900, 600);
    /// The height of the axes, and that of a line of the legend with its share of the border (pixels).
    const HEIGHT: f64 = 460.0;
    const ROW: f64 = 30.0;
    /// Colours that people with colour vision deficiency can distinguish.
    const COLOURS: [RGBColor; 7] = [
        RGBColor(0, 114, 178),
        RGBColor(213, 94, 0),
        RGBColor(0, 158, 115),
        RGBColor(204, 121, 167),
        RGBColor(86, 180, 233),
        RGBColor(230, 159, 0),
        RGBColor(0, 0, 0),
    ];

    /// The largest number of points of a curve that is drawn with a marker at each: a single point
    /// has no line.
    const MARKED: usize = 12;

    /// Draws the curves as SVG at `path`. Points that are no numbers, or beyond 1e290, are left out.
    ///
    /// # Errors
    /// [`Error::Write`].
    pub fn save(&self, path: impl AsRef<Path>) -> Result<(), Error> {
        let nothing = (f64::INFINITY, f64::NEG_INFINITY);
        let legend = SeriesLabelPosition::UpperLeft;
        save(path.as_ref(), Self::SIZE, |canvas| {
            self.draw(canvas, nothing, legend)
        })
    }

    /// As [`Curves::save`], with a y axis that begins at 0 and has room for the legend above the curves.
    pub(super) fn save_from_zero(&self, path: &Path) -> Result<(), Error> {
        let points = self.curves.iter().flat_map(finite);
        let highest = points.map(|(_, y)| y).fold(0.0, f64::max);
        let rows = match self.curves.len() {
            1 => 0.0,
            count => Self::ROW * count.min(12) as f64,
        };
        let shown = (0.0, highest * Self::HEIGHT / (Self::HEIGHT - rows));
        let legend = SeriesLabelPosition::UpperRight;
        save(path, Self::SIZE, |canvas| self.draw(canvas, shown, legend))
    }

    fn draw(
        &self,
        canvas: &Canvas<'_>,
        shown: (f64, f64),
        legend: SeriesLabelPosition,
    ) -> Result<(), DrawError> {
        let range = |of: fn(&(f64, f64)) -> f64, ends: (f64, f64)| {
            let points = self.curves.iter().flat_map(finite);
            let (low, high) = points.fold(ends, |(low, high), point| {
                (low.min(of(&point)), high.max(of(&point)))
            });
            match low < high {
                true => low..high + 0.03 * (high - low),
                false if low == high => low - 0.5..high + 0.5,
                false => 0.0..1.0,
            }
        };
        let none = (f64::INFINITY, f64::NEG_INFINITY);
        let (x_range, y_range) = (range(|p| p.0, none), range(|p| p.1, shown));
        let mut chart = ChartBuilder::on(canvas)
            .caption(&self.title, ("sans-serif", 26))
            .margin(20)
            .x_label_area_size(60)
            .y_label_area_size(90)
            .build_cartesian_2d(x_range.clone(), y_range.clone())?;
        chart
            .configure_mesh()
            .x_desc(&self.x_label)
            .y_desc(&self.y_label)
            .x_label_formatter(&|x| short(nearly_zero(*x, &x_range)))
            .y_label_formatter(&|y| short(nearly_zero(*y, &y_range)))
            .label_style(("sans-serif", 18))
            .axis_desc_style(("sans-serif", 22))
            .light_line_style(BLACK.mix(0.0))
            .draw()?;
        for (curve, colour) in self.curves.iter().zip(Self::COLOURS.iter().cycle()) {
            let style = ShapeStyle::from(colour).stroke_width(3);
            let sample = move |(x, y)| PathElement::new([(x, y), (x + 24, y)], style);
            chart
                .draw_series(LineSeries::new(finite(curve), style))?
                .label(&curve.name)
                .legend(sample);
            if curve.points.len() <= Self::MARKED {
                let marks = finite(curve).map(|point| Circle::new(point, 5, style.filled()));
                chart.draw_series(marks)?;
            }
        }
        if self.curves.len() > 1 {
            chart
                .configure_series_labels()
                .position(legend)
                .background_style(WHITE)
                .border_style(BLACK)
                .label_font(("sans-serif", 18))
                .draw()?;
        }
        Ok(())
    }
}

/// The value of a tick; round-off around zero is removed.
fn nearly_zero(value: f64, range: &std::ops::Range<f64>) -> f64 {
    let noise = 1e-9 * (range.end - range.start);
    if value.abs() < noise { 0.0 } else { value }
}

/// The largest number that is drawn: differences and products of axes stay finite.
const LARGEST: f64 = 1e290;

fn finite(curve: &Curve) -> impl Iterator<Item = (f64, f64)> + '_ {
    let points = curve.points.iter().copied();
    points.filter(|(x, y)| x.abs() <= LARGEST && y.abs() <= LARGEST)
}
