//! Physics adopted beyond the basic model.

use common::{AdoptedEffect, Document};
use page::words::key;
use serde_json::Value;

use crate::{Cell, Section, Table};

/// The section; None where the document has nothing of it.
pub fn section(document: &Document) -> Option<Section> {
    let effects = &document.model.as_ref()?.effects;
    let mut section = Section::new("model", "Model beyond the line");
    section.words.push("`simulate` and `correct` apply these effects.".into());
    let mut table = Table::new(
        "Effects",
        [("effect", ""), ("acts on", ""), ("found by", ""), ("parameter", ""), ("value", ""), ("unit", "")],
    );
    for effect in effects {
        let found_by = effect.extra.get("found_by").and_then(Value::as_str);
        let head =
            || -> [Cell; 3] { [effect.effect.replace('_', " ").into(), on(effect).into(), found_by.into()] };
        for (name, value) in &effect.parameters {
            let (name, unit) = key(name);
            let [effect, on, found_by] = head();
            table.row([effect, on, found_by, name.into(), value.into(), unit.into()]);
        }
        if effect.parameters.is_empty() {
            let [effect, on, found_by] = head();
            table.row([effect, on, found_by, Cell::Empty, Cell::Empty, Cell::Empty]);
        }
    }
    section.table(table);
    (!section.items.is_empty()).then_some(section)
}

fn on(effect: &AdoptedEffect) -> String {
    let targets = [
        effect.sensor.map(|axis| format!("sensor {axis}")),
        effect.coil.map(|axis| format!("coil {axis}")),
        effect.column.clone(),
        effect.recording.as_ref().map(|id| format!("in {id}")),
    ];
    let targets: Vec<String> = targets.into_iter().flatten().collect();
    if targets.is_empty() { "all".into() } else { targets.join(", ") }
}
