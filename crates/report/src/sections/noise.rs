//! Noise of each sensor: merged spectrum with its fit and the floor of the codes, Allan deviation.

use common::{AllanDeviation, Axis, Document, Quantity, SensorNoise};
use page::words::rounded;

use super::effects::{self, findings};
use super::nulling::{add_lines, lines_table};
use crate::plot::{Dimension, Mark, Plot, Series};
use crate::{Cell, Section, Table};

/// The section; None where the document has nothing of it.
pub fn section(document: &Document) -> Option<Section> {
    let sensors = document.calibration.as_ref()?.sensors.as_ref()?;
    let mut section = Section::new("noise", "Noise");
    section.words.push("P(f) = A f^−α + white, one-sided.".into());
    let mut fits = Table::new(
        "Noise of each sensor",
        [
            ("sensor", ""),
            ("A at 1 Hz", "nT²/Hz"),
            ("√A", "nT/√Hz"),
            ("α", ""),
            ("white, of a reading", "nT rms"),
            ("goodness, p", ""),
        ],
    );
    let mut series = Table::new(
        "Series",
        [
            ("sensor", ""),
            ("recording", ""),
            ("samples", ""),
            ("rate", "Hz"),
            ("mean", "nT"),
            ("rms", "nT"),
            ("white, quantisation included", "nT rms"),
            ("quantisation step", "nT"),
            ("measured at its highest frequencies", ""),
        ],
    );
    let mut bands = Table::new(
        "Flicker noise in bands: √∫ A f^−α df",
        [("sensor", ""), ("from", "Hz"), ("to", "Hz"), ("rms", "nT")],
    );
    let mut lines = lines_table();
    let mut plots = Vec::new();
    for (axis, sensor) in sensors.iter() {
        let Some(noise) = &sensor.noise else { continue };
        let name = format!("sensor {axis}");
        section.warnings.extend(findings(&name, &noise.findings, &effects::sensors::NOISE, &()));
        fits.row([
            name.as_str().into(),
            (&noise.flicker_nt2_per_hz_at_1hz).into(),
            (&noise.density_at_1hz_nt_per_sqrt_hz).into(),
            (&noise.flicker_exponent).into(),
            (&noise.white_rms_nt).into(),
            Cell::Probability(noise.goodness_p),
        ]);
        for one in &noise.series {
            series.row([
                name.as_str().into(),
                one.recording.as_str().into(),
                one.samples.into(),
                one.rate_hz.into(),
                Cell::Figures(one.mean_nt, 4),
                Cell::Figures(one.rms_nt, 3),
                (&one.white_rms_nt).into(),
                one.code_nt.map(|code| Cell::Number(rounded(code))).into(),
                one.measured.as_str().into(),
            ]);
        }
        for one in &noise.bands {
            let [from, to] = one.band_hz;
            bands.row([
                name.as_str().into(),
                Cell::Number(rounded(from)),
                Cell::Number(rounded(to)),
                (&one.flicker_rms_nt).into(),
            ]);
        }
        add_lines(&mut lines, &noise.lines);
        plots.push(spectrum(axis, noise));
    }
    for (axis, sensor) in sensors.iter() {
        let Some(noise) = &sensor.noise else { continue };
        let names = noise.series.iter().map(|one| one.recording.as_str());
        plots.push(allan(
            format!("allan-{axis}"),
            format!("Allan deviation, sensor {axis}"),
            &noise.allan,
            names,
        ));
    }
    section.table(fits);
    plots.into_iter().for_each(|plot| section.plot(plot));
    section.table(series);
    section.table(bands);
    section.table(lines);
    (!section.items.is_empty()).then_some(section)
}

fn spectrum(axis: Axis, noise: &SensorNoise) -> Plot {
    let mut plot = Plot::new(
        format!("noise-{axis}"),
        format!("Merged spectrum, sensor {axis}"),
        Dimension::log("frequency", "Hz"),
        Dimension::log("power density", "nT²/Hz"),
    )
    .note("Band: 95 % interval. Fit and rounding are drawn for each series by itself, over the frequencies that it has.");
    let spectrum = &noise.spectrum;
    plot.push(
        Series::new(
            "measured",
            Mark::Line,
            axis.index(),
            &spectrum.frequency_hz,
            &spectrum.density_nt2_per_hz,
        )
        .between(&spectrum.low_nt2_per_hz, &spectrum.high_nt2_per_hz),
    );
    let mut fit = Series { name: "fit".into(), mark: Mark::Dashes, style: 5, points: Vec::new() };
    let mut floor =
        Series { name: "quantisation, δ² Δt/6".into(), mark: Mark::Dashes, style: 3, points: Vec::new() };
    for one in &noise.series {
        // White noise of a reading is spread up to the Nyquist frequency: 2 σ² Δt.
        let white = 2.0 * one.white_rms_nt.value().powi(2) / one.rate_hz;
        let frequencies = even_in_log(one.rate_hz / one.samples as f64, one.rate_hz / 2.0);
        let density = |f: &f64| flicker(noise, *f) + white;
        fit.append(&frequencies, &frequencies.iter().map(density).collect::<Vec<_>>());
        if let Some(rounding) = one.rounding_nt2_per_hz {
            let ends = [one.rate_hz / one.samples as f64, one.rate_hz / 2.0];
            floor.append(&ends, &[rounding; 2]);
        }
    }
    plot.push(fit);
    plot.push(floor);
    plot
}

/// A f^-α.
fn flicker(noise: &SensorNoise, frequency_hz: f64) -> f64 {
    let value = Quantity::value;
    value(&noise.flicker_nt2_per_hz_at_1hz) * frequency_hz.powf(-value(&noise.flicker_exponent))
}

fn even_in_log(low: f64, high: f64) -> Vec<f64> {
    const STEPS: i32 = 24;
    (0..=STEPS).map(|n| low * (high / low).powf(f64::from(n) / f64::from(STEPS))).collect()
}

/// The Allan deviation of several series.
pub fn allan<'a>(
    id: String,
    title: String,
    allan: &AllanDeviation,
    names: impl Iterator<Item = &'a str>,
) -> Plot {
    let x = Dimension::log("averaging time", "s");
    let mut plot =
        Plot::new(id, title, x, Dimension::log("Allan deviation", "nT")).note("Bars: 95 % intervals.");
    for (number, name) in names.enumerate() {
        let of = |column: &[f64]| -> Vec<f64> {
            let rows = allan.series.iter().zip(column).filter(|(series, _)| **series == number);
            rows.map(|(_, value)| *value).collect()
        };
        plot.push(
            Series::new(name, Mark::Points, number, &of(&allan.averaging_s), &of(&allan.deviation_nt))
                .between(&of(&allan.low_nt), &of(&allan.high_nt)),
        );
    }
    plot
}
