//! The clock's offset in parts of the recording and in bands of period: what one number for all leaves out.
//!
//! In a part, or a band, what the test instrument reads beside the reference is fitted by −dB/dt and by the
//! field itself. Noise of the reference is in both columns and makes the coefficient of −dB/dt too small, by
//! a factor λ that would make any delay seem none, and sure. So the reference is moved by a little to either
//! side: the coefficient follows by λ times as much, and the delay is the coefficient over λ. Offsets that
//! are further apart than their uncertainties are not one clock: filters differ, or the clock wanders. Their
//! scatter is then the uncertainty.

use std::ops::Range;

use common::{ClockDifference, DelayBand, DelayBands, OffsetScatter, Quantity};
use estimate::spectrum::Spectrum;

use crate::look::Look;
use crate::prepare::Prepared;
use crate::{Error, TOLD_BELOW};
use axis::{Heard, OfAxis, OfBand, Seen};
use forms::Band;
use joined::Pair;
use offset::{Offset, mean, scatter};

mod axis;
mod forms;
mod offset;

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
/// A coefficient follows the reference by this share at least, or the offset would be known to nothing.
const FOLLOWS: f64 = 0.1;
/// Where it follows by more, all periods count as they are.
const ALL: f64 = 0.9;

/// Sets what parts and bands say, and widens the uncertainties of offset and rate by it.
pub fn judge(raw: &Pair, prepared: &mut Prepared) -> Result<(), Error> {
    if prepared.clock.is_none() {
        return Ok(());
    }
    let (together, look) = prepared.together(raw)?;
    let aside_s = ASIDE * together.step_s;
    let moved = |by_s: f64| -> Result<Pair, Error> {
        let mut pair = prepared.moved(raw, by_s);
        look.complete(&mut pair)?;
        Ok(pair)
    };
    let pairs = [moved(-aside_s)?, together, moved(aside_s)?];
    let pair = &pairs[1];
    let (octaves, rows) = (octaves(pair, &look), rows_of_parts(pair));
    // One axis after the other: each is many times as large as the readings.
    let axes: Vec<OfAxis<'_>> =
        (0..look.axes.len()).map(|axis| OfAxis { pairs: &pairs, look: &look, axis, aside_s }).collect();
    let (mut everywhere, mut of_bands, mut field) = (Vec::new(), Vec::new(), Vec::new());
    for axis in &axes {
        everywhere.push(axis.whole(&Heard::default())?);
        let (bands, spectrum) = axis.bands(&octaves)?;
        of_bands.push(bands);
        field.push(spectrum);
    }
    let bands = bands(pair, &look, &octaves, &of_bands, &field);
    let heard = Heard::of(bands.iter().map(|band| &band.told));
    let (mut within, mut of_parts) = (Vec::new(), vec![Vec::new(); rows.len()]);
    for axis in &axes {
        within.push(axis.whole(&heard)?);
        let of_axis = axis.in_parts(&rows, &heard)?;
        of_parts.iter_mut().zip(of_axis).for_each(|(known, of)| known.extend(of));
    }
    let of_parts: Vec<Offset> = of_parts.iter().filter_map(|known| mean(known)).collect();
    let follows = follows(&everywhere);
    let (shift_s, shift_ppm) = (prepared.shift.offset_s, 1e6 * prepared.shift.rate);
    if let Some(clock) = &mut prepared.clock {
        clock.rate_ppm = over(&clock.rate_ppm, shift_ppm, follows);
        clock.offset_s = match delay(&within).or_else(|| delay(&everywhere)) {
            Some(offset) if follows < ALL => Quantity::new(shift_s + offset.s, offset.std),
            _ => over(&clock.offset_s, shift_s, follows),
        };
        let bands = (bands.len() > 1).then(|| forms::told(bands, shift_s, pair.step_s));
        widen(clock, scatter(&of_parts), bands);
    }
    drop(pairs);
    prepared.settle(raw)
}

/// The delay that the axes show together; None where none shows it.
fn delay(axes: &[Seen]) -> Option<Offset> {
    mean(&axes.iter().filter_map(|seen| seen.delay(1.0)).collect::<Vec<_>>())
}

/// By how much the coefficient follows, the axes by their information; 1 where nothing is seen.
fn follows(axes: &[Seen]) -> f64 {
    let weight = |seen: &Seen| seen.late.std.powi(-2);
    let sum: f64 = axes.iter().map(|seen| seen.follows * weight(seen)).sum();
    let follows = sum / axes.iter().map(weight).sum::<f64>();
    if follows.is_finite() { follows.clamp(FOLLOWS, 1.0) } else { 1.0 }
}

/// What is left beside `moved`, over what it follows by.
fn over(of: &Quantity, moved: f64, follows: f64) -> Quantity {
    Quantity::new(moved + (of.value() - moved) / follows, of.std().unwrap_or(0.0) / follows)
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

/// Octaves of frequency, from high to low.
fn octaves(pair: &Pair, look: &Look) -> Vec<Range<f64>> {
    let lowest = FREQUENCIES / (pair.whole.len() as f64 * pair.step_s);
    let nyquist = 0.5 / pair.step_s;
    let noise = look.axes.iter().map(|axis| axis.noise.highest_hz());
    let mut highest = noise.fold(pair.highest_hz.unwrap_or(nyquist).min(nyquist), f64::min);
    let mut octaves = Vec::new();
    while highest / 2.0 >= lowest {
        octaves.push(highest / 2.0..highest);
        highest /= 2.0;
    }
    octaves
}

/// What is left of the offset, and the gain, in those octaves that say something of a delay, from short
/// periods to long.
fn bands(
    pair: &Pair,
    look: &Look,
    octaves: &[Range<f64>],
    of_axes: &[Vec<OfBand>],
    field: &[Spectrum],
) -> Vec<Band> {
    let mut bands = Vec::new();
    for (number, within) in octaves.iter().enumerate() {
        let delays: Vec<Offset> = of_axes.iter().filter_map(|of| of[number].delay).collect();
        let gains: Vec<Offset> = of_axes.iter().map(|of| of[number].gain).collect();
        let (Some(delay), Some(gain)) = (mean(&delays), mean(&gains)) else { continue };
        if delay.std < TELLS / within.end {
            let told = DelayBand {
                shortest_s: 1.0 / within.end,
                longest_s: 1.0 / within.start,
                delay_s: Quantity::new(delay.s, delay.std),
                gain: Quantity::new(gain.s, gain.std),
            };
            // The variance of a gain is what is left over the field, for each of the sines and cosines of
            // all axes.
            let length_s = pair.whole.len() as f64 * pair.step_s;
            let each = look.axes.len() as f64 * 2.0 * (within.end - within.start) * length_s;
            let frequency_hz = frequency(look, field, within);
            bands.push(Band { told, lowered: each * gain.std.powi(2), frequency_hz });
        }
    }
    bands
}

/// Root of the mean square of a band's frequencies, each by what the field there is over the noise.
fn frequency(look: &Look, field: &[Spectrum], within: &Range<f64>) -> f64 {
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
