//! Colour scales.

use plotters::prelude::{ColorMap, ViridisRGB};
use plotters::style::RGBColor;

use super::short;

/// A range of values, from dark to bright.
#[derive(Default)]
pub(super) struct Colours {
    pub low: f64,
    pub high: f64,
    /// The largest value, which may be above `high`.
    pub highest: f64,
}

impl Colours {
    /// Of values that are no numbers, or of which the range is none.
    const NONE: RGBColor = RGBColor(190, 190, 190);

    /// Whether there are values above `high`.
    fn is_cut(&self) -> bool {
        self.highest > self.high
    }

    /// The largest value, if it is beyond the scale.
    pub fn beyond(&self) -> Option<String> {
        let rounded = format!("{:.4e}", self.highest)
            .parse()
            .unwrap_or(self.highest);
        self.is_cut().then(|| format!("max {}", short(rounded)))
    }

    /// The colour of a value.
    pub fn of(&self, value: f64) -> RGBColor {
        let span = (self.high - self.low).max(f64::MIN_POSITIVE);
        let share = ((value - self.low) / span).clamp(0.0, 1.0);
        match share.is_nan() || !span.is_finite() {
            true => Self::NONE,
            false => ViridisRGB.get_color(share),
        }
    }

    /// Round numbers within the range, about five, with their labels; and the upper end if values
    /// exceed it, with the share `clear` of the range below it for its label.
    pub fn ticks(&self, clear: f64) -> Vec<(f64, String)> {
        let span = self.high - self.low;
        if !(span > 0.0) {
            return vec![(self.low, short(self.low))];
        }
        if !span.is_finite() {
            return Vec::new();
        }
        let power = 10f64.powf((span / 5.0).log10().floor());
        let steps = [1.0, 2.0, 5.0, 10.0].map(|digit| digit * power);
        let step = steps.into_iter().find(|step| span / step <= 6.0);
        let step = step.unwrap_or(span);
        let first = (self.low / step).ceil() as i64;
        let last = (self.high / step).floor() as i64;
        let round = (first..=last).map(|k| k as f64 * step);
        if !self.is_cut() {
            return round.map(|tick| (tick, short(tick))).collect();
        }
        let others = round.filter(|tick| self.high - tick > clear * span);
        let ticks = others.map(|tick| (tick, short(tick)));
        let rounded = format!("{:.2e}", self.high).parse().unwrap_or(self.high);
        let end = (self.high, format!("≥ {}", short(rounded)));
        ticks.chain([end]).collect()
    }
}
