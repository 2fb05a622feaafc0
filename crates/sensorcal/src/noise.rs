//! Noise of a sensor in a shield ("Measurement of Sensor Noise in Low Field").

use common::number::{bare, p_value, significant};
use common::{
    Axis, BandRms, Code, Document, Findings, MergedSpectrum, Noise, NoiseSeriesResult, Quantity, Recording,
    SensorNoise, SpectralLine, procedure, series,
};
use estimate::allan::Deviations;
use estimate::even::evened;
use estimate::periodogram::{Periodogram, periodogram};
use estimate::stats;
use estimate::whittle::{self, Estimate, White, WhittleFit};
use physics::Unit;
use rayon::prelude::*;

use crate::readings::{code, output};
use crate::{Error, Result};

/// A series is in the merged spectrum up to this share of its Nyquist frequency, if a faster one follows.
const TRUSTED: f64 = 0.8;
const BINS: f64 = 10.0;
/// A bin counts as so many ordinates of a Fourier transform at least.
const LEAST_COUNT: f64 = 1.0;
/// Shares of rounding in the fast end's density up to which it is the sensor, and from which the quantiser.
const MEASURED: [f64; 2] = [0.1, 0.5];
/// Below this probability the spectrum does not have the form that is fitted.
const UNLIKE_BELOW: f64 = 1e-3;
/// What the covariance of the noise runs over.
const ORDER: [&str; 3] = ["flicker_nt2_per_hz_at_1hz", "flicker_exponent", "series.white_rms_nt"];
/// Steepest noise that a covariance is made for.
const STEEPEST: f64 = 2.0;

struct Series<'a> {
    recording: &'a Recording,
    step_s: f64,
    mean_nt: f64,
    rms_nt: f64,
    code_nt: Option<f64>,
    periodogram: Periodogram,
    allan: Deviations,
    field_nt: Vec<f64>,
    /// How far its times are from even ones, where it was interpolated, s.
    uneven_s: Option<f64>,
}

/// The measured noise as instruments declare theirs, no steeper than a covariance is made for.
pub fn as_noise(measured: &SensorNoise) -> Noise {
    let noise = measured.as_noise();
    Noise { flicker_exponent: noise.flicker_exponent.map(|exponent| exponent.min(STEEPEST)), ..noise }
}

/// Noise of a sensor from all its series; None without a recording that holds it.
pub fn analyse(
    document: &Document,
    sensor: Axis,
    sensitivity: &(dyn Fn(Unit) -> Option<(f64, f64)> + Sync),
) -> Result<Option<SensorNoise>> {
    let mut mine: Vec<(usize, &Recording)> = Vec::new();
    for (index, recording) in document.recordings.iter().enumerate() {
        if recording.procedure == procedure::SENSOR_NOISE && holds(recording, index, sensor)? {
            mine.push((index, recording));
        }
    }
    let mut all: Vec<Series<'_>> = mine
        .par_iter()
        .map(|(index, recording)| read(recording, &format!("recordings[{index}]"), sensor, sensitivity))
        .collect::<Result<_>>()?;
    if all.is_empty() {
        return Ok(None);
    }
    all.sort_by(|a, b| b.step_s.total_cmp(&a.step_s));
    let periodograms: Vec<Periodogram> = all.iter().map(|one| one.periodogram.clone()).collect();
    let fit = whittle::fit(&periodograms)?;
    Ok(Some(result(&all, &fit, sensor)))
}

/// Whether a recording has readings of a sensor; one that names the sensor must.
fn holds(recording: &Recording, index: usize, sensor: Axis) -> Result<bool> {
    let path = format!("recordings[{index}]");
    recording.at_hand(&path)?;
    match recording.conditions.sensor {
        Some(of) if of == sensor => output(recording, &path, sensor).map(|_| true),
        Some(_) => Ok(false),
        None => Ok(["v", "nt"].iter().any(|unit| recording.axis_column("sensor", sensor, unit).is_some())),
    }
}

fn read<'a>(
    recording: &'a Recording,
    path: &str,
    sensor: Axis,
    sensitivity: &(dyn Fn(Unit) -> Option<(f64, f64)> + Sync),
) -> Result<Series<'a>> {
    let (reading, unit) = output(recording, path, sensor)?;
    let column = format!("{path}.columns.sensor_{sensor}_{}", unit.suffix());
    let Some(even) = evened(recording.column("time_s").unwrap_or_default(), reading) else {
        let times = format!("{path}.columns.time_s");
        return Err(Error::document(times, "no such times", series::EVEN_TIMES));
    };
    let Some((k, _)) = sensitivity(unit) else {
        let expected = format!(
            "calibration.sensors.{sensor}.sensitivity_nt_per_v, instrument.nominal_sensitivity_nt_per_v or a `sensor_sensitivity` recording"
        );
        return Err(Error::document(column, "readings in V without a sensitivity", expected));
    };
    let step_s = even.step_s;
    let filled = series::filled(even.column, &column)?.into_iter();
    let field_nt: Vec<f64> = filled.map(|value| k * value).collect();
    let count = field_nt.len() as f64;
    let mean_nt = stats::mean(&field_nt);
    let rms_nt = (field_nt.iter().map(|b| (b - mean_nt).powi(2)).sum::<f64>() / count).sqrt();
    if field_nt.iter().all(|field| *field == field_nt[0]) {
        let found = format!("the constant reading {}", reading[0]);
        let expected = "readings that vary: was the sensor connected, or is its noise below one quantisation step? Amplify before the converter";
        return Err(Error::document(column, found, expected));
    }
    let (periodogram, allan) =
        rayon::join(|| periodogram(&field_nt, step_s), || Deviations::of(&field_nt, step_s));
    let code_nt = code(reading).map(|code| code * k);
    Ok(Series {
        recording,
        step_s,
        mean_nt,
        rms_nt,
        code_nt,
        periodogram: periodogram?,
        allan: allan?,
        field_nt,
        uneven_s: even.uneven_s,
    })
}

fn quantity(estimate: Estimate) -> Quantity {
    Quantity::new(estimate.value, estimate.std)
}

fn result(all: &[Series<'_>], fit: &WhittleFit, sensor: Axis) -> SensorNoise {
    let mut found = SensorNoise {
        series: all.iter().zip(&fit.white_rms).map(|(one, white)| series_result(one, *white, fit)).collect(),
        flicker_nt2_per_hz_at_1hz: quantity(fit.amplitude),
        flicker_below_nt2_per_hz: fit.amplitude.bound(),
        flicker_exponent: quantity(fit.exponent),
        density_at_1hz_nt_per_sqrt_hz: quantity(fit.flicker_density(1.0).root()),
        white: match fit.white {
            White::PerReading => "per_reading",
            White::Density => "density",
            White::Each => "each",
        }
        .into(),
        goodness_p: fit.goodness.unwrap_or(1.0),
        spectrum: merged(all),
        ..SensorNoise::default()
    };
    (found.white_rms_nt, found.white_below_nt) = white(all, fit);
    if let Some(covariance) = covariance(all, fit) {
        found.covariance = covariance.map(Vec::from).into();
        found.covariance_order = ORDER.map(String::from).into();
    }
    let slowest = 1.0 / all.iter().map(|one| one.periodogram.length_s).fold(0.0, f64::max);
    let fastest = 0.5 / all.iter().map(|one| one.step_s).fold(f64::INFINITY, f64::min);
    if fit.amplitude.value > 0.0 {
        let mut low = 10f64.powf(slowest.log10().floor());
        let mut bands = vec![[slowest, fastest]];
        while low * 1e3 <= fastest * 1.001 {
            if low >= slowest * 0.999 {
                bands.push([low, low * 1e3]);
            }
            low *= 10.0;
        }
        let rms = |[low, high]: [f64; 2]| quantity(fit.flicker_variance(low, high).root());
        found.bands =
            bands.into_iter().map(|band| BandRms { band_hz: band, flicker_rms_nt: rms(band) }).collect();
    }
    for (number, one) in all.iter().enumerate() {
        for point in one.allan.of_noise(fit) {
            found.allan.push(number, point.averaging_s, point.deviation, point.band(0.95));
        }
        for line in &one.periodogram.lines {
            found.lines.push(SpectralLine {
                recording: one.recording.id.clone(),
                sensor: sensor.to_string(),
                frequency_hz: line.frequency_hz,
                amplitude_nt: line.amplitude,
                name: None,
            });
        }
    }
    found.findings = findings(&found, fit);
    let uneven = all.iter().filter_map(|one| Some((&one.recording.id, one.step_s, one.uneven_s?)));
    found.findings.extend(uneven.map(|(id, step_s, off_s)| {
        Code::UnevenTimes.said(format!(
            "recording \"{id}\": its times are uneven by up to {} s; the series was interpolated to steps of {} s, and its white noise is underestimated",
            significant(off_s, 2),
            bare(step_s)
        ))
    }));
    found
}

/// Covariance over [`ORDER`]; None where flicker or white noise was not found.
fn covariance(all: &[Series<'_>], fit: &WhittleFit) -> Option<[[f64; 3]; 3]> {
    let fastest = all.len() - 1;
    let own = if fit.white == White::Each { fastest } else { 0 };
    let white = fit.white_rms[fastest].value;
    let of_one = if fit.white == White::Density { 0.5 / all[fastest].step_s } else { 1.0 };
    // From ln A, α and a white variance.
    let by = [(0, fit.amplitude.value), (1, 1.0), (2 + own, of_one / (2.0 * white))];
    let entry = |(i, a): (usize, f64), (j, b): (usize, f64)| a * b * fit.covariance[(i, j)];
    let seen = fit.amplitude.value > 0.0 && white > 0.0;
    seen.then(|| by.map(|one| by.map(|other| entry(one, other))))
}

/// White noise of one reading with rounding taken off, averaged over the series by their readings.
fn white(all: &[Series<'_>], fit: &WhittleFit) -> (Quantity, Option<f64>) {
    let count: f64 = all.iter().map(|one| one.periodogram.samples as f64).sum();
    let mut total = (0.0, 0.0);
    let mut own = 0.0;
    for (one, white) in all.iter().zip(&fit.white_rms) {
        let share = one.periodogram.samples as f64 / count;
        let rounding = one.code_nt.map_or(0.0, |code| code * code / 12.0);
        own += share * (white.value * white.value - rounding).max(0.0);
        total.0 += share * white.value;
        // One rms for all is one estimate; else they are independent.
        let std = 2.0 * white.value * white.std;
        total.1 = match fit.white {
            White::Each => (total.1 * total.1 + (share * std).powi(2)).sqrt(),
            _ => total.1 + share * std,
        };
    }
    let rms = own.sqrt();
    if rms == 0.0 {
        let bounds = fit.white_rms.iter().filter_map(Estimate::bound);
        let seen = fit.white_rms.iter().map(|white| white.value + 1.645 * white.std).fold(0.0, f64::max);
        return (Quantity::new(0.0, 0.0), Some(bounds.fold(seen, f64::max)));
    }
    (Quantity::new(rms, total.1 / (2.0 * rms)), None)
}

fn series_result(one: &Series<'_>, white: Estimate, fit: &WhittleFit) -> NoiseSeriesResult {
    let rounding = one.code_nt.map(|code| code * code * one.step_s / 6.0);
    let nyquist = 0.5 / one.step_s;
    let all = 2.0 * white.value * white.value * one.step_s + fit.flicker_density(nyquist).value;
    let own = (all - rounding.unwrap_or(0.0)).max(0.0);
    let share = rounding.map_or(0.0, |rounding| rounding / all.max(rounding));
    NoiseSeriesResult {
        recording: one.recording.id.clone(),
        samples: one.field_nt.len(),
        rate_hz: 1.0 / one.step_s,
        mean_nt: one.mean_nt,
        rms_nt: one.rms_nt,
        white_rms_nt: quantity(white),
        code_nt: one.code_nt,
        rounding_nt2_per_hz: rounding,
        measured: match share {
            share if share < MEASURED[0] => "sensor",
            share if share < MEASURED[1] => "both",
            _ => "quantiser",
        }
        .into(),
        // Rounding falls with the square of the amplification; it is to be a tenth of the whole.
        amplification_needed: rounding
            .filter(|_| share >= MEASURED[0] && own > 0.0)
            .map(|rounding| (rounding / (own / 9.0)).sqrt()),
    }
}

/// The periodograms joined, slowest first, in bins of a tenth of a decade or more, with 95 % bands.
fn merged(all: &[Series<'_>]) -> MergedSpectrum {
    let mut spectrum = MergedSpectrum::default();
    let first = |one: &Series<'_>| 1.0 / one.periodogram.length_s;
    let mut reached: f64 = 0.0;
    for (number, one) in all.iter().enumerate() {
        let nyquist = 0.5 / one.step_s;
        let end = all.get(number + 1).map_or(nyquist, |next| first(next).clamp(TRUSTED * nyquist, nyquist));
        let inside =
            one.periodogram.bins.iter().filter(|bin| bin.frequency_hz > reached && bin.frequency_hz <= end);
        // Number, and sums of power, frequency and count.
        let mut wider: Vec<(i64, f64, f64, f64)> = Vec::new();
        for bin in inside {
            let at = (bin.frequency_hz.log10() * BINS).floor() as i64;
            let (power, frequency) = (bin.density * bin.count, bin.frequency_hz * bin.count);
            match wider.last_mut() {
                Some(open) if open.0 == at || open.3 < LEAST_COUNT => {
                    *open = (at, open.1 + power, open.2 + frequency, open.3 + bin.count);
                }
                _ => wider.push((at, power, frequency, bin.count)),
            }
        }
        for (_, power, frequency, count) in wider {
            let density = power / count;
            let (low, high) = stats::variance_interval(2.0 * count, 0.95);
            spectrum.frequency_hz.push(frequency / count);
            spectrum.density_nt2_per_hz.push(density);
            spectrum.low_nt2_per_hz.push(density * low);
            spectrum.high_nt2_per_hz.push(density * high);
        }
        reached = end;
    }
    spectrum
}

fn findings(found: &SensorNoise, fit: &WhittleFit) -> Findings {
    let mut findings = Findings::default();
    for series in found.series.iter().filter(|series| series.measured != "sensor") {
        let more = match series.amplification_needed {
            Some(gain) => format!("at least {} times more before the converter", significant(gain, 2)),
            None => "before the converter until the readings scatter over several quantisation steps".into(),
        };
        let what = match series.measured.as_str() {
            "both" => "that of sensor and quantiser together",
            _ => "that of the quantiser, not of the sensor",
        };
        findings.push(Code::QuantisationNoise.said(format!(
            "recording \"{}\": quantisation step {} nT; the noise measured at its highest frequencies is {what}; amplify {more}",
            series.recording,
            significant(series.code_nt.unwrap_or(0.0), 3)
        )));
    }
    if found.goodness_p < UNLIKE_BELOW {
        findings.push(Code::SpectralForm.said(format!(
            "the spectrum is not of the form A/f^α plus white noise ({}); the intervals assume that form",
            p_value(found.goodness_p)
        )));
    }
    if fit.exponent_at_limit {
        let words = "the exponent is at the limit of its range; the readings may contain a drift";
        findings.push(Code::ExponentAtLimit.said(words));
    }
    if found.flicker_below_nt2_per_hz.is_some() {
        findings
            .push(Code::FlickerNotDetected.said("no flicker noise was detected; an upper bound is given"));
    }
    findings
}
