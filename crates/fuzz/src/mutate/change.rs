//! What a change to a JSON value is.

use serde_json::Value;

use crate::corpus::Corpus;
use crate::draw::Draw;
use crate::kind::FileKind;

/// A change: whether it could be made here.
pub type Change = fn(&mut Value, &Context<'_>, &mut Draw) -> bool;

/// What a change may take from elsewhere.
pub struct Context<'a> {
    /// All files.
    pub corpus: &'a Corpus,
    /// What is changed.
    pub kind: FileKind,
}
