//! Documents of sensors turned in a field, without the forward model: b = μᵀ B + noise, V = (b − O)/k.

use common::{Axis, Calibration, Document, Noise, NoiseOfSensors, ScalarCalibration};
use indexmap::IndexMap;
use nalgebra::{Matrix3, Rotation3, Vector3};
use noise::Stream;
use partial::Take;
use physics::Unit;
use rayon::prelude::*;
use scalarcal::stream::{self, Partial, Statistics};
use scalarcal::{Error, Options, Source};
use serde_json::json;
use std::ops::Range;

/// How the sensors are turned.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Turns {
    /// Any direction, one after the other at random.
    Any,
    /// Slowly over the sphere, on a spiral.
    Slow,
    /// About z in steps, tilted a little by hand.
    Poor,
    /// Exactly about z.
    AboutZ,
}

/// What is true, and how it is recorded.
#[derive(Clone, Debug)]
pub struct Campaign {
    pub rows: usize,
    pub turns: Turns,
    /// Noise of each sensor, nT: white, and flicker at 1 Hz (nT²/Hz).
    pub white_nt: f64,
    pub flicker: f64,
    pub reference_nt: f64,
    /// What the reference reads too much, nT.
    pub bias_nt: f64,
    /// Share by which the magnitude varies.
    pub varies: f64,
    /// By how much it wanders, nT/√s, where nothing measures it; with no value the reference does.
    pub wanders: Option<f64>,
    pub sensitivity: [f64; 3],
    pub offset_nt: [f64; 3],
    /// Angles xy, yz, xz off a right angle, rad.
    pub angles: [f64; 3],
    /// nT/K of each sensor.
    pub per_k: [f64; 3],
    /// Iron of the body: H − 1, symmetric, and h, nT.
    pub soft: Matrix3<f64>,
    pub hard_nt: Vector3<f64>,
}

/// The nine parameters, and how the offsets follow a temperature.
pub const NAMES: [&str; 15] =
    ["k x", "k y", "k z", "O x", "O y", "O z", "xy", "yz", "xz", "x/K", "x/K²", "y/K", "y/K²", "z/K", "z/K²"];
pub const MAGNITUDE_NT: f64 = 48_000.0;

impl Default for Campaign {
    fn default() -> Self {
        Self {
            rows: 600,
            turns: Turns::Any,
            white_nt: 0.5,
            flicker: 0.0,
            reference_nt: 0.1,
            bias_nt: 0.0,
            varies: 0.05,
            wanders: None,
            sensitivity: [6412.8, 6380.8, 6406.4],
            offset_nt: [12.0, -8.0, 4.0],
            angles: [0.0087, -0.0052, 0.0035],
            per_k: [0.0; 3],
            soft: Matrix3::zeros(),
            hard_nt: Vector3::zeros(),
        }
    }
}

impl Campaign {
    /// μ with x along x and y in the plane of x and y.
    pub fn mu(&self) -> Matrix3<f64> {
        let [xy, yz, xz] = self.angles.map(f64::sin);
        let y = (1.0 - xy * xy).sqrt();
        let across = (yz - xz * xy) / y;
        Matrix3::new(1.0, xy, xz, 0.0, y, across, 0.0, 0.0, (1.0 - xz * xz - across * across).sqrt())
    }

    /// The field in SEN in each row.
    fn fields(&self, stream: &mut Stream) -> Vec<Vector3<f64>> {
        let rows = self.rows as f64;
        let mut off = 0.0;
        (0..self.rows)
            .map(|row| {
                off += self.wanders.map_or(0.0, |size| size * stream.normal());
                let part = (row as f64 + 0.5) / rows;
                let direction = match self.turns {
                    Turns::Any => Vector3::from_fn(|_, _| stream.normal()).normalize(),
                    Turns::Slow => {
                        let (height, angle) = (1.0 - 2.0 * part, 40.0 * std::f64::consts::PI * part);
                        let across = (1.0 - height * height).sqrt();
                        Vector3::new(across * angle.cos(), across * angle.sin(), height)
                    }
                    Turns::Poor | Turns::AboutZ => {
                        let angle = 24.0 * std::f64::consts::PI * part;
                        let tilt = if self.turns == Turns::Poor { 0.2 * (7.3 * angle).sin() } else { 0.0 };
                        let level = Vector3::new(0.5 * angle.cos(), 0.5 * angle.sin(), 0.75_f64.sqrt());
                        Rotation3::from_axis_angle(&Vector3::x_axis(), tilt) * level
                    }
                };
                let wave = (part * 2.0 * std::f64::consts::PI * 7.0).sin();
                direction * (MAGNITUDE_NT * (1.0 + self.varies * wave) + off)
            })
            .collect()
    }

    /// The document.
    pub fn document(&self, seed: u64) -> Document {
        let mut stream = Stream::new(seed, "turns");
        let fields = self.fields(&mut stream);
        let mu = self.mu();
        let temperature: Vec<f64> =
            (0..self.rows).map(|row| 20.0 + 10.0 * (0.004 * row as f64).sin()).collect();
        let mut columns: Vec<(String, Vec<f64>)> =
            vec![("time_s".into(), (0..self.rows).map(|row| row as f64).collect())];
        for axis in 0..3 {
            let name = ["x", "y", "z"][axis];
            let mut noise = Stream::new(seed, name);
            // Cut out of a longer series: the noise did not begin with the recording.
            let slow = if self.flicker > 0.0 {
                noise::power_law(&mut noise, 64 * self.rows, 1.0, self.flicker, 1.0)
            } else {
                vec![0.0; self.rows]
            };
            let volts = fields.iter().enumerate().map(|(row, field)| {
                let along = mu.column(axis).dot(&(field + self.soft * field + self.hard_nt))
                    + self.white_nt * noise.normal()
                    + slow[row]
                    + self.per_k[axis] * (temperature[row] - 20.0);
                (along - self.offset_nt[axis]) / self.sensitivity[axis]
            });
            columns.push((format!("sensor_{name}_v"), volts.collect()));
        }
        let mut noise = Stream::new(seed, "reference");
        let reference =
            fields.iter().map(|field| field.norm() + self.bias_nt + self.reference_nt * noise.normal());
        if self.wanders.is_none() {
            columns.push(("reference_nt".into(), reference.collect()));
        }
        columns.push(("sensor_temperature_c".into(), temperature));
        let columns: IndexMap<String, Vec<f64>> = columns.into_iter().collect();
        let document = json!({
            "fluxcal": 1,
            "instrument": {"nominal_sensitivity_nt_per_v": 6400.0},
            "facility": {"reference_std_nt": self.reference_nt},
            "recordings": [{"id": "turned", "procedure": "free_run", "columns": columns}],
        });
        serde_json::from_value(document).expect("a document")
    }

    /// The nine true parameters, in order: sensitivities, offsets, angles (arcsec).
    pub fn truth(&self) -> [f64; 9] {
        let arcsec = self.angles.map(|angle| angle.to_degrees() * 3600.0);
        std::array::from_fn(|k| [self.sensitivity, self.offset_nt, arcsec][k / 3][k % 3])
    }
}

/// Some rows of the recording, as they are kept of a stream.
pub fn piece(document: &Document, rows: Range<usize>) -> Partial {
    let mut statistics = Statistics::new(Unit::Volt, Source::Scalar);
    take(&mut statistics, document, rows);
    statistics.finish().expect("a piece")
}

pub fn take(statistics: &mut Statistics, document: &Document, rows: Range<usize>) {
    let recording = &document.recordings[0];
    let column = |name: &str| &recording.column(name).expect("a column")[rows.clone()];
    let columns = ["time_s", "sensor_x_v", "sensor_y_v", "sensor_z_v", "reference_nt"].map(column);
    statistics.push(&columns).expect("good rows");
}

/// Declares that the noise is white.
pub fn declared(mut document: Document, white_nt: f64) -> Document {
    let noise = Noise { white_rms_nt: Some(white_nt), ..Noise::default() };
    document.instrument.get_or_insert_default().noise = Some(NoiseOfSensors::Same(noise));
    document
}

/// Sets the values of a column of the recording by what they are and by their rows.
pub fn change(document: &mut Document, name: &str, to: impl Fn(usize, f64) -> f64) {
    let column = document.recordings[0].columns.get_mut(name).expect("a column");
    column.iter_mut().enumerate().for_each(|(row, value)| *value = to(row, *value));
}

pub fn run(document: Document, options: &Options) -> Document {
    scalarcal::run(document, options).unwrap_or_else(|error| panic!("{error}"))
}

/// What is found of the rows at hand, or in one pass over those of the one recording.
pub fn result(document: Document, options: &Options, in_one_pass: bool) -> Result<Document, Error> {
    if !in_one_pass {
        return scalarcal::run(document, options);
    }
    let rows = 0..document.recordings[0].rows();
    stream::document(&piece(&document, rows), document, &options.fit)
}

/// The message of a refusal, or the findings.
pub fn told(result: Result<Document, Error>) -> String {
    result.map_or_else(|error| error.to_string(), |document| findings(&document))
}

pub fn scalar(document: &Document) -> &ScalarCalibration {
    document.calibration.as_ref().and_then(|c| c.scalar.as_ref()).expect("a calibration")
}

pub fn findings(document: &Document) -> String {
    scalar(document).findings.join("\n")
}

/// The parameters that were found, in the order of [`Campaign::truth`]: value, standard uncertainty.
pub fn found(document: &Document) -> Vec<(f64, f64)> {
    scalar(document).parameters.iter().map(|parameter| (parameter.value, parameter.std)).collect()
}

/// Errors of values with their standard uncertainties, as far as the truth goes.
pub fn errors(found: &[(f64, f64)], truth: &[f64]) -> Vec<(f64, f64)> {
    found.iter().zip(truth).map(|((value, std), truth)| (value - truth, *std)).collect()
}

/// That each value is within four standard uncertainties of the truth, as far as that goes.
pub fn near(found: &[(f64, f64)], truth: &[f64]) {
    for ((value, std), truth) in found.iter().zip(truth) {
        assert!((value - truth).abs() < 4.0 * std, "{value} {std} {truth}");
    }
}

/// The sensitivities of a calibration, then the offsets.
pub fn constants(calibration: &Calibration) -> Vec<f64> {
    let of = |axis: Axis| calibration.sensor(axis).expect("a sensor");
    let sensitivities = Axis::ALL.map(|axis| of(axis).sensitivity_nt_per_v.as_ref().expect("k").value());
    let offsets = Axis::ALL.map(|axis| of(axis).offset_nt.as_ref().expect("an offset").value());
    [sensitivities, offsets].concat()
}

/// Unit vectors along the sensors of a calibration.
pub fn directions(calibration: &Calibration) -> [Vector3<f64>; 3] {
    let axes = calibration.axes.as_ref().and_then(|axes| axes.sensors.as_ref()).expect("axes");
    let matrix = axes.matrix.expect("directions");
    [0, 1, 2].map(|k| Vector3::from_fn(|row, _| matrix[row][k]).normalize())
}

/// Runs so many campaigns as are usual (FLUXCAL_CAMPAIGNS sets another number) and checks that intervals of
/// 95 % hold as often as a band says. Error and standard uncertainty come of a seed.
pub fn intervals_hold(
    name: &str,
    parameters: &[&str],
    (usual, band): (u64, [f64; 2]),
    of: impl Fn(u64) -> Vec<(f64, f64)> + Sync + Send,
) -> Vec<Vec<(f64, f64)>> {
    let campaigns: Vec<Vec<(f64, f64)>> = (0..testkit::campaigns(usual)).into_par_iter().map(of).collect();
    let count = campaigns.len();
    for (place, parameter) in parameters.iter().enumerate() {
        let all = || campaigns.iter().map(|one| one[place]);
        let inside = all().filter(|(off, std)| off.abs() <= 1.96 * std).count();
        let mean = |of: fn((f64, f64)) -> f64| all().map(of).sum::<f64>() / count as f64;
        println!(
            "{name}, {parameter}: {inside} of {count} inside, mean error {:+.3e}, rms {:.3e}, standard uncertainty {:.3e}",
            mean(|(off, _)| off),
            mean(|(off, _)| off * off).sqrt(),
            mean(|(_, std)| std)
        );
        let agrees = testkit::agrees(inside, count, band, parameters.len());
        assert!(agrees, "{name}, {parameter}: {inside} of {count} in their 95 % intervals");
    }
    campaigns
}
