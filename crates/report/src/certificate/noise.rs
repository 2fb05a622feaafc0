use common::{Axis, Document, SensorNoise};

use super::verdict::{Found, Missing, Shown};
use super::{Requirement, sensor_name};

/// Below this probability the spectrum is not of the form that is integrated.
const UNLIKE_BELOW: f64 = 0.001;
/// From an upper 95 % bound to a standard uncertainty about zero.
const BOUND: f64 = 1.645;

/// Zero to peak of the noise in a band, nT: σ g, σ the rms in the band and g = [`peak`] of n = 2 ν₀ T.
///
/// σ² = ∫ P df and ν₀² = ∫ f² P df / σ² over the band, P(f) = A f^-α + 2 w² Δt one-sided, w the white noise of one reading
/// (rounding included) of the fastest series and Δt its step. ν₀ is how often the noise crosses zero upwards in a second (Rice 1944,
/// Bell Syst. Tech. J. 23, 282). u(σ g) adds the sizes of the changes by u(A), u(α) and u(w): no correlation makes it larger.
pub fn zero_to_peak(document: &Document, requirement: &Requirement) -> Vec<Shown> {
    let (Some(band), Some(over_s)) = (requirement.band_hz, requirement.over_s) else { return Vec::new() };
    Axis::ALL.map(|axis| one(document, axis, band, over_s)).into()
}

fn one(document: &Document, axis: Axis, band: [f64; 2], over_s: f64) -> Shown {
    let missing = |why: String| Missing { of: sensor_name(axis), why };
    let noise = document.calibration.as_ref().and_then(|c| c.sensor(axis)?.noise.as_ref());
    let noise = noise.ok_or_else(|| {
        missing(
            "its noise was not measured; sensorcal finds its spectrum from `sensor_noise` in a shield".into(),
        )
    })?;
    let fastest = noise.series.iter().max_by(|a, b| a.rate_hz.total_cmp(&b.rate_hz));
    let fastest =
        fastest.filter(|series| series.rate_hz >= 2.0 * band[1] * (1.0 - 1e-9)).ok_or_else(|| {
            missing(format!(
                "no series of `sensor_noise` has the {} readings a second that show noise up to {} Hz",
                2.0 * band[1],
                band[1]
            ))
        })?;
    let spectrum = Spectrum::of(noise, fastest);
    let rms = spectrum.rms(band);
    let figure = |spectrum: &Spectrum| spectrum.rms(band) * peak(2.0 * spectrum.crossings_hz(band) * over_s);
    let value = if rms > 0.0 { figure(&spectrum) } else { 0.0 };
    let std = spectrum.moved().iter().map(|moved| (figure(moved) - value).abs()).sum();
    let mut gaps = Vec::new();
    if noise.goodness_p < UNLIKE_BELOW {
        gaps.push(format!(
            "the spectrum is not of the form that is integrated (p = {:.1e})",
            noise.goodness_p
        ));
    }
    let lines = noise.lines.iter().filter(|line| line.recording == fastest.recording);
    let inside = lines.filter(|line| (band[0]..=band[1]).contains(&line.frequency_hz));
    gaps.extend(inside.map(|line| {
        format!("a line of {:.3} nT at {:.3} Hz is not in the figure", line.amplitude_nt, line.frequency_hz)
    }));
    let often = spectrum.crossings_hz(band);
    let how = if rms > 0.0 {
        let exceeded = rms * (2.0 * (2.0 * often * over_s / -(0.95f64.ln())).ln()).sqrt();
        format!(
            "{rms:.4} nT rms, {often:.1} crossings a second, peak {:.2} times the rms; one record in twenty exceeds {exceeded:.3} nT",
            value / rms
        )
    } else {
        "no noise was found".into()
    };
    Ok(Found { of: sensor_name(axis), value, std, gaps, how })
}

/// Expected largest departure from zero, in either direction, of Gaussian noise of unit rms with n independent chances to
/// exceed: g = ∫ (1 − exp(−n exp(−m²/2))) dm from 0 (Davenport 1964, Proc. Inst. Civ. Eng. 28, 187, without his expansion).
pub fn peak(chances: f64) -> f64 {
    let (top, steps) = (12.0, 1200);
    let width = top / steps as f64;
    let exceeded = |m: f64| -(-chances * (-0.5 * m * m).exp()).exp_m1();
    let inside: f64 = (1..steps).map(|step| exceeded(step as f64 * width)).sum();
    width * (inside + 0.5 * (exceeded(0.0) + exceeded(top)))
}

/// P(f) = A f^-α + white, with standard uncertainties.
#[derive(Clone, Copy, Debug)]
struct Spectrum {
    amplitude: [f64; 2],
    exponent: [f64; 2],
    /// White noise of a reading, nT rms.
    white: [f64; 2],
    step_s: f64,
}

impl Spectrum {
    /// As it was found; what was not seen is zero, give or take its bound.
    fn of(noise: &SensorNoise, fastest: &common::NoiseSeriesResult) -> Self {
        let pair = |quantity: &common::Quantity| [quantity.value(), quantity.std().unwrap_or(0.0)];
        let or_bound = |[value, std]: [f64; 2], bound: Option<f64>| match bound {
            Some(bound) if value == 0.0 => [0.0, bound / BOUND],
            _ => [value, std],
        };
        Self {
            amplitude: or_bound(pair(&noise.flicker_nt2_per_hz_at_1hz), noise.flicker_below_nt2_per_hz),
            exponent: pair(&noise.flicker_exponent),
            white: or_bound(pair(&fastest.white_rms_nt), noise.white_below_nt),
            step_s: 1.0 / fastest.rate_hz,
        }
    }

    /// √∫ P df, nT.
    fn rms(&self, band: [f64; 2]) -> f64 {
        self.moment(0, band).sqrt()
    }

    /// ν₀ = √(∫ f² P df / ∫ P df), Hz.
    fn crossings_hz(&self, band: [f64; 2]) -> f64 {
        (self.moment(2, band) / self.moment(0, band)).sqrt()
    }

    /// ∫ f^k P df over a band.
    fn moment(&self, order: i32, [low, high]: [f64; 2]) -> f64 {
        let power = |exponent: f64| {
            if exponent.abs() < 1e-9 {
                (high / low).ln()
            } else {
                (high.powf(exponent) - low.powf(exponent)) / exponent
            }
        };
        let order = f64::from(order) + 1.0;
        self.amplitude[0] * power(order - self.exponent[0])
            + 2.0 * self.white[0].powi(2) * self.step_s * power(order)
    }

    /// With each parameter larger by its standard uncertainty.
    fn moved(&self) -> [Self; 3] {
        let mut moved = [*self; 3];
        moved[0].amplitude[0] += self.amplitude[1];
        moved[1].exponent[0] += self.exponent[1];
        moved[2].white[0] += self.white[1];
        moved
    }
}
