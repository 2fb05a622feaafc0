//! The sets by name.

use sha2::{Digest, Sha256};

use crate::case::Labels;
use crate::scenes::Length;

/// What is concealed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub enum Set {
    /// Nothing.
    Clean,
    /// Nothing, in noise that did not begin with the recordings, as documents would have it, but long before.
    Old,
    /// One effect, at three strengths.
    Single,
    /// Two effects at once.
    Pairs,
    /// Three effects at once.
    Triples,
    /// One effect that the recordings cannot tell from another.
    Ambiguous,
    /// Physics that the catalogue does not have.
    Outside,
    /// One effect in thousands of rows, at five strengths, its form not quite that of a formula.
    LongSingle,
    /// Two or three of those at once.
    LongSeveral,
    /// Physics that the catalogue does not have, in thousands of rows.
    LongOutside,
    /// Nothing, in thousands of rows.
    LongClean,
    /// One effect of the group `develop`, in recordings as instruments write them.
    Develop,
    /// Two to four of those at once.
    DevelopSeveral,
    /// Physics of that group that the catalogue does not have.
    DevelopOutside,
    /// One effect of the group `choose`.
    Choose,
    /// Two to four of those at once.
    ChooseSeveral,
    /// Physics of that group that the catalogue does not have.
    ChooseOutside,
    /// One effect of the group `score`.
    Score,
    /// Two to four of those at once.
    ScoreSeveral,
    /// Physics of that group that the catalogue does not have.
    ScoreOutside,
    /// Nothing, in recordings as instruments write them.
    RecordedClean,
    /// One effect whose name is taken out of the finder's catalogue, for every name in turn.
    Removed,
}

impl Set {
    /// Those of the proof.
    pub const ALL: [Set; 7] =
        [Set::Clean, Set::Old, Set::Single, Set::Pairs, Set::Triples, Set::Ambiguous, Set::Outside];

    /// Those of long recordings.
    pub const LONG: [Set; 4] = [Set::LongSingle, Set::LongSeveral, Set::LongOutside, Set::LongClean];

    /// Those of the group `develop`.
    pub const DEVELOP: [Set; 3] = [Set::Develop, Set::DevelopSeveral, Set::DevelopOutside];

    /// Those of the group `choose`.
    pub const CHOOSE: [Set; 3] = [Set::Choose, Set::ChooseSeveral, Set::ChooseOutside];

    /// Those of a release: physics that nobody has looked at, and a catalogue with holes.
    pub const SCORE: [Set; 5] =
        [Set::Score, Set::ScoreSeveral, Set::ScoreOutside, Set::RecordedClean, Set::Removed];

    /// Its name.
    pub fn word(self) -> &'static str {
        match self {
            Set::Clean => "clean",
            Set::Old => "old",
            Set::Single => "single",
            Set::Pairs => "pairs",
            Set::Triples => "triples",
            Set::Ambiguous => "ambiguous",
            Set::Outside => "outside",
            Set::LongSingle => "long-single",
            Set::LongSeveral => "long-several",
            Set::LongOutside => "long-outside",
            Set::LongClean => "long-clean",
            Set::Develop => "develop",
            Set::DevelopSeveral => "develop-several",
            Set::DevelopOutside => "develop-outside",
            Set::Choose => "choose",
            Set::ChooseSeveral => "choose-several",
            Set::ChooseOutside => "choose-outside",
            Set::Score => "score",
            Set::ScoreSeveral => "score-several",
            Set::ScoreOutside => "score-outside",
            Set::RecordedClean => "recorded-clean",
            Set::Removed => "removed",
        }
    }

    pub(super) fn labels(self, seed: u64, number: usize, strength: f64, length: Length) -> Labels {
        Labels {
            // Documents and files bear this name, which says nothing of what is in them.
            case: neutral(&format!("{}/{seed}/{number}", self.word())),
            set: self.word().into(),
            seed,
            number,
            strength,
            length,
        }
    }
}

/// A name that says nothing.
pub fn neutral(of: &str) -> String {
    Sha256::digest(of.as_bytes()).iter().take(5).map(|byte| format!("{byte:02x}")).collect()
}
