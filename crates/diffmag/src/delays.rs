//! The clock's offset in parts of the recording and in bands of period: what one number for all leaves out.
//!
//! In a part, or a band, what the test instrument reads beside the reference is fitted by −dB/dt and by the field itself. Noise of the
//! reference is in both columns and makes the coefficient of −dB/dt too small, by a factor λ that would make any delay seem none, and sure. So
//! the reference is moved by a little to either side: the coefficient follows by λ times as much, and the delay is the coefficient over λ. Offsets
//! that are further apart than their uncertainties are not one clock: filters differ, or the clock wanders. Their scatter is then the
//! uncertainty.

use std::ops::Range;

use common::number::{duration, p_value, significant, uncertain};
use common::{ClockDifference, DelayBand, DelayBands, DelayForm, OffsetScatter, Quantity};
use estimate::periodogram::periodogram;
use estimate::spectral::{Transform, Transformer};
use estimate::spectrum::{Spectrum, welch};
use estimate::stats;
use rayon::prelude::*;

use crate::clock::{Look, Parts};
use crate::difference::Noise;
use crate::prepare::Prepared;
use crate::series::Pair;
use crate::{Error, TOLD_BELOW, axes};
use average::Band;

mod average;
mod forms;

/// Rows of a part, and how many parts there are at least and at most.
const ROWS: [usize; 2] = [256, 64];
const PARTS: [usize; 2] = [8, 24];
/// Fewer of a part's rows than this share that are whole say nothing.
const WHOLE: f64 = 0.5;
/// A band holds at least so many frequencies of the transform.
const FREQUENCIES: f64 = 16.0;
/// A band says something of a delay that is known to this share of its shortest period.
const TELLS: f64 = 0.1;
/// What the reference is moved by to either side, in steps.
const ASIDE: f64 = 0.2;
/// Where the coefficient follows by less than this share, no delay is seen.
const FOLLOWS: f64 = 0.1;
/// Where it follows by more, all periods count as they are.
const ALL: f64 = 0.9;
/// Halvings in which the variance between offsets is sought.
const HALVINGS: usize = 60;
/// A band with less of the response is heard of one instrument alone.
const HEARD: f64 = 0.5;
/// Share of the rows over which each end is tapered: else the ends' mismatch would be most of what is fitted at short periods.
const TAPERED: f64 = 0.1;

/// An offset with its standard uncertainty.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Offset {
    s: f64,
    std: f64,
}

/// Sets what parts and bands say, and widens the uncertainties of offset and rate by it.
pub fn judge(raw: &Pair, prepared: &mut Prepared) -> Result<(), Error> {
    if prepared.clock.is_none() {
        return Ok(());
    }
    let (together, look) = prepared.together(raw)?;
    let aside_s = ASIDE * together.step_s;
    let moved = |by_s: f64| -> Result<[Parts; 3], Error> {
        let mut pair = prepared.moved(raw, by_s);
        look.complete(&mut pair)?;
        Ok(look.parts(&pair))
    };
    let three = Three {
        at: [moved(-aside_s)?, look.parts(&together), moved(aside_s)?],
        aside_s,
        step_s: together.step_s,
    };
    let bands = in_bands(&together, &look, &three)?;
    let heard = Heard::of(bands.iter().map(|band| &band.told));
    let (everywhere, follows) = three.whole(&look, &Heard::default())?;
    let (within, _) = three.whole(&look, &heard)?;
    let of_parts = in_parts(&together, &look, &three, &heard)?;
    let (shift_s, shift_ppm) = prepared.moved_by();
    if let Some(clock) = &mut prepared.clock {
        clock.rate_ppm = over(&clock.rate_ppm, shift_ppm, follows);
        clock.offset_s = match within.or(everywhere) {
            Some(offset) if follows < ALL => Quantity::new(shift_s + offset.s, offset.std),
            _ => over(&clock.offset_s, shift_s, follows),
        };
        let bands = (bands.len() > 1).then(|| forms::told(bands, shift_s, together.step_s));
        widen(clock, scatter(&of_parts), bands);
    }
    prepared.settle(raw)
}

/// Bands in which the reference's changes are seen in the test instrument.
#[derive(Default)]
struct Heard(Option<Vec<Range<f64>>>);

impl Heard {
    /// Those of half the response or more; where there is none, all.
    fn of<'a>(bands: impl Iterator<Item = &'a DelayBand>) -> Self {
        let heard: Vec<Range<f64>> = bands
            .filter(|band| band.gain.value() >= HEARD)
            .map(|band| 1.0 / band.longest_s..1.0 / band.shortest_s)
            .collect();
        Self((!heard.is_empty()).then_some(heard))
    }

    /// The density of noise for weights: infinite elsewhere.
    fn density(&self, noise: &Noise, f: f64) -> f64 {
        let within = self.0.as_ref().is_none_or(|bands| bands.iter().any(|band| band.contains(&f)));
        if within { noise.density(f) } else { f64::INFINITY }
    }
}

/// What is left beside `moved`, over what it follows by.
fn over(of: &Quantity, moved: f64, follows: f64) -> Quantity {
    Quantity::new(moved + (of.value() - moved) / follows, of.std().unwrap_or(0.0) / follows)
}

/// The instruments with the reference moved aside, where it is, and to the other side.
struct Three {
    at: [[Parts; 3]; 3],
    aside_s: f64,
    step_s: f64,
}

/// What one axis says of a delay.
struct Seen {
    /// Coefficient of −dB/dt, and by how much it follows the reference.
    late: Offset,
    follows: f64,
    gain: Offset,
    /// What the columns leave.
    left: Vec<f64>,
}

/// One axis over some rows, its ends tapered; the reference before, where it is, and after.
struct Tapered {
    transformer: Transformer,
    /// Of −dB/dt, the field and what the test instrument reads beside it.
    transforms: [[Transform; 3]; 3],
    /// −dB/dt and the field where the reference is, and what the test instrument reads beside it.
    columns: [Vec<f64>; 2],
    left: Vec<f64>,
    /// How many times as wide as without a taper uncertainties are.
    wider: f64,
    aside_s: f64,
    step_s: f64,
}

impl Tapered {
    /// The fit under noise of this density.
    fn seen(&self, density: &(dyn Fn(f64) -> f64 + Sync)) -> Result<Seen, Error> {
        let [before, here, after] = axes::try_each(|at| {
            let [late, turned, left] = &self.transforms[at];
            self.transformer.regress(&[late, turned], left, self.step_s, density)
        })?;
        let follows = (before.weighted[0] - after.weighted[0]) / (2.0 * self.aside_s);
        let of = |i: usize| self.wider * here.weighted_covariance[(i, i)].sqrt();
        Ok(Seen {
            late: Offset { s: here.weighted[0], std: of(0) },
            follows,
            gain: Offset { s: 1.0 + here.weighted[1], std: of(1) },
            left: crate::residual::rest(&self.columns, &self.left, &here.weighted),
        })
    }
}

impl Three {
    /// An axis over some rows.
    fn tapered(&self, axis: usize, rows: &Range<usize>) -> Tapered {
        let (taper, wider) = taper(rows.len());
        let cut = |values: &[f64]| -> Vec<f64> {
            let middle = stats::mean(&values[rows.clone()]);
            values[rows.clone()].iter().zip(&taper).map(|(value, w)| w * (value - middle)).collect()
        };
        let transformer = Transformer::new(rows.len());
        let transforms = axes::each(|at| {
            let of = &self.at[at][axis];
            [&of.late, &of.turned, &of.left].map(|values| transformer.transform(&cut(values)))
        });
        let here = &self.at[1][axis];
        Tapered {
            transformer,
            transforms,
            columns: [cut(&here.late), cut(&here.turned)],
            left: cut(&here.left),
            wider,
            aside_s: self.aside_s,
            step_s: self.step_s,
        }
    }

    /// What is left of the offset over all rows, and by how much the coefficient follows, the axes by their information; 1 where nothing
    /// is seen.
    fn whole(&self, look: &Look, heard: &Heard) -> Result<(Option<Offset>, f64), Error> {
        let rows = 0..self.at[1][0].left.len();
        let (mut delays, mut sum, mut weight) = (Vec::new(), 0.0, 0.0);
        for axis in 0..3 {
            let noise = &look.axes[axis].noise;
            let seen = self.tapered(axis, &rows).seen(&|f| heard.density(noise, f))?;
            sum += seen.follows * seen.late.std.powi(-2);
            weight += seen.late.std.powi(-2);
            delays.extend(seen.delay(1.0));
        }
        let follows = sum / weight;
        Ok((mean(&delays), if follows.is_finite() { follows.clamp(FOLLOWS, 1.0) } else { 1.0 }))
    }
}

impl Seen {
    /// The delay and its uncertainty; None where none is seen.
    fn delay(&self, wider: f64) -> Option<Offset> {
        let of = Offset { s: self.late.s / self.follows, std: wider * self.late.std / self.follows };
        (self.follows > FOLLOWS && of.s.is_finite() && of.std.is_finite()).then_some(of)
    }
}

/// A taper of mean square one, and how many times as wide as without it uncertainties are.
fn taper(rows: usize) -> (Vec<f64>, f64) {
    let reach = (TAPERED * rows as f64).max(1.0);
    let of = |row: usize| {
        let end = (row.min(rows - 1 - row) as f64 + 0.5) / reach;
        if end < 1.0 { (0.5 * std::f64::consts::PI * end).sin().powi(2) } else { 1.0 }
    };
    let plain: Vec<f64> = (0..rows).map(of).collect();
    let power = |n: i32| plain.iter().map(|w| w.powi(n)).sum::<f64>() / rows as f64;
    let size = power(2).sqrt();
    let wider = (power(4) / power(2).powi(2)).sqrt();
    (plain.into_iter().map(|w| w / size).collect(), wider)
}

/// The offset's uncertainty covers what parts and bands give.
fn widen(clock: &mut ClockDifference, parts: Option<OffsetScatter>, bands: Option<DelayBands>) {
    let std = |of: &Quantity| of.std().unwrap_or(0.0);
    let alike = |of: &OffsetScatter| of.p >= TOLD_BELOW;
    let birge = parts.as_ref().map_or(1.0, |of| of.birge_ratio.max(1.0));
    let of_parts = parts.as_ref().filter(|of| !alike(of)).map_or(0.0, |of| of.between_s);
    let of_bands =
        bands.as_ref().map(|of| &of.scatter).filter(|of| !alike(of)).map_or(0.0, |of| of.between_s);
    let plain = std(&clock.offset_s);
    let by = if of_parts > 0.0 { 1.0 } else { birge };
    clock.offset_s = Quantity::new(clock.offset_s.value(), (by * plain).hypot(of_parts.max(of_bands)));
    clock.rate_ppm = Quantity::new(clock.rate_ppm.value(), birge * std(&clock.rate_ppm));
    (clock.parts, clock.bands) = (parts, bands);
}

/// The rows of parts of much the same length, none of them across a jump.
fn rows_of_parts(pair: &Pair) -> Vec<Range<usize>> {
    let rows = pair.whole.len();
    let many = rows / ROWS[0];
    let length = if many >= PARTS[0] { rows / many.min(PARTS[1]) } else { (rows / PARTS[0]).max(ROWS[1]) };
    let of_segment = |rows: &Range<usize>| {
        let (start, length_of, count) = (rows.start, rows.len(), rows.len() / length);
        (0..count).map(move |k| start + k * length_of / count..start + (k + 1) * length_of / count)
    };
    let mut parts: Vec<Range<usize>> =
        pair.segments.iter().flat_map(|segment| of_segment(&segment.rows)).collect();
    parts.retain(|part| {
        let whole = pair.whole[part.clone()].iter().filter(|whole| **whole).count();
        whole as f64 >= WHOLE * part.len() as f64
    });
    parts
}

/// What is left of the offset in each part.
fn in_parts(pair: &Pair, look: &Look, three: &Three, heard: &Heard) -> Result<Vec<Offset>, Error> {
    let mut offsets = Vec::new();
    for rows in rows_of_parts(pair) {
        let part = pair.part(rows.clone());
        let mut known = Vec::new();
        for axis in 0..3 {
            let tapered = three.tapered(axis, &rows);
            let first = tapered.seen(&|f| heard.density(&look.axes[axis].noise, f))?;
            // Its own noise: a disturbed part knows less.
            let noise = Noise::seen(&first.left, &part)?;
            known.extend(tapered.seen(&|f| heard.density(&noise, f))?.delay(1.0));
        }
        offsets.extend(mean(&known));
    }
    Ok(offsets)
}

/// What is left of the offset, and the gain, in octaves of period, from short to long.
fn in_bands(pair: &Pair, look: &Look, three: &Three) -> Result<Vec<Band>, Error> {
    let rows = 0..pair.whole.len();
    let lowest = FREQUENCIES / (rows.len() as f64 * pair.step_s);
    let noise = look.axes.iter().map(|axis| axis.noise.highest_hz());
    let nyquist = 0.5 / pair.step_s;
    let mut highest = noise.fold(pair.highest_hz.unwrap_or(nyquist).min(nyquist), f64::min);
    let share = pair.samples() as f64 / rows.len() as f64;
    let segment = (rows.len() / 4).max(16);
    let field = three.at[1].each_ref().map(|parts| welch(&parts.turned, pair.step_s, segment));
    let [x, y, z] = field;
    let field = [x?, y?, z?];
    let mut octaves = Vec::new();
    while highest / 2.0 >= lowest {
        octaves.push(highest / 2.0..highest);
        highest /= 2.0;
    }
    let mut of_axes = Vec::new();
    for axis in 0..3 {
        let (noise, tapered) = (&look.axes[axis].noise, three.tapered(axis, &rows));
        let of_band = |within: &Range<f64>| {
            let density = |f: f64| if within.contains(&f) { noise.density(f) } else { f64::INFINITY };
            let seen = tapered.seen(&density)?;
            let ratios: Vec<f64> = periodogram(&seen.left, pair.step_s)?
                .bins
                .iter()
                .filter(|bin| within.contains(&bin.frequency_hz))
                .map(|bin| bin.density / (share * noise.density(bin.frequency_hz)))
                .collect();
            let wider = (ratios.iter().sum::<f64>() / ratios.len().max(1) as f64).max(1.0).sqrt();
            let gain = Offset { s: seen.gain.s, std: wider * seen.gain.std };
            Ok((seen.delay(wider), gain))
        };
        of_axes.push(octaves.par_iter().map(of_band).collect::<Result<Vec<_>, Error>>()?);
    }
    let mut bands = Vec::new();
    for (number, within) in octaves.into_iter().enumerate() {
        let delays: Vec<Offset> = of_axes.iter().filter_map(|of| of[number].0).collect();
        let gains: Vec<Offset> = of_axes.iter().map(|of| of[number].1).collect();
        let (Some(delay), Some(gain)) = (mean(&delays), mean(&gains)) else { continue };
        if delay.std < TELLS / within.end {
            let told = DelayBand {
                shortest_s: 1.0 / within.end,
                longest_s: 1.0 / within.start,
                delay_s: Quantity::new(delay.s, delay.std),
                gain: Quantity::new(gain.s, gain.std),
            };
            // The variance of a gain is what is left over the field, for each of the sines and cosines of three axes.
            let each = 3.0 * 2.0 * (within.end - within.start) * rows.len() as f64 * pair.step_s;
            let frequency_hz = frequency(look, &field, &within);
            bands.push(Band { told, lowered: each * gain.std.powi(2), frequency_hz });
        }
    }
    Ok(bands)
}

/// Root of the mean square of a band's frequencies, each by what the field there is over the noise.
fn frequency(look: &Look, field: &[Spectrum; 3], within: &Range<f64>) -> f64 {
    let (mut squares, mut weight) = (0.0, 0.0);
    for (axis, field) in look.axes.iter().zip(field) {
        for (f, density) in field.frequency_hz.iter().zip(&field.density).filter(|(f, _)| within.contains(f))
        {
            let tells = density / axis.noise.density(*f);
            squares += tells * f * f;
            weight += tells;
        }
    }
    if weight > 0.0 { (squares / weight).sqrt() } else { (within.start * within.end).sqrt() }
}

/// By their information; None where there is none.
fn mean(known: &[Offset]) -> Option<Offset> {
    let usable = || known.iter().filter(|of| of.s.is_finite() && of.std.is_finite() && of.std > 0.0);
    let weight: f64 = usable().map(|of| of.std.powi(-2)).sum();
    let sum: f64 = usable().map(|of| of.s * of.std.powi(-2)).sum();
    (weight > 0.0).then(|| Offset { s: sum / weight, std: weight.sqrt().recip() })
}

/// How offsets scatter: Q(τ²) = Σ (δ − δ̄)²/(σ² + τ²), δ̄ their mean with the same weights, is χ² at τ = 0 with one degree of freedom less than
/// there are if all are the same; the variance between them is the τ² at which Q is that number of degrees.
///
/// Sources: R. T. Birge, Phys. Rev. 40 (1932) 207–227; R. C. Paule and J. Mandel, J. Res. NBS 87 (1982) 377–385.
fn scatter(offsets: &[Offset]) -> Option<OffsetScatter> {
    let all = mean(offsets).filter(|_| offsets.len() > 1)?;
    let freedom = offsets.len() as f64 - 1.0;
    let q = |between: f64| -> f64 {
        let wider: Vec<Offset> =
            offsets.iter().map(|of| Offset { s: of.s, std: of.std.hypot(between) }).collect();
        let middle = mean(&wider).map_or(f64::NAN, |of| of.s);
        wider.iter().map(|of| ((of.s - middle) / of.std).powi(2)).sum()
    };
    // Beyond the range of all offsets Q is below one each.
    let (low, high) = offsets.iter().fold((all.s, all.s), |(low, high), of| (low.min(of.s), high.max(of.s)));
    let (mut from, mut to) = (0.0, high - low);
    for _ in 0..HALVINGS {
        let middle = 0.5 * (from + to);
        if q(middle) > freedom { from = middle } else { to = middle }
    }
    let alike = q(0.0);
    Some(OffsetScatter {
        count: offsets.len(),
        std_if_same_s: all.std,
        birge_ratio: (alike / freedom).sqrt(),
        p: stats::chi_squared_p(alike, freedom),
        between_s: if alike > freedom { from } else { 0.0 },
    })
}

/// What parts and bands say, in words.
pub fn findings(clock: &ClockDifference) -> Vec<String> {
    let mut findings = Vec::new();
    if let Some(parts) = clock.parts.as_ref().filter(|parts| parts.p < TOLD_BELOW) {
        findings.push(format!(
            "the clocks' offset is not the same in all parts of the recording: {} parts scatter by {} s, {} times their uncertainties ({}); its \
             uncertainty is that scatter",
            parts.count,
            significant(parts.between_s, 2),
            significant(parts.birge_ratio, 2),
            p_value(parts.p)
        ));
    }
    if let Some(length) = clock.bands.as_ref().and_then(|bands| bands.average_s.as_ref()) {
        let whose = if length.value() < 0.0 { "reference" } else { "test instrument" };
        findings.push(format!(
            "the response by period is as if the readings of the {whose} were means over {} s where the other's are not; half of that is in the offset of the \
             clocks where such a mean is stamped at its beginning or end",
            uncertain(length.value().abs(), length.std().unwrap_or(0.0))
        ));
    }
    let Some(bands) = clock.bands.as_ref().filter(|bands| bands.scatter.p < TOLD_BELOW) else {
        return findings;
    };
    let ends = [bands.bands.first(), bands.bands.last()].map(|band| {
        band.map_or_else(String::new, |band| {
            format!(
                "{} at periods of {} to {}",
                band.delay_in_words(),
                duration(band.shortest_s),
                duration(band.longest_s)
            )
        })
    });
    let form = match (bands.form, &bands.time_constant_s) {
        (DelayForm::LowPass, Some(time)) => {
            let whose = if time.value() < 0.0 { "reference" } else { "test instrument" };
            let size = uncertain(time.value().abs(), time.std().unwrap_or(0.0));
            format!("as of a low-pass filter of first order in the {whose}, with a time constant of {size} s")
        }
        _ => "not as of a low-pass filter of first order".into(),
    };
    findings.push(format!(
        "the delay depends on the period ({}): {} and {}, {form}. A filter is no clock: no shift of times mends it",
        p_value(bands.scatter.p),
        ends[0],
        ends[1]
    ));
    findings
}

#[cfg(test)]
mod tests {
    use super::*;
    use noise::Stream;

    #[test]
    fn a_scatter_is_told_from_uncertainties() {
        let (mut alike, mut apart) = (0, 0.0);
        for seed in 0..400 {
            let mut stream = Stream::new(seed, "offsets");
            let mut of = |between: f64| -> Vec<Offset> {
                let stds = (0..16).map(|k| 0.01 * f64::from(1 + k % 3));
                stds.map(|std| Offset { s: 0.1 + std * stream.normal() + between * stream.normal(), std })
                    .collect()
            };
            alike += usize::from(scatter(&of(0.0)).expect("offsets").p < TOLD_BELOW);
            apart += scatter(&of(0.05)).expect("offsets").between_s / 400.0;
        }
        assert!(alike <= 12, "{alike} of 400 at 1 %");
        assert!((apart - 0.05).abs() < 0.004, "{apart}");
    }
}
