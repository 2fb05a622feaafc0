//! INTERMAGNET's ImagCDF (Technical Note TN8, version 1.2): components of the field, each with its times, and
//! temperatures.

use common::Extra;
use indexmap::IndexMap;
use tables::Place;

use crate::cdf::{Table, there};
use crate::iaga::{convert, letter as component};
use crate::piece::Piece;
use crate::text::Source;
use crate::{Error, Options, series};

/// Attributes of the file that the document keeps, as the header of IAGA-2002 calls them.
const KEPT: [(&str, &str); 9] = [
    ("Institution", "source of data"),
    ("ObservatoryName", "station name"),
    ("Latitude", "geodetic latitude"),
    ("Longitude", "geodetic longitude"),
    ("Elevation", "elevation"),
    ("ElementsRecorded", "reported"),
    ("VectorSensOrient", "sensor orientation"),
    ("PublicationLevel", "publication level"),
    ("PublicationDate", "publication date"),
];

/// Reads a file; None for a CDF that is not INTERMAGNET's. Errors: no components; components of one time with
/// other numbers of records.
pub fn read(source: &Source, options: &Options) -> Result<Option<Piece>, Error> {
    let mut table = Table::of(source)?;
    let format = table.cdf.text("FormatDescription").unwrap_or_default();
    if !format.to_ascii_uppercase().contains("INTERMAGNET") {
        return Ok(None);
    }
    // Components and temperatures by the variable of their times.
    let mut by_times: IndexMap<String, Vec<(Element, Vec<f64>)>> = IndexMap::new();
    for column in table.columns {
        let Some(element) = Element::of(&column.name) else {
            table.notes.push(format!("the variable {:?} is ignored", column.name));
            continue;
        };
        let named = column.times.filter(|times| table.moments.iter().any(|(name, _)| name == times));
        let times = named.unwrap_or_else(|| element.usual_times(&table.moments));
        by_times.entry(times).or_default().push((element, column.values));
    }
    let mut converted_words = None;
    let mut pieces = Vec::new();
    for (times, elements) in by_times {
        let moments =
            table.moments.iter().find(|(name, _)| *name == times).map(|(_, moments)| moments.as_slice());
        let mut piece = Piece::of(source, "ImagCDF");
        piece.times_ns = there(source, &times, moments.unwrap_or_default())?;
        piece.lines = (1..=piece.times_ns.len() as u32).collect();
        let count = piece.times_ns.len();
        if let Some((element, values)) = elements.iter().find(|(_, values)| values.len() != count) {
            let found = format!("{} records of {} and {count} of {times}", values.len(), element.name());
            return Err(source.fault(Place::Whole, found, "as many times as values"));
        }
        let (mut letters, mut fields) = (Vec::new(), Vec::new());
        for (element, values) in elements {
            match element {
                // The format has degrees, the conversion minutes of arc.
                Element::Field(letter @ ('D' | 'I')) => {
                    letters.push(letter);
                    fields.push(values.into_iter().map(|value| 60.0 * value).collect());
                }
                Element::Field(letter) => {
                    letters.push(letter);
                    fields.push(values);
                }
                Element::Temperature(1) => drop(piece.columns.insert("sensor_temperature_c".into(), values)),
                Element::Temperature(number) => {
                    piece.columns.insert(format!("sensor_temperature_{number}_c"), values);
                }
            }
        }
        let converted = convert(&letters, fields, options.declination_base_arcmin, &options.quantity);
        converted_words = converted_words.or(converted.words);
        piece.columns.extend(converted.columns);
        pieces.push(piece);
    }
    if pieces.iter().all(|piece| piece.columns.is_empty()) {
        let expected = "variables GeomagneticFieldX, …H, …D, …Z, …F, …S with readings";
        return Err(source.fault(Place::Whole, "an ImagCDF file without a component", expected));
    }
    let (joined, _) = series::join(pieces, options.keep, options.sort)?;
    let mut piece = Piece::of(source, "ImagCDF");
    piece.lines = (1..=joined.times_ns.len() as u32).collect();
    (piece.times_ns, piece.columns, piece.notes) = (joined.times_ns, joined.columns, table.notes);
    piece.station = table.cdf.text("IagaCode").filter(|code| !code.is_empty());
    let header =
        KEPT.into_iter().filter_map(|(name, label)| Some((label.to_string(), table.cdf.text(name)?.into())));
    piece.header = header.collect::<Extra>();
    piece.header.extend(converted_words.map(|words| ("converted".to_string(), words.into())));
    Ok(Some(piece))
}

enum Element {
    Field(char),
    Temperature(u32),
}

impl Element {
    fn of(name: &str) -> Option<Self> {
        if let Some(letter) = name.strip_prefix("GeomagneticField") {
            return component(letter).map(Element::Field);
        }
        name.strip_prefix("Temperature")?.parse().ok().map(Element::Temperature)
    }

    fn name(&self) -> String {
        match self {
            Element::Field(letter) => format!("GeomagneticField{letter}"),
            Element::Temperature(number) => format!("Temperature{number}"),
        }
    }

    /// Where no DEPEND_0 says it: the times of its kind, else those of all data.
    fn usual_times(&self, moments: &[(String, Vec<Option<i64>>)]) -> String {
        let own = match self {
            Element::Field('S' | 'F' | 'G') => "GeomagneticScalarTimes".into(),
            Element::Field(_) => "GeomagneticVectorTimes".into(),
            Element::Temperature(number) => format!("Temperature{number}Times"),
        };
        if moments.iter().any(|(name, _)| *name == own) { own } else { "DataTimes".into() }
    }
}
