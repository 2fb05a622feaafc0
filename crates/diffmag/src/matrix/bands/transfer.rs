//! The transfer function of one axis in one band.

use std::f64::consts::PI;
use std::ops::Range;

use estimate::cross_spectrum::CrossSpectra;
use faer::Mat;
use nalgebra::{Complex, Matrix3, Vector3};

use crate::constancy::Estimate;

type C = Complex<f64>;

/// Z of one axis in one band: T = R Z.
pub struct Transfer {
    /// Z: real parts, then imaginary parts, with their covariance.
    pub estimate: Estimate,
    /// What Z would be off for each second that the test instrument is late, laid out in the same way.
    pub late: Vec<f64>,
    /// Multiple coherence of the test instrument's axis with the reference.
    pub coherence: f64,
    /// Variance that is left in the band, nT².
    pub residual: f64,
}

impl Transfer {
    /// Z, an offset of the clock taken off.
    pub fn less(&self, offset_s: f64) -> Estimate {
        let value = self.estimate.value.iter().zip(&self.late).map(|(z, late)| z - offset_s * late).collect();
        Estimate { value, ..self.estimate.clone() }
    }
}

/// The band `ordinates` of spectra of R (channels 0 to 2) and d = T − R η (channel 3 + j), `effective`
/// complex degrees of freedom.
///
/// With the weights 1/P, P(f) the density of the noise, the sums M = Σ S_RR/P, v = Σ S_Rd/P, u = Σ S_dd/P
/// over m ordinates give
///
/// Z = η + M⁻¹ v, s² = (u − vᴴ M⁻¹ v)/m · n/(n − 3), ⟨δZ δZᴴ⟩ = s² m M⁻¹/n,
///
/// n = `effective`; δZ is circular, and s² has 2 (n − 3) degrees of freedom: with it the uncertainties hold
/// whether P is right in the band or not. A clock that is late by δ adds −δ dR/dt η; of samples Δt apart the
/// rate is taken as their central differences, −i sin(2π f Δt)/Δt in place of −2πi f.
///
/// Source: M. B. Priestley, Spectral Analysis and Time Series, Academic Press 1981, sections 9.2 and 9.3.
pub fn transfer(
    spectra: &CrossSpectra,
    ordinates: Range<usize>,
    j: usize,
    eta: &[f64],
    density: &dyn Fn(f64) -> f64,
    effective: f64,
    step_s: f64,
) -> Option<Transfer> {
    let eta = Vector3::new(eta[0], eta[1], eta[2]).map(|value| C::new(value, 0.0));
    let (mut m, mut v, mut u) = (Matrix3::<C>::zeros(), Vector3::<C>::zeros(), 0.0);
    let (mut plain_m, mut plain_v, mut plain_u) = (m, v, u);
    let mut slopes = Vector3::<C>::zeros();
    for k in ordinates.clone() {
        let (frequency, of) = (spectra.frequency_hz[k], &spectra.matrices[k]);
        let reference = Matrix3::from_fn(|i, l| of[(i, l)]);
        let cross = Vector3::from_fn(|i, _| of[(i, 3 + j)]);
        let weight = 1.0 / density(frequency);
        let scaled = reference * C::new(weight, 0.0);
        slopes += scaled * eta * C::new(0.0, -(2.0 * PI * frequency * step_s).sin() / step_s);
        m += scaled;
        v += cross * C::new(weight, 0.0);
        u += weight * of[(3 + j, 3 + j)].re;
        plain_m += reference;
        plain_v += cross;
        plain_u += of[(3 + j, 3 + j)].re;
    }
    let count = ordinates.len() as f64;
    let inverse = m.try_inverse()?;
    let apart = inverse * v;
    let freedom = 2.0 * (effective - 3.0);
    let scale = (u - v.dotc(&apart).re) / count * effective / (effective - 3.0);
    let covariance = inverse * C::new(scale * count / effective, 0.0);
    let bias = inverse * eta * C::new(-count / eta.norm_squared(), 0.0);
    let residual = plain_u - 2.0 * apart.dotc(&plain_v).re + apart.dotc(&(plain_m * apart)).re;
    let whole = plain_u + 2.0 * eta.dotc(&plain_v).re + eta.dotc(&(plain_m * eta)).re;
    let width_hz = spectra.frequency_hz.first()?;
    Some(Transfer {
        estimate: Estimate {
            value: parts(&(eta + apart)),
            covariance: Mat::from_fn(6, 6, |a, b| {
                let of = covariance[(a % 3, b % 3)];
                0.5 * match (a < 3, b < 3) {
                    (true, false) => -of.im,
                    (false, true) => of.im,
                    _ => of.re,
                }
            }),
            bias: parts(&bias),
            freedom,
        },
        late: parts(&(inverse * slopes)),
        coherence: 1.0 - residual / whole,
        residual: residual * width_hz,
    })
}

fn parts(values: &Vector3<C>) -> Vec<f64> {
    values.iter().map(|value| value.re).chain(values.iter().map(|value| value.im)).collect()
}

/// Complex degrees of freedom of the mean over `ordinates` neighbouring frequencies and the first sine tapers
/// of one segment:
///
/// (m K)²/Σ_abkl |G_ab(k − l)|², G_ab(d) = ∫ 2 sin(aπx) sin(bπx) e^(−2πi d x) dx over 0 … 1.
pub fn effective(tapers: usize, ordinates: usize) -> f64 {
    // ∫ cos(pπx) e^(−2πi d x) dx: real for even p, imaginary for odd p.
    let cosine = |p: usize, d: usize| -> (f64, f64) {
        if p % 2 == 1 {
            let (p, d) = (p as f64, d as f64);
            return (0.0, 4.0 * d / (4.0 * d * d - p * p) / PI);
        }
        let value = if p != 2 * d {
            0.0
        } else if p == 0 {
            1.0
        } else {
            0.5
        };
        (value, 0.0)
    };
    let mut common = 0.0;
    for a in 1..=tapers {
        for b in 1..=tapers {
            for d in 0..ordinates {
                let (near, far) = (cosine(a.abs_diff(b), d), cosine(a + b, d));
                let square = (near.0 - far.0).powi(2) + (near.1 - far.1).powi(2);
                let pairs = if d == 0 { ordinates } else { 2 * (ordinates - d) };
                common += pairs as f64 * square;
            }
        }
    }
    ((ordinates * tapers) as f64).powi(2) / common
}

#[cfg(test)]
mod tests {
    use super::*;
    use testkit::reference::{list, number, numbers, reference};

    #[test]
    fn freedom_of_means() {
        // One frequency: as many as tapers. Many: as many as frequencies over ∫ (Σ w²/K)² = 1 + 1/(2K).
        assert!((effective(3, 1) - 3.0).abs() < 1e-12);
        let many = effective(3, 4000) * (1.0 + 1.0 / 6.0) / 4000.0;
        assert!((many - 1.0).abs() < 1e-3, "{many}");
        // One taper, by sums over its squares.
        let (n, m) = (4096_usize, 5_usize);
        let square = |d: usize| {
            let (mut re, mut im) = (0.0, 0.0);
            for i in 0..n {
                let x = (i as f64 + 0.5) / n as f64;
                let w = 2.0 * (PI * x).sin().powi(2) / n as f64;
                re += w * (2.0 * PI * d as f64 * x).cos();
                im += w * (2.0 * PI * d as f64 * x).sin();
            }
            re * re + im * im
        };
        let sum: f64 = (0..m).flat_map(|k| (0..m).map(move |l| k.abs_diff(l))).map(square).sum();
        assert!((effective(1, m) - (m * m) as f64 / sum).abs() < 1e-6);
    }

    #[test]
    fn transfer_functions_of_scipy() {
        let fixture = reference("diffmag_bands");
        let series: Vec<Vec<f64>> = list(&fixture["series"]).iter().map(numbers).collect();
        let channels: Vec<&[f64]> = series.iter().map(Vec::as_slice).collect();
        let step_s = number(&fixture["step_s"]);
        for case in list(&fixture["cases"]) {
            let whole = |key: &str| case[key].as_u64().expect("a whole number") as usize;
            let spectra = CrossSpectra::of(&channels, step_s, whole("segment_samples"), whole("tapers"))
                .expect("spectra");
            for band in list(&case["bands"]) {
                let at = |key: &str| band[key].as_u64().expect("a whole number") as usize;
                let found = transfer(
                    &spectra,
                    at("from") - 1..at("to") - 1,
                    0,
                    &numbers(&fixture["eta"]),
                    &|f| 2e-3 / f + 0.1,
                    20.0,
                    step_s,
                )
                .expect("a transfer function");
                for (found, expected) in found.estimate.value.iter().zip(numbers(&band["z"])) {
                    assert!((found - expected).abs() < 1e-9, "{found} {expected}");
                }
                assert!((found.coherence - number(&band["coherence"])).abs() < 1e-9);
                let residual = number(&band["residual"]);
                assert!((found.residual / residual - 1.0).abs() < 1e-9);
            }
        }
    }
}
