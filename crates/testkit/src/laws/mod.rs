//! Laws that hold whatever was recorded: changes of a document after which every answer is known.
//!
//! A change is one function from a document to a document, as JSON: it changes what was recorded and what was
//! answered alike. So one definition serves every stage, and most laws are one sentence ([`commutes`]): what
//! a stage answers to the changed document is what it answered to the document, changed. The documents are
//! drawn campaigns ([`plan`]), many more of them with FLUXCAL_CAMPAIGNS.

mod canonical;
mod close;
mod draw;
mod geo;
mod noise;
mod order;
mod reference;
mod rename;
mod unknown;
mod volts;
mod walk;

pub use close::Close;
pub use draw::{Draw, plan, warm};
pub use geo::{rotate_geo, rotation};
pub use noise::{double_noise, doubled, quiet};
pub use order::{reorder, split};
pub use reference::move_reference;
pub use rename::rename_axes;
pub use unknown::unknown_keys;
pub use volts::scale_volts;

use common::Document;
use serde_json::Value;
use std::fmt::Debug;

/// A stage's library as it is asked here: JSON in, JSON out.
pub fn stage<E: Debug>(run: impl Fn(Document) -> Result<Document, E>) -> impl Fn(&Value) -> Value {
    move |document| {
        let document = Document::parse(&document.to_string()).expect("a document");
        json(&run(document).expect("an answer"))
    }
}

/// A document as JSON.
pub fn json(document: &Document) -> Value {
    serde_json::from_str(&document.clone().to_line().expect("finite numbers")).expect("JSON")
}

/// The stage answers the changed document as it answered the document, changed.
pub fn commutes(
    law: &str,
    document: &Value,
    change: impl Fn(&Value) -> Value,
    stage: impl Fn(&Value) -> Value,
    close: &Close,
) {
    let expected = change(&stage(document));
    let found = stage(&change(document));
    close.check(law, &found, &expected);
}

/// The stage answers the changed document as it answered the document.
pub fn invariant(
    law: &str,
    document: &Value,
    change: impl Fn(&Value) -> Value,
    stage: impl Fn(&Value) -> Value,
    close: &Close,
) {
    close.check(law, &stage(&change(document)), &stage(document));
}

/// Keys that no version knows change nothing else, and stay where they were.
pub fn keeps_unknown_keys(document: &Value, stage: impl Fn(&Value) -> Value) {
    let plain = stage(document);
    let asked = unknown_keys(document);
    let found = stage(&asked);
    assert!(unknown::without_unknown_keys(&found) == plain, "unknown keys change an answer");
    let lost = unknown::lost(&asked, &found, &plain);
    assert!(lost.is_empty(), "unknown keys are lost at {}", lost.join(", "));
}
