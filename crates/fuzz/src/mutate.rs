//! Changes to files: mostly small, sometimes several at once.

pub mod bytes;
pub mod change;
pub mod columns;
pub mod json;
pub mod pointers;
pub mod recordings;
pub mod text;
pub mod values;

use crate::corpus::{Corpus, Seed};
use crate::draw::Draw;
use crate::kind::FileKind;

/// A changed copy of a file, and what was changed.
pub fn changed(seed: &Seed, corpus: &Corpus, draw: &mut Draw) -> (Vec<u8>, Vec<&'static str>) {
    let edits = *draw.weighted(&[(4, 0), (58, 1), (20, 2), (10, 3), (8, 6)]);
    let mut done = Vec::new();
    let mut bytes = match (&seed.value, draw.chance(92)) {
        (Some(value), true) => {
            let mut value = value.clone();
            for _ in 0..edits {
                done.extend(json::edit(&mut value, seed.kind, corpus, draw));
            }
            return (common::to_text(&value).into_bytes(), done);
        }
        _ => seed.bytes.clone(),
    };
    for _ in 0..edits {
        done.push(match seed.kind {
            FileKind::Parquet | FileKind::Cdf => bytes::edit(&mut bytes, draw),
            _ if draw.chance(12) => bytes::edit(&mut bytes, draw),
            kind => text::edit(&mut bytes, kind, draw),
        });
    }
    (bytes, done)
}
