//! The mapping file: which column of a file is which of the document, in which unit, and how times are
//! written.

mod check;

#[cfg(feature = "schema")]
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::fmt;
use std::num::NonZeroUsize;

/// How a file of columns is read. `ingest guess FILE` writes one to begin with.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct Mapping {
    /// Format version of the mapping, 1.
    #[serde(rename = "fluxcal-mapping")]
    pub version: u64,
    /// Free text.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub note: Option<String>,
    /// What stands between values: `,`, `;`, a tabulator, `|`, or a blank for any number of blanks. CSV only.
    #[serde(default = "comma")]
    pub separator: char,
    /// The decimal mark, `.` or `,`. CSV only.
    #[serde(default = "point")]
    pub decimal: char,
    /// What stands between groups of three digits before the decimal mark, as in "48,520.31": `,`, `.`, `'`,
    /// `_` or a blank; a field that holds the separator too stands in quotes. Absent: nothing does. CSV only.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub thousands: Option<char>,
    /// Lines that begin so, perhaps after blanks, are passed over; absent: none are. CSV only.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub comment: Option<String>,
    /// The line that names the columns, counted from 1 with comments and empty lines; absent: no line does,
    /// and columns go by number. CSV only.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub header_line: Option<u32>,
    /// The line of the first row; absent: the one after the names. CSV only.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub first_row_line: Option<u32>,
    /// What stands for a missing value, besides nothing, `nan`, `null` and `NA`. A number counts by its
    /// value.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub missing: Vec<String>,
    /// When a row was taken; absent: rows have no times.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub time: Option<TimeMapping>,
    /// The columns that are taken. The others are not looked at.
    pub columns: Vec<ColumnMapping>,
}

fn comma() -> char {
    ','
}

fn point() -> char {
    '.'
}

impl Default for Mapping {
    fn default() -> Self {
        Mapping {
            version: 1,
            note: None,
            separator: comma(),
            decimal: point(),
            thousands: None,
            comment: None,
            header_line: None,
            first_row_line: None,
            missing: Vec::new(),
            time: None,
            columns: Vec::new(),
        }
    }
}

/// A column of the file, by its name or by its number from 1.
#[derive(Clone, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
#[serde(untagged, expecting = "the name of a column, or its number from 1")]
pub enum SourceColumn {
    /// Its number, from 1.
    Number(NonZeroUsize),
    /// Its name in the header.
    Name(String),
}

impl SourceColumn {
    /// Its name; empty where it goes by its number.
    pub fn name(&self) -> &str {
        match self {
            SourceColumn::Name(name) => name,
            SourceColumn::Number(_) => "",
        }
    }
}

impl fmt::Display for SourceColumn {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        match self {
            SourceColumn::Number(number) => write!(f, "{number}"),
            SourceColumn::Name(name) => write!(f, "{name:?}"),
        }
    }
}

impl Mapping {
    /// The first column that goes by its number.
    pub fn number(&self) -> Option<NonZeroUsize> {
        let times = self.time.iter().flat_map(|time| &time.columns);
        times.chain(self.columns.iter().map(|column| &column.from)).find_map(|from| match from {
            SourceColumn::Number(number) => Some(*number),
            SourceColumn::Name(_) => None,
        })
    }
}

/// How times are written.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct TimeMapping {
    /// The columns that hold the time, joined by a blank where there are several (date and time of day).
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub columns: Vec<SourceColumn>,
    /// `iso`; `unix_s`, `unix_ms`, `unix_us`, `unix_ns` (since 1970, UTC); `seconds` or `milliseconds` (since
    /// the recording's start); `seconds_of_day`, `milliseconds_of_day`, `hours_of_day` (since midnight, with
    /// decimals; the day is that of `date_in_name` or of `start`, or a pattern of it stands before: `%Y-%m-%d
    /// seconds_of_day`, `%Y %j seconds_of_day`); `day_of_year` (year and day, 1 January = 1, with decimals);
    /// `excel_days`, `matlab_days`; or a pattern as of strptime, such as `%d.%m.%Y %H:%M:%S%.f`, `%Y %j
    /// %H:%M`, `%m/%d/%Y %I:%M:%S %p`.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub format: String,
    /// The clock's time zone where the times themselves do not say it: `UTC`, `+02:00`, `Europe/Vienna`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub zone: Option<String>,
    /// Where rows hold the time of day alone: pattern of the date in the file's name, such as `%Y_%m_%d` or
    /// `%b%d%y`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub date_in_name: Option<String>,
    /// For `seconds`, `milliseconds` and `step_s`: when they begin, RFC 3339. Absent: on the campaign's
    /// clock. For `seconds_of_day` and the like: the first row's day.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub start: Option<String>,
    /// In place of columns: rows follow one another by so many seconds.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub step_s: Option<f64>,
    /// Free text.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub note: Option<String>,
}

/// A column that is taken: value = sign × (file's value × scale, converted from `unit`) + offset. `missing`,
/// `bits` and `valid` speak of the file's value, in this order, before anything else.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct ColumnMapping {
    /// Which column of the file.
    pub from: SourceColumn,
    /// Its name in the document, `quantity_axis_unit`: `sensor_x_nt`, `reference_nt`, `sensor_temperature_c`.
    pub to: String,
    /// The unit in the file. `?` where it is not known yet: such a mapping is refused until you say it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub unit: Option<String>,
    /// Multiplies the file's values before they are converted; from `counts` or volts to field: what one is
    /// in the document's unit.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub scale: Option<f64>,
    /// Numbers that stand for a missing value in this column.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub missing: Vec<f64>,
    /// The file has signed whole numbers of so many bits (2 to 53) in two's complement, written without sign:
    /// 2ᵇ⁻¹ and more are negative.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub bits: Option<u8>,
    /// The least and the greatest value that is a reading, in the file's unit; others are taken as missing,
    /// and counted.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub valid: Option<[f64; 2]>,
    /// −1 turns an axis around.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub sign: Option<i8>,
    /// Is added at the end, in the document's unit: a compensation field.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub offset: Option<f64>,
    /// Free text.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub note: Option<String>,
}

impl ColumnMapping {
    /// A column as it stands in the file.
    pub fn plain(from: SourceColumn, to: impl Into<String>, unit: Option<String>) -> Self {
        ColumnMapping {
            from,
            to: to.into(),
            unit,
            scale: None,
            missing: Vec::new(),
            bits: None,
            valid: None,
            sign: None,
            offset: None,
            note: None,
        }
    }
}

/// Words of [`TimeMapping::format`] that are no patterns.
pub const FORMATS: &str = "iso, unix_s, unix_ms, unix_us, unix_ns, seconds, milliseconds, seconds_of_day, milliseconds_of_day, \
                           hours_of_day, day_of_year, excel_days, matlab_days";
