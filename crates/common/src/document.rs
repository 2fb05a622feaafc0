use serde::{Deserialize, Serialize};
use std::collections::HashMap;

use crate::number::counted;
use crate::{
    Calibration, Certificate, Diagnosis, Error, Extra, Facility, Instrument, Model, Recording, Undetermined,
    Versioned, check, parse, to_line, to_text, undetermined,
};

/// One campaign: the facility, the instrument, what was recorded and what was found.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Document {
    /// Format version; a newer one is refused.
    pub fluxcal: u64,
    /// Free text.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub title: Option<String>,
    /// The coil facility.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub facility: Option<Facility>,
    /// The magnetometer.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub instrument: Option<Instrument>,
    /// The recordings; their order means nothing.
    #[serde(default)]
    pub recordings: Vec<Recording>,
    /// What the stages found.
    #[serde(default, skip_serializing_if = "Option::is_none", deserialize_with = "undetermined::read")]
    pub calibration: Option<Calibration>,
    /// Physics adopted beyond the basic model.
    #[serde(default, skip_serializing_if = "Option::is_none", deserialize_with = "undetermined::read")]
    pub model: Option<Model>,
    /// What diagnose wrote.
    #[serde(default, skip_serializing_if = "Option::is_none", deserialize_with = "undetermined::read")]
    pub diagnosis: Option<Vec<Diagnosis>>,
    /// Numbers of `calibration`, `model` and `diagnosis` that are `null`.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub undetermined: Vec<Undetermined>,
    /// What a calibration certificate states beside the results.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub certificate: Option<Box<Certificate>>,
    /// The stages that the document went through.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub history: Vec<HistoryEntry>,
    /// Keys that this version does not know.
    #[serde(flatten)]
    pub extra: Extra,
}

impl Document {
    /// Reads a document from text and checks what holds for every stage: the version, unique ids,
    /// columns of one length.
    pub fn parse(text: &str) -> Result<Self, Error> {
        let document: Document = parse(text)?;
        document.check()?;
        Ok(document)
    }

    /// As JSON that people read, one key on a line; what is undetermined of it is listed before.
    ///
    /// # Errors
    ///
    /// A reading that no instrument can give.
    pub fn to_text(&mut self) -> Result<String, Error> {
        self.check_numbers()?;
        Ok(to_text(self))
    }

    /// As JSON on one line.
    ///
    /// # Errors
    ///
    /// As [`Self::to_text`].
    pub fn to_line(&mut self) -> Result<String, Error> {
        self.check_numbers()?;
        Ok(to_line(self))
    }

    /// What is undetermined is listed; a reason that was given before stays. The recordings, where a missing
    /// reading is none, are held to what instruments can give.
    fn check_numbers(&mut self) -> Result<(), Error> {
        let mut found = undetermined::undetermined("calibration", &self.calibration);
        found.extend(undetermined::undetermined("model", &self.model));
        found.extend(undetermined::undetermined("diagnosis", &self.diagnosis));
        for one in &mut found {
            if let Some(before) = self.undetermined.iter().find(|before| before.path == one.path) {
                *one = before.clone();
            }
        }
        self.undetermined = found;
        self.calibration.iter().try_for_each(check::constants).map_err(Error::came_out)?;
        undetermined::readings(&self.recordings)
    }

    /// Ids are unique, the columns of a recording have one length, `start` is a moment, every reading is one
    /// that an instrument can give, times do not run backwards, and the calibration is one that can be.
    pub fn check(&self) -> Result<(), Error> {
        self.calibration.iter().try_for_each(check::calibration)?;
        self.facility.iter().try_for_each(check::facility)?;
        self.instrument.iter().try_for_each(check::instrument)?;
        let mut seen = HashMap::new();
        for (index, recording) in self.recordings.iter().enumerate() {
            let path = format!("recordings[{index}]");
            if let Some(first) = seen.insert(recording.id.as_str(), index) {
                return Err(Error::document(
                    format!("{path}.id"),
                    format!("\"{}\", which recordings[{first}] has already", recording.id),
                    "an id that is unique within the document; rename one of the two",
                ));
            }
            if recording.start.is_some() && recording.start().is_none() {
                return Err(Error::document(
                    format!("{path}.start"),
                    format!("\"{}\"", recording.start.as_deref().unwrap_or_default()),
                    "a moment with its offset from UTC, as in \"1977-05-26T14:44:35Z\" (RFC 3339)",
                ));
            }
            recording.check(&path)?;
            let rows = recording.rows();
            for (name, column) in &recording.columns {
                if column.len() != rows {
                    return Err(Error::document(
                        format!("{path}.columns.{name}"),
                        format!("{} where another column has {rows}", counted(column.len(), "row")),
                        "columns of one length; write null for a missing reading",
                    ));
                }
            }
        }
        Ok(())
    }
}

/// One line of the document's history. No clock times: the same input gives the same bytes.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct HistoryEntry {
    /// The program.
    pub stage: String,
    /// Its version.
    pub version: String,
    /// What it was asked, without file names.
    #[serde(default)]
    pub arguments: Vec<String>,
    /// SHA-256 of the bytes that it read, in hexadecimal.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub input_sha256: Option<String>,
    /// Keys that this version does not know.
    #[serde(flatten)]
    pub extra: Extra,
}

impl Versioned for Document {
    fn format_version(&self) -> Option<u64> {
        Some(self.fluxcal)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{at_path, line_of};
    use serde_json::Value;

    #[test]
    fn unknown_keys_survive_at_every_level() {
        let text = r#"{"fluxcal": 1, "mood": "fair", "facility": {"roof": "tin", "coils": {"x": {"turns": 9}, "w": 1}},
            "instrument": {"maker": "A", "noise": {"white_rms_nt": 0.1, "note": "n"}},
            "recordings": [{"id": "a", "procedure": "free_run", "weather": "dry",
                "conditions": {"door": "shut", "theodolite": {"phi_x_rad": 0.5, "theta_x_rad": 1.5, "phi_y_rad": 0.5, "theta_y_rad": 1.5, "by": "me"}},
                "columns": {"time_s": [0.5, null]}}],
            "calibration": {"axes": {"note": 1, "sensors": {"glue": true}}, "coils": {"x": {"offset_nt": {"value": 1.5, "from": "b"}}}, "differential": {"a": 1}},
            "model": {"effects": [{"effect": "e", "parameters": {"a_nt": 2.5}, "why": "w"}], "v": 2}, "diagnosis": [{"verdict": "agrees"}]}"#;
        let document = Document::parse(text).expect("a good document");
        let before: Value = serde_json::from_str(text).expect("JSON");
        let after = serde_json::to_value(&document).expect("JSON");
        assert_eq!(before, after);
    }

    #[test]
    fn a_byte_order_mark_is_passed_over() {
        let marked = "\u{feff}{\"fluxcal\": 1,\n \"title\": 2}";
        let error = Document::parse(marked).expect_err("no title");
        assert_eq!(error.to_string(), "title: found 2; expected a string");
        assert_eq!(line_of(marked, "title"), Some(2));
        assert!(Document::parse("\u{feff}{\"fluxcal\": 1}").is_ok());
        assert_eq!(at_path::<Value>("\u{feff}[1]").expect("a list"), serde_json::json!([1]));
    }

    #[test]
    fn messages_speak_of_json() {
        let said =
            |text: &str| Document::parse(&format!("{{\"fluxcal\": 1, {text}}}")).expect_err(text).to_string();
        for (text, message) in [
            (r#""recordings": 5"#, "recordings: found 5; expected a list"),
            (r#""recordings": [[]]"#, "recordings[0]: found a list; expected an object"),
            (r#""recordings": [{"id": 1.5}]"#, "recordings[0].id: found 1.5; expected a string"),
            (
                r#""recordings": [{"id": "a", "id": "b"}]"#,
                "recordings[0]: found the key `id` twice; expected each key once",
            ),
            (
                r#""recordings": [{"id": "a"}]"#,
                "recordings[0]: found no key `procedure`; expected `procedure`, which is required there",
            ),
            (
                r#""calibration": {"axes": {"sensors": {"matrix": [[1, 2]]}}}"#,
                "calibration.axes.sensors.matrix[0]: found a list; expected a list of 3",
            ),
        ] {
            assert_eq!(said(text), message);
        }
    }
}
