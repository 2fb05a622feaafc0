//! Effects that the document's model states already, taken off the readings of a pair.

use common::{Axis, Document};
use physics::{References, Setting};

use crate::Error;

/// The document with the test instrument's readings less what the effects of its model do to them, as the catalogue
/// predicts it from the reference's readings in the same recording; what cannot act there stays as it is.
pub fn less_effects(document: &Document) -> Result<Document, Error> {
    let effects = physics::adopt(document).map_err(|error| error.at("model"))?;
    let mut less = document.clone();
    if effects.is_empty() {
        return Ok(less);
    }
    let references = References::of(document);
    for (index, recording) in document.recordings.iter().enumerate() {
        let at = |error: physics::Error| error.at(&format!("recordings[{index}]"));
        let Setting { basic, context } = Setting::of(document, recording, references).map_err(at)?;
        if context.reference_nt.is_none() {
            continue;
        }
        let own: Vec<_> = effects.iter().filter(|effect| effect.acts(recording)).cloned().collect();
        let with = physics::predict_acting(&basic, &own, &context).map_err(at)?.0.readings;
        let without = physics::predict(&basic, &[], &context).map_err(at)?.readings;
        for axis in Axis::ALL {
            let Some(column) = less.recordings[index].columns.get_mut(&format!("test_{axis}_nt")) else {
                continue;
            };
            for (value, (with, without)) in column.iter_mut().zip(with.iter().zip(&without)) {
                *value -= with[axis.index()] - without[axis.index()];
            }
        }
    }
    Ok(less)
}
