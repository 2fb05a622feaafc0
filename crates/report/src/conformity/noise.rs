use common::number::{bare, duration, p_value, significant};
use common::{Axis, Document, SensorNoise};

use crate::conformity::joint::sensor;
use crate::conformity::spec::Requirement;
use crate::conformity::verdict::ShownValue;

/// Below this probability the spectrum is not of the form that is integrated.
const UNLIKE_BELOW: f64 = 0.001;
/// From an upper 95 % bound to a standard uncertainty about zero.
const BOUND: f64 = 1.645;

/// Zero to peak of the noise in a band, nT: σ g, σ the rms in the band and g = [`peak`] of n = 2 ν₀ T.
///
/// σ² = ∫ P df and ν₀² = ∫ f² P df / σ² over the band, P(f) = A f^-α + 2 w² Δt one-sided, w the white noise
/// of one reading (rounding included) of the fastest series and Δt its step. ν₀ is how often the noise
/// crosses zero upwards in a second (Rice 1944, Bell Syst. Tech. J. 23, 282). u²(σ g) = Σ d_i ρ_ij d_j, d_i
/// the changes by u(A), u(α) and u(w) and ρ their correlations. Where the document does not state these, it
/// is the square of the sum of their sizes: no correlation makes it larger.
pub fn zero_to_peak(
    document: &Document,
    requirement: &Requirement,
    axis: Axis,
) -> Result<ShownValue, String> {
    let asked = requirement.band_hz.zip(requirement.over_s);
    let (band, over_s) = asked.ok_or("the requirement has no band of frequencies")?;
    let noise = sensor(document, axis)
        .and_then(|sensor| sensor.noise.as_ref())
        .ok_or("its noise was not measured; sensorcal finds its spectrum from `sensor_noise` in a shield")?;
    let fastest = noise.series.iter().max_by(|a, b| a.rate_hz.total_cmp(&b.rate_hz));
    let fastest = fastest.filter(|series| series.rate_hz >= 2.0 * band[1] * (1.0 - 1e-9));
    let fastest = fastest.ok_or_else(|| {
        let [rate, up_to] = [2.0 * band[1], band[1]].map(bare);
        format!(
            "no series of `sensor_noise` has the {rate} readings a second that show noise up to {up_to} Hz"
        )
    })?;
    let spectrum = Spectrum::of(noise, fastest);
    let value = spectrum.zero_to_peak(band, over_s);
    let changes = spectrum.moved().map(|moved| moved.zero_to_peak(band, over_s) - value);
    let mut gaps = Vec::new();
    if noise.goodness_p < UNLIKE_BELOW {
        let p = p_value(noise.goodness_p);
        gaps.push(format!("the spectrum is not of the form that is integrated ({p})"));
    }
    let longest =
        noise.series.iter().map(|series| series.samples as f64 / series.rate_hz).fold(0.0, f64::max);
    if longest * band[0] < 1.0 {
        let (length, lowest) = (duration(longest), bare(band[0]));
        gaps.push(format!("the longest series of {length} shows nothing of {lowest} Hz"));
    }
    let lines = noise.lines.iter().filter(|line| line.recording == fastest.recording);
    let inside = lines.filter(|line| (band[0]..=band[1]).contains(&line.frequency_hz));
    gaps.extend(inside.map(|line| {
        let (size, frequency) = (significant(line.amplitude_nt, 3), significant(line.frequency_hz, 5));
        format!("a line of {size} nT at {frequency} Hz is not in the figure")
    }));
    let (rms, often) = (spectrum.rms(band), spectrum.crossings_hz(band));
    let how = if rms > 0.0 {
        let exceeded = rms * (2.0 * (2.0 * often * over_s / -(0.95f64.ln())).ln()).max(0.0).sqrt();
        let [rms, often, peak, exceeded] =
            [rms, often, value / rms, exceeded].map(|number| significant(number, 3));
        format!(
            "{rms} nT rms, {often} crossings a second, peak {peak} times the rms; one record in twenty exceeds {exceeded} nT"
        )
    } else {
        "no noise was found".into()
    };
    let std = together(changes, correlation(noise));
    Ok(ShownValue { value, std, gaps, how, ..ShownValue::default() })
}

/// Correlations of A, α and w, where the document states their covariance.
fn correlation(noise: &SensorNoise) -> Option<[[f64; 3]; 3]> {
    let entry = |i: usize, j: usize| noise.covariance.get(i)?.get(j).copied();
    let mut all = [[1.0; 3]; 3];
    for (i, j) in (0..9).map(|place| (place / 3, place % 3)) {
        let both = (entry(i, i)?.sqrt(), entry(j, j)?.sqrt(), entry(i, j)?);
        if i != j {
            all[i][j] = Some(both.2 / (both.0 * both.1)).filter(|found| found.is_finite())?;
        }
    }
    Some(all)
}

fn together(changes: [f64; 3], correlation: Option<[[f64; 3]; 3]>) -> f64 {
    let Some(correlation) = correlation else { return changes.iter().map(|change| change.abs()).sum() };
    let row = |i: usize| (0..3).map(|j| changes[i] * correlation[i][j] * changes[j]).sum::<f64>();
    (0..3).map(row).sum::<f64>().max(0.0).sqrt()
}

/// Expected largest departure from zero, in either direction, of Gaussian noise of unit rms with n
/// independent chances to exceed: g = ∫ (1 − exp(−n exp(−m²/2))) dm from 0 (Davenport 1964, Proc. Inst. Civ.
/// Eng. 28, 187, without his expansion).
fn peak(chances: f64) -> f64 {
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

    /// σ g, nT.
    fn zero_to_peak(&self, band: [f64; 2], over_s: f64) -> f64 {
        let rms = self.rms(band);
        if rms > 0.0 { rms * peak(2.0 * self.crossings_hz(band) * over_s) } else { 0.0 }
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

    fn moved(&self) -> [Self; 3] {
        let mut moved = [*self; 3];
        moved[0].amplitude[0] += self.amplitude[1];
        moved[1].exponent[0] += self.exponent[1];
        moved[2].white[0] += self.white[1];
        moved
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::Value;

    /// Cases of `fixtures/reference/certificate.py`, with what SciPy gives.
    #[test]
    fn rms_and_zero_to_peak_are_those_of_scipy() {
        let text = testkit::read_fixture("reference/certificate.json");
        let reference: Value = serde_json::from_str(&text).expect("JSON");
        for case in reference["noise"].as_array().expect("cases") {
            let number = |key: &str| case[key].as_f64().expect("a number");
            let band = [0, 1].map(|end| case["band_hz"][end].as_f64().expect("a frequency"));
            let over_s = number("over_s");
            let spectrum = Spectrum {
                amplitude: [number("amplitude"), 0.05 * number("amplitude")],
                exponent: [number("exponent"), 0.03],
                white: [number("white"), 0.02 * number("white")],
                step_s: number("step_s"),
            };
            assert!((spectrum.rms(band) / number("rms_nt") - 1.0).abs() < 1e-10, "{case}");
            // Peaks come in clumps where low frequencies are strong; the formula takes them one by one and is
            // a little high.
            let by = spectrum.zero_to_peak(band, over_s) / number("zero_to_peak_nt") - 1.0;
            let chance = 3.0 * number("error_of_mean_nt") / number("zero_to_peak_nt");
            println!("{by:+.4} ± {:.4}", chance / 3.0);
            assert!((-chance..0.02 + chance).contains(&by), "{by:+.4}: {case}");
            // Over parameters that move together in any sense, the figure moves by no more than u, and in one
            // sense by u.
            let value = spectrum.zero_to_peak(band, over_s);
            let moves = |moved: Spectrum| (moved.zero_to_peak(band, over_s) - value).abs();
            let std: f64 = spectrum.moved().map(moves).iter().sum();
            let moved = |signs: [f64; 3]| {
                let mut all = spectrum;
                all.amplitude[0] += signs[0] * all.amplitude[1];
                all.exponent[0] += signs[1] * all.exponent[1];
                all.white[0] += signs[2] * all.white[1];
                moves(all)
            };
            let all = (0..8).map(|k| [k & 1, k >> 1 & 1, k >> 2].map(|sign| f64::from(2 * sign - 1)));
            let most = all.map(moved).fold(0.0, f64::max);
            assert!((most / std - 1.0).abs() < 0.05, "{most} beside {std}: {case}");
        }
    }

    #[test]
    fn changes_that_are_correlated_by_hand() {
        assert_eq!(together([3.0, -4.0, 0.0], None), 7.0);
        let with = |rho: f64| Some([[1.0, rho, 0.0], [rho, 1.0, 0.0], [0.0, 0.0, 1.0]]);
        assert_eq!(together([3.0, -4.0, 0.0], with(0.0)), 5.0);
        assert_eq!(together([3.0, -4.0, 0.0], with(1.0)), 1.0);
        assert_eq!(together([3.0, -4.0, 0.0], with(-1.0)), 7.0);
        let mut noise = SensorNoise {
            covariance: vec![vec![4.0, 3.0, 0.0], vec![3.0, 9.0, 0.0], vec![0.0, 0.0, 1.0]],
            ..SensorNoise::default()
        };
        assert_eq!(correlation(&noise).expect("stated")[0][1], 0.5);
        noise.covariance.pop();
        assert_eq!(correlation(&noise), None);
    }

    #[test]
    fn the_peak_of_one_chance_and_of_many() {
        // n → 0: ∫ n exp(−m²/2) dm = n √(π/2).
        assert!((peak(1e-6) / 1e-6 - (std::f64::consts::PI / 2.0).sqrt()).abs() < 1e-5);
        // Davenport's expansion, good to 0.3 % for many: √(2 ln n) + γ/√(2 ln n).
        let root = (2.0 * 1e6f64.ln()).sqrt();
        assert!((peak(1e6) / (root + 0.577_215_664_9 / root) - 1.0).abs() < 3e-3);
    }
}
