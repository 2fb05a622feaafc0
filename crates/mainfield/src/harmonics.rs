//! A field from spherical harmonics.

/// Mean radius of the Earth to which Gauss coefficients refer, km.
pub const RADIUS_KM: f64 = 6371.2;

/// The field north, east and down at a geocentric place, in the unit of the coefficients: B = −∇V with
///
/// V = a Σₙ (a/r)ⁿ⁺¹ Σₘ (gₙᵐ cos mλ + hₙᵐ sin mλ) Pₙᵐ(cos θ)
///
/// and Schmidt's semi-normalised Pₙᵐ. Coefficients are in the order g₁⁰, g₁¹, h₁¹, g₂⁰, g₂¹, h₂¹, …; `latitude` and
/// `longitude` are in rad. At the poles north is along the meridian of `longitude`.
///
/// Source: Alken et al., Earth Planets Space 73, 49 (2021), eq. 1; recursions by differentiation of those of Pₙᵐ.
pub fn synthesis(coefficients: &[f64], latitude: f64, longitude: f64, radius_km: f64) -> [f64; 3] {
    // cos θ and sin θ of the colatitude.
    let (cos, sin) = latitude.sin_cos();
    let degrees = (coefficients.len() as f64 + 1.0).sqrt() as usize - 1;
    let ratio = RADIUS_KM / radius_km;
    let mut field = [0.0; 3];
    // Pₘᵐ and its derivative by θ; for m > 0 Pₘᵐ/sin θ, which is finite at the poles.
    let (mut first, mut first_slope, mut first_over) = (1.0, 0.0, 0.0);
    for m in 0..=degrees {
        let order = m as f64;
        if m > 0 {
            let factor = if m == 1 { 1.0 } else { (1.0 - 0.5 / order).sqrt() };
            first_over = factor * if m == 1 { 1.0 } else { sin * first_over };
            first_slope = factor * (sin * first_slope + cos * first);
            first *= factor * sin;
        }
        let (sin_m, cos_m) = (order * longitude).sin_cos();
        let (mut last, mut now) = ([0.0; 3], [first, first_slope, first_over]);
        for n in m.max(1)..=degrees {
            let degree = n as f64;
            if n > m {
                let before = ((degree - 1.0).powi(2) - order * order).sqrt();
                let by = (degree * degree - order * order).sqrt();
                let step = |k: usize, slope: f64| ((2.0 * degree - 1.0) * slope - before * last[k]) / by;
                let next =
                    [step(0, cos * now[0]), step(1, cos * now[1] - sin * now[0]), step(2, cos * now[2])];
                (last, now) = (now, next);
            }
            let place = n * n - 1 + if m == 0 { 0 } else { 2 * m - 1 };
            let (g, h) = (coefficients[place], if m == 0 { 0.0 } else { coefficients[place + 1] });
            let value = g * cos_m + h * sin_m;
            let power = ratio.powi(n as i32 + 2);
            field[0] += power * value * now[1];
            field[1] += power * order * (g * sin_m - h * cos_m) * now[2];
            field[2] -= power * (degree + 1.0) * value * now[0];
        }
    }
    field
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_field_is_the_gradient_of_a_potential() {
        // Σ over a closed way of B · dl is zero, and so is the divergence.
        let coefficients: Vec<f64> = (0..48).map(|k| f64::from((37 * k + 11) % 29) - 14.0).collect();
        let at = |latitude: f64, longitude: f64, r: f64| synthesis(&coefficients, latitude, longitude, r);
        let d = 1e-5;
        for (latitude, longitude, r) in [(0.3, 1.1, 6800.0), (-1.2, 4.0, 6400.0), (1.3, -2.0, 7000.0)] {
            let by = |k: usize, [dl, dm, dr]: [f64; 3]| {
                let [a, b] =
                    [1.0, -1.0].map(|s: f64| at(latitude + s * dl, longitude + s * dm, r + s * dr)[k]);
                (a - b) / (2.0 * d)
            };
            let [north, east, down] = at(latitude, longitude, r);
            let (sin, cos) = latitude.sin_cos();
            // Along the sphere, d is an angle; outwards a length of d r.
            let curl_r = by(1, [d, 0.0, 0.0]) * cos - east * sin - by(0, [0.0, d, 0.0]);
            let outwards = |k: usize| by(k, [0.0, 0.0, d * r]);
            let divergence =
                -outwards(2) - 2.0 * down + by(0, [d, 0.0, 0.0]) + (by(1, [0.0, d, 0.0]) - north * sin) / cos;
            let curl_across = outwards(0) + north + by(2, [d, 0.0, 0.0]);
            for rest in [curl_r, divergence, curl_across] {
                assert!(rest.abs() < 1e-6 * (north.hypot(east) + down.abs()), "{rest}");
            }
        }
    }
}
