//! The readings of a sensor in a coil's field, with what is wrong told by its place.

use common::number::{bare, counted, significant};
use common::{Axis, Document, Recording};
use nalgebra::Vector3;
use physics::{Basic, Context, References, Unit};

use crate::{Error, Result};

/// Share of the variance that a straight line of the reading against the field must explain.
const FOLLOWS: f64 = 0.9;
/// A sensitivity may differ from what is stated by this factor before it is a mistake of columns or units.
const STATED_WITHIN: f64 = 1.25;
/// A sensor turned along a coil points there by its stated orientation at least so far (cosine).
const ALONG: f64 = 0.7;

/// So many readings show their codes.
const ENOUGH: usize = 100_000;
/// So many readings share a code, in the mean, where codes are to be seen.
const SHARED: usize = 2;

/// One recording of one sensor that was turned along a coil.
#[derive(Clone)]
pub struct Run<'a> {
    pub context: Context<'a>,
    pub path: String,
    pub sensor: Axis,
    /// The coil along which it was turned.
    pub coil: Axis,
    /// The chain: the sensor points along the field of its coil, as it was turned to its largest reading.
    pub basic: Basic,
    /// Whether the orientation of the block is stated.
    pub oriented: bool,
    /// Readings in the recording's unit, by row.
    pub reading: Vec<f64>,
    pub rows: Vec<usize>,
}

impl Run<'_> {
    /// Applied field of each coil along its own axis at a row, nT.
    pub fn coil_nt(&self, coil: Axis, row: usize) -> f64 {
        self.basic.coils[coil.index()].constant_nt_per_a * self.context.current_a[row][coil.index()]
    }

    /// Applied field along the sensor at a row, nT: the coil's, its offset with it.
    pub fn applied_nt(&self, row: usize) -> f64 {
        self.coil_nt(self.coil, row) + self.basic.coils[self.coil.index()].offset_nt
    }

    /// The times of the rows that are used, where they are there.
    pub fn times(&self) -> Option<Vec<f64>> {
        times(self.context.recording, &self.rows)
    }
}

/// The times of some rows, where they are all there and do not run backwards.
pub fn times(recording: &Recording, rows: &[usize]) -> Option<Vec<f64>> {
    let time = recording.column("time_s")?;
    let times: Vec<f64> = rows.iter().map(|row| time[*row]).collect();
    (times.iter().all(|t| t.is_finite()) && times.windows(2).all(|pair| pair[1] >= pair[0])).then_some(times)
}

/// The recordings of a procedure and a sensor, with their places, in the order of time.
pub fn recordings<'a>(
    document: &'a Document,
    procedure: &str,
    sensor: Axis,
) -> Result<Vec<(String, &'a Recording)>> {
    let mut found = Vec::new();
    for (index, recording) in document.recordings.iter().enumerate() {
        if recording.procedure != procedure {
            continue;
        }
        let path = format!("recordings[{index}]");
        recording.at_hand(&path)?;
        let Some(of) = recording.conditions.sensor else {
            let expected = "\"x\", \"y\" or \"z\", the sensor that is calibrated";
            return Err(Error::document(format!("{path}.conditions.sensor"), "no such key", expected));
        };
        if of == sensor {
            found.push((path, recording));
        }
    }
    let beginning_s = References::stated(document).beginning_s.unwrap_or(0.0);
    let moment = |recording: &Recording| {
        let first = recording.column("time_s").into_iter().flatten().find(|t| t.is_finite());
        recording.start().map_or(beginning_s, |start| start.unix_s) + first.copied().unwrap_or(0.0)
    };
    found.sort_by(|(_, a), (_, b)| moment(a).total_cmp(&moment(b)).then_with(|| a.id.cmp(&b.id)));
    Ok(found)
}

pub fn output<'a>(recording: &'a Recording, path: &str, sensor: Axis) -> Result<(&'a [f64], Unit)> {
    let columns = format!("{path}.columns");
    match (recording.axis_column("sensor", sensor, "v"), recording.axis_column("sensor", sensor, "nt")) {
        (Some(volts), None) => Ok((volts, Unit::Volt)),
        (None, Some(field)) => Ok((field, Unit::Nanotesla)),
        (Some(_), Some(_)) => {
            let found = format!("both `sensor_{sensor}_v` and `sensor_{sensor}_nt`");
            Err(Error::document(columns, found, "one of them"))
        }
        (None, None) => {
            let found = format!("no readings of sensor {sensor}");
            let expected =
                format!("`sensor_{sensor}_v`, or `sensor_{sensor}_nt` of an instrument that gives field");
            Err(Error::document(columns, found, expected))
        }
    }
}

pub fn runs<'a>(
    document: &'a Document,
    references: References,
    procedure: &str,
    sensor: Axis,
) -> Result<Vec<Run<'a>>> {
    let found = recordings(document, procedure, sensor)?;
    let runs: Vec<Run<'a>> = found
        .into_iter()
        .map(|(path, recording)| run(document, recording, path, sensor, references))
        .collect::<Result<_>>()?;
    if let Some(other) = runs.iter().find(|run| run.context.unit != runs[0].context.unit) {
        let found = "a unit other than that of the recording before";
        let expected = "one unit for all recordings of a sensor's procedure";
        return Err(Error::document(format!("{}.columns", other.path), found, expected));
    }
    Ok(runs)
}

fn run<'a>(
    document: &Document,
    recording: &'a Recording,
    path: String,
    sensor: Axis,
    references: References,
) -> Result<Run<'a>> {
    let Some(coil) = recording.conditions.coil else {
        let expected = "\"x\", \"y\" or \"z\", the coil along which the sensor is turned";
        return Err(Error::document(format!("{path}.conditions.coil"), "no such key", expected));
    };
    let (reading, unit) = output(recording, &path, sensor)?;
    let reading = reading.to_vec();
    let context = Context::new(document, recording, references)
        .map_err(|error| error.at(&format!("{path}.conditions.orientation")))?;
    if !["a", "v"].iter().any(|unit| recording.axis_column("coil", coil, unit).is_some()) {
        let expected = format!("`coil_{coil}_a`, or `coil_{coil}_v` across the precision resistor");
        let found = format!("no drive of coil {coil}");
        return Err(Error::document(format!("{path}.columns"), found, expected));
    }
    let mut basic = Basic::of(document, unit);
    for driven in Axis::ALL {
        let constant = basic.coils[driven.index()].constant_nt_per_a;
        let driven_at_all = context.current_a.iter().any(|current| current[driven.index()] != 0.0);
        if driven_at_all && constant == 0.0 {
            let key = format!("calibration.coils.{driven}.constant_nt_per_a");
            let expected = "the constant of a coil that carries current; coilcal finds it, or state it there";
            return Err(Error::document(key, "no such key", expected));
        }
    }
    let oriented = recording.conditions.orientation.is_some() || recording.conditions.theodolite.is_some();
    let along: Vector3<f64> = context.orientation.rotation * basic.eta.column(coil.index());
    let cosine = along.dot(&basic.mu.column(sensor.index()));
    if oriented && cosine.abs() < ALONG {
        let found = format!(
            "an orientation that puts sensor {sensor} stands {}° from coil {coil}",
            significant(cosine.clamp(-1.0, 1.0).acos().to_degrees(), 3)
        );
        let expected = "the orientation in which the sensor was aligned with the coil";
        return Err(Error::document(format!("{path}.conditions.orientation"), found, expected));
    }
    let direction = if oriented { cosine.signum() } else { 1.0 };
    basic.mu.set_column(sensor.index(), &(along * direction));
    let rows = (0..recording.rows())
        .filter(|row| reading[*row].is_finite() && context.current_a[*row].iter().all(|a| a.is_finite()))
        .filter(|row| recording.column("time_s").is_none_or(|time| time[*row].is_finite()))
        .collect();
    let mut run = Run { context, path, sensor, coil, basic, oriented, reading, rows };
    begin(document, &mut run, unit, direction)?;
    Ok(run)
}

/// First constants, by a straight line; readings that do not follow the field at all are refused.
fn begin(document: &Document, run: &mut Run<'_>, unit: Unit, direction: f64) -> Result<()> {
    let sensor = run.sensor;
    let column = format!("{}.columns.sensor_{sensor}_{}", run.path, unit.suffix());
    let points: Vec<(f64, f64)> =
        run.rows.iter().map(|row| (direction * run.applied_nt(*row), run.reading[*row])).collect();
    if points.len() < 4 {
        let found = format!("{} in a known field", counted(points.len(), "reading"));
        return Err(Error::document(column, found, "at least four"));
    }
    let line = Line::through(&points);
    let largest = points.iter().map(|point| point.0.abs()).fold(0.0, f64::max);
    if line.bb <= 1e-18 * points.len() as f64 * largest * largest {
        let key = format!("{}.columns.coil_{}", run.path, run.coil);
        let expected = "fields on both sides of zero; one field alone does not determine a sensitivity";
        return Err(Error::document(key, "a drive that never changes", expected));
    }
    if line.vv <= 1e-12 * line.mean.1 * line.mean.1 {
        let found = format!("the constant reading {}", bare(line.mean.1));
        let expected = format!(
            "readings that follow the {} nT by which the field changes; was the sensor connected?",
            significant(span(points.iter().map(|point| point.0)), 4)
        );
        return Err(Error::document(column, found, expected));
    }
    // The ends may be clipped: where the inner half follows the field better, the first line goes through it.
    let inner: Vec<(f64, f64)> =
        points.iter().copied().filter(|point| point.0.abs() <= 0.5 * largest).collect();
    let inner = Line::through(&inner);
    let line = if inner.explained() > line.explained() { inner } else { line };
    let explained = line.explained();
    if explained < FOLLOWS {
        let percent = significant(100.0 * explained, 3);
        let found = format!("readings that follow the field of coil {} by {percent} % only", run.coil);
        let expected = "a sensor aligned with the driven coil; are columns, sensor or coil swapped, or is the output clipped?";
        return Err(Error::document(column, found, expected));
    }
    let sensitivity = line.bb / line.bv;
    let stated = run.basic.sensors[sensor.index()].sensitivity;
    let calibrated = document.calibration.as_ref().and_then(|calibration| calibration.sensor(sensor));
    let known = calibrated.is_some_and(|calibrated| physics::sensitivity(calibrated, unit).is_some());
    let nominal = document.instrument.as_ref().is_some_and(|i| i.nominal_sensitivity_nt_per_v.is_some());
    let compared = known || unit == Unit::Nanotesla || nominal;
    let ratio = sensitivity / stated;
    if sensitivity < 0.0 {
        let expected = "readings that rise with it; is the sensor reversed (`conditions.orientation`), or the sign of a drive lost?";
        return Err(Error::document(column, "readings that fall as the field rises", expected));
    }
    if compared && !(1.0 / STATED_WITHIN..=STATED_WITHIN).contains(&ratio) {
        let found = format!("a sensitivity of {} nT per unit of reading", bare(sensitivity));
        let expected = format!("about {}, as stated; are units, columns or coils mixed up?", bare(stated));
        return Err(Error::document(column, found, expected));
    }
    let first = &mut run.basic.sensors[sensor.index()];
    first.sensitivity = sensitivity;
    first.offset_nt = line.mean.0 - sensitivity * line.mean.1;
    Ok(())
}

struct Line {
    mean: (f64, f64),
    bb: f64,
    bv: f64,
    vv: f64,
}

impl Line {
    fn through(points: &[(f64, f64)]) -> Self {
        let count = points.len() as f64;
        let mean = points.iter().fold((0.0, 0.0), |(b, v), point| (b + point.0 / count, v + point.1 / count));
        let mut line = Self { mean, bb: 0.0, bv: 0.0, vv: 0.0 };
        for (b, v) in points {
            let (b, v) = (b - mean.0, v - mean.1);
            (line.bb, line.bv, line.vv) = (line.bb + b * b, line.bv + b * v, line.vv + v * v);
        }
        line
    }

    /// Share of the readings' variance that it explains; none where there is none.
    fn explained(&self) -> f64 {
        let share = self.bv * self.bv / (self.bb * self.vv);
        if share.is_finite() { share } else { 0.0 }
    }
}

/// The mean of the sensitivities that straight lines through each run give.
pub fn first_sensitivity(runs: &[Run<'_>]) -> f64 {
    runs.iter().map(|run| run.basic.sensors[run.sensor.index()].sensitivity).sum::<f64>() / runs.len() as f64
}

/// Width of a code as a series of readings shows it: the smallest step between different readings, where all
/// steps are whole multiples of it; None where they are not.
pub fn code(readings: &[f64]) -> Option<f64> {
    let mut sorted: Vec<f64> = readings.iter().copied().filter(|v| v.is_finite()).take(ENOUGH).collect();
    sorted.sort_by(f64::total_cmp);
    let largest = sorted.iter().fold(0.0f64, |m, v| m.max(v.abs()));
    let rounding = 1e-12 * largest;
    let steps: Vec<f64> = sorted.windows(2).map(|p| p[1] - p[0]).filter(|step| *step > rounding).collect();
    let width = steps.iter().copied().fold(f64::INFINITY, f64::min);
    let whole =
        |step: &f64| (step / width - (step / width).round()).abs() * width <= rounding.max(1e-6 * width);
    (!steps.is_empty() && SHARED * (steps.len() + 1) <= sorted.len() && steps.iter().all(whole))
        .then_some(width)
}

/// Width of a code as the instrument states it, in the unit of a run (steps of a sweep would pass for one).
pub fn code_width(document: &Document, run: &Run<'_>) -> f64 {
    run.context.unit.code_width(document.instrument.as_ref()).unwrap_or(0.0)
}

pub fn span(values: impl Iterator<Item = f64> + Clone) -> f64 {
    values.clone().fold(f64::NEG_INFINITY, f64::max) - values.fold(f64::INFINITY, f64::min)
}

/// Applied field along the sensor, nT, with its sign as the sensor stands, by row.
pub fn along(run: &Run<'_>) -> Vec<f64> {
    let at = run.sensor.index();
    let axis = run.context.orientation.rotation.transpose() * run.basic.mu.column(at);
    let sign = axis.dot(&run.basic.eta.column(run.coil.index())).signum();
    (0..run.context.rows).map(|row| sign * run.applied_nt(row)).collect()
}
