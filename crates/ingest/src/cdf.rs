//! NASA's CDF: variables as columns, what their attributes say of units, fill values and valid ranges.

use crate::nasa::{Cdf, Values, Variable};
use common::number::counted;
use tables::Place;

use crate::Error;
use crate::mapping::{Mapping, SourceColumn};
use crate::parts::Rows;
use crate::piece::Piece;
use crate::text::Source;
use crate::times::Times;
use crate::units;

/// Most columns that a vector variable may make.
const MOST: usize = 32;

/// Variables of a file as columns.
pub struct Table {
    pub cdf: Cdf,
    pub moments: Vec<(String, Vec<Option<i64>>)>,
    /// Variables of numbers; a vector has a column for each component.
    pub columns: Vec<Column>,
    pub notes: Vec<String>,
}

pub struct Column {
    /// Its name: that of the variable, of a vector with `_x`, `_y`, `_z` or the component's number.
    pub name: String,
    /// Its unit, as a mapping writes it; `?` for one that is not known.
    pub unit: Option<String>,
    /// Values; NaN where one is missing.
    pub values: Vec<f64>,
    /// The variable of its times.
    pub times: Option<String>,
}

impl Table {
    pub fn of(source: &Source) -> Result<Self, Error> {
        let cdf = Cdf::parse(&source.bytes).map_err(|error| {
            source.fault(Place::Whole, error.to_string(), "a CDF of version 3 in one file")
        })?;
        let (mut moments, mut columns, mut notes) = (Vec::new(), Vec::new(), Vec::new());
        for variable in cdf.variables.iter().filter(|variable| variable.varies) {
            match &variable.values {
                Values::Moments(values) if variable.width() == 1 => {
                    moments.push((variable.name.clone(), values.clone()))
                }
                Values::Numbers(values) if variable.dimensions.len() < 2 && variable.width() <= MOST => {
                    columns.extend(columns_of(variable, values, &mut notes));
                }
                _ => notes
                    .push(format!("the variable {:?} is not a numeric column and is ignored", variable.name)),
            }
        }
        Ok(Table { cdf, moments, columns, notes })
    }

    pub fn column(&self, name: &str) -> Option<&Column> {
        self.columns.iter().find(|column| column.name == name)
    }
}

fn columns_of(variable: &Variable, values: &[f64], notes: &mut Vec<String>) -> Vec<Column> {
    let width = variable.width();
    let number = |name: &str| variable.attribute(name).and_then(Values::number);
    let (fill, low, high) = (number("FILLVAL"), number("VALIDMIN"), number("VALIDMAX"));
    let valid = low.zip(high).filter(|(low, high)| low < high);
    let (mut fills, mut outside) = (0, 0);
    let mut clean = |value: f64| {
        if Some(value) == fill {
            fills += 1;
            f64::NAN
        } else if valid.is_some_and(|(low, high)| value < low || value > high) {
            outside += 1;
            f64::NAN
        } else {
            value
        }
    };
    let values: Vec<f64> = values.iter().map(|value| clean(*value)).collect();
    if fills + outside > 0 {
        let (fills, outside) = (counted(fills, "fill value"), counted(outside, "value"));
        let name = &variable.name;
        notes.push(format!(
            "{name}: {fills} (FILLVAL) and {outside} outside VALIDMIN to VALIDMAX, taken as missing"
        ));
    }
    let unit = variable.text("UNITS").map(|unit| unit.trim().to_string()).filter(|unit| !unit.is_empty());
    let unit = unit.map(|unit| unit_of(&unit));
    let times = variable.text("DEPEND_0");
    let name = |component: usize| match (width, component) {
        (1, _) => variable.name.clone(),
        (3, component) => format!("{}_{}", variable.name, ["x", "y", "z"][component]),
        (_, component) => format!("{}_{}", variable.name, component + 1),
    };
    let column = |component: usize| Column {
        name: name(component),
        unit: unit.clone(),
        values: values.iter().skip(component).step_by(width.max(1)).copied().collect(),
        times: times.clone(),
    };
    (0..width).map(column).collect()
}

/// A unit as CDF files write it, in a mapping's spelling.
fn unit_of(unit: &str) -> String {
    let lower = unit.to_ascii_lowercase();
    match lower.as_str() {
        "celsius" | "degrees celsius" | "deg c" | "degrees c" => "C".into(),
        "kelvin" | "kelvins" => "K".into(),
        "degrees of arc" | "degrees" | "degree" | "deg" => "deg".into(),
        "minutes of arc" => "arcmin".into(),
        "nanotesla" | "nt" => "nT".into(),
        "volt" | "volts" => "V".into(),
        "counts" | "count" => "counts".into(),
        _ if units::is_known(unit) => unit.into(),
        _ => "?".into(),
    }
}

/// Reads a file by a mapping; times are those of a variable of moments (`unix_ns`) or of numbers. Errors: a
/// variable that is not there, or has other records than the times; a time that is missing.
pub fn read(source: &Source, mapping: &Mapping) -> Result<Piece, Error> {
    let table = Table::of(source)?;
    let times = Times::new(source, mapping.time.as_ref(), '.')?;
    let mut rows = Rows::default();
    for column in &mapping.columns {
        let name = column.from.name();
        let found = table.column(name).ok_or_else(|| absent(source, &table, name))?;
        rows.columns.push(found.values.clone());
    }
    let count = rows.columns.first().map_or(0, Vec::len);
    rows.lines = (1..=count as u32).collect();
    let time = mapping.time.iter().flat_map(|time| &time.columns).next().map(SourceColumn::name);
    if let Some(time) = time.filter(|_| !times.are_counted()) {
        if let Some((_, moments)) = table.moments.iter().find(|(known, _)| known == time) {
            rows.times_ns = there(source, time, moments)?;
        } else {
            let column = table.column(time).ok_or_else(|| absent(source, &table, time))?;
            let moment = |(row, value): (usize, &f64)| {
                let place = || Place::Row { row: row as u64 + 1, name: time.into() };
                times.read_number(*value).map_err(|expected| source.fault(place(), value, expected))
            };
            rows.times_ns = column.values.iter().enumerate().map(moment).collect::<Result<_, _>>()?;
        }
        if let Some((column, values)) =
            mapping.columns.iter().zip(&rows.columns).find(|(_, values)| values.len() != rows.times_ns.len())
        {
            let (count, from, times) = (counted(values.len(), "record"), &column.from, rows.times_ns.len());
            let found = format!("{count} of {from} and {times} of {time}");
            let expected = "columns of one time; write a mapping for each time, and join them with --add";
            return Err(source.fault(Place::Whole, found, expected));
        }
    }
    let mut piece = Piece::mapped(source, "CDF", mapping, &times, rows)?;
    piece.notes.extend(table.notes);
    Ok(piece)
}

/// Moments, none of which may be missing.
pub fn there(source: &Source, name: &str, moments: &[Option<i64>]) -> Result<Vec<i64>, Error> {
    let moment = |(row, moment): (usize, &Option<i64>)| {
        moment.ok_or_else(|| {
            let place = Place::Row { row: row as u64 + 1, name: name.into() };
            source.fault(place, "no time", "a time since 1972 for each record")
        })
    };
    moments.iter().enumerate().map(moment).collect()
}

fn absent(source: &Source, table: &Table, name: &str) -> Error {
    let names =
        table.moments.iter().map(|(name, _)| name).chain(table.columns.iter().map(|column| &column.name));
    let names: Vec<&str> = names.map(String::as_str).take(30).collect();
    let found = format!("no variable {name:?} among {}", names.join(", "));
    source.fault(Place::Whole, found, "the variables that the mapping takes")
}
