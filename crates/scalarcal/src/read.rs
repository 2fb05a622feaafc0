//! The recordings that scalarcal uses: readings of the three sensors with the magnitude of the field.

use common::number::{counted, quoted, significant};
use common::{Axis, Document, Quantity, Recording, procedure};
use estimate::stats::median_of;
use physics::Unit;

use crate::{Error, Options};

/// The condition that states a constant magnitude.
pub const MAGNITUDE: &str = "magnitude_nt";
/// Magnitudes outside these limits are hardly a field in nT, nT.
const PLAUSIBLE: [f64; 2] = [1e3, 1e7];
/// Magnitudes of the Earth's field at its surface, nT.
const EARTH: [f64; 2] = [2e4, 7e4];
/// Readings in nT and a reference whose ratio is outside these limits are in different units.
const ALIKE: f64 = 5.0;

/// Where the magnitude comes from.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Source {
    /// `reference_nt`: a scalar magnetometer.
    Scalar,
    /// `ambient_{x,y,z}_nt`: a model of the field, or an observatory.
    Ambient,
    /// `conditions.magnitude_nt`.
    Stated,
    /// Constant and not known.
    Constant,
}

impl Source {
    /// In words.
    pub fn words(self) -> &'static str {
        match self {
            Source::Scalar => "a scalar magnetometer (reference_nt)",
            Source::Ambient => "the magnitude of the known field (ambient_*_nt)",
            Source::Stated => "the stated magnitude (conditions.magnitude_nt)",
            Source::Constant => "a constant, unknown magnitude",
        }
    }
}

/// One recording, rows with all readings alone.
#[derive(Clone, Debug)]
pub struct Series {
    pub index: usize,
    pub id: String,
    /// Times of the rows, s; None where there are none.
    pub time_s: Option<Vec<f64>>,
    /// The rows of the recording that are used.
    pub rows: Vec<usize>,
    pub readings: [Vec<f64>; 3],
    /// The magnitude of the field, nT; one where it is not known.
    pub magnitude_nt: Vec<f64>,
    /// Columns that effects follow, nT, each with an rms of the typical magnitude.
    pub follows: Vec<Vec<f64>>,
    pub source: Source,
    /// Rows that lack a reading.
    pub missing: usize,
}

impl Series {
    pub fn len(&self) -> usize {
        self.rows.len()
    }

    pub fn reading(&self, row: usize) -> [f64; 3] {
        self.readings.each_ref().map(|column| column[row])
    }

    pub fn path(&self) -> String {
        format!("recordings[{}]", self.index)
    }
}

/// The unit of the readings, and the recordings.
///
/// Errors: no recording with sensors and a magnitude; a sensor that does not move; a reference in another
/// unit; readings in V and in nT.
pub fn read(document: &Document, options: &Options) -> Result<(Unit, Vec<Series>), Error> {
    let mut all: Vec<(Unit, Series)> = Vec::new();
    let mut without = None;
    for (index, recording) in document.recordings.iter().enumerate().filter(|(_, one)| is_free(one)) {
        recording.at_hand(&format!("recordings[{index}]"))?;
        let Some(unit) = unit_of(|name| recording.column(name).is_some()) else { continue };
        match magnitude(recording, index, options)? {
            Some(magnitude) => all.push((unit, series(recording, index, unit, magnitude))),
            None => without = without.or(Some((index, recording))),
        }
    }
    let Some((unit, first)) = all.first().map(|(unit, one)| (*unit, one.index)) else {
        return Err(nothing(document, without));
    };
    if let Some((other, one)) = all.iter().find(|(other, _)| *other != unit) {
        let found =
            format!("readings in {} where recordings[{first}] has them in {}", other.suffix(), unit.suffix());
        return Err(Error::document(format!("{}.columns", one.path()), found, "one unit throughout"));
    }
    let all: Vec<Series> = all.into_iter().map(|(_, one)| one).collect();
    all.iter().try_for_each(|series| check(series, unit, document))?;
    Ok((unit, all))
}

/// What is missing where no recording can be used; `without` has readings of the sensors, but no magnitude.
fn nothing(document: &Document, without: Option<(usize, &Recording)>) -> Error {
    let Some((index, recording)) = without else {
        let expected = format!(
            "a recording of procedure `{}` with `sensor_x_v`, `sensor_y_v`, `sensor_z_v` (or `_nt`) and `reference_nt`",
            procedure::FREE_RUN
        );
        let free = document.recordings.iter().find(|one| is_free(one));
        let found = free.map_or("none that scalarcal can use".into(), |one| {
            format!("no readings of three sensors in \"{}\", whose columns are {}", one.id, names(one, ""))
        });
        return Error::document("recordings", found, expected);
    };
    let expected = format!(
        "`reference_nt` (a scalar magnetometer; `series rename` gives a column this name), `ambient_x_nt`, … (a model of the field), --magnitude-nt (`conditions.{MAGNITUDE}`) if it is known, --place LAT,LON,HEIGHT for that of a model, or --constant-magnitude if the field was constant"
    );
    let (id, beside) = (&recording.id, names(recording, "sensor_"));
    let found =
        format!("no magnitude of the field beside the readings of \"{id}\" (its other columns: {beside})");
    Error::document(format!("recordings[{index}].columns"), found, expected)
}

/// The columns that do not begin so, but for the times.
fn names(recording: &Recording, but: &str) -> String {
    let shown = |name: &&String| name.as_str() != "time_s" && (but.is_empty() || !name.starts_with(but));
    let all: Vec<&str> = recording.columns.keys().filter(shown).map(String::as_str).collect();
    if all.is_empty() { "none".into() } else { all.join(", ") }
}

/// Whether the field is that of the surroundings, and not made by coils.
pub fn is_free(recording: &Recording) -> bool {
    let driven = |name: &String| name.starts_with("coil_") && !name.ends_with("_c");
    recording.procedure == procedure::FREE_RUN && !recording.columns.keys().any(driven)
}

pub fn columns(unit: Unit) -> [String; 3] {
    Axis::ALL.map(|axis| format!("sensor_{axis}_{}", unit.suffix()))
}

/// The unit in which all three sensors are read, by the columns that there are.
pub fn unit_of(has: impl Fn(&String) -> bool) -> Option<Unit> {
    [Unit::Volt, Unit::Nanotesla].into_iter().find(|unit| columns(*unit).iter().all(&has))
}

fn series(
    recording: &Recording,
    index: usize,
    unit: Unit,
    (source, magnitude): (Source, Vec<f64>),
) -> Series {
    let columns = columns(unit).map(|name| recording.column(&name).unwrap_or_default());
    let time = recording.column("time_s");
    let whole = |row: &usize| {
        let mut all = columns.iter().chain(&time).map(|column| column[*row]);
        all.all(f64::is_finite) && magnitude[*row].is_finite() && magnitude[*row] > 0.0
    };
    let rows: Vec<usize> = (0..recording.rows()).filter(whole).collect();
    let of = |column: &[f64]| rows.iter().map(|row| column[*row]).collect::<Vec<f64>>();
    Series {
        index,
        id: recording.id.clone(),
        time_s: time.map(of),
        readings: columns.map(of),
        magnitude_nt: of(&magnitude),
        follows: Vec::new(),
        source,
        missing: recording.rows() - rows.len(),
        rows,
    }
}

fn magnitude(
    recording: &Recording,
    index: usize,
    options: &Options,
) -> Result<Option<(Source, Vec<f64>)>, Error> {
    if let Some(reference) = recording.column("reference_nt") {
        return Ok(Some((Source::Scalar, reference.to_vec())));
    }
    let ambient = Axis::ALL.map(|axis| {
        let name = format!("ambient_{axis}_nt");
        let throughout = recording.conditions.extra.get(&name).and_then(serde_json::Value::as_f64);
        recording.column(&name).map(<[f64]>::to_vec).or(throughout.map(|value| vec![value; recording.rows()]))
    });
    if let [Some(x), Some(y), Some(z)] = ambient {
        let length = |row: usize| x[row].hypot(y[row]).hypot(z[row]);
        return Ok(Some((Source::Ambient, (0..recording.rows()).map(length).collect())));
    }
    let path = format!("recordings[{index}]");
    if let Some(stated) = recording.conditions.quantity(MAGNITUDE, &path)? {
        let value = stated.value();
        if value.is_nan() || value <= 0.0 {
            let key = format!("{path}.conditions.{MAGNITUDE}");
            return Err(Error::document(key, quoted(value), "a positive number"));
        }
        return Ok(Some((Source::Stated, vec![value; recording.rows()])));
    }
    Ok(options.constant_magnitude.then(|| (Source::Constant, vec![1.0; recording.rows()])))
}

fn check(series: &Series, unit: Unit, document: &Document) -> Result<(), Error> {
    let path = series.path();
    if series.rows.is_empty() {
        let found =
            format!("no row of \"{}\" in which all three sensors and the reference were read", series.id);
        return Err(Error::document(format!("{path}.columns"), found, "rows without a null"));
    }
    for (axis, readings) in Axis::ALL.iter().zip(&series.readings) {
        if readings.len() > 1 && readings.iter().all(|reading| *reading == readings[0]) {
            let found =
                format!("the reading {} in all {}", quoted(readings[0]), counted(readings.len(), "row"));
            let expected = format!("a rotated sensor; is {axis} connected, or did the logger freeze?");
            let column = format!("{path}.columns.sensor_{axis}_{}", unit.suffix());
            return Err(Error::document(column, found, expected));
        }
    }
    for (a, b) in [(Axis::X, Axis::Y), (Axis::Y, Axis::Z), (Axis::X, Axis::Z)] {
        if series.len() > 1 && series.readings[a.index()] == series.readings[b.index()] {
            let found = format!("the readings of sensor_{a}_{}", unit.suffix());
            let column = format!("{path}.columns.sensor_{b}_{}", unit.suffix());
            return Err(Error::document(column, found, "readings of its own; was a column copied?"));
        }
    }
    if series.source == Source::Constant {
        return Ok(());
    }
    let magnitude = median_of(&mut series.magnitude_nt.clone());
    let column = match series.source {
        Source::Scalar => format!("{path}.columns.reference_nt"),
        Source::Ambient => format!("{path}.columns.ambient_x_nt"),
        _ => format!("{path}.conditions.{MAGNITUDE}"),
    };
    let read = is_stated(document, unit).then(|| size_of(&along(document, unit, series), magnitude));
    in_units(column, magnitude, read)
}

/// What the readings are along each sensor by the calibration that the document states, nT.
pub fn along(document: &Document, unit: Unit, series: &Series) -> [Vec<f64>; 3] {
    let basic = physics::Basic::found(document, unit);
    Axis::ALL.map(|axis| {
        let sensor = basic.sensors[axis.index()];
        let along = |reading: &f64| sensor.sensitivity * reading + sensor.offset_nt;
        series.readings[axis.index()].iter().map(along).collect()
    })
}

/// The nT of a unit of the readings where no calibration states them.
pub fn nominal(document: &Document, unit: Unit) -> Option<f64> {
    match unit {
        Unit::Volt => document.instrument.as_ref()?.nominal_sensitivity_nt_per_v,
        Unit::Nanotesla => Some(1.0),
    }
}

/// That a magnitude is in nT: like that of a field, and like that of the readings where they tell it.
///
/// Errors: a magnitude that is in another unit, at a place of the document.
pub fn in_units(column: String, magnitude: f64, read: Option<f64>) -> Result<(), Error> {
    // Smaller readings beside the Earth's field are variations about one that is compensated.
    let least = if (EARTH[0]..=EARTH[1]).contains(&magnitude) { 0.0 } else { 1.0 / ALIKE };
    let unlike = read.filter(|read| !(least..=ALIKE).contains(&(read / magnitude)));
    if (PLAUSIBLE[0]..=PLAUSIBLE[1]).contains(&magnitude) && unlike.is_none() {
        return Ok(());
    }
    let other = unlike.unwrap_or(5e4) / magnitude;
    let mut units = [("µT", 1e3), ("mG", 1e2), ("G", 1e5), ("T", 1e9), ("pT", 1e-3)].into_iter();
    let unit = units.find(|(_, factor)| (1.0 / ALIKE..=ALIKE).contains(&(other / factor)));
    let beside =
        unlike.map(|read| format!(" beside readings of {} nT", significant(read, 4))).unwrap_or_default();
    let found = format!("a magnitude of {}{beside}", significant(magnitude, 4));
    let expected = match unit {
        Some((unit, _)) => format!("nT; is it in {unit}?"),
        None => "both in nT; is one of them in another unit, or a sensitivity wrong?".into(),
    };
    Err(Error::document(column, found, expected))
}

/// How large a field the readings along the axes are of, nT: offsets that are not stated can make them longer
/// than the field, but not let them vary more than a field that is turned. So it is their length where that
/// is below the magnitude, else the root of the sum of squared median deviations; between both they fit.
fn size_of(along: &[Vec<f64>; 3], magnitude_nt: f64) -> f64 {
    let rows = 0..along[0].len();
    let mut lengths: Vec<f64> =
        rows.map(|row| along.iter().map(|b| b[row].powi(2)).sum::<f64>().sqrt()).collect();
    let varies = along.iter().map(|b| {
        let middle = median_of(&mut b.clone());
        median_of(&mut b.iter().map(|value| (value - middle).abs()).collect::<Vec<f64>>()).powi(2)
    });
    let (length, varies) = (median_of(&mut lengths), varies.sum::<f64>().sqrt());
    magnitude_nt.clamp(varies.min(length), length)
}

/// The sensitivity that the document states of a sensor, its own or the nominal one.
pub fn sensitivity(document: &Document, unit: Unit, axis: Axis) -> Option<f64> {
    let sensor = document.calibration.as_ref().and_then(|calibration| calibration.sensor(axis));
    let own = sensor.and_then(|sensor| physics::sensitivity(sensor, unit)).map(Quantity::value);
    own.or_else(|| nominal(document, unit))
}

/// Whether the document states the sensitivities of all three sensors.
pub fn is_stated(document: &Document, unit: Unit) -> bool {
    Axis::ALL.iter().all(|axis| sensitivity(document, unit, *axis).is_some())
}
