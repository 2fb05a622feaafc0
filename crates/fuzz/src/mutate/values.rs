//! Numbers and words that somebody did not think of.

use serde_json::{Value, json};

use crate::draw::Draw;

pub const NUMBERS: [f64; 30] = [
    0.0, -0.0, 1.0, -1.0, 2.0, 3.0, 0.5, 1e-308, 5e-324, 1e308, -1e308, 1e-30, 1e30, 1e154, 1e-154, 1e12,
    -1e31, 1e-9, 1e9, -1e9, 99999.0, 88888.88, 180.0, 360.0, -273.15, -273.2, 1e6, 1.7e9, 64000.0, 1e5,
];

const WHOLE: [i64; 10] = [0, 1, -1, 2, 7, 255, 65536, 4_294_967_296, i64::MAX, i64::MIN];

/// Numbers of a command line, with bars between them.
pub const TYPED: &str = "nan|inf|-inf|1e308|-1|0|1e-308|-0|1|0.5|2|5|24|25|1e400||x|1e9|1e-9|\
    18446744073709551616|4294967297|1,5|0x10| 1";

/// Words, with bars between them.
const WORDS: &str = "| |x|y|z|all|flight|0|1.5|1e308|\u{0}|\u{feff}x|ÄÖ µT\u{202e}|../x|/dev/zero|a\nb|\
    <script>&\"'|1977-05-26T14:44:35Z|0000-01-01T00:00:00Z|-009999-01-02T01:59:59Z|9999-12-30T22:00:00Z|\
    1977-02-30T00:00:00Z|sensor_x_v|time_s|nT|https://example.org/";

/// A number of JSON that is seldom thought of.
pub fn number(draw: &mut Draw) -> Value {
    match draw.below(20) {
        0..=13 => json!(*draw.of(&NUMBERS)),
        14..=17 => json!(*draw.of(&WHOLE)),
        18 => json!(u64::MAX),
        _ => json!(draw.between(0, 100)),
    }
}

pub fn word(draw: &mut Draw) -> String {
    if draw.chance(3) { "long ".repeat(20_000) } else { draw.part(WORDS).to_string() }
}

pub fn of_another_type(value: &Value, draw: &mut Draw) -> Value {
    let others = [
        Value::Null,
        json!(true),
        json!([]),
        json!({}),
        json!(""),
        json!([value]),
        json!({"value": value}),
        json!({"value": value, "std": 0.0}),
        json!({"value": 1.0, "std": -1.0}),
        json!([[value]]),
        json!(value.to_string().chars().take(40).collect::<String>()),
        json!(1),
        json!("NaN"),
    ];
    draw.of(&others).clone()
}

/// A value inside many lists or objects.
pub fn nested(value: Value, draw: &mut Draw) -> Value {
    let depth = *draw.of(&[2, 100, 130, 3000]);
    let in_lists = draw.chance(50);
    (0..depth).fold(value, |inner, _| if in_lists { Value::Array(vec![inner]) } else { json!({"a": inner}) })
}
