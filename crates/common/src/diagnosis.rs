use indexmap::IndexMap;
use serde::{Deserialize, Serialize};

use crate::residual::{EnergyShare, Remaining, Residual, ResidualSeries};
use crate::{Axis, Extra, Quantity};

/// One answer of diagnose: what the model left out.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct Diagnosis {
    /// What it comes to.
    pub verdict: Verdict,
    /// The same in one sentence, with its size and what it does to the residuals.
    #[serde(default, skip_serializing_if = "String::is_empty")]
    pub answer: String,
    /// The figures that led there, in words.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub reasons: Vec<String>,
    /// Ids of the recordings in which something shows.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub recordings: Vec<String>,
    /// Where it shows.
    #[serde(default, rename = "where", skip_serializing_if = "Vec::is_empty")]
    pub places: Vec<Share>,
    /// The effects that explain it, by how much they lower the rms of readings left out: the largest first.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub effects: Vec<ExplainedEffect>,
    /// The kinds of physics that explain it, whatever their form, the one that explains most first.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub families: Vec<ExplainedFamily>,
    /// Sets of effects that do equally well, `no effect` where none may be needed; empty where there is one answer.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub ambiguity: Vec<Vec<String>>,
    /// Structure that no effect names.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub unnamed: Vec<UnnamedStructure>,
    /// Of that what was adopted as the effect `empirical` because `--empirical` asks for it.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub empirical: Vec<AdoptedStructure>,
    /// How well the recordings are met.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub fit: Option<Residual>,
    /// In which recordings, sensors, times, bands and regions of the covariates the difference lies.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub energy: Vec<EnergyShare>,
    /// Residuals before and after against time and covariates, for the sensors and recordings that show
    /// something.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub series: Vec<ResidualSeries>,
    /// How far the calibration's parameters moved.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub base_shift: Vec<BaseShift>,
    /// Constants that moved farther than their stated uncertainty allows: the calibration as stated no longer
    /// holds.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub calibration_moved: Vec<MovedConstant>,
    /// What these recordings could have shown.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub detectable: Vec<Detectable>,
    /// What is left.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub remaining: Option<Remaining>,
    /// The recording that would decide, in words.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub next_experiment: Option<String>,
    /// Recordings that would decide between names, the best first.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub experiments: Vec<Experiment>,
    /// Keys that this version does not know.
    #[serde(flatten)]
    pub extra: Extra,
}

/// What a diagnosis comes to.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "snake_case")]
pub enum Verdict {
    /// The recordings are met to the noise.
    #[default]
    Agrees,
    /// Named effects, or constants that moved, explain the difference, and nothing else is left.
    Explained,
    /// Named effects explain a part of it.
    PartlyExplained,
    /// Several effects explain it equally well.
    Ambiguous,
    /// There is structure that no effect explains.
    Unexplained,
}

impl Verdict {
    /// The word that documents use.
    pub fn word(self) -> &'static str {
        match self {
            Verdict::Agrees => "agrees",
            Verdict::Explained => "explained",
            Verdict::PartlyExplained => "partly_explained",
            Verdict::Ambiguous => "ambiguous",
            Verdict::Unexplained => "unexplained",
        }
    }
}

/// A part of the difference and where it lies.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(default)]
pub struct Share {
    /// `sensor`, `electronics`, `logger`, `facility`, `environment`, `spacecraft`, `sites`; absent where it
    /// is not known.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub place: Option<String>,
    /// The sensors that show it.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub sensors: Vec<Axis>,
    /// `SEN` where it turns with the sensor block, `GEO` where it does not.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub frame: Option<String>,
    /// What it follows.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub covariates: Vec<String>,
    /// Share of the explainable energy of the difference, 0 to 1: by how much it lowers the weighted sum of
    /// squares, over the sum's excess above the noise before.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub energy_share: Option<f64>,
    /// The recordings in which it shows.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub recordings: Vec<String>,
    /// The span of `time_s` that it lies in.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub time_s: Option<[f64; 2]>,
    /// The band of frequencies that it lies in.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub band_hz: Option<[f64; 2]>,
    /// Single readings.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub readings: Vec<DoubtfulValue>,
    /// The same in words.
    #[serde(skip_serializing_if = "String::is_empty")]
    pub description: String,
    /// Keys that this version does not know.
    #[serde(flatten)]
    pub extra: Extra,
}

/// One reading that is not as its neighbours.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(default)]
pub struct DoubtfulValue {
    /// The recording.
    pub recording: String,
    /// Name of the column.
    pub column: String,
    /// The row, from 0.
    pub row: usize,
    /// How far it is from where the others have it, nT.
    pub departure_nt: Quantity,
}

/// An effect that explains a difference.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(default)]
pub struct ExplainedEffect {
    /// The catalogue's name, or `dependence` on a column that no effect knows.
    pub effect: String,
    /// The kind of physics: see [`ExplainedFamily`].
    #[serde(skip_serializing_if = "String::is_empty")]
    pub family: String,
    /// The sensor that it acts on, for an effect of one sensor.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub sensor: Option<Axis>,
    /// The coil that it acts on, for an effect of one coil.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub coil: Option<Axis>,
    /// The column that it follows, for an effect that does.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub column: Option<String>,
    /// The recording in which it acts; absent: all.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub recording: Option<String>,
    /// In the field's words.
    pub title: String,
    /// One sentence of physics.
    pub physics: String,
    /// The equation of its contribution.
    pub equation: String,
    /// Where that is written.
    pub source: String,
    /// Its parameters; the unit stands in the key. None of a list, whose parts have their own.
    pub parameters: IndexMap<String, Quantity>,
    /// The parts of a list: readings off by themselves, one by one.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub list: Vec<ListedEffect>,
    /// Probability of such a gain by chance, with all that was searched.
    pub p_adjusted: f64,
    /// Probability of the name, of all sets of effects and of structure without a name that were weighed.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub probability: Option<f64>,
    /// Share that it explains of what any effects and structure can explain.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub share: Option<f64>,
    /// Share of its energy by which it departs from its equation: what its form leaves.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub departure: Option<f64>,
    /// By how much it lowers the rms of readings that were left out of the fit, nT.
    pub held_out_gain_nt: f64,
    /// The same for each part left out.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub held_out_by_block_nt: Vec<f64>,
    /// Share of its energy that the calibration had not swallowed.
    pub visible_fraction: f64,
    /// Effects that were rejected, and why.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub rivals: Vec<Rival>,
    /// Keys that this version does not know.
    #[serde(flatten)]
    pub extra: Extra,
}

impl ExplainedEffect {
    /// Its name with what it acts on or follows.
    pub fn label(&self) -> String {
        let sensor = self.sensor.map(|axis| format!("sensor {axis}"));
        let coil = self.coil.map(|axis| format!("coil {axis}"));
        let targets = [sensor, coil, self.column.clone()].into_iter().flatten();
        std::iter::once(self.effect.replace('_', " ")).chain(targets).collect::<Vec<_>>().join(", ")
    }
}

/// A kind of physics that explains a difference, whatever its form.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(default)]
pub struct ExplainedFamily {
    /// `late_response`, `follows_column`, `own_field`, `outside_field`, `position`, `lines`, `time`, `moments`
    /// or `codes`.
    pub family: String,
    /// The same in words.
    pub title: String,
    /// The sensors in which it shows; empty for what acts on all.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub sensors: Vec<Axis>,
    /// Probability that something of this kind acts, of all sets of effects and structure that were weighed.
    pub probability: f64,
    /// Share that it explains of what any effects and structure can explain.
    pub share: f64,
    /// Effects of this kind, each with the probability that it is one of those that act.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub members: Vec<FamilyMember>,
    /// Probability that it acts in a form that none of them has.
    pub no_member: f64,
    /// The recording that tells its members apart.
    pub told_apart_by: String,
}

/// An effect of a kind of physics.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(default)]
pub struct FamilyMember {
    /// Its name with its target.
    pub effect: String,
    /// Probability that it is one of those that act.
    pub probability: f64,
}

/// A recording that would decide between names.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(default)]
pub struct Experiment {
    /// The names.
    pub between: Vec<String>,
    /// What is done, in words.
    pub what: String,
    /// Expected log odds between the two of the names that it parts least.
    pub log_odds: f64,
    /// The plan of the best one, for `simulate campaign`.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub plan: Option<serde_json::Value>,
}

/// Structure that no effect names: what it follows, and how.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(default)]
pub struct UnnamedStructure {
    /// The sensor.
    pub sensor: Option<Axis>,
    /// What it follows.
    pub follows: String,
    /// Whether it is `even` or `odd` in the field that it follows; absent where neither, or where that has no
    /// meaning.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub parity: Option<String>,
    /// How far back, where it follows the past of something, s.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub lag_s: Option<f64>,
    /// The value at which it changes, where it has one level below and one above.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub threshold: Option<f64>,
    /// Share that it explains of what any effects and structure can explain.
    pub share: f64,
    /// What `x` is: the covariate, or `time_s` where it follows something that is no column.
    pub along: String,
    /// Means of readings of about equal number, in the order of `along`.
    pub x: Vec<f64>,
    /// What the structure makes of them, nT.
    pub contribution_nt: Vec<f64>,
}

/// Structure without a name that was adopted: what it follows, and what that does to readings left out of the fit.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(default)]
pub struct AdoptedStructure {
    /// The column of `empirical`.
    pub column: String,
    /// Its lag, where it follows the past of that, s.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub lag_s: Option<f64>,
    /// Rms of readings that were left out, without it, nT.
    pub held_out_before_nt: f64,
    /// The same with it.
    pub held_out_after_nt: f64,
}

/// One of a list of like effects.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(default)]
pub struct ListedEffect {
    /// The recording in which it is; absent: all.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub recording: Option<String>,
    /// Its parameters; the unit stands in the key.
    pub parameters: IndexMap<String, Quantity>,
}

/// An effect that was considered and lost.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(default)]
pub struct Rival {
    /// Its name.
    pub effect: String,
    /// Why it lost, in words.
    pub why_not: String,
}

/// How far a parameter of the calibration moved when the effects came in.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(default)]
pub struct BaseShift {
    /// The parameter; the unit stands in its name.
    pub parameter: String,
    /// From the calibration as it came, with the standard uncertainty of the new value.
    pub shift: Quantity,
}

/// A constant that is not where the calibration states it.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(default)]
pub struct MovedConstant {
    /// The constant; the unit stands in its name.
    pub parameter: String,
    /// From the calibration as it came, where the other constants are known as they are stated.
    pub shift: Quantity,
    /// Standard uncertainty that the calibration states.
    pub stated_std: f64,
    /// Probability that the calibration holds and seems not to by chance, all its constants counted.
    pub p_adjusted: f64,
    /// Constants that could have moved in its place.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub alternatives: Vec<String>,
    /// The one cause that moves it together with others of this list.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub cause: Option<String>,
}

/// The smallest effect that would have been seen.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(default)]
pub struct Detectable {
    /// Its name.
    pub effect: String,
    /// The sensor, coil or column.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub target: Option<String>,
    /// Smallest size of each amplitude by itself that is claimed nine times in ten; absent where these
    /// recordings cannot show it.
    #[serde(skip_serializing_if = "IndexMap::is_empty")]
    pub smallest: IndexMap<String, f64>,
    /// Share of its energy that the calibration does not swallow.
    pub visible_fraction: f64,
}
