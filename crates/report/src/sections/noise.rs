//! Noise: the merged spectrum of each sensor with its fit and the floor of the codes, Allan deviation; what
//! the nulling leaves, in each condition of the site.

use common::{Axis, Document, Quantity, SensorNoise};
use page::words::{cells, rounded};

use super::effects::{self, findings};
use super::shared::{add_lines, lines};
use crate::plot::{Dimension, Mark, Plot, Series};
use crate::{Cell, Section, Table, number};

pub fn section(document: &Document) -> Option<Section> {
    let sensors = document.calibration.as_ref()?.sensors.as_ref()?;
    let mut section = Section::new("noise", "Noise");
    section.words.push("P(f) = A f^−α + white, one-sided.".into());
    let mut fits = Table::new(
        "Noise of each sensor",
        "sensor | A at 1 Hz [nT²/Hz] | √A [nT/√Hz] | α | white, of a reading [nT rms] | goodness, p",
    );
    let mut series = Table::new(
        "Series",
        "sensor | recording | samples | rate [Hz] | mean [nT] | rms [nT] | white, quantisation included [nT rms] | \
         quantisation step [nT] | measured at its highest frequencies",
    );
    let mut bands =
        Table::new("Flicker noise in bands: √∫ A f^−α df", "sensor | from [Hz] | to [Hz] | rms [nT]");
    let mut lines = lines();
    let (mut spectra, mut deviations) = (Vec::new(), Vec::new());
    for (axis, sensor) in sensors.iter() {
        let Some(noise) = &sensor.noise else { continue };
        let name = format!("sensor {axis}");
        section.warnings.extend(findings(&name, &noise.findings, &effects::sensors::NOISE, &()));
        fits.row((
            &name,
            &noise.flicker_nt2_per_hz_at_1hz,
            &noise.density_at_1hz_nt_per_sqrt_hz,
            &noise.flicker_exponent,
            &noise.white_rms_nt,
            Cell::Probability(noise.goodness_p),
        ));
        for one in &noise.series {
            series.row((
                &name,
                &one.recording,
                one.samples,
                one.rate_hz,
                Cell::Figures(one.mean_nt, 4),
                Cell::Figures(one.rms_nt, 3),
                &one.white_rms_nt,
                one.code_nt.map(rounded),
                one.measured.as_str(),
            ));
        }
        for one in &noise.bands {
            let [from, to] = one.band_hz.map(rounded);
            bands.row((&name, from, to, &one.flicker_rms_nt));
        }
        add_lines(&mut lines, &noise.lines);
        spectra.push(spectrum(axis, noise));
        deviations.push(allan(axis, noise));
    }
    section.table(fits);
    spectra.into_iter().chain(deviations).for_each(|plot| section.plot(plot));
    section.table(series);
    section.table(bands);
    section.table(lines);
    (!section.items.is_empty()).then_some(section)
}

fn spectrum(axis: Axis, noise: &SensorNoise) -> Plot {
    let spectrum = &noise.spectrum;
    let measured = Series::new(
        "measured",
        Mark::Line,
        axis.index(),
        &spectrum.frequency_hz,
        &spectrum.density_nt2_per_hz,
    );
    let mut fit = Series::new("fit", Mark::Dashes, 5, &[], &[]);
    let mut floor = Series::new("quantisation, δ² Δt/6", Mark::Dashes, 3, &[], &[]);
    for one in &noise.series {
        // White noise of a reading is spread up to the Nyquist frequency: 2 σ² Δt.
        let white = 2.0 * one.white_rms_nt.value().powi(2) / one.rate_hz;
        let ends = [one.rate_hz / one.samples as f64, one.rate_hz / 2.0];
        let frequencies = even_in_log(ends);
        let density = |f: &f64| flicker(noise, *f) + white;
        fit.append(&frequencies, &frequencies.iter().map(density).collect::<Vec<_>>());
        if let Some(rounding) = one.rounding_nt2_per_hz {
            floor.append(&ends, &[rounding; 2]);
        }
    }
    Plot::new(format!("noise-{axis}"), format!("Merged spectrum, sensor {axis}"))
        .axes(Dimension::log("frequency [Hz]"), Dimension::log("power density [nT²/Hz]"))
        .note("Band: 95 % interval. Fit and rounding are drawn for each series by itself, over the frequencies that it has.")
        .with(measured.between(&spectrum.low_nt2_per_hz, &spectrum.high_nt2_per_hz))
        .with(fit)
        .with(floor)
}

/// A f^-α.
fn flicker(noise: &SensorNoise, frequency_hz: f64) -> f64 {
    let value = Quantity::value;
    value(&noise.flicker_nt2_per_hz_at_1hz) * frequency_hz.powf(-value(&noise.flicker_exponent))
}

fn even_in_log([low, high]: [f64; 2]) -> Vec<f64> {
    const STEPS: i32 = 24;
    (0..=STEPS).map(|n| low * (high / low).powf(f64::from(n) / f64::from(STEPS))).collect()
}

/// The Allan deviation of each series.
fn allan(axis: Axis, noise: &SensorNoise) -> Plot {
    let allan = &noise.allan;
    let mut plot = Plot::new(format!("allan-{axis}"), format!("Allan deviation, sensor {axis}"))
        .axes(Dimension::log("averaging time [s]"), Dimension::log("Allan deviation [nT]"))
        .note("Bars: 95 % intervals.");
    for (number, one) in noise.series.iter().enumerate() {
        let of = |column: &[f64]| -> Vec<f64> {
            let rows = allan.series.iter().zip(column).filter(|(series, _)| **series == number);
            rows.map(|(_, value)| *value).collect()
        };
        let points =
            Series::points(&one.recording, number, &of(&allan.averaging_s), &of(&allan.deviation_nt));
        plot.push(points.between(&of(&allan.low_nt), &of(&allan.high_nt)));
    }
    plot
}

/// What the nulling leaves: spectra in each condition of the site.
pub fn nulling(document: &Document) -> Option<Section> {
    let nulling = document.calibration.as_ref()?.nulling.as_ref()?;
    let mut section = Section::new("nulling", "Residual field after nulling");
    if let Some(quietest) = &nulling.quietest {
        section.words.push(format!("Quietest condition of the site: {quietest}."));
    }
    for axis in Axis::ALL {
        let mut plot = Plot::new(format!("nulling-{axis}"), format!("Spectrum by condition, sensor {axis}"))
            .axes(Dimension::log("frequency [Hz]"), Dimension::log("power density [nT²/Hz]"))
            .note("Bands: 95 % intervals.");
        for (style, (site, spectra)) in nulling.sites.iter().enumerate() {
            let Some(spectrum) = spectra.spectra.get(axis) else { continue };
            let (frequency, density) = (&spectrum.frequency_hz, &spectrum.density_nt2_per_hz);
            let line = Series::new(site, Mark::Line, style, frequency, density);
            plot.push(line.between(&spectrum.low_nt2_per_hz, &spectrum.high_nt2_per_hz));
        }
        section.plot(plot);
    }
    let mut expected = Table::new(
        "Expected rms error of a measurement: √∫ P df from one over its length to the instrument's Nyquist frequency",
        "condition | length [s] | from [Hz] | to [Hz] | x [nT] | y [nT] | z [nT]",
    );
    let mut lines = lines();
    let mut series = Table::new(
        "Series behind the spectra",
        "condition | recording | rate [Hz] | segments | degrees of freedom | from [Hz] | to [Hz]",
    );
    for (site, spectra) in &nulling.sites {
        for one in &spectra.expected {
            let ([x, y, z], [from, to]) = (cells(Some(&one.rms_nt)), one.band_hz.map(rounded));
            expected.row((site, one.length_s, from, to, x, y, z));
        }
        add_lines(&mut lines, &spectra.lines);
        for one in &spectra.series {
            let ([from, to], freedom) = (one.band_hz.map(rounded), Cell::Figures(one.freedom, 3));
            series.row((site, &one.recording, one.rate_hz, one.segments, freedom, from, to));
        }
        for gap in &spectra.gaps_hz {
            let [from, to] = gap.map(number::bare);
            section.words.push(format!("{site}: no series shows {from} to {to} Hz."));
        }
    }
    section.table(expected);
    section.table(lines);
    section.table(series);
    (!section.items.is_empty()).then_some(section)
}
