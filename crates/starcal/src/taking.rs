//! Rows become products: d = M y + m₀ + …, the field in the frame of a camera by what the sensors read.

use common::{AttitudeFrame, Recording, procedure};
use mainfield::Model;
use nalgebra::{Matrix3, Vector3};
use partial::{Covered, Error as Fault, Series, Take};
use physics::frames::attitude;

use crate::field::{Fields, Known};
use crate::layout::{CAMERAS, FIELD_NT, Layout, Row};
use crate::partial::{DELAYS, DIRECTIONS, Error, PLACES, Partial};

/// Rows further apart tell nothing of how field and attitude change, s.
const LONGEST_STEP_S: f64 = 60.0;
/// Times are of a clock within some thousand years, s.
const FURTHEST_S: f64 = 1e11;
/// Beyond this Kp, rows count as disturbed.
const QUIET_KP: f64 = 2.0;
/// Rows of which the magnitude differs from that of the field by more than this share are left out.
const ODD: f64 = 0.2;
/// Rows that are multiplied at a time.
const AT_ONCE: usize = 256;

/// Takes a flight from documents and tables.
#[derive(Clone, Debug, Default)]
pub struct Columns {
    /// The frame from which attitudes turn.
    pub frame: AttitudeFrame,
    /// The field where no columns have it.
    pub model: Model,
    /// UT1 less UTC, s.
    pub ut1_utc_s: f64,
}

impl Series for Columns {
    type Partial = Partial;
    type Take = Statistics;
    const PROCEDURE: &'static str = procedure::FREE_RUN;

    /// Recordings with a star camera, with the frame that each states.
    fn of_recording(&self, recording: &Recording, path: &str) -> Result<Option<Self>, common::Error> {
        if !recording.columns.keys().any(|name| name.starts_with("camera_")) && recording.table.is_none() {
            return Ok(None);
        }
        let Some(frame) = recording.conditions.extra.get("attitude_frame") else {
            return Ok(Some(self.clone()));
        };
        let known = frame.as_str().and_then(AttitudeFrame::named).ok_or_else(|| {
            let path = format!("{path}.conditions.attitude_frame");
            common::Error::document(path, frame.to_string(), "\"geo\", \"itrf\" or \"icrf\"")
        })?;
        Ok(Some(Self { frame: known, ..self.clone() }))
    }

    fn begin(&self, there: &[String]) -> Result<(Vec<String>, Statistics), String> {
        let layout = Layout::of(there, self.frame, &self.model.to_string())?;
        let fields = Fields::new(self.model, self.ut1_utc_s, self.frame);
        Ok((layout.names(), Statistics::new(layout, fields)))
    }
}

/// A row with its field, and the fields and rotations of the cameras.
struct Moment {
    row: Row,
    known: Known,
    turns: [Option<Matrix3<f64>>; CAMERAS],
}

/// Takes rows one after another. A row waits for the next one, which tells how its field changes.
pub struct Statistics {
    partial: Partial,
    fields: Fields,
    taken: u64,
    first_s: f64,
    last_s: f64,
    before: Option<Moment>,
    waiting: Option<Moment>,
    /// Rows of a window that are not multiplied yet, by camera, place and direction.
    window: i64,
    buffers: Vec<[[Vec<f64>; DIRECTIONS]; PLACES]>,
}

impl Statistics {
    fn new(layout: Layout, fields: Fields) -> Self {
        Self {
            buffers: vec![Default::default(); layout.cameras.len()],
            partial: Partial::new(layout),
            fields,
            taken: 0,
            first_s: f64::NAN,
            last_s: f64::NEG_INFINITY,
            before: None,
            waiting: None,
            window: 0,
        }
    }

    fn take(&mut self, values: &[f64]) -> Result<(), Error> {
        let (number, time_s) = (self.taken, values[0]);
        if !time_s.is_finite() {
            return Err(Fault::NoTime { row: number }.into());
        }
        if time_s <= self.last_s {
            return Err(Fault::Backwards { row: number, time_s }.into());
        }
        if time_s.abs() > FURTHEST_S {
            let expected = "seconds of a clock; is it in another unit?".into();
            return Err(Error::NoField { row: number, found: format!("a time of {time_s} s"), expected });
        }
        if number == 0 {
            self.first_s = time_s;
        }
        self.taken += 1;
        self.last_s = time_s;
        let Some(row) = self.partial.layout.row(values) else {
            self.partial.missing += 1;
            return Ok(());
        };
        let known = self.fields.known(&row);
        let known = known.map_err(|[found, expected]| Error::NoField { row: number, found, expected })?;
        let turns = row.attitudes.map(|parts| parts.and_then(attitude));
        let size = known.geo.norm();
        if turns[0].is_none() {
            let is_odd = row.attitudes[0].is_some();
            *(if is_odd { &mut self.partial.odd } else { &mut self.partial.blind }) += 1;
            return Ok(());
        }
        if (row.readings.norm() - size).abs() > ODD * size || size == 0.0 {
            self.partial.odd += 1;
            return Ok(());
        }
        self.partial.rows += 1;
        let next = Moment { row, known, turns };
        if let Some(waiting) = self.waiting.take() {
            self.add(&waiting, Some(&next));
            self.before = Some(waiting);
        }
        self.waiting = Some(next);
        Ok(())
    }

    /// Adds the rows of a moment, one for each camera and direction.
    fn add(&mut self, moment: &Moment, next: Option<&Moment>) {
        let time_s = moment.row.time_s;
        if self.partial.window(time_s) != self.window {
            self.multiply();
            // Windows may be wider now.
            self.window = self.partial.window(time_s);
        }
        let frame = self.partial.layout.frame;
        let place = usize::from(moment.known.is_polar() || moment.row.kp > QUIET_KP);
        // Attitudes of other heads are compared with that of the first, without which they say nothing here.
        let Some(first) = moment.turns[0] else { return };
        self.sample(moment);
        let first = first * moment.known.of(frame);
        for camera in 0..self.partial.layout.cameras.len() {
            let Some(turn) = moment.turns[camera] else { continue };
            let field = turn * moment.known.of(frame);
            let mut delays = [Vector3::zeros(); DELAYS];
            let mut signals = moment.row.signals.clone();
            if camera == 0 {
                let [whole, attitude] = self.changes(moment, next, frame);
                let turning =
                    if frame == AttitudeFrame::Icrf { turn * moment.known.turning } else { Vector3::zeros() };
                delays = [whole, attitude, turning];
            } else {
                let seen = first / FIELD_NT;
                let warm = moment.row.warmth.iter().flat_map(|warmth| (seen * *warmth).data.0[0]);
                signals = seen.iter().copied().chain(warm).collect();
            }
            let along = field.normalize();
            let boresight = Vector3::z();
            let across = boresight.cross(&along).try_normalize(1e-6);
            let across = across.unwrap_or_else(|| Vector3::x().cross(&along).normalize());
            for (direction, unit) in [along, across, along.cross(&across)].into_iter().enumerate() {
                let buffer = &mut self.buffers[camera][place][direction];
                for part in unit.iter() {
                    buffer.extend(signals.iter().map(|signal| part * signal));
                }
                buffer.extend(delays.iter().chain([&field]).map(|vector| unit.dot(vector)));
            }
        }
        let limit = AT_ONCE * self.partial.width(0);
        if self.buffers.iter().flatten().flatten().any(|buffer| buffer.len() >= limit) {
            self.multiply();
        }
    }

    /// How the field in the first camera's frame changes, nT/s, and how it would with the field at rest, by the rows before
    /// and after; zero without them.
    fn changes(&self, now: &Moment, next: Option<&Moment>, frame: AttitudeFrame) -> [Vector3<f64>; 2] {
        let near = |other: &Moment| (other.row.time_s - now.row.time_s).abs() <= LONGEST_STEP_S;
        let ends = self.before.as_ref().filter(|one| near(one)).zip(next.filter(|one| near(one)));
        let turns = ends.and_then(|(before, next)| Some((before, before.turns[0]?, next, next.turns[0]?)));
        let Some((before, first, next, second)) = turns else { return [Vector3::zeros(); 2] };
        let span_s = next.row.time_s - before.row.time_s;
        let whole = second * next.known.of(frame) - first * before.known.of(frame);
        let still = now.known.of(frame);
        [whole / span_s, (second * still - first * still) / span_s]
    }

    fn sample(&mut self, moment: &Moment) {
        let Moment { row, known, .. } = moment;
        let Some(q) = row.attitudes[0] else { return };
        let (y, [a, b, c]) = (row.readings, [known.geo, known.itrf, known.icrf]);
        self.partial.sample.take([
            row.time_s, y.x, y.y, y.z, q[0], q[1], q[2], q[3], a.x, a.y, a.z, b.x, b.y, b.z, c.x, c.y, c.z,
        ]);
    }

    fn multiply(&mut self) {
        if self.buffers.iter().flatten().flatten().all(Vec::is_empty) {
            return;
        }
        let widths: Vec<usize> = (0..self.buffers.len()).map(|camera| self.partial.width(camera)).collect();
        let window = self.partial.at(self.window);
        for ((products, buffers), width) in window.iter_mut().zip(&mut self.buffers).zip(widths) {
            let all = products.iter_mut().flatten().zip(buffers.iter_mut().flatten());
            all.for_each(|(products, buffer)| {
                products.add(buffer, width);
                buffer.clear();
            });
        }
        self.partial.settle();
    }
}

impl Take for Statistics {
    type Partial = Partial;

    fn push(&mut self, columns: &[&[f64]]) -> Result<(), Error> {
        let (found, expected) = (columns.len(), self.partial.layout.names().len());
        if found != expected {
            return Err(Fault::Lengths { found, expected }.into());
        }
        let rows = columns[0].len();
        if let Some(odd) = columns.iter().find(|column| column.len() != rows) {
            return Err(Fault::Lengths { found: odd.len(), expected: rows }.into());
        }
        let mut values = vec![0.0; expected];
        for row in 0..rows {
            values.iter_mut().zip(columns).for_each(|(value, column)| *value = column[row]);
            self.take(&values)?;
        }
        Ok(())
    }

    fn finish(mut self) -> Result<Partial, Error> {
        if let Some(last) = self.waiting.take() {
            self.add(&last, None);
        }
        self.multiply();
        if self.taken > 0 {
            self.partial.covered = Covered::of(self.first_s, self.last_s);
        }
        Ok(self.partial)
    }
}
