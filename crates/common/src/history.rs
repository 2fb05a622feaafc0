#[cfg(feature = "schema")]
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use crate::Extra;

/// One line of the document's history. No clock times: the same input gives the same bytes.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(JsonSchema))]
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
