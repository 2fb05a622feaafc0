//! What a file of the program says, in whichever format.

use indexmap::IndexMap;
use serde_json::Value;

/// What such a file says.
pub struct Said {
    pub station: String,
    /// Components by letter; D in minutes of arc.
    pub letters: Vec<char>,
    pub times_ns: Vec<i64>,
    pub columns: Vec<Vec<f64>>,
    pub lines: Vec<u32>,
    pub header: IndexMap<String, Value>,
}
