//! The merged spectrum of each sensor's noise with its fit and the floor of the codes.

use common::{Axis, Calibration, PerAxis, Quantity, SensorNoise};

use super::Plots;
use crate::plot::{Dimension, Mark, Plot, Series};

pub fn plots(plots: &mut Plots, calibration: &Calibration) {
    let sensors = calibration.sensors.iter().flat_map(PerAxis::iter);
    let noises = sensors.filter_map(|(axis, sensor)| Some(spectrum(axis, sensor.noise.as_deref()?)));
    plots.insert("noise".into(), noises.collect());
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
