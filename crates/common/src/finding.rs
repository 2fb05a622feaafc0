//! What looks wrong in a result: sentences for people, each with a code for programs.

use std::fmt;
use std::ops::Deref;

use serde::de::IntoDeserializer;
use serde::de::value::Error as Unknown;
use serde::{Deserialize, Serialize};

/// Codes, by what a finding of each does to the result where no number of the document says it.
macro_rules! codes {
    ($($effect:literal: $($code:ident),+;)+) => {
        /// By what programs know a finding; in documents in snake_case.
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
        #[serde(rename_all = "snake_case")]
        pub enum Code {
            $($(#[doc = $effect] $code,)+)+
        }

        impl Code {
            /// What such a finding does to the result, where no number of the document says it.
            pub fn effect(self) -> &'static str {
                match self {
                    $($(Self::$code)|+ => $effect,)+
                }
            }
        }
    };
}

codes! {
    "uncertainties only":
        ResidualsNotNormal, SeriallyCorrelated, ExcessScatter, NoiseOverstated, NoiseNotDeclared, SpectralForm,
        ExponentAtLimit, FlickerNotDetected, QuantisationNoise, UnevenTimes, RandomWalkPossible, RepeatedReadings,
        NoisesNotIndependent, ThirdInstrument;
    "not determined by the readings":
        NotDetermined, OneDirectionOnly, TemperatureNotRecorded, TemperaturesInseparable, TooFewDates,
        TooFewDegreesOfFreedom, WeakCoil, MagnitudeUnknown, IncludesBody;
    "the readings do not decide":
        Ambiguous;
    "left out of the result":
        Saturated, EffectNotApplied, MagnitudeUnknownInSome, MissingSamples;
    "not significant":
        TrendNotSignificant, CrossFieldNotSignificant, EventsNotConfirmed;
    "not in the document":
        Nonlinear, LackOfFit, HigherOrderTerm, Outliers, OffsetsDisagree, RecordingsDiffer, ReversalsDiffer,
        Trend, AnnualTerm, FollowsTemperature, AtReferenceTemperatures, Departure, CrossField,
        SquaredCrossField, PriorContradicted, OrientationContradicted, KnownCoilsContradicted, Swapped,
        SensorReversed, CoilReversed, ModelSubtracted, PhaseLag, NoOrientation, NominalSensitivity,
        ReferenceOffset, NotConstant, OffsetsWander, MagnitudeAssumed, CalibrationAssumed, LevelOnly, UnequalSensitivities,
        NotOrthogonal, LeftHanded, Rotated, AttitudeInverted, ShortWindows, CorrelationNotEstimated, Joined,
        TimesInterpolated, Filtered, Contribution, ClockOffset, ResidualIncreased, RegressionPredictsBetter,
        DriftOrNoise, TimesJump, BaselineSteps, ClockNotConstant, AveragedReadings, DelayDependsOnPeriod, TimesShifted,
        EventsUnassigned, TooManyEvents, SteadyChange, DiffersWhenDisturbed, DependsOnPeriod,
        BiasedByReference, PossiblyBiasedByReference, FieldTooQuiet, NoiseOfReference, ResponsesDiffer;
}

impl Code {
    /// A finding of this code.
    pub fn said(self, words: impl Into<String>) -> Finding {
        Finding { code: self.to_string(), words: words.into() }
    }

    /// A finding about one axis, recording or column, or of a size that the document holds nowhere else; its
    /// words are to be said.
    pub fn about(self, what: impl fmt::Display) -> Finding {
        Finding { code: format!("{self}:{what}"), words: String::new() }
    }
}

impl fmt::Display for Code {
    fn fmt(&self, to: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.serialize(to)
    }
}

/// A sentence with its code.
#[derive(Clone, Debug, PartialEq)]
pub struct Finding {
    code: String,
    /// The sentence.
    pub words: String,
}

impl Finding {
    /// The same in these words.
    pub fn said(self, words: impl Into<String>) -> Self {
        Self { words: words.into(), ..self }
    }
}

/// What looks wrong in a part of a document. It reads as the list of sentences.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(default)]
pub struct Findings {
    /// What looks wrong, in words.
    #[serde(rename = "findings", skip_serializing_if = "Vec::is_empty")]
    words: Vec<String>,
    /// The code of each finding. Behind a colon may stand what it is about: an axis, a recording, a column, a
    /// departure, an order, or a size in nT or standard uncertainties.
    #[serde(rename = "finding_codes", skip_serializing_if = "Vec::is_empty")]
    codes: Vec<String>,
}

impl Findings {
    /// Adds a finding.
    pub fn push(&mut self, finding: Finding) {
        // Documents of earlier versions have sentences alone.
        self.codes.resize(self.words.len(), String::new());
        self.words.push(finding.words);
        self.codes.push(finding.code);
    }

    /// Puts some before the others.
    pub fn prepend(&mut self, first: Vec<Finding>) {
        let Self { words, codes } = std::mem::take(self);
        self.extend(first);
        self.words.extend(words);
        self.codes.extend(codes);
    }

    /// Each sentence with its code, where this version knows it, and what that is about.
    pub fn coded(&self) -> impl Iterator<Item = (&str, Option<Code>, &str)> {
        self.words.iter().enumerate().map(|(at, words)| {
            let code = self.codes.get(at).map_or("", String::as_str);
            let (name, about) = code.split_once(':').unwrap_or((code, ""));
            let name = IntoDeserializer::<Unknown>::into_deserializer(name);
            (words.as_str(), Code::deserialize(name).ok(), about)
        })
    }
}

impl Extend<Finding> for Findings {
    fn extend<I: IntoIterator<Item = Finding>>(&mut self, findings: I) {
        findings.into_iter().for_each(|finding| self.push(finding));
    }
}

impl Deref for Findings {
    type Target = [String];

    fn deref(&self) -> &[String] {
        &self.words
    }
}
