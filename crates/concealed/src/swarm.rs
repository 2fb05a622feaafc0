//! An orbit: a vector magnetometer beside a scalar one for thirty days, and a disturbance that depends on the
//! Sun's direction in the body.

mod earth;

use nalgebra::{Matrix3, Vector3};
use serde_json::{Map, Value, json};

use crate::case::{Case, TrueEffect, Truth, nonce};
use crate::document::{rounded, rows};
use crate::draw::Draw;
use crate::scene::AXES;
use crate::sets::neutral;

pub use earth::Moment;

/// Time from one row to the next, s, and how long it goes on, days.
const STEP_S: f64 = 120.0;
const DAYS: f64 = 30.0;
/// Noise of a vector reading and of the scalar magnetometer, nT.
const VECTOR_NT: f64 = 0.14;
const SCALAR_NT: f64 = 0.05;
/// Rms of the disturbance along the field, over sunlit rows and eclipse alike, nT.
const SIZE_NT: f64 = 1.0;

/// Terms of a smooth function of the Sun's direction s: all products of its components up to the third
/// degree, the constant first.
const TERMS: usize = 16;

fn terms(s: &Vector3<f64>) -> [f64; TERMS] {
    let (x, y, z) = (s.x, s.y, s.z);
    [
        1.0,
        x,
        y,
        z,
        x * y,
        y * z,
        z * x,
        x * x - y * y,
        3.0 * z * z - 1.0,
        x * (x * x - 3.0 * y * y),
        y * (3.0 * x * x - y * y),
        z * (x * x - y * y),
        x * y * z,
        x * (5.0 * z * z - 1.0),
        y * (5.0 * z * z - 1.0),
        z * (5.0 * z * z - 3.0),
    ]
}

/// The orbit with what is true on it.
pub struct Flight {
    /// What is written and what is sealed.
    pub case: Case,
    /// The moments of the rows.
    pub moments: Vec<Moment>,
    /// The disturbance at each row, body frame, nT.
    pub disturbance: Vec<Vector3<f64>>,
    /// |vector| as the stated calibration corrects it, less the scalar reading, nT.
    pub residual: Vec<f64>,
}

/// The flight of a seed.
///
/// Near-polar at 460 km, the body looking down and along the velocity, the local time drifting by 2.7 min a
/// day as Swarm's does; the field is the International Geomagnetic Reference Field to degree 3. The
/// disturbance is a vector fixed in the body,
///
/// ```text
/// d(s) = Σ_k c_k Y_k(s) in the Sun, 0 in the Earth's shadow
/// ```
///
/// s the Sun's direction in the body, Y_k the spherical harmonics to degree 3. Source: Tøffner-Clausen et al.
/// 2016, In-flight scalar calibration and characterisation of the Swarm magnetometry package, Earth Planets
/// Space 68, 129.
pub fn flight(seed: u64) -> Flight {
    let mut draw = Draw::new("swarm", seed);
    let count = (DAYS * 86_400.0 / STEP_S) as usize;
    let start_longitude = draw.between(0.0, 360.0);
    let moments: Vec<Moment> =
        (0..count).map(|row| Moment::at(row as f64 * STEP_S, start_longitude)).collect();

    let coefficients: Vec<Vector3<f64>> =
        (0..TERMS).map(|_| Vector3::from_fn(|_, _| draw.normal())).collect();
    let shape = |moment: &Moment| -> Vector3<f64> {
        let lit = if moment.eclipse { 0.0 } else { 1.0 };
        terms(&moment.sun).iter().zip(&coefficients).map(|(term, c)| c * (lit * term)).sum()
    };
    let along = |moment: &Moment| shape(moment).dot(&moment.field.normalize());
    let size = SIZE_NT / rms(moments.iter().map(along));
    let disturbance: Vec<Vector3<f64>> = moments.iter().map(|moment| shape(moment) * size).collect();

    let instrument = Instrument::of(&mut draw);
    let warm = |t: f64| {
        let orbit = std::f64::consts::TAU * t / earth::PERIOD_S;
        18.0 + 1.5 * orbit.sin() + 2.0 * (std::f64::consts::TAU * t / (11.0 * 86_400.0)).sin()
    };
    let temperature: Vec<f64> = moments.iter().map(|m| warm(m.time_s) + 0.1 * draw.normal()).collect();
    let mut readings = [0; 3].map(|_| Vec::with_capacity(count));
    let (mut scalar, mut noise) = (Vec::with_capacity(count), Vec::with_capacity(count));
    for (moment, disturbance) in moments.iter().zip(&disturbance) {
        let own: Vector3<f64> = Vector3::from_fn(|_, _| VECTOR_NT * draw.normal());
        let of_scalar = SCALAR_NT * draw.normal();
        noise.push(own.dot(&moment.field.normalize()) - of_scalar);
        let read = instrument.read(&(moment.field + disturbance));
        readings.iter_mut().enumerate().for_each(|(k, column)| column.push(read[k] + own[k]));
        scalar.push(moment.field.norm() + of_scalar);
    }
    let stated = instrument.stated(&mut draw);
    let residual = (0..count)
        .map(|row| stated.corrected(&Vector3::from_fn(|k, _| readings[k][row])).norm() - scalar[row])
        .collect();

    let mut columns = Map::new();
    columns.insert("time_s".into(), rounded(moments.iter().map(|m| m.time_s), 1.0));
    for (axis, readings) in AXES.iter().zip(&readings) {
        columns.insert(format!("sensor_{axis}_nt"), rounded(readings.iter().copied(), 1e-3));
    }
    columns.insert("reference_nt".into(), rounded(scalar.iter().copied(), 1e-3));
    columns.insert("sensor_temperature_c".into(), rounded(temperature.iter().copied(), 1e-2));
    columns.insert("sun_azimuth_rad".into(), rounded(moments.iter().map(|m| m.sun.y.atan2(m.sun.x)), 1e-6));
    columns.insert("sun_elevation_rad".into(), rounded(moments.iter().map(|m| m.sun.z.asin()), 1e-6));
    columns.insert("eclipse".into(), rounded(moments.iter().map(|m| f64::from(u8::from(m.eclipse))), 1.0));
    let case = neutral(&format!("swarm/{seed}"));
    let document = json!({
        "fluxcal": 1,
        "title": case,
        "facility": {"reference_std_nt": SCALAR_NT},
        "instrument": {"range_nt": 65000, "quantisation_nt": 0.001, "noise": {"white_rms_nt": VECTOR_NT}},
        "calibration": stated.calibration(),
        "recordings": [{"id": "orbits", "procedure": "free_run", "start": "2026-01-10T00:00:00+00:00", "columns": columns}],
    });
    let truth = Truth {
        case,
        set: "swarm".into(),
        seed,
        number: 0,
        strength: SIZE_NT / VECTOR_NT.hypot(SCALAR_NT),
        length: "long".into(),
        covariates: "apart".into(),
        scene: "an orbit".into(),
        readings: count,
        recorded: Vec::new(),
        noise_nt: rms(noise.iter().copied()),
        effects: vec![TrueEffect {
            name: "sun_thermoelectric".into(),
            physics: "a vector in the body, spherical harmonics to degree 3 of the Sun's direction, zero in eclipse".into(),
            accepted: vec!["sun_thermoelectric".into(), "sun_thermoelectric_harmonics".into()],
            sensors: Vec::new(),
            parameters: Map::from_iter([(
                "terms_nt".to_string(),
                json!(coefficients.iter().map(|c| [c.x * size, c.y * size, c.z * size]).collect::<Vec<_>>()),
            )]),
            form_error: 0.0,
            left_nt: SIZE_NT,
        }],
        without: Vec::new(),
        nonce: nonce(&mut draw),
    };
    Flight { case: Case { document, truth }, moments, disturbance, residual }
}

/// Rms of a series.
pub fn rms(values: impl Iterator<Item = f64>) -> f64 {
    let (sum, count) = values.fold((0.0, 0_usize), |(sum, count), v| (sum + v * v, count + 1));
    (sum / count.max(1) as f64).sqrt()
}

/// k M + O = μᵀ B.
#[derive(Clone, Debug)]
struct Instrument {
    mu: Matrix3<f64>,
    sensitivity: Vector3<f64>,
    offset_nt: Vector3<f64>,
}

/// Standard uncertainties of the calibration before flight: relative, nT, arcsec.
const BEFORE_FLIGHT: [f64; 3] = [2e-6, 0.1, 0.5];

impl Instrument {
    fn of(draw: &mut Draw) -> Self {
        let mut mu = Matrix3::identity();
        for k in 0..3 {
            let column = Vector3::from_fn(|j, _| if j == k { 1.0 } else { 2e-3 * draw.between(-1.0, 1.0) });
            mu.set_column(k, &column.normalize());
        }
        Self {
            mu,
            sensitivity: Vector3::from_fn(|_, _| 1.0 + 5e-4 * draw.between(-1.0, 1.0)),
            offset_nt: Vector3::from_fn(|_, _| draw.between(-10.0, 10.0)),
        }
    }

    fn read(&self, field: &Vector3<f64>) -> Vector3<f64> {
        (self.mu.tr_mul(field) - self.offset_nt).component_div(&self.sensitivity)
    }

    fn corrected(&self, reading: &Vector3<f64>) -> Vector3<f64> {
        let along = reading.component_mul(&self.sensitivity) + self.offset_nt;
        self.mu.transpose().try_inverse().map_or(along, |inverse| inverse * along)
    }

    /// What was found before flight.
    fn stated(&self, draw: &mut Draw) -> Self {
        let [relative, offset, arcsec] = BEFORE_FLIGHT;
        let mut stated = self.clone();
        stated.sensitivity.iter_mut().for_each(|k| *k *= 1.0 + relative * draw.normal());
        stated.offset_nt.iter_mut().for_each(|o| *o += offset * draw.normal());
        for mut column in stated.mu.column_iter_mut() {
            column.iter_mut().for_each(|part| *part += arcsec * 4.848e-6 * draw.normal());
            let norm = column.norm();
            column /= norm;
        }
        stated
    }

    fn calibration(&self) -> Value {
        let [relative, offset, arcsec] = BEFORE_FLIGHT;
        let sensors: Map<String, Value> = (0..3)
            .map(|k| {
                let sensitivity = json!({"value": self.sensitivity[k], "std": relative});
                let offset = json!({"value": self.offset_nt[k], "std": offset});
                (AXES[k].to_string(), json!({"sensitivity_nt_per_nt": sensitivity, "offset_nt": offset}))
            })
            .collect();
        json!({"sensors": sensors, "axes": {"sensors": {"matrix": rows(&self.mu), "std_arcsec": arcsec}},
            "reference_conditions": {"sensor_temperature_c": 18.0}})
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_scalar_residual_is_a_nanotesla_in_the_sun_and_the_noise_in_eclipse() {
        let flight = flight(1);
        let of = |eclipse: bool| {
            let rows = flight.moments.iter().zip(&flight.residual).filter(|(m, _)| m.eclipse == eclipse);
            rms(rows.map(|(_, residual)| *residual))
        };
        let share = flight.moments.iter().filter(|m| m.eclipse).count() as f64 / flight.moments.len() as f64;
        assert!((0.2..0.45).contains(&share), "{share}");
        assert!((0.9..1.8).contains(&of(false)) && of(true) < 0.35, "{} {}", of(false), of(true));
    }

    /// The harmonics are orthogonal over the sphere.
    #[test]
    fn terms_are_orthogonal() {
        let mut sums = [[0.0; TERMS]; TERMS];
        let count = 200;
        for i in 0..count {
            let z = (2 * i + 1) as f64 / count as f64 - 1.0;
            for j in 0..64 {
                let angle = std::f64::consts::TAU * f64::from(j) / 64.0;
                let across = (1.0 - z * z).sqrt();
                let of = terms(&Vector3::new(across * angle.cos(), across * angle.sin(), z));
                (0..TERMS).for_each(|a| (0..TERMS).for_each(|b| sums[a][b] += of[a] * of[b]));
            }
        }
        for (a, row) in sums.iter().enumerate() {
            for (b, sum) in row.iter().enumerate() {
                let scale = (row[a] * sums[b][b]).sqrt();
                assert!(a == b || sum.abs() < 1e-3 * scale, "{a} {b}");
            }
        }
    }
}
