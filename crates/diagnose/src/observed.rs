//! What was read, as channels: one sensor, the scalar magnetometer, or the length of the corrected vector, in
//! one recording.

use common::number::counted;
use common::{Axis, Document, Recording, procedure};
use nalgebra::Vector3;
use physics::{Basic, Prediction, References, Setting, Unit};
use std::collections::BTreeSet;

use crate::Error;
use crate::channel::{Channel, Reader, Run};
use crate::magnitude;

/// Procedures whose readings the chain of sensors and coils does not predict.
const NOT_PREDICTED: [&str; 4] =
    [procedure::COIL_GRADIENT, procedure::NULLING_RESIDUAL, procedure::ABSOLUTE, procedure::VARIOMETER];

/// Fewest readings of a channel.
const FEWEST: usize = 3;

impl Channel {
    /// What is predicted of it, nT, at its rows.
    pub fn predicted(&self, basic: &Basic, prediction: &Prediction) -> Vec<f64> {
        let rows = self.rows.iter();
        match self.reader {
            Reader::Sensor(axis) => {
                rows.map(|row| self.to_nt * prediction.readings[*row][axis.index()]).collect()
            }
            Reader::Scalar => rows.map(|row| prediction.field_geo[*row].norm()).collect(),
            Reader::Magnitude => magnitude::predicted(self, basic, prediction),
        }
    }

    pub fn derivative(&self, basic: &Basic, prediction: &Prediction, derivative: &Prediction) -> Vec<f64> {
        let rows = self.rows.iter();
        match self.reader {
            Reader::Sensor(axis) => {
                rows.map(|row| self.to_nt * derivative.readings[*row][axis.index()]).collect()
            }
            Reader::Scalar => rows
                .map(|row| prediction.field_geo[*row].normalize().dot(&derivative.field_geo[*row]))
                .collect(),
            Reader::Magnitude => magnitude::derivative(self, basic, prediction, derivative),
        }
    }
}

/// All recordings that can be predicted.
#[derive(Clone, Debug)]
pub struct Observed<'a> {
    pub document: &'a Document,
    pub runs: Vec<Run<'a>>,
    pub channels: Vec<Channel>,
    pub rows: usize,
    /// What was left aside, in words.
    pub notes: Vec<String>,
}

impl<'a> Observed<'a> {
    pub fn columns(&self) -> BTreeSet<String> {
        self.runs.iter().flat_map(|run| run.recording.columns.keys().cloned()).collect()
    }

    /// Mean of a column over all recordings that have it.
    pub fn mean(&self, name: &str) -> f64 {
        let values = self.runs.iter().filter_map(|run| run.recording.column(name)).flatten();
        let (sum, count) =
            values.filter(|value| value.is_finite()).fold((0.0, 0), |(s, n), v| (s + v, n + 1));
        sum / f64::from(count.max(1))
    }

    /// Reads a document. Two instruments side by side are not among it: `beside` answers of these.
    pub fn of(document: &'a Document) -> Result<Self, Error> {
        let references = References::of(document);
        let mut observed =
            Observed { document, runs: Vec::new(), channels: Vec::new(), rows: 0, notes: Vec::new() };
        for (index, recording) in document.recordings.iter().enumerate() {
            let path = format!("recordings[{index}]");
            if recording.procedure == procedure::DIFFERENTIAL {
                continue;
            }
            recording.at_hand(&path)?;
            if NOT_PREDICTED.contains(&recording.procedure.as_str()) {
                let what = format!(
                    "\"{}\" ({}) has no readings that the model predicts",
                    recording.id, recording.procedure
                );
                observed.notes.push(what);
                continue;
            }
            let setting = Setting::of(document, recording, references).map_err(|error| error.at(&path))?;
            check_coils(&setting, &path)?;
            check_sensors(document, &setting, &path)?;
            let times = setting.context.times("the search");
            if let Some(error) = times.as_ref().err().filter(|_| recording.column("time_s").is_some()) {
                let what = format!(
                    "the times of \"{}\": {error}; effects that need them are not searched there",
                    recording.id
                );
                observed.notes.push(what);
            }
            let time_s = times.ok().filter(|time| !time.is_empty());
            let run = Run { recording, path, setting, time_s, smooth: Vec::new() };
            if magnitude::alone(&run) {
                observed.notes.push(format!(
                    "\"{}\" is compared with the magnitude of the field alone: a common rotation of all sensors and disturbances transverse to the field are not observable. They need the field's direction, from the attitude and a field model",
                    recording.id
                ));
                observed.runs.push(run);
                observed.add_magnitude()?;
            } else {
                observed.add(run)?;
            }
        }
        if observed.channels.is_empty() { Err(nothing(document)) } else { Ok(observed) }
    }

    /// Adds the channels of a recording that can be predicted.
    fn add(&mut self, run: Run<'a>) -> Result<(), Error> {
        let Setting { basic, context } = &run.setting;
        let prediction = physics::predict(basic, &[], context).map_err(|error| error.at(&run.path))?;
        let of = |axis: Axis| {
            let to_nt = basic.sensors[axis.index()].sensitivity;
            (Reader::Sensor(axis), format!("sensor_{axis}_{}", context.unit.suffix()), to_nt)
        };
        let mut found: Vec<(Reader, String, f64)> = Axis::ALL.map(of).to_vec();
        if run.recording.procedure == procedure::COIL_CONSTANT {
            found.push((Reader::Scalar, "reference_nt".into(), 1.0));
        }
        for (reader, column, to_nt) in found {
            let Some(values) = run.recording.column(&column) else { continue };
            let whole = Channel {
                run: self.runs.len(),
                reader,
                column,
                rows: (0..values.len()).collect(),
                readings: Vec::new(),
                to_nt,
                at: self.rows,
                vectors: Vec::new(),
                nominal: Vector3::zeros(),
                shares: Vec::new(),
            };
            let predicted = whole.predicted(basic, &prediction);
            let rows: Vec<usize> = (0..values.len())
                .filter(|row| values[*row].is_finite() && predicted[*row].is_finite())
                .collect();
            if rows.len() < FEWEST {
                continue;
            }
            self.rows += rows.len();
            let readings = rows.iter().map(|row| values[*row]).collect();
            self.channels.push(Channel { rows, readings, ..whole });
        }
        self.runs.push(run);
        Ok(())
    }

    fn add_magnitude(&mut self) -> Result<(), Error> {
        let at = self.runs.len() - 1;
        let found = magnitude::channel(&mut self.runs[at], at, self.rows)?;
        if let Some(channel) = found.filter(|channel| channel.rows.len() >= FEWEST) {
            self.rows += channel.rows.len();
            self.channels.push(channel);
        }
        let run = &mut self.runs[at];
        if !run.smooth.is_empty() {
            run.setting.context.ambient_nt =
                magnitude::ambient(run, &run.setting.basic, &run.setting.context);
        }
        Ok(())
    }

    /// Beginning and length of all recordings on the campaign's clock, s.
    pub fn span(&self) -> Option<(f64, f64)> {
        let ends = self.runs.iter().filter_map(|run| {
            let (time, clock) = (run.time_s?, run.setting.context.clock_s);
            Some((time.first()? + clock, time.last()? + clock))
        });
        let (from, to) = ends.fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), (f, t)| (a.min(f), b.max(t)));
        (to > from).then_some((from, to - from))
    }

    pub fn channels_of(&self, run: usize) -> impl Iterator<Item = &Channel> {
        self.channels.iter().filter(move |channel| channel.run == run)
    }

    /// The times of a channel's rows.
    pub fn times(&self, channel: &Channel) -> Option<Vec<f64>> {
        self.runs[channel.run].time_s.map(|time| channel.rows.iter().map(|row| time[*row]).collect())
    }
}

/// Where no recording can be predicted: what stands in them instead.
fn nothing(document: &Document) -> Error {
    let of = |recording: &Recording| {
        let readings =
            |values: &[f64]| counted(values.iter().filter(|value| value.is_finite()).count(), "reading");
        let columns = recording.columns.iter();
        let columns: Vec<String> =
            columns.map(|(name, values)| format!("`{name}` ({})", readings(values))).collect();
        let columns = if columns.is_empty() { "no column".into() } else { columns.join(", ") };
        format!("\"{}\" ({}) has {columns}", recording.id, recording.procedure)
    };
    let all: Vec<String> = document.recordings.iter().map(of).collect();
    let why = if all.is_empty() { "there is none".into() } else { all.join("; ") };
    Error::Request(format!(
        "no recording whose readings can be predicted: {why}; diagnose needs readings of sensors (`sensor_x_v`, `sensor_x_nt`, …), of a scalar magnetometer in a coil, or of two magnetometers side by side"
    ))
}

fn check_sensors(document: &Document, setting: &Setting<'_>, path: &str) -> Result<(), Error> {
    let calibration = document.calibration.as_ref();
    let nominal = document.instrument.as_ref().and_then(|instrument| instrument.nominal_sensitivity_nt_per_v);
    for axis in Axis::ALL.into_iter().filter(|_| nominal.is_none() && setting.context.unit == Unit::Volt) {
        let column = format!("sensor_{axis}_v");
        let sensor = calibration.and_then(|calibration| calibration.sensor(axis));
        let known = sensor.is_some_and(|sensor| sensor.sensitivity_nt_per_v.is_some());
        if setting.context.recording.column(&column).is_some() && !known {
            let expected = format!(
                "calibration.sensors.{axis}.sensitivity_nt_per_v, or instrument.nominal_sensitivity_nt_per_v; run sensorcal first, or \
                 state it"
            );
            let found = "volts of a sensor whose sensitivity is not known";
            return Err(Error::document(format!("{path}.columns.{column}"), found, expected));
        }
    }
    Ok(())
}

fn check_coils(setting: &Setting<'_>, path: &str) -> Result<(), Error> {
    for coil in Axis::ALL {
        let driven = setting.context.current_a.iter().any(|current| current[coil.index()].abs() > 0.0);
        if driven && setting.basic.coils[coil.index()].constant_nt_per_a == 0.0 {
            let found = format!("a drive of coil {coil}, whose constant is not known");
            let expected =
                format!("calibration.coils.{coil}.constant_nt_per_a; run coilcal first, or state it");
            return Err(Error::document(path, found, expected));
        }
    }
    Ok(())
}
