//! A document with every key of the schema fills every column of every table: the names in the templates are
//! those of the document.

use common::Document;
use report::Options;
use serde_json::{Map, Value, json};

/// Keys that the templates ask for in maps whose keys are data.
const KEYS: &str = "a_nt xx constant_nt_per_a offset_nt sensitivity_ppm_per_k offset_nt_per_k";

/// What a schema allows, with every key; of several forms the last that is not null. A type within itself is
/// left out.
fn filled(schema: &Value, definitions: &Value, within: &[&str]) -> Value {
    if let Some(name) = schema["$ref"].as_str().and_then(|path| path.rsplit('/').next()) {
        let within = [within, &[name]].concat();
        let again = within.iter().filter(|other| **other == name).count() > 1;
        return if again { Value::Null } else { filled(&definitions[name], definitions, &within) };
    }
    let inner = |schema: &Value| filled(schema, definitions, within);
    if let Some(forms) = schema["anyOf"].as_array().or(schema["oneOf"].as_array()) {
        let form = forms.iter().rev().find(|form| form["type"] != "null").expect("a form");
        return inner(form);
    }
    if let Some(one) = schema.get("const").or(schema["enum"].get(0)) {
        return one.clone();
    }
    let kind = &schema["type"];
    match kind.as_str().or(kind[0].as_str()) {
        Some("object") => {
            let properties = schema["properties"].as_object().into_iter().flatten();
            let mut all: Map<String, Value> =
                properties.map(|(key, one)| (key.clone(), inner(one))).collect();
            if schema["additionalProperties"].is_object() {
                let value = inner(&schema["additionalProperties"]);
                all.extend(KEYS.split(' ').map(|key| (key.to_string(), value.clone())));
            }
            all.retain(|_, value| !value.is_null());
            all.into()
        }
        Some("array") => {
            let item = inner(&schema["items"]);
            let count = schema["minItems"].as_u64().unwrap_or(1);
            (0..count).map(|_| item.clone()).filter(|item| !item.is_null()).collect()
        }
        Some("boolean") => json!(true),
        Some("integer") => json!(0),
        Some("number") => json!(0.5),
        _ => json!("words"),
    }
}

#[test]
fn every_column_is_filled() {
    let schema = common::schema::document();
    let mut document = filled(&schema, &schema["$defs"], &[]);
    // Names of columns and of axes are data as well.
    document["recordings"][0]["columns"] =
        json!({"time_s": [0.0], "field_x_nt": [1.0], "field_std_x_nt": [0.1]});
    document["calibration"]["scalar"]["stability"] = Value::Null;
    let document: Document = serde_json::from_value(document).expect("a document");
    let page = report::run(&document, &Options::default()).expect("a page");
    let page = report::html::render(&page).expect("HTML");
    let rows = include_str!("../../src/sections.jinja").split(" row({").skip(1);
    for row in rows.filter_map(|row| row.split("}) %}").next()) {
        let parts: Vec<&str> = row.split('"').collect();
        let headers = parts.windows(2).filter(|pair| pair[1].starts_with(": ")).map(|pair| pair[0]);
        for header in headers.filter(|header| !["value", "std"].contains(header)) {
            let (name, unit) = header.trim_end_matches(']').split_once(" [").unwrap_or((header, ""));
            let (name, unit) = (name.replace('\'', "&#39;"), format!(" <span class=\"unit\">{unit}</span>"));
            let unit = unit.replace(" <span class=\"unit\"></span>", "");
            assert!(page.contains(&format!("<th scope=\"col\">{name}{unit}</th>")), "{header}");
        }
    }
}

/// Each result of a certificate, of sensors or of a coil system alone, is there with its unit.
#[test]
fn every_result_is_there() {
    let schema = common::schema::document();
    let mut sensors = filled(&schema, &schema["$defs"], &[]);
    // Covariances are held against the parameters that they name.
    let calibration = &mut sensors["calibration"];
    calibration["uncertainty"] = Value::Null;
    ["sensors", "coils"].iter().for_each(|of| calibration["axes"][*of]["covariance"] = Value::Null);
    let mut coils = sensors.clone();
    let calibration = coils["calibration"].as_object_mut().expect("an object");
    calibration.retain(|key, _| key == "coils");
    let pages = [sensors, coils].map(|document| {
        let document: Document = serde_json::from_value(document).expect("a document");
        let sheet = report::certificate::run(&document, &report::certificate::Asked::default())
            .expect("a certificate");
        report::certificate::render(&sheet, None).expect("HTML")
    });
    let template = include_str!("../../src/certificate/certificate.jinja");
    for call in template.split(" result(").skip(1).filter_map(|rest| rest.split(" %}").next()) {
        for word in call.split('"').skip(1).step_by(2).filter(|word| !["value", "std"].contains(word)) {
            assert!(pages.iter().any(|page| page.contains(word)), "{word} of {call}");
        }
    }
}
