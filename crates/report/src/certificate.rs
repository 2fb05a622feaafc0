//! The document against a specification.

use common::Document;

use crate::{Error, Section};

/// A specification.
#[derive(Clone, Debug, Default)]
pub struct Spec {}

impl Spec {
    /// Reads a specification.
    ///
    /// # Errors
    ///
    /// Where the text is no specification.
    pub fn parse(_text: &str) -> Result<Self, common::Error> {
        Ok(Self {})
    }
}

/// Each requirement with its verdict.
///
/// # Errors
///
/// Where the document contradicts itself.
pub fn section(_document: &Document, _spec: &Spec) -> Result<Section, Error> {
    Ok(Section::new("certificate", "Certificate"))
}
