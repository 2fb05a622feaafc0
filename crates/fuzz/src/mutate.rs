//! Changes to files: mostly small, sometimes several at once.

pub mod json;
pub mod pointers;
mod recordings;
mod text;
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
            FileKind::Parquet | FileKind::Cdf => text::edit_bytes(&mut bytes, draw),
            _ if draw.chance(12) => text::edit_bytes(&mut bytes, draw),
            kind => text::edit(&mut bytes, kind, draw),
        });
    }
    (bytes, done)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn any_content_will_do() {
        let mut draw = Draw::new(1, 1);
        for text in ["", "\n", "a,b\n1,2\n", "{\"a\": -1.5e3}\n", &"7".repeat(4000)] {
            for _ in 0..200 {
                text::edit_bytes(&mut text.as_bytes().to_vec(), &mut draw);
                for kind in [FileKind::Csv, FileKind::Iaga, FileKind::Ndjson, FileKind::Document] {
                    text::edit(&mut text.as_bytes().to_vec(), kind, &mut draw);
                }
            }
        }
    }
}
