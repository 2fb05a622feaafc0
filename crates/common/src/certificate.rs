use serde::{Deserialize, Serialize};

use crate::{Error, Extra, Quantity, json, parse};

/// What a calibration certificate states and no program finds (ISO/IEC 17025:2017, 7.8.2 and 7.8.4). An
/// absent key is a blank line on the certificate. An empty text or list is the statement that there is none.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(default)]
pub struct Certificate {
    /// Its unique identification.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub number: Option<String>,
    /// The laboratory that issues it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub laboratory: Option<Party>,
    /// Where the calibration was carried out.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub location: Option<String>,
    /// The customer.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub customer: Option<Party>,
    /// The laboratory's own procedure.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub method: Option<Method>,
    /// What was calibrated.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub item: Option<CalibratedItem>,
    /// Day on which the item was received, YYYY-MM-DD.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub received: Option<String>,
    /// Days of the calibration, YYYY-MM-DD: one, or the first and the last. Absent: those of the recordings'
    /// `start`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub calibrated: Option<Vec<String>>,
    /// Day of issue, YYYY-MM-DD. No program reads a clock.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub issued: Option<String>,
    /// Sampling plan and method.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub sampling: Option<String>,
    /// What the laboratory itself sampled; an empty list: nothing.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub sampled: Option<Vec<Sampling>>,
    /// Additions to, deviations from and exclusions from the method.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub deviations: Option<String>,
    /// Who authorises the certificate.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub authorised_by: Option<Vec<Person>>,
    /// Results that come from external providers, a sentence each.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub external_results: Option<Vec<String>>,
    /// Data that the customer supplied, a sentence each.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub customer_data: Option<Vec<String>>,
    /// Conditions that may have influenced the results, a sentence each, beside the temperatures that stand
    /// in the document.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub conditions: Option<Vec<String>>,
    /// How the measurements are metrologically traceable, in words.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub traceability: Option<String>,
    /// The standards and instruments that the calibration rests on.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub references: Option<Vec<Reference>>,
    /// Adjustment or repair of the item.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub adjustment: Option<Adjustment>,
    /// Opinions and interpretations.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub opinions: Option<String>,
    /// Calibration interval, only where it was agreed with the customer.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub agreed_interval: Option<String>,
    /// Keys that this version does not know.
    #[serde(flatten)]
    pub extra: Extra,
}

impl Certificate {
    /// These data with those of a text put over them, key by key; a list replaces a list.
    ///
    /// # Errors
    ///
    /// A text that is no JSON object of such data, with the path in it.
    pub fn overlaid(&self, text: &str) -> Result<Self, Error> {
        let over: Self = parse::at_path(text)?;
        parse::at_path(&json::overlaid(self, &over))
    }
}

/// A laboratory or a customer.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(default)]
pub struct Party {
    /// Name.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub name: Option<String>,
    /// Postal address, one line or several.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub address: Option<String>,
    /// Person, telephone or electronic mail.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub contact: Option<String>,
    /// Keys that this version does not know.
    #[serde(flatten)]
    pub extra: Extra,
}

/// A procedure of the laboratory.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(default)]
pub struct Method {
    /// Its name or number.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub procedure: Option<String>,
    /// Its version.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub version: Option<String>,
    /// Keys that this version does not know.
    #[serde(flatten)]
    pub extra: Extra,
}

/// Sampling by the laboratory (7.8.5).
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(default)]
pub struct Sampling {
    /// Day of the sampling, YYYY-MM-DD.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub date: Option<String>,
    /// What was sampled: manufacturer, type and serial numbers.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub item: Option<String>,
    /// Where.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub location: Option<String>,
    /// The plan and the method.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub method: Option<String>,
    /// Conditions that affect the interpretation.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub conditions: Option<String>,
    /// What the uncertainty of later results needs to know of the sampling.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub uncertainty: Option<String>,
    /// Keys that this version does not know.
    #[serde(flatten)]
    pub extra: Extra,
}

/// The item that was calibrated.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(default)]
pub struct CalibratedItem {
    /// What it is. Absent: `instrument.name`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub description: Option<String>,
    /// Who made it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub manufacturer: Option<String>,
    /// Its type.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub model: Option<String>,
    /// Its serial number.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub serial: Option<String>,
    /// Its condition when it was received.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub condition: Option<String>,
    /// Keys that this version does not know.
    #[serde(flatten)]
    pub extra: Extra,
}

/// Who authorises a certificate.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(default)]
pub struct Person {
    /// Name.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub name: Option<String>,
    /// Function in the laboratory.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub function: Option<String>,
    /// Keys that this version does not know.
    #[serde(flatten)]
    pub extra: Extra,
}

/// A standard or an instrument that the calibration rests on.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(default)]
pub struct Reference {
    /// What it is.
    pub kind: ReferenceKind,
    /// Maker, type and serial number, or another unambiguous name.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub identity: Option<String>,
    /// The number of its own certificate.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub certificate: Option<String>,
    /// Who issued that.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub issued_by: Option<String>,
    /// The day of that certificate, YYYY-MM-DD.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub date: Option<String>,
    /// Keys that this version does not know.
    #[serde(flatten)]
    pub extra: Extra,
}

/// What a reference is.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
pub enum ReferenceKind {
    /// The coil system.
    Coils,
    /// The voltmeter that reads the precision resistors.
    Voltmeter,
    /// A precision resistor.
    Resistor,
    /// The scalar magnetometer.
    ScalarMagnetometer,
    /// The theodolites.
    Theodolite,
    /// A thermometer.
    Thermometer,
    /// The magnetometer that the item was compared with.
    Magnetometer,
    /// Anything else.
    #[default]
    Other,
}

/// Adjustment or repair of the item.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(default)]
pub struct Adjustment {
    /// What was done; an empty text: nothing.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub done: Option<String>,
    /// Results from before, where there are some; those of the certificate are from after.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub before: Vec<ResultBefore>,
    /// Keys that this version does not know.
    #[serde(flatten)]
    pub extra: Extra,
}

/// A result from before an adjustment.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(default)]
pub struct ResultBefore {
    /// Of what, in the words of the certificate.
    pub of: String,
    /// The result.
    pub result: Quantity,
    /// Its unit.
    pub unit: String,
    /// Keys that this version does not know.
    #[serde(flatten)]
    pub extra: Extra,
}
