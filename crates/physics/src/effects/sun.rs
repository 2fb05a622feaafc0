//! What the Sun does to a spacecraft: a field in SEN that depends on its direction and vanishes in eclipse.

use super::prelude::*;

/// Row by row whether the Sun shines, 1, or is eclipsed, 0, and its azimuth and elevation, rad.
fn sun<'a, T: Real>(around: &Surroundings<'a, T>) -> Result<impl Fn(usize) -> (f64, [f64; 2]) + use<'a, T>> {
    let context = around.context;
    let azimuth = context.angle("sun_azimuth");
    let azimuth = azimuth.ok_or_else(|| around.missing("the column `sun_azimuth_rad`"))?;
    let elevation = context.angle("sun_elevation");
    let (sunlit, eclipse) = (context.optional("sunlit"), context.optional("eclipse"));
    Ok(move |row| {
        let lit = match (&sunlit, &eclipse) {
            (Some(sunlit), _) => sunlit[row],
            (None, Some(eclipse)) => 1.0 - eclipse[row],
            (None, None) => 1.0,
        };
        (lit, [azimuth[row], elevation.as_ref().map_or(0.0, |angle| angle[row])])
    })
}

/// Adds Σ_n c_n seen_n to each component of a field; each component has N coefficients of its own.
fn add<T: Real, const N: usize>(parameters: &[T], seen: [f64; N], field: &mut Vector3<T>) {
    for (component, coefficients) in field.iter_mut().zip(parameters.chunks_exact(N)) {
        coefficients.iter().zip(seen).for_each(|(coefficient, seen)| *component += *coefficient * seen);
    }
}

/// Elevation and `sunlit` (1 in the Sun, 0 in eclipse), or `eclipse`, where there are such columns; else el = 0 and lit.
impl Effect for SunThermoelectric {
    const ABOUT: About = About {
        name: "sun_thermoelectric",
        title: "thermoelectric currents driven by the Sun",
        physics: "Sunlight warms one side of a metal structure, and currents between unlike metals flow that depend on \
            the direction of the Sun and vanish in eclipse.",
        equation: "dB_sen = sunlit (a + cos(el) (c cos(az) + s sin(az)) + u sin(el))",
        source: "Tøffner-Clausen et al. 2016, In-flight scalar calibration and characterisation of the Swarm magnetometry \
            package, Earth Planets Space 68, 129",
        parameters: amplitudes!(
            0.05 to 20.0: "x_lit_nt", "x_cosine_nt", "x_sine_nt", "x_up_nt",
                          "y_lit_nt", "y_cosine_nt", "y_sine_nt", "y_up_nt",
                          "z_lit_nt", "z_cosine_nt", "z_sine_nt", "z_up_nt"
        ),
        needs: &["sun_azimuth_rad"],
        ..About::of(Family::FollowsColumn, Place::Spacecraft, Stage::Block, Acts::Everything)
    };

    fn apply<T: Real>(parameters: &[T], signal: &mut [Vector3<T>], around: &Surroundings<'_, T>) -> Result {
        let sun = sun(around)?;
        for (row, field) in signal.iter_mut().enumerate() {
            let (lit, [azimuth, elevation]) = sun(row);
            let (up, level) = elevation.sin_cos();
            let (sine, cosine) = azimuth.sin_cos();
            add(parameters, [lit, lit * level * cosine, lit * level * sine, lit * up], field);
        }
        Ok(())
    }
}

/// Highest degree of the harmonics.
const DEGREE: usize = 4;
/// Harmonics up to that degree.
pub const HARMONICS: usize = (DEGREE + 1) * (DEGREE + 1);

/// Coefficients of one component, by degree and order, a cosine before its sine; a higher degree is smaller.
macro_rules! component {
    ($axis:literal) => {
        component!(
            $axis,
            0.05 to 20.0: "00" "10" "c11" "s11",
            0.05 to 10.0: "20" "c21" "s21" "c22" "s22",
            0.02 to 5.0: "30" "c31" "s31" "c32" "s32" "c33" "s33" "40" "c41" "s41" "c42" "s42" "c43" "s43" "c44" "s44"
        )
    };
    ($axis:literal, $($low:literal to $high:literal: $($order:literal)+),+) => {
        [$($(ParameterInfo::amplitude(concat!($axis, "_", $order, "_nt"), $low, $high)),+),+]
    };
}

const COMPONENTS: &[[ParameterInfo; HARMONICS]] = &[component!("x"), component!("y"), component!("z")];

/// P_nm are Schmidt's, of which the squares over the sphere have the mean 1/(2n + 1).
impl Effect for SunThermoelectricHarmonics {
    const ABOUT: About = About {
        name: "sun_thermoelectric_harmonics",
        title: "field that varies smoothly with the direction of the Sun",
        physics: "What the Sun heats, and the currents that flow for it, depend on the shape of the spacecraft and its shadows: the \
            field is a smooth function of the Sun's direction and vanishes in eclipse.",
        equation: "dB_sen = sunlit sum_nm P_nm(sin el) (c_nm cos(m az) + s_nm sin(m az)), n = 0..4, P_nm after Schmidt",
        parameters: COMPONENTS.as_flattened(),
        ..SunThermoelectric::ABOUT
    };

    fn apply<T: Real>(parameters: &[T], signal: &mut [Vector3<T>], around: &Surroundings<'_, T>) -> Result {
        let sun = sun(around)?;
        for (row, field) in signal.iter_mut().enumerate() {
            let (lit, direction) = sun(row);
            add(parameters, harmonics_at(direction).map(|seen| lit * seen), field);
        }
        Ok(())
    }
}

/// Schmidt's harmonics in the direction of an azimuth and an elevation, in the order of the parameters.
pub fn harmonics_at([azimuth, elevation]: [f64; 2]) -> [f64; HARMONICS] {
    let (up, level) = elevation.sin_cos();
    // P_mm, then up in degree: √((n+m)(n−m)) P_nm = (2n − 1) sin el P_(n−1)m − √((n+m−1)(n−m−1)) P_(n−2)m.
    let mut p = [[0.0; DEGREE + 1]; DEGREE + 1];
    p[0][0] = 1.0;
    for m in 0..=DEGREE {
        if m > 0 {
            let next = if m == 1 { 1.0 } else { ((2 * m - 1) as f64 / (2 * m) as f64).sqrt() };
            p[m][m] = next * level * p[m - 1][m - 1];
        }
        for n in m + 1..=DEGREE {
            let below = if n > m + 1 { p[n - 2][m] } else { 0.0 };
            let root = |n: usize| (((n + m) * (n - m)) as f64).sqrt();
            p[n][m] = ((2 * n - 1) as f64 * up * p[n - 1][m] - root(n - 1) * below) / root(n);
        }
    }
    let mut all = [0.0; HARMONICS];
    let mut at = 0;
    for (n, p) in p.iter().enumerate() {
        all[at] = p[0];
        at += 1;
        for (m, p) in p.iter().enumerate().take(n + 1).skip(1) {
            let (sine, cosine) = (m as f64 * azimuth).sin_cos();
            (all[at], all[at + 1]) = (p * cosine, p * sine);
            at += 2;
        }
    }
    all
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Means over the sphere: Gauss-Legendre along sin(el), even steps along the azimuth; exact to degree 9.
    #[test]
    fn harmonics_are_orthogonal_with_the_squares_of_schmidt() {
        let [a, b] = [2.0, -2.0].map(|sign| (5.0 + sign * (10.0_f64 / 7.0).sqrt()).sqrt() / 3.0);
        let (wa, wb) = ((322.0 - 13.0 * 70.0_f64.sqrt()) / 900.0, (322.0 + 13.0 * 70.0_f64.sqrt()) / 900.0);
        let nodes = [(-a, wa), (-b, wb), (0.0, 128.0 / 225.0), (b, wb), (a, wa)];
        let degree = |k: usize| (k as f64).sqrt().floor();
        for i in 0..HARMONICS {
            for j in 0..HARMONICS {
                let mut mean = 0.0;
                for (x, weight) in nodes {
                    for step in 0..16 {
                        let all =
                            harmonics_at([std::f64::consts::TAU * f64::from(step) / 16.0, f64::asin(x)]);
                        mean += 0.5 * weight / 16.0 * all[i] * all[j];
                    }
                }
                let expected = if i == j { 1.0 / (2.0 * degree(i) + 1.0) } else { 0.0 };
                assert!((mean - expected).abs() < 1e-12, "{i} {j}: {mean}");
            }
        }
        // By hand, el = 30°, az = 90°: P_33 = √(5/8) c³, its sine −1.
        let found = harmonics_at([90.0_f64.to_radians(), 30.0_f64.to_radians()])[15];
        assert!((found + (5.0_f64 / 8.0).sqrt() * 0.75_f64.powf(1.5)).abs() < 1e-12, "{found}");
    }
}
