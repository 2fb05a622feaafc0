//! Plain regressions beside an answer: what they predict of readings that were left out, and whether they do it
//! better.

use serde::{Deserialize, Serialize};

use crate::number::significant;

/// A regression that a careful person would try.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(default)]
pub struct PlainRegression {
    /// How its terms are chosen.
    pub name: String,
    /// Rms of readings that were left out, nT.
    pub held_out_nt: f64,
    /// Its terms.
    pub terms: Vec<String>,
}

impl PlainRegression {
    /// Readings of which more than this is left, over what noise or the best plain regression leaves, have something in
    /// them.
    pub const WORSE: f64 = 1.05;

    /// The one that predicts best, where it does so better than an answer of which readings that were left out have
    /// this rms, nT.
    pub fn better(all: &[Self], named_nt: f64) -> Option<&Self> {
        let best = all.iter().min_by(|a, b| a.held_out_nt.total_cmp(&b.held_out_nt))?;
        (named_nt > Self::WORSE * best.held_out_nt).then_some(best)
    }

    /// That it predicts better, in a sentence.
    pub fn predicts_better(&self, named_nt: f64) -> String {
        format!(
            "{} ({}) predicts held-out readings better: {} nT, not {}",
            self.name,
            self.in_words(),
            significant(self.held_out_nt, 3),
            significant(named_nt, 3)
        )
    }

    /// Its terms in words.
    pub fn in_words(&self) -> String {
        if self.terms.is_empty() { "no term".into() } else { self.terms.join(", ") }
    }
}

/// How well readings that were left out are predicted.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(default)]
pub struct HeldOutPrediction {
    /// Rms by the answer, nT.
    pub named_nt: f64,
    /// What plain regressions on the same columns predict of the same readings.
    pub plain: Vec<PlainRegression>,
}
