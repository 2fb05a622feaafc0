//! Some rows of a file as text, whatever its format.

use common::number::counted;
use serde_json::{Map, Value};
use std::io::Cursor;
use std::num::NonZeroUsize;
use tables::{COLUMN_LIMIT, ColumnKind, Content, Place, Reader};

use super::hapi;
use super::notation::{Notation, is_missing};
use crate::Error;
use crate::cdf;
use crate::clock;
use crate::mapping::SourceColumn;
use crate::text::{Source, lines};

const ROWS: usize = 400;

/// Columns and some of their cells.
pub struct Sample {
    /// How text is written; the usual one for other formats.
    pub notation: Notation,
    /// How the mapping names each column.
    pub from: Vec<SourceColumn>,
    /// Names as people read them; empty where there are none.
    pub names: Vec<String>,
    /// Units that stand below the names, where a line holds them.
    pub units: Vec<Option<String>>,
    pub cells: Vec<Vec<String>>,
    pub kinds: Vec<Cells>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Cells {
    /// Numbers, with the decimal mark of the file.
    Numbers,
    /// Moments of type TIMESTAMP.
    Moments,
    /// Date and time, or a date, as ISO 8601 writes it.
    Iso,
    Text,
    Empty,
}

impl Sample {
    pub fn of(source: &Source) -> Result<Self, Error> {
        match source.kind {
            Content::NdJson => Self::of_ndjson(source),
            Content::Parquet => Self::of_parquet(source),
            Content::Cdf => Self::of_cdf(source),
            Content::Delimited | Content::Iaga | Content::Iaf | Content::Document => Self::of_text(source),
        }
    }

    fn new(notation: Notation, from: Vec<SourceColumn>, names: Vec<String>, cells: Vec<Vec<String>>) -> Self {
        let kinds = cells.iter().map(|column| kind(column, &notation)).collect();
        let units = notation.units.clone().unwrap_or_else(|| vec![None; names.len()]);
        Sample { notation, from, names, units, cells, kinds }
    }

    fn of_text(source: &Source) -> Result<Self, Error> {
        let mut notation = Notation::of(source, ROWS)?;
        let width = notation.width;
        if let Some(columns) = hapi::header(&source.bytes) {
            if columns.len() != width {
                let found = format!("{} in the first row", counted(width, "value"));
                let expected = format!("{}, as the header of the HAPI server says", columns.len());
                return Err(source.fault(Place::Whole, found, expected));
            }
            notation.mapping.header_line = None;
            notation.names = Some(columns.iter().map(|column| column.name.clone()).collect());
            notation.units = Some(columns.into_iter().map(|column| column.unit).collect());
        }
        let names = notation.names.clone().unwrap_or_else(|| vec![String::new(); width]);
        let by_number = notation.mapping.header_line.is_none();
        let alone =
            |name: &String| names.iter().filter(|other| *other == name).count() == 1 && !name.is_empty();
        let from = names.iter().enumerate().map(|(index, name)| {
            let number = NonZeroUsize::MIN.saturating_add(index);
            if alone(name) && !by_number {
                SourceColumn::Name(name.clone())
            } else {
                SourceColumn::Number(number)
            }
        });
        let cell = |row: &Vec<String>, column: usize| row.get(column).cloned().unwrap_or_default();
        let cells = (0..width).map(|column| notation.rows.iter().map(|row| cell(row, column)).collect());
        let (from, cells) = (from.collect(), cells.collect());
        Ok(Self::new(notation, from, names, cells))
    }

    fn of_ndjson(source: &Source) -> Result<Self, Error> {
        let mut names: Vec<String> = Vec::new();
        let mut objects: Vec<Map<String, Value>> = Vec::new();
        for (number, line) in
            lines(&source.bytes).filter(|(_, line)| !line.trim_ascii().is_empty()).take(ROWS)
        {
            let object: Map<String, Value> = serde_json::from_slice(line).map_err(|error| {
                let place = Place::Line(number.into());
                let cut = if error.is_eof() { "; was the file cut?" } else { "" };
                let expected = format!("one JSON object on each line{cut}");
                source.fault(place, format!("no JSON object ({error})"), expected)
            })?;
            names.extend(object.keys().filter(|key| !names.contains(key)).cloned().collect::<Vec<_>>());
            objects.push(object);
        }
        if names.len() > COLUMN_LIMIT {
            return Err(crate::delimited::too_many(source, 1, names.len()));
        }
        let cell = |value: Option<&Value>| match value {
            None | Some(Value::Null) => String::new(),
            Some(Value::String(text)) => text.clone(),
            Some(other) => other.to_string(),
        };
        let cells = names.iter().map(|name| objects.iter().map(|object| cell(object.get(name))).collect());
        let (cells, from) = (cells.collect(), by_name(&names));
        let mut sample = Self::new(Notation::default(), from, names, cells);
        // A number in quotes is text here.
        for (kind, name) in sample.kinds.iter_mut().zip(&sample.names) {
            if *kind == Cells::Numbers
                && objects.iter().any(|object| object.get(name).is_some_and(Value::is_string))
            {
                *kind = Cells::Text;
            }
        }
        Ok(sample)
    }

    fn of_cdf(source: &Source) -> Result<Self, Error> {
        let table = cdf::Table::of(source)?;
        let (notation, mut names, mut cells) = (Notation::default(), Vec::new(), Vec::new());
        let (mut units, mut kinds) = (Vec::new(), Vec::new());
        let moments = table.moments.into_iter().map(|(name, _)| (name, Vec::new(), None, Cells::Moments));
        let numbers = table.columns.into_iter();
        let numbers = numbers.map(|one| (one.name, first_cells(&one.values), one.unit, Cells::Numbers));
        for (name, some, unit, kind) in moments.chain(numbers) {
            names.push(name);
            cells.push(some);
            units.push(unit);
            kinds.push(kind);
        }
        Ok(Sample { notation, from: by_name(&names), names, units, cells, kinds })
    }

    fn of_parquet(source: &Source) -> Result<Self, Error> {
        let bytes = || Cursor::new(source.bytes.clone());
        let columns = tables::parquet_columns(bytes(), &source.shown)?;
        let wanted = columns.iter().filter(|(_, kind)| *kind != ColumnKind::Other);
        let wanted: Vec<&str> = wanted.map(|(name, _)| name.as_str()).collect();
        if wanted.is_empty() {
            return Err(source.fault(Place::Whole, "no column of numbers", "a table of readings"));
        }
        let batch = Reader::parquet(bytes(), &source.shown, Some(&wanted))?.next().transpose()?;
        let values = batch.map_or_else(|| vec![Vec::new(); wanted.len()], |batch| batch.columns);
        let cells = values.iter().map(|column| first_cells(column)).collect();
        let names: Vec<String> = wanted.iter().map(|name| name.to_string()).collect();
        let mut sample = Self::new(Notation::default(), by_name(&names), names, cells);
        for (kind, name) in sample.kinds.iter_mut().zip(&sample.names) {
            if columns.iter().any(|(known, kind)| known == name && *kind == ColumnKind::Time) {
                *kind = Cells::Moments;
            }
        }
        Ok(sample)
    }

    pub fn numbers(&self, column: usize) -> Vec<f64> {
        self.cells[column].iter().filter_map(|cell| self.notation.number(cell)).collect()
    }
}

fn by_name(names: &[String]) -> Vec<SourceColumn> {
    names.iter().cloned().map(SourceColumn::Name).collect()
}

fn first_cells(values: &[f64]) -> Vec<String> {
    let cell = |value: &f64| if value.is_nan() { String::new() } else { value.to_string() };
    values.iter().take(ROWS).map(cell).collect()
}

fn kind(cells: &[String], notation: &Notation) -> Cells {
    let there = cells.iter().filter(|cell| !is_missing(cell));
    if there.clone().next().is_none() {
        return Cells::Empty;
    }
    // Most cells decide: the one that is not like them shall be named with its line when the file is read.
    let all = there.clone().count();
    let most = |like: &dyn Fn(&str) -> bool| 2 * there.clone().filter(|cell| like(cell.trim())).count() > all;
    if most(&|cell| notation.number(cell).is_some()) {
        Cells::Numbers
    } else if most(&|cell| clock::iso(cell.as_bytes()).is_some()) {
        Cells::Iso
    } else {
        Cells::Text
    }
}
