//! The merged spectrum of each sensor's noise with its fit and the floor of the codes.

use common::{Axis, Calibration, PerAxis, SensorNoise};

use super::Plots;
use crate::plot::{Dimension, Mark, Plot, Series};

pub fn plots(plots: &mut Plots, calibration: &Calibration) {
    let sensors = calibration.sensors.iter().flat_map(PerAxis::iter);
    let noises = sensors.filter_map(|(axis, sensor)| Some(spectrum(axis, sensor.noise.as_deref()?)));
    plots.insert("noise".into(), noises.collect());
}

fn spectrum(axis: Axis, noise: &SensorNoise) -> Plot {
    const STEPS: i32 = 24;
    let spectrum = &noise.spectrum;
    let (frequency, density) = (&spectrum.frequency_hz, &spectrum.density_nt2_per_hz);
    let measured = Series::new("measured", Mark::Line, axis.index(), frequency, density);
    let mut fit = Series::new("fit", Mark::Dashes, 5, &[], &[]);
    let mut floor = Series::new("quantisation, δ² Δt/6", Mark::Dashes, 3, &[], &[]);
    let (amplitude, exponent) = (noise.flicker_nt2_per_hz_at_1hz.value(), noise.flicker_exponent.value());
    for one in &noise.series {
        // A f^-α, and white noise of a reading, which is spread up to the Nyquist frequency: 2 σ² Δt.
        let white = 2.0 * one.white_rms_nt.value().powi(2) / one.rate_hz;
        let ends = [one.rate_hz / one.samples as f64, one.rate_hz / 2.0];
        let even_in_log = |n: i32| ends[0] * (ends[1] / ends[0]).powf(f64::from(n) / f64::from(STEPS));
        let frequencies: Vec<f64> = (0..=STEPS).map(even_in_log).collect();
        let density = |f: &f64| amplitude * f.powf(-exponent) + white;
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
