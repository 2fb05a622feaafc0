//! What all procedures are planned with: the facility as it is stated, its limits, and the fixture.

use common::number::bare;
use common::range::{SCALAR_MARGIN, SCALAR_NT};
use common::{Axis, Conditions, Document, Error, Facility, Noise};
use nalgebra::{Matrix3, Rotation3, Vector3};
use noise::Stream;
use physics::Basic;
use physics::frames::{self, ARCSEC};

use crate::differential::DifferentialTruth;
use crate::outside::OutsidePlan;
use crate::planned::{Planned, Reads, Rows, Step};
use crate::timing::Timing;

/// Rows that a campaign may have in all its recordings together.
pub const MOST_ROWS: f64 = 5e7;

/// What the operator knows and has.
pub struct Bench<'a> {
    pub seed: u64,
    pub start: Option<&'a str>,
    pub timing: &'a Timing,
    pub outside: Option<&'a OutsidePlan>,
    pub differential: Option<&'a DifferentialTruth>,
    /// What the document will state of facility, instrument and calibration.
    pub document: &'a Document,
    /// The chain as it is stated: the operator sets currents by it.
    pub stated: &'a Basic,
    pub truth: &'a Basic,
}

impl Bench<'_> {
    pub fn facility(&self) -> Option<&Facility> {
        self.document.facility.as_ref()
    }

    /// The sensors of a procedure: its own, else the instrument's, else all.
    pub fn sensors(&self, own: &Option<Vec<Axis>>, path: &str) -> Result<Vec<Axis>, Error> {
        let instrument = self.document.instrument.as_ref().and_then(|instrument| instrument.sensors.as_ref());
        for (path, list) in [(path, own.as_ref()), ("instrument", instrument)] {
            list.map_or(Ok(()), |list| filled(path, "sensors", list, "at least one sensor"))?;
        }
        Ok(own.as_ref().or(instrument).map_or(Axis::ALL.to_vec(), Vec::clone))
    }

    /// The currents that the operator sets for a field along each coil, nT -> A.
    pub fn currents(&self, field_nt: Vector3<f64>) -> Vector3<f64> {
        Vector3::from_fn(|c, _| {
            let coil = &self.stated.coils[c];
            let current = (field_nt[c] - coil.offset_nt) / coil.constant_nt_per_a;
            if coil.constant_nt_per_a == 0.0 { 0.0 } else { current }
        })
    }

    /// The coil has a constant, and makes no more than the facility says.
    pub fn within(&self, coil: Axis, field_nt: f64, path: &str) -> Result<(), Error> {
        if field_nt != 0.0 && self.stated.coils[coil.index()].constant_nt_per_a == 0.0 {
            let found = format!("a drive of coil {coil}, whose constant is not stated");
            let expected = format!("calibration.coils.{coil}.constant_nt_per_a in the plan");
            return Err(Error::document(path, found, expected));
        }
        let Some(max) = self.max_nt(coil).filter(|max| field_nt.abs() > *max) else { return Ok(()) };
        let found = format!("{} nT on coil {coil}", bare(field_nt.abs()));
        let expected = format!("at most {max} nT, which is what facility.coils.{coil}.max_nt allows");
        Err(Error::document(path, found, expected))
    }

    /// The scalar magnetometer reads such a field: `coilcal` refuses readings beyond its range.
    pub fn scalar_reads(&self, field_nt: f64, path: &str) -> Result<(), Error> {
        let stated = self.facility().and_then(|facility| facility.reference_range_nt);
        let [low, high] = stated.unwrap_or(SCALAR_NT);
        if (low * (1.0 - SCALAR_MARGIN)..=high * (1.0 + SCALAR_MARGIN)).contains(&field_nt) {
            return Ok(());
        }
        let found = format!("{field_nt} nT, which the scalar magnetometer does not read");
        let expected =
            format!("{low} to {high} nT; another magnetometer's range is `facility.reference_range_nt`");
        Err(Error::document(path, found, expected))
    }

    /// The largest field of a coil, nT, where it is stated.
    pub fn max_nt(&self, coil: Axis) -> Option<f64> {
        let coils = self.facility().and_then(|facility| facility.coils.as_ref())?;
        coils.get(coil)?.max_nt
    }

    /// A sensor turned along a coil, and the block about it by quarters of a turn, as a procedure begins.
    pub fn along(
        &self,
        id: &str,
        sensor: Axis,
        coil: Axis,
        alignment_arcmin: f64,
        quarter_turns: f64,
    ) -> Aligned {
        // The nominal turn takes the coil's axis to the sensor's; the fixture is then adjusted to the largest
        // reading.
        let steps = (3 + sensor.index() - coil.index()) % 3;
        let mut nominal = Matrix3::from_fn(|row, column| f64::from(u8::from(row == (column + steps) % 3)));
        nominal = turn(sensor, quarter_turns) * nominal;
        let from = nominal * self.truth.eta.column(coil.index());
        let to = self.truth.mu.column(sensor.index()).into_owned();
        let between = Rotation3::rotation_between(&from, &to).unwrap_or_else(Rotation3::identity);
        let mut stream = Stream::new(self.seed, &format!("{id}/fixture"));
        let missed = self.random(&mut stream, alignment_arcmin * 60.0 * ARCSEC);
        let rotation = frames::small_rotation(&missed) * between.into_inner() * nominal;
        let theodolite = self.theodolite_arcsec();
        let read = frames::small_rotation(&self.random(&mut stream, theodolite * ARCSEC)) * rotation;
        let conditions = Conditions {
            sensor: Some(sensor),
            coil: Some(coil),
            orientation: Some(frames::rows(&read)),
            ..Conditions::default()
        };
        let rows = Rows::new(format!("sensor {sensor} along coil {coil}"), self.timing.orientation_s);
        Aligned { sensor, conditions, rotations: [rotation, nominal], rows }
    }

    /// Standard deviation of one theodolite reading with what it has in common with others, arcsec.
    pub fn theodolite_arcsec(&self) -> f64 {
        let facility = self.facility();
        facility.and_then(|facility| facility.theodolite_std_arcsec(1)).unwrap_or(0.0)
    }

    pub fn random(&self, stream: &mut Stream, std: f64) -> Vector3<f64> {
        Vector3::from_fn(|_, _| stream.normal() * std)
    }

    /// Readings at one drive, after the field has settled.
    pub fn set(&self, action: String, field_nt: Vector3<f64>, readings: usize) -> Step {
        let (wait_s, length_s) = (self.timing.field_settle_s, readings as f64 * self.timing.reading_s);
        Step { current_a: self.currents(field_nt), ..Step::still(action, wait_s, readings, length_s) }
    }

    /// A series without drive.
    pub fn record(&self, action: String, length_s: f64, step_s: f64) -> Step {
        let readings = (length_s / step_s).round() as usize;
        Step::still(action, self.timing.field_settle_s, readings, length_s)
    }
}

/// A turn about an axis. Whole quarters are exact.
fn turn(axis: Axis, quarters: f64) -> Matrix3<f64> {
    let quarters = quarters.rem_euclid(4.0);
    let whole = [[0.0, 1.0], [1.0, 0.0], [0.0, -1.0], [-1.0, 0.0]];
    let [sin, cos] = if quarters.fract() == 0.0 {
        whole[quarters as usize % 4]
    } else {
        let (sin, cos) = (quarters * std::f64::consts::FRAC_PI_2).sin_cos();
        [sin, cos]
    };
    let (first, second) = ((axis.index() + 1) % 3, (axis.index() + 2) % 3);
    let mut turn = Matrix3::zeros();
    turn[(axis.index(), axis.index())] = 1.0;
    (turn[(first, first)], turn[(second, second)]) = (cos, cos);
    (turn[(first, second)], turn[(second, first)]) = (-sin, sin);
    turn
}

pub struct Aligned {
    sensor: Axis,
    /// Sensor, coil and the orientation as the theodolites read it.
    conditions: Conditions,
    /// The orientation as it is, and as the operator sets it.
    rotations: [Matrix3<f64>; 2],
    /// Rows that begin when it is there.
    pub rows: Rows,
}

impl Aligned {
    /// The recording of the sensor with what was driven on these coils.
    pub fn recording(self, procedure: &str, id: String, path: &str, coils: &[Axis]) -> Planned {
        let [rotation, nominal] = self.rotations;
        Planned {
            rotation,
            nominal,
            reads: Reads::Sensors(vec![self.sensor]),
            ..Planned::new(procedure, id, path, self.conditions, self.rows, coils)
        }
    }
}

pub fn positive<const COUNT: usize>(path: &str, values: [(&str, f64); COUNT]) -> Result<(), Error> {
    values.into_iter().try_for_each(|(key, value)| {
        held(value.is_finite() && value > 0.0, path, key, value.to_string(), "a positive number")
    })
}

pub fn filled<T>(path: &str, key: &str, list: &[T], expected: &str) -> Result<(), Error> {
    held(!list.is_empty(), path, key, "an empty list", expected)
}

pub fn deviation(path: &str, key: &str, value: f64) -> Result<(), Error> {
    held(value >= 0.0, path, key, "a negative number", "a standard deviation")
}

pub fn exponent(path: &str, noise: &Noise) -> Result<(), Error> {
    let exponent = noise.flicker_exponent.unwrap_or(1.0);
    let expected = "an exponent from 0 (white) to 2 (random walk)";
    held((0.0..=2.0).contains(&exponent), path, "flicker_exponent", exponent.to_string(), expected)
}

fn held(holds: bool, path: &str, key: &str, found: impl Into<String>, expected: &str) -> Result<(), Error> {
    if holds { Ok(()) } else { Err(Error::document(format!("{path}.{key}"), found, expected)) }
}

/// Samples of a series; refuses too few and too many.
pub fn samples(path: &str, count: f64, least: f64) -> Result<f64, Error> {
    samples_up_to(MOST_ROWS, path, count, least)
}

/// The same of a series with a limit of its own.
pub fn samples_up_to(most: f64, path: &str, count: f64, least: f64) -> Result<f64, Error> {
    if (least..=most).contains(&count) {
        return Ok(count);
    }
    let found =
        format!("{} {} in one recording", bare(count), if count == 1.0 { "sample" } else { "samples" });
    Err(Error::document(path, found, format!("at least {} and at most {}", bare(least), bare(most))))
}

/// Numbers from −to to +to in so many points.
pub fn sweep(to: f64, points: usize) -> Vec<f64> {
    (0..points).map(|step| -to + 2.0 * to * step as f64 / (points - 1).max(1) as f64).collect()
}

/// A unit vector times a number.
pub fn on(coil: Axis, field_nt: f64) -> Vector3<f64> {
    Vector3::ith(coil.index(), field_nt)
}
