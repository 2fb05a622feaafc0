//! The natural field in which simulated pairs stand.

use serde_json::{Value, json};

/// At a middle latitude on a quiet day, with the variations of its background.
pub fn outside() -> Value {
    json!({
        "main_field_nt": [20800, 700, 47500],
        "daily_nt": [22, 28, 12],
        "background": {"flicker_nt2_per_hz_at_1hz": 2e-4, "flicker_exponent": 1.6}
    })
}
