//! Levels of octaves over a form of noise.

use estimate::periodogram::Bin;

/// The lowest octave has so many degrees of freedom; each further one as many as all below it.
const LOWEST: f64 = 8.0;

/// The level of an octave over a form.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Octave {
    /// ln of its middle frequency (Hz).
    middle: f64,
    /// ln of what the ordinates are over the form, in the mean.
    ratio: f64,
    /// Standard uncertainty of that.
    std: f64,
}

/// By what the ordinates of octaves exceed a form, from the lowest on.
#[derive(Clone, Debug, Default)]
pub struct Octaves(Vec<Octave>);

impl Octaves {
    /// Of ordinates, from the lowest frequency on, over the density `form`.
    pub fn of(bins: &[Bin], form: impl Fn(f64) -> f64) -> Self {
        let mut octaves = Vec::new();
        let (mut below, mut own, mut power, mut middle) = (0.0, 0.0, 0.0, 0.0);
        for (place, bin) in bins.iter().enumerate() {
            // An ordinate has two degrees of freedom for each count of one.
            own += 2.0 * bin.count;
            power += 2.0 * bin.count * bin.density / form(bin.frequency_hz);
            middle += 2.0 * bin.count * bin.frequency_hz.ln();
            let whole = own >= LOWEST.max(below);
            if whole || (place + 1 == bins.len() && octaves.is_empty()) {
                let ratio = (power / own).max(f64::MIN_POSITIVE).ln();
                octaves.push(Octave { middle: middle / own, ratio, std: (2.0 / own).sqrt() });
                (below, own, power, middle) = (below + own, 0.0, 0.0, 0.0);
            }
        }
        Self(octaves)
    }

    /// Whether the form is taken as it is.
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// Level over the form at a frequency: on lines between the middles of octaves, in logarithms.
    pub fn ratio(&self, frequency_hz: f64) -> f64 {
        if self.is_empty() { 1.0 } else { self.at(frequency_hz, |octave| octave.ratio).exp() }
    }

    /// Standard uncertainty of that over it.
    pub fn relative_std(&self, frequency_hz: f64) -> f64 {
        if self.is_empty() { 0.0 } else { self.at(frequency_hz, |octave| octave.std) }
    }

    fn at(&self, frequency_hz: f64, of: impl Fn(&Octave) -> f64) -> f64 {
        let place = frequency_hz.ln();
        let after = self.0.partition_point(|octave| octave.middle < place);
        match (after.checked_sub(1).map(|before| &self.0[before]), self.0.get(after)) {
            (Some(low), Some(high)) => {
                let share = (place - low.middle) / (high.middle - low.middle);
                (1.0 - share) * of(low) + share * of(high)
            }
            (Some(end), None) | (None, Some(end)) => of(end),
            (None, None) => 0.0,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn octaves_have_their_levels() {
        let bin = |k: usize, density: f64| Bin { frequency_hz: k as f64, density, count: 0.5 };
        let level = |k: usize| if k <= 64 { 3.0 } else { 0.5 };
        let bins: Vec<Bin> = (1..=1024).map(|k| bin(k, 2.0 * level(k))).collect();
        let octaves = Octaves::of(&bins, |_| 2.0);
        assert!((octaves.ratio(2.0) - 3.0).abs() < 1e-9 && (octaves.ratio(30.0) - 3.0).abs() < 1e-9);
        assert!((octaves.ratio(400.0) - 0.5).abs() < 1e-9 && (octaves.ratio(1e4) - 0.5).abs() < 1e-9);
        assert!(octaves.relative_std(1.0) > 4.0 * octaves.relative_std(700.0));
        assert_eq!(Octaves::default().ratio(1.0), 1.0);
    }
}
