//! A recording before it is made: what the operator sets, row by row, and how long it takes.

use common::{Axis, Column, Columns, Conditions, Recording};
use nalgebra::{Matrix3, Vector3};

use crate::aboard::KnownField;
use crate::timing::Timing;

/// A recording without its readings.
pub struct Planned {
    /// Conditions and what is set; times from its beginning.
    pub recording: Recording,
    /// R in which it is truly made.
    pub rotation: Matrix3<f64>,
    /// R as the operator sets it.
    pub nominal: Matrix3<f64>,
    /// JSON path in the plan.
    pub path: String,
    pub reads: Reads,
    pub surroundings: Surroundings,
    /// What a code of the converter is divided by.
    pub amplification: f64,
    pub outside: bool,
    pub begins: Begins,
    pub steps: Vec<Step>,
}

#[derive(Clone, Debug, PartialEq)]
pub enum Reads {
    Sensors(Vec<Axis>),
    /// The scalar magnetometer, at the coils' centre or along a coil's axis.
    Scalar,
    /// The reference and the test magnetometer.
    Differential,
    /// Aboard a satellite: sensors, a scalar magnetometer beside them, and what is written of field and attitude.
    Aboard {
        sensors: Vec<Axis>,
        scalar: bool,
        known: Option<Box<KnownField>>,
    },
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Surroundings {
    /// In the coils, with what nulling leaves.
    Coils,
    Shield,
    Open,
}

#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Begins {
    /// When the one before has ended.
    Next,
    /// At the next such day of the week (0 = Monday) and hour, on the local clock.
    At { day: u8, hour: f64 },
    /// So many seconds after the procedure's first recording.
    After(f64),
    /// As its own times say, which are on the campaign's clock; where the campaign has a date, as `Next`.
    AsItSays,
}

/// What the operator does, for the run sheet.
#[derive(Clone, Debug, PartialEq)]
pub struct Step {
    pub action: String,
    pub current_a: Vector3<f64>,
    /// Temperatures of sensors and electronics, where they are set, degC.
    pub temperatures_c: Option<[f64; 2]>,
    /// Waiting before the first reading, s.
    pub wait_s: f64,
    pub readings: usize,
    /// From the first reading to the end, s.
    pub length_s: f64,
}

impl Step {
    pub fn still(action: String, wait_s: f64, readings: usize, length_s: f64) -> Self {
        Self { action, current_a: Vector3::zeros(), temperatures_c: None, wait_s, readings, length_s }
    }
}

/// Builds the rows of a recording from steps.
#[derive(Default)]
pub struct Rows {
    time_s: Vec<f64>,
    current_a: Vec<Vector3<f64>>,
    more: Vec<(String, Vec<f64>)>,
    steps: Vec<Step>,
    end_s: f64,
}

impl Rows {
    /// Rows that begin after the set-up of a procedure or an orientation.
    pub fn new(action: impl Into<String>, setup_s: f64) -> Self {
        let steps = vec![Step::still(action.into(), setup_s, 0, 0.0)];
        Self { end_s: setup_s, steps, ..Self::default() }
    }

    /// Readings at one setting. `more` are further columns, the same ones at each step.
    pub fn step(&mut self, step: Step, timing: &Timing, more: &[(&str, f64)]) {
        let from = self.end_s + step.wait_s;
        for reading in 0..step.readings {
            self.time_s.push(from + reading as f64 * timing.reading_s);
            self.current_a.push(step.current_a);
            for (number, (name, value)) in more.iter().enumerate() {
                match self.more.get_mut(number) {
                    Some((_, column)) => column.push(*value),
                    None => self.more.push((name.to_string(), vec![*value])),
                }
            }
        }
        self.end_s = from + step.length_s;
        self.steps.push(step);
    }

    /// A series at even times from now, with currents of its own.
    pub fn series(&mut self, step: Step, step_s: f64, current_a: impl Fn(f64) -> Vector3<f64>) {
        let from = self.end_s + step.wait_s;
        let local = |row: usize| row as f64 * step_s;
        self.time_s.extend((0..step.readings).map(|row| from + local(row)));
        self.current_a.extend((0..step.readings).map(|row| current_a(local(row))));
        self.end_s = from + step.length_s;
        self.steps.push(step);
    }

    /// The columns: times, the coils that are named, and what was added; and the steps.
    pub fn finish(self, coils: &[Axis]) -> (Columns, Vec<Step>) {
        let mut columns = Columns::from_iter([("time_s".to_string(), Column::from(self.time_s))]);
        for coil in coils {
            let current = self.current_a.iter().map(|current| current[coil.index()]);
            columns.insert(format!("coil_{coil}_a"), current.collect());
        }
        columns.extend(self.more.into_iter().map(|(name, column)| (name, Column::from(column))));
        (columns, self.steps)
    }
}

/// Columns by their names, of rows that have the values in the order of the names.
pub fn columns<Name: ToString>(names: impl IntoIterator<Item = Name>, rows: &[impl AsRef<[f64]>]) -> Columns {
    let of =
        |(at, name): (usize, Name)| (name.to_string(), rows.iter().map(|row| row.as_ref()[at]).collect());
    names.into_iter().enumerate().map(of).collect()
}

impl Planned {
    /// A recording in the coils, by the sensors, when the one before has ended, in the identity.
    pub fn new(
        procedure: &str,
        id: String,
        path: &str,
        conditions: Conditions,
        rows: Rows,
        coils: &[Axis],
    ) -> Self {
        let (columns, steps) = rows.finish(coils);
        let procedure = procedure.into();
        Self::of(Recording { id, procedure, conditions, columns, ..Recording::default() }, path, steps)
    }

    /// The same with columns that are made already.
    pub fn of(recording: Recording, path: &str, steps: Vec<Step>) -> Self {
        Self {
            recording,
            rotation: Matrix3::identity(),
            nominal: Matrix3::identity(),
            path: path.into(),
            reads: Reads::Scalar,
            surroundings: Surroundings::Coils,
            amplification: 1.0,
            outside: false,
            begins: Begins::Next,
            steps,
        }
    }

    /// From its beginning to its end, s.
    pub fn length_s(&self) -> f64 {
        self.steps.iter().map(|step| step.wait_s + step.length_s).sum()
    }
}
