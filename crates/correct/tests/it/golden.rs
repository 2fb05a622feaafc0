//! Golden documents, a line a case. BLESS=1 writes them anew; read the difference before it is kept.
//! `truth.rs` holds the same flight against the script that made it.

use common::{Document, to_text};
use correct::Frame;

#[test]
fn golden() {
    for (case, frame) in [("correct/flight", Frame::Sen), ("correct/flight-geo", Frame::Geo)] {
        testkit::golden(case, "correct/flight/input.json", |text| {
            let document = Document::parse(text).expect("a document");
            to_text(&correct::run(document, frame).expect("corrected"))
        });
    }
}
