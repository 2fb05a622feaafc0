//! What the nulling leaves, by site condition (NASA, "Test Earth Field Nulling System").

use common::{
    Axis, Document, ExpectedRms, MergedSpectrum, NullingCalibration, PerAxis, Quantity, Recording,
    SeriesOfSpectrum, SiteSpectra, SpectralLine, procedure, series,
};
use estimate::even::{Evened, evened};
use estimate::spectrum::{Spectrum, welch};
use estimate::stats;
use indexmap::IndexMap;

use crate::{Error, Result};

/// Segments into which a series is cut, before overlapping.
const SEGMENTS: usize = 8;
/// A series is in the merged spectrum up to this share of its Nyquist frequency, if a faster one follows.
const TRUSTED: f64 = 0.8;
const BINS: f64 = 10.0;
/// Lengths of measurements in the table, s.
const LENGTHS_S: [f64; 6] = [0.1, 1.0, 10.0, 60.0, 600.0, 3600.0];
/// A line is told below this probability, adjusted for all frequencies of its series.
const LINE_BELOW: f64 = 1e-3;
/// Frequencies to either side from which the level beside a line is taken.
const BESIDE: usize = 15;
/// Lowest frequency that can be a line, in steps: below it the level beside is a guess.
const LOWEST: usize = 6;
/// A line's power is spread over so many frequencies to either side by the window.
const SPREAD: usize = 2;
/// Sum of the correlations of neighbouring Hann estimates: 1 + 2 (4/9 + 1/36).
const CORRELATED: f64 = 1.0 + 2.0 * (4.0 / 9.0 + 1.0 / 36.0);

struct Series<'a> {
    recording: &'a Recording,
    rate_hz: f64,
    /// How far its times are from even ones, where it was interpolated, s.
    uneven_s: Option<f64>,
    spectra: Vec<(Axis, Spectrum)>,
    band_hz: [f64; 2],
}

/// The spectra of every condition; None without a recording. `nyquist_hz` is the instrument's.
pub fn residual(document: &Document, nyquist_hz: f64) -> Result<Option<NullingCalibration>> {
    let mut sites: IndexMap<String, Vec<(usize, &Recording)>> = IndexMap::new();
    for (index, recording) in document.recordings.iter().enumerate() {
        if recording.procedure == procedure::NULLING_RESIDUAL {
            let site = recording.conditions.extra.get("site").and_then(|site| site.as_str());
            let site = site.ok_or_else(|| {
                let path = format!("recordings[{index}].conditions.site");
                Error::document(path, "no such key", "the condition of the site, as in \"weekday-day\"")
            })?;
            sites.entry(site.to_string()).or_default().push((index, recording));
        }
    }
    let mut found = NullingCalibration::default();
    for (name, recordings) in sites {
        let series = recordings.into_iter().map(|(index, recording)| read(document, recording, index));
        found.sites.insert(name, merge(series.collect::<Result<_>>()?, nyquist_hz));
    }
    let total = |site: &SiteSpectra| {
        let longest = site.expected.last()?;
        Some(longest.rms_nt.iter().map(|(_, rms)| rms.value().powi(2)).sum::<f64>())
    };
    let quietest = found.sites.iter().filter_map(|(name, site)| Some((name, total(site)?)));
    found.quietest = quietest.min_by(|a, b| a.1.total_cmp(&b.1)).map(|(name, _)| name.clone());
    Ok((!found.sites.is_empty()).then_some(found))
}

fn read<'a>(document: &Document, recording: &'a Recording, index: usize) -> Result<Series<'a>> {
    let path = format!("recordings[{index}].columns");
    let mut spectra = Vec::new();
    let (mut step_s, mut uneven_s) = (f64::NAN, None);
    for axis in Axis::ALL {
        let Some(field) = field(document, recording, axis, &path)? else { continue };
        let segment = (field.column.len() / SEGMENTS).max(8);
        (step_s, uneven_s) = (field.step_s, field.uneven_s);
        spectra.push((axis, welch(&field.column, step_s, segment)?));
    }
    if spectra.is_empty() {
        let expected = "`sensor_x_nt` or `sensor_x_v`, or those of another sensor";
        return Err(Error::document(path, "no readings", expected));
    }
    Ok(Series { recording, rate_hz: 1.0 / step_s, uneven_s, spectra, band_hz: [0.0, 0.0] })
}

/// The readings of a sensor in nT at even times; a missing one is the mean of its neighbours that are there.
fn field(document: &Document, recording: &Recording, axis: Axis, path: &str) -> Result<Option<Evened>> {
    let (column, scale) = match recording.axis_column("sensor", axis, "nt") {
        Some(column) => (column, 1.0),
        None => {
            let Some(column) = recording.axis_column("sensor", axis, "v") else { return Ok(None) };
            let found = document.calibration.as_ref().and_then(|calibration| calibration.sensor(axis));
            let found = found.and_then(|sensor| sensor.sensitivity_nt_per_v.as_ref()).map(Quantity::value);
            let nominal = document.instrument.as_ref().and_then(|i| i.nominal_sensitivity_nt_per_v);
            let scale = found.or(nominal).ok_or_else(|| {
                let expected = format!(
                    "calibration.sensors.{axis}.sensitivity_nt_per_v, or instrument.nominal_sensitivity_nt_per_v"
                );
                Error::document(format!("{path}.sensor_{axis}_v"), "readings in V without a sensitivity", expected)
            })?;
            (column, scale)
        }
    };
    let Some(even) = evened(recording.column("time_s").unwrap_or_default(), column) else {
        return Err(Error::document(format!("{path}.time_s"), "no such times", series::EVEN_TIMES));
    };
    let filled = series::filled(even.column, &format!("{path}.sensor_{axis}"))?;
    Ok(Some(Evened { column: filled.into_iter().map(|value| value * scale).collect(), ..even }))
}

/// Joins the series of a condition: the slowest stands from its second frequency to a share of its Nyquist
/// frequency, the next one from there on, the fastest to its end.
fn merge(mut series: Vec<Series<'_>>, nyquist_hz: f64) -> SiteSpectra {
    series.sort_by(|a, b| a.rate_hz.total_cmp(&b.rate_hz));
    let first: Vec<f64> = series.iter().map(|one| one.spectra[0].1.frequency_hz[1]).collect();
    let mut reached: f64 = 0.0;
    for (number, one) in series.iter_mut().enumerate() {
        let nyquist = 0.5 * one.rate_hz;
        // The faster series takes over early where it reaches down so far.
        let end = first.get(number + 1).map_or(nyquist, |next| next.clamp(TRUSTED * nyquist, nyquist));
        one.band_hz = [reached.max(first[number]), end];
        reached = end;
    }
    let mut site = SiteSpectra::default();
    let pairs = series.windows(2).map(|pair| [pair[0].band_hz[1], pair[1].band_hz[0]]);
    site.gaps_hz = pairs.filter(|[from, to]| to > from).collect();
    for one in &series {
        let spectrum = &one.spectra[0].1;
        site.series.push(SeriesOfSpectrum {
            recording: one.recording.id.clone(),
            rate_hz: one.rate_hz,
            uneven_s: one.uneven_s,
            window: "hann".into(),
            segment_samples: spectrum.segment_samples,
            overlap: spectrum.overlap,
            segments: spectrum.segments,
            freedom: spectrum.freedom,
            band_hz: one.band_hz,
        });
        for (axis, spectrum) in &one.spectra {
            site.lines.extend(lines(one, *axis, spectrum));
        }
    }
    for axis in Axis::ALL {
        let spectrum = binned(&series, axis);
        if !spectrum.frequency_hz.is_empty() {
            *site.spectra.entry(axis) = Some(spectrum);
        }
    }
    site.expected = LENGTHS_S.iter().filter_map(|length| expected(&series, *length, nyquist_hz)).collect();
    site
}

fn of<'s>(series: &'s Series<'_>, axis: Axis) -> Option<&'s Spectrum> {
    series.spectra.iter().find(|(of, _)| *of == axis).map(|(_, spectrum)| spectrum)
}

/// The estimates of the merged spectrum in bins of a tenth of a decade, with their band: ν of a bin is that
/// of its estimates together, less what neighbours share.
fn binned(series: &[Series<'_>], axis: Axis) -> MergedSpectrum {
    let mut merged = MergedSpectrum::default();
    for one in series {
        let Some(spectrum) = of(one, axis) else { continue };
        // Number, and sums of densities, frequencies and estimates.
        let mut bins: Vec<(i64, f64, f64, f64)> = Vec::new();
        let inside = spectrum.frequency_hz.iter().zip(&spectrum.density);
        for (frequency, density) in inside.filter(|(f, _)| (one.band_hz[0]..=one.band_hz[1]).contains(*f)) {
            let number = (frequency.log10() * BINS).floor() as i64;
            match bins.last_mut() {
                Some(open) if open.0 == number => {
                    *open = (number, open.1 + density, open.2 + frequency, open.3 + 1.0);
                }
                _ => bins.push((number, *density, *frequency, 1.0)),
            }
        }
        for (_, sum, frequencies, count) in bins {
            let freedom = spectrum.freedom * count / CORRELATED.min(count);
            let quantile = |p: f64| stats::chi_squared_quantile(p, freedom) / freedom;
            let density = sum / count;
            merged.frequency_hz.push(frequencies / count);
            merged.density_nt2_per_hz.push(density);
            merged.low_nt2_per_hz.push(density / quantile(0.975));
            merged.high_nt2_per_hz.push(density / quantile(0.025));
        }
    }
    merged
}

/// √∫ P df from one over the length to the Nyquist frequency of the instrument, over what was recorded.
fn expected(series: &[Series<'_>], length_s: f64, nyquist_hz: f64) -> Option<ExpectedRms> {
    let low = f64::max(1.0 / length_s, series.first()?.band_hz[0]);
    let high = f64::min(nyquist_hz, series.last()?.band_hz[1]);
    if low >= high {
        return None;
    }
    let mut rms_nt = PerAxis::default();
    for axis in Axis::ALL {
        let (mut power, mut variance) = (0.0, 0.0);
        for one in series {
            let Some(spectrum) = of(one, axis) else { continue };
            let (from, to) = (low.max(one.band_hz[0]), high.min(one.band_hz[1]));
            if from < to {
                power += spectrum.power(from, to);
                let step = spectrum.frequency_hz[1];
                let inside = spectrum.frequency_hz.iter().zip(&spectrum.density);
                let squares: f64 = inside
                    .filter(|(f, _)| (from..=to).contains(*f))
                    .map(|(_, density)| (density * step).powi(2))
                    .sum();
                variance += squares * 2.0 / spectrum.freedom * CORRELATED;
            }
        }
        if power > 0.0 {
            *rms_nt.entry(axis) = Some(Quantity::new(power.sqrt(), variance.sqrt() / (2.0 * power.sqrt())));
        }
    }
    Some(ExpectedRms { length_s, band_hz: [low, high], rms_nt })
}

/// Peaks above what is beside them by more than chance allows over all frequencies of the series.
fn lines(series: &Series<'_>, axis: Axis, spectrum: &Spectrum) -> Vec<SpectralLine> {
    let (frequency, density) = (&spectrum.frequency_hz, &spectrum.density);
    let last = density.len() - 1;
    let mut found = Vec::new();
    for at in LOWEST..last.saturating_sub(SPREAD) {
        let near = &density[at - SPREAD..=at + SPREAD];
        if near.iter().any(|other| *other > density[at]) {
            continue;
        }
        let (level, freedom) = beside(spectrum, at);
        let p = stats::f_p(density[at] / level, spectrum.freedom, freedom);
        if p * (last as f64) < LINE_BELOW {
            let power: f64 = near.iter().map(|density| density - level).sum::<f64>() * frequency[1];
            found.push(SpectralLine {
                recording: series.recording.id.clone(),
                sensor: axis.to_string(),
                frequency_hz: frequency[at],
                amplitude_nt: (2.0 * power.max(0.0)).sqrt(),
                name: name(frequency[at], frequency[1], series.rate_hz),
            });
        }
    }
    found
}

/// The density at a frequency as its neighbours have it, with its degrees of freedom: a power law through
/// them, other lines left out.
fn beside(spectrum: &Spectrum, at: usize) -> (f64, f64) {
    let near = at.saturating_sub(BESIDE).max(1)..=(at + BESIDE).min(spectrum.density.len() - 1);
    let point = |k: usize| (spectrum.frequency_hz[k].ln(), spectrum.density[k].ln());
    let mut others: Vec<(f64, f64)> =
        near.filter(|k| k.abs_diff(at) > SPREAD && spectrum.density[*k] > 0.0).map(point).collect();
    let scatter = (2.0 / spectrum.freedom).sqrt();
    let mut line = power_law(&others);
    others.retain(|(x, y)| (y - line(*x)) < 3.0 * scatter);
    line = power_law(&others);
    // The mean logarithm of χ²/ν lies 1/ν below zero.
    let level = (line(point(at).0) + 1.0 / spectrum.freedom).exp();
    (level, spectrum.freedom * (others.len() as f64 / CORRELATED - 2.0).max(1.0))
}

/// The least-squares line through points; flat where there are too few.
fn power_law(points: &[(f64, f64)]) -> Box<dyn Fn(f64) -> f64> {
    let count = points.len().max(1) as f64;
    let (x, y) = points.iter().fold((0.0, 0.0), |(x, y), point| (x + point.0 / count, y + point.1 / count));
    let (xx, xy) = points
        .iter()
        .fold((0.0, 0.0), |(xx, xy), point| (xx + (point.0 - x).powi(2), xy + (point.0 - x) * (point.1 - y)));
    let slope = if xx > 0.0 { xy / xx } else { 0.0 };
    Box::new(move |at| y + slope * (at - x))
}

/// Mains with its harmonics and railway power, where the frequency or its alias is within a step.
fn name(frequency_hz: f64, step_hz: f64, rate_hz: f64) -> Option<String> {
    let mains = [50.0, 60.0].into_iter().flat_map(|hz| {
        (1..=5).map(move |multiple| {
            let harmonic = if multiple == 1 { String::new() } else { format!(", harmonic {multiple}") };
            (hz * f64::from(multiple), format!("mains {hz} Hz{harmonic}"))
        })
    });
    let known = mains.chain([(50.0 / 3.0, "railway power 16.7 Hz".to_string())]);
    let seen = |hz: f64| (hz - (hz / rate_hz).round() * rate_hz).abs();
    let near = known.filter(|(hz, _)| (seen(*hz) - frequency_hz).abs() <= 1.5 * step_hz);
    // A line at its own frequency comes before an alias.
    let best = near.min_by_key(|(hz, _)| u8::from(*hz > rate_hz / 2.0));
    best.map(|(hz, name)| if hz > rate_hz / 2.0 { format!("alias of {name}") } else { name })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_have_their_names() {
        for (frequency_hz, rate_hz, expected) in [
            (60.0, 128.0, Some("mains 60 Hz")),
            (50.01, 128.0, Some("mains 50 Hz")),
            (16.68, 128.0, Some("railway power 16.7 Hz")),
            // 120 Hz at 128 Hz stands at 8 Hz, 16.7 Hz at 10 Hz at 3.33 Hz.
            (8.0, 128.0, Some("alias of mains 60 Hz, harmonic 2")),
            (3.333, 10.0, Some("alias of railway power 16.7 Hz")),
            (23.0, 128.0, None),
        ] {
            assert_eq!(name(frequency_hz, 0.02, rate_hz).as_deref(), expected, "{frequency_hz} Hz");
        }
    }
}
