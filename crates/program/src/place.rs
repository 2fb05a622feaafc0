//! A magnitude of the field that nobody measured: as it is stated, or by a model of the Earth's field.

use clap::Args;
use clap::builder::{PossibleValuesParser, TypedValueParser};
use common::time::Start;
use common::{Axis, Document, Error, Quantity, Recording};
use mainfield::{Model, Place};
use serde_json::json;

use crate::number;

/// A place whose field a model says.
#[derive(Args, Clone, Debug, Default, PartialEq)]
pub struct AtPlace {
    /// Where it was recorded: degrees north and east, metres above the ellipsoid; a model of the Earth's field tells the field there
    #[arg(long, value_name = "LAT,LON,HEIGHT", allow_hyphen_values = true, value_parser = place)]
    pub place: Option<Place>,
    /// When, in place of the recording's `start`: 2026-11-30, or RFC 3339 with its zone
    #[arg(long, requires = "place", value_parser = date)]
    pub date: Option<String>,
    /// The model [default: igrf14]
    #[arg(long, requires = "place", value_parser = PossibleValuesParser::new(Model::ALL.map(Model::name)).map(model))]
    pub field_model: Option<Model>,
}

/// A magnitude for recordings in which none was measured.
#[derive(Args, Clone, Debug, Default, PartialEq)]
pub struct KnownMagnitude {
    /// Magnitude of the field in recordings without a reference, nT
    #[arg(long, value_name = "NT", value_parser = number::positive, conflicts_with = "place")]
    pub magnitude_nt: Option<f64>,
    /// Its standard uncertainty, nT [default: 138 of a model, none of a number]
    #[arg(long, value_name = "NT", value_parser = number::positive)]
    pub magnitude_std_nt: Option<f64>,
    #[command(flatten)]
    #[allow(missing_docs)]
    pub at: AtPlace,
}

impl AtPlace {
    /// The field north, east and down at the place at a moment, which stands at this path, or on the date of the
    /// option, and where it comes from; None where no place is named.
    ///
    /// # Errors
    ///
    /// A moment that is not known, or outside the years of the model.
    pub fn field_nt(&self, start: Option<Start>, path: &str) -> Result<Option<([f64; 3], String)>, Error> {
        let Some(place) = &self.place else { return Ok(None) };
        let moment = self.date.as_deref().map_or(start, moment);
        let Some(year) = moment.and_then(Start::year) else {
            let expected = "a moment such as 2026-11-30T12:00:00Z, or --date: the field of a place changes by some 50 nT a year";
            return Err(Error::document(path, "none", expected));
        };
        let model = self.field_model.unwrap_or_default();
        let field = model.field_nt(place, year).ok_or_else(|| {
            let [from, to] = model.years();
            let others = Model::ALL.iter().filter(|other| other.field_nt(place, year).is_some());
            let others: Vec<String> = others.map(|other| format!("--field-model {}", other.name())).collect();
            let remedy = if others.is_empty() { "--magnitude-nt".into() } else { others.join(", ") };
            Error::Request(format!("{model} holds from {from} to {to}, and not in {year:.1}; use {remedy}"))
        })?;
        let Place { latitude_deg, longitude_deg, height_m } = place;
        let said = format!("{model} at {latitude_deg}°, {longitude_deg}°, {height_m} m in {year:.2}");
        Ok(Some((field, said)))
    }

    /// What the history records of the request.
    pub fn arguments(&self) -> Vec<String> {
        let place = self
            .place
            .iter()
            .map(|at| format!("--place={},{},{}", at.latitude_deg, at.longitude_deg, at.height_m));
        let date = self.date.iter().map(|date| format!("--date={date}"));
        let model = self.field_model.iter().map(|model| format!("--field-model={}", model.name()));
        place.chain(date).chain(model).collect()
    }
}

impl KnownMagnitude {
    /// States the magnitude, `conditions.magnitude_nt`, of those recordings of sensors in which none was measured,
    /// with where it comes from (`conditions.field_model`). A place leaves a magnitude that is stated as it is.
    ///
    /// # Errors
    ///
    /// See [`AtPlace::field_nt`].
    pub fn state(&self, document: &mut Document, of: impl Fn(&Recording) -> bool) -> Result<(), Error> {
        if self.magnitude_std_nt.is_some() && self.magnitude_nt.is_none() && self.at.place.is_none() {
            let words =
                "--magnitude-std-nt is the uncertainty of a magnitude: give --magnitude-nt or --place too";
            return Err(Error::Request(words.into()));
        }
        for (index, recording) in document.recordings.iter_mut().enumerate() {
            let own = &recording.conditions.extra;
            let stated = own.contains_key("magnitude_nt") && !own.contains_key("field_model");
            let keeps = stated && self.magnitude_nt.is_none();
            // The columns of a table beside the document may not be at hand.
            let columns = recording.columns.keys();
            let measured = columns.len() > 0 && is_measured(columns, own.keys());
            if measured || keeps || !of(recording) {
                continue;
            }
            let modelled = self.at.field_nt(recording.start(), &format!("recordings[{index}].start"))?;
            let (value, std, said) = match (self.magnitude_nt, modelled) {
                (Some(value), _) => (value, self.magnitude_std_nt, None),
                (None, Some(([x, y, z], said))) => {
                    let length = (10.0 * x.hypot(y).hypot(z)).round() / 10.0;
                    (length, self.magnitude_std_nt.or(Some(Model::MAGNITUDE_STD_NT)), Some(said))
                }
                (None, None) => return Ok(()),
            };
            let magnitude = std.map_or(Quantity::Bare(value), |std| Quantity::new(value, std));
            let conditions = &mut recording.conditions.extra;
            conditions.insert("magnitude_nt".into(), json!(magnitude));
            conditions.remove("field_model");
            conditions.extend(said.map(|said| ("field_model".to_string(), json!(said))));
        }
        Ok(())
    }

    /// What the history records of the request.
    pub fn arguments(&self) -> Vec<String> {
        let numbers = [("magnitude-nt", self.magnitude_nt), ("magnitude-std-nt", self.magnitude_std_nt)];
        let numbers = numbers.into_iter().filter_map(|(name, value)| Some(format!("--{name}={}", value?)));
        numbers.chain(self.at.arguments()).collect()
    }
}

/// Whether columns and conditions have a magnitude, or columns no sensors.
pub fn is_measured<'a>(
    columns: impl Iterator<Item = &'a String> + Clone,
    conditions: impl Iterator<Item = &'a String> + Clone,
) -> bool {
    let column = |wanted: &str| columns.clone().any(|name| name == wanted);
    let ambient = |axis: Axis| {
        let wanted = format!("ambient_{axis}_nt");
        column(&wanted) || conditions.clone().any(|name| *name == wanted)
    };
    let sensors = columns.clone().any(|name| name.starts_with("sensor_"));
    !sensors || column("reference_nt") || Axis::ALL.into_iter().all(ambient)
}

fn place(text: &str) -> Result<Place, String> {
    let numbers: Option<Vec<f64>> = text.split(',').map(|part| part.trim().parse().ok()).collect();
    let wrong = || "expected degrees north, degrees east and metres, such as 47.93,15.87,1087".to_string();
    let [latitude_deg, longitude_deg, height_m] = numbers.unwrap_or_default()[..] else {
        return Err(wrong());
    };
    if !(-1e4..=2e6).contains(&height_m) {
        return Err("expected a height in metres, from 10 km below the ellipsoid to 2 000 km above".into());
    }
    let known = latitude_deg.abs() <= 90.0 && longitude_deg.abs() <= 360.0;
    if known { Ok(Place { latitude_deg, longitude_deg, height_m }) } else { Err(wrong()) }
}

/// A moment, or the beginning of a day.
fn moment(text: &str) -> Option<Start> {
    Start::parse(text).or_else(|| Start::parse(&format!("{text}T00:00:00Z")))
}

fn date(text: &str) -> Result<String, String> {
    moment(text).map(|_| text.into()).ok_or_else(|| {
        "expected a date such as 2026-11-30, or a moment with its zone such as 2026-11-30T12:00:00Z".into()
    })
}

fn model(name: String) -> Model {
    Model::ALL.into_iter().find(|model| model.name() == name).unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_place_states_what_was_not_measured() {
        let text = r#"{"fluxcal": 1, "recordings": [
            {"id": "a", "procedure": "free_run", "start": "2022-08-10T00:00:00Z", "columns": {"sensor_x_v": [1]}},
            {"id": "b", "procedure": "free_run", "columns": {"sensor_x_v": [1], "reference_nt": [48850]}},
            {"id": "c", "procedure": "free_run", "columns": {"sensor_x_v": [1]}}]}"#;
        let mut document = Document::parse(text).expect("a document");
        let at = AtPlace { place: place("47.93,15.865,1087").ok(), ..AtPlace::default() };
        let mut known = KnownMagnitude { at, ..KnownMagnitude::default() };
        let error = known.state(&mut document, |_| true).expect_err("no moment").to_string();
        assert!(error.starts_with("recordings[2].start: found none") && error.contains("--date"), "{error}");
        known.at.date = date("2022-08-10").ok();
        known.state(&mut document, |_| true).expect("stated");
        let of = |at: usize| document.recordings[at].conditions.extra.get("magnitude_nt");
        let stated: Quantity = serde_json::from_value(of(0).expect("stated").clone()).expect("a quantity");
        // The scalar magnetometer of the Conrad Observatory read 48 855 nT on that day.
        assert!((stated.value() - 48_855.0).abs() < 138.0 && stated.std() == Some(138.0), "{stated:?}");
        assert_eq!((of(1), of(2)), (None, of(0)));
    }

    #[test]
    fn what_is_no_place_and_no_date_of_the_model_is_refused() {
        for text in ["47.93,15.87", "97,0,0", "47.93N,15.87,10.0,1087", "0,0,-6378137", ""] {
            assert!(place(text).is_err(), "{text}");
        }
        assert!(date("30.11.2026").is_err());
        let at = |date: &str, field_model: Model| AtPlace {
            place: place("0,0,0").ok(),
            date: Some(date.into()),
            field_model: Some(field_model),
        };
        let error = at("2022-01-01", Model::Wmm2025).field_nt(None, "").expect_err("too early").to_string();
        assert!(error.contains("--field-model igrf14"), "{error}");
        let error = at("1850-01-01", Model::Igrf14).field_nt(None, "").expect_err("too early").to_string();
        assert!(error.contains("--magnitude-nt"), "{error}");
    }
}
