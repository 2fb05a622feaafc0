//! What all procedures are planned with: the facility as it is stated, its limits, and the fixture.

use common::number::bare;
use common::range::{SCALAR_MARGIN, SCALAR_NT};
use common::{Axis, Conditions, Document, Error, Facility};
use nalgebra::{Matrix3, Vector3};
use noise::Stream;
use physics::Basic;
use physics::frames::{self, ARCSEC};

use crate::differential::DifferentialTruth;
use crate::outside::OutsidePlan;
use crate::planned::Step;
use crate::timing::Timing;

/// Rows that a campaign may have in all its recordings together.
pub const MOST_ROWS: f64 = 5e7;

/// What the operator knows and has.
pub struct Bench<'a> {
    /// Seed of all noise.
    pub seed: u64,
    /// When the campaign begins, where that is planned.
    pub start: Option<&'a str>,
    /// How long things take.
    pub timing: &'a Timing,
    /// The natural field outside, where there is one.
    pub outside: Option<&'a OutsidePlan>,
    /// The two magnetometers of a differential recording, where there are two.
    pub differential: Option<&'a DifferentialTruth>,
    /// What the document will state of facility, instrument and calibration.
    pub document: &'a Document,
    /// The chain as it is stated: the operator sets currents by it.
    pub stated: &'a Basic,
    /// The chain as it is true.
    pub truth: &'a Basic,
}

impl Bench<'_> {
    /// The facility as it is stated.
    pub fn facility(&self) -> Option<&Facility> {
        self.document.facility.as_ref()
    }

    /// The sensors of a procedure: its own, else the instrument's, else all.
    pub fn sensors(&self, own: &Option<Vec<Axis>>, path: &str) -> Result<Vec<Axis>, Error> {
        if own.as_ref().is_some_and(Vec::is_empty) {
            return Err(Error::document(format!("{path}.sensors"), "an empty list", "at least one sensor"));
        }
        let instrument = self.document.instrument.as_ref().and_then(|instrument| instrument.sensors.clone());
        if instrument.as_ref().is_some_and(Vec::is_empty) {
            return Err(Error::document("instrument.sensors", "an empty list", "at least one sensor"));
        }
        Ok(own.clone().or(instrument).unwrap_or_else(|| Axis::ALL.to_vec()))
    }

    /// The currents that the operator sets for a field along each coil, nT -> A.
    pub fn currents(&self, field_nt: Vector3<f64>) -> Vector3<f64> {
        Vector3::from_fn(|c, _| {
            let coil = &self.stated.coils[c];
            if coil.constant_nt_per_a == 0.0 {
                0.0
            } else {
                (field_nt[c] - coil.offset_nt) / coil.constant_nt_per_a
            }
        })
    }

    /// The coil has a constant, and makes no more than the facility says.
    pub fn within(&self, coil: Axis, field_nt: f64, path: &str) -> Result<(), Error> {
        if field_nt != 0.0 && self.stated.coils[coil.index()].constant_nt_per_a == 0.0 {
            return Err(Error::document(
                path,
                format!("a drive of coil {coil}, whose constant is not stated"),
                format!("calibration.coils.{coil}.constant_nt_per_a in the plan"),
            ));
        }
        match self.max_nt(coil).filter(|max| field_nt.abs() > *max) {
            Some(max) => Err(Error::document(
                path,
                format!("{} nT on coil {coil}", bare(field_nt.abs())),
                format!("at most {max} nT, which is what facility.coils.{coil}.max_nt allows"),
            )),
            None => Ok(()),
        }
    }

    /// The scalar magnetometer reads such a field: `coilcal` refuses readings beyond its range.
    pub fn scalar_reads(&self, field_nt: f64, path: &str) -> Result<(), Error> {
        let stated = self.facility().and_then(|facility| facility.reference_range_nt);
        let [low, high] = stated.unwrap_or(SCALAR_NT);
        if (low * (1.0 - SCALAR_MARGIN)..=high * (1.0 + SCALAR_MARGIN)).contains(&field_nt) {
            return Ok(());
        }
        Err(Error::document(
            path,
            format!("{field_nt} nT, which the scalar magnetometer does not read"),
            format!("{low} to {high} nT; another magnetometer's range is `facility.reference_range_nt`"),
        ))
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
        let between =
            nalgebra::Rotation3::rotation_between(&from, &to).unwrap_or_else(nalgebra::Rotation3::identity);
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
        Aligned { conditions, rotation, nominal }
    }

    /// Standard deviation of one theodolite reading with what it has in common with others, arcsec.
    pub fn theodolite_arcsec(&self) -> f64 {
        let facility = self.facility();
        facility.and_then(|facility| facility.theodolite_std_arcsec(1)).unwrap_or(0.0)
    }

    /// A vector of normal numbers.
    pub fn random(&self, stream: &mut Stream, std: f64) -> Vector3<f64> {
        Vector3::from_fn(|_, _| stream.normal() * std)
    }

    /// Readings at one drive, after the field has settled.
    pub fn set(&self, action: String, field_nt: Vector3<f64>, readings: usize) -> Step {
        let timing = self.timing;
        Step {
            action,
            current_a: self.currents(field_nt),
            temperatures_c: None,
            wait_s: timing.field_settle_s,
            readings,
            length_s: readings as f64 * timing.reading_s,
        }
    }

    /// A series without drive.
    pub fn record(&self, action: String, length_s: f64, step_s: f64) -> Step {
        Step {
            action,
            current_a: Vector3::zeros(),
            temperatures_c: None,
            wait_s: self.timing.field_settle_s,
            readings: (length_s / step_s).round() as usize,
            length_s,
        }
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

/// A sensor along a coil.
pub struct Aligned {
    /// Sensor, coil and the orientation as the theodolites read it.
    pub conditions: Conditions,
    /// The orientation as it is.
    pub rotation: Matrix3<f64>,
    /// The orientation as the operator sets it.
    pub nominal: Matrix3<f64>,
}

/// Refuses what is not a positive number.
pub fn positive(path: &str, key: &str, value: f64) -> Result<(), Error> {
    if value.is_finite() && value > 0.0 {
        Ok(())
    } else {
        Err(Error::document(format!("{path}.{key}"), value.to_string(), "a positive number"))
    }
}

/// Refuses a list without content.
pub fn filled<T>(path: &str, key: &str, list: &[T]) -> Result<(), Error> {
    if list.is_empty() {
        return Err(Error::document(format!("{path}.{key}"), "an empty list", "at least one entry"));
    }
    Ok(())
}

/// Refuses a negative standard deviation.
pub fn deviation(path: &str, key: &str, value: f64) -> Result<(), Error> {
    if value >= 0.0 {
        Ok(())
    } else {
        Err(Error::document(format!("{path}.{key}"), "a negative number", "a standard deviation"))
    }
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
