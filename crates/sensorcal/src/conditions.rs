//! What temperatures do to a sensor, as it was found, for the other procedures.

use common::covariance::between;
use common::uncertainty::{Block, by_themselves};
use common::{Axis, Code, Finding};
use faer::Mat;
use physics::{Basic, Context, EffectInstance, Parameter, SensorConstants};

use crate::Result;
use crate::fit::KnownParameters;
use crate::readings::Run;

/// Effects of temperature on one sensor with the covariance of their parameters.
#[derive(Clone)]
pub struct Conditions {
    pub effects: Vec<EffectInstance>,
    /// Covariance over their parameters, one effect after the other.
    pub covariance: Mat<f64>,
    pub paths: Vec<String>,
    /// How they were estimated; None: they are stated.
    pub block: Option<Block>,
}

impl Conditions {
    pub fn none() -> Self {
        Self { effects: Vec::new(), covariance: Mat::new(), paths: Vec::new(), block: None }
    }

    /// Whether all that the effects need was recorded.
    fn known_in(&self, context: &Context<'_>) -> bool {
        let needs = self.effects.iter().flat_map(|effect| effect.kind.about().needs);
        needs.into_iter().all(|name| match *name {
            "time_s" => context.recording.column("time_s").is_some(),
            name => context.optional(name).is_some(),
        })
    }

    fn parameters(&self) -> Vec<Parameter> {
        let of = |(at, effect): (usize, &EffectInstance)| {
            (0..effect.parameters.len()).map(move |number| Parameter::Effect(at, number))
        };
        self.effects.iter().enumerate().flat_map(of).collect()
    }

    /// The effects for a fit, and what is uncertain about them; none where a temperature is absent.
    pub fn effects_in(&self, runs: &[Run<'_>]) -> (Vec<EffectInstance>, Option<KnownParameters>) {
        if self.effects.is_empty() || !runs.iter().all(|run| self.known_in(&run.context)) {
            return (Vec::new(), None);
        }
        let known = KnownParameters {
            parameters: self.parameters(),
            covariance: self.covariance.clone(),
            rests_on: by_themselves(&self.paths),
        };
        (self.effects.clone(), Some(known))
    }

    /// What to say where temperatures matter and were not recorded.
    pub fn not_recorded(&self, runs: &[Run<'_>]) -> Option<Finding> {
        let without = runs.iter().filter(|run| !self.known_in(&run.context));
        let lacking: Vec<&str> = without.map(|run| run.context.recording.id.as_str()).collect();
        if self.effects.is_empty() || lacking.is_empty() {
            return None;
        }
        Some(Code::TemperatureNotRecorded.said(format!(
            "no temperatures were recorded in {}; k and O apply at the unknown temperatures there",
            lacking.join(", ")
        )))
    }

    /// What they add to the field that is read without a field, nT by row, with the derivative by each
    /// parameter; None where a temperature is not recorded.
    pub fn contribution(
        &self,
        context: &Context<'_>,
        sensor: Axis,
        path: &str,
    ) -> Result<Option<Contribution>> {
        if self.effects.is_empty() || !self.known_in(context) {
            return Ok(None);
        }
        let mut still = context.clone();
        still.ambient_nt = vec![nalgebra::Vector3::zeros()];
        let mut basic = Basic::of(&common::Document::default(), still.unit);
        basic.sensors = [SensorConstants { sensitivity: 1.0, offset_nt: 0.0 }; 3];
        let (prediction, derivatives) =
            physics::predict_with_jacobian(&basic, &self.effects, &still, &self.parameters())
                .map_err(|error| error.at(path))?;
        let of =
            |series: &[nalgebra::Vector3<f64>]| series.iter().map(|v| v[sensor.index()]).collect::<Vec<_>>();
        Ok(Some(Contribution {
            field_nt: of(&prediction.readings),
            derivatives: derivatives.iter().map(|derivative| of(&derivative.readings)).collect(),
        }))
    }

    /// Variance of a sum of the parameters with the weights `by`.
    pub fn variance(&self, by: &[f64]) -> f64 {
        between(&self.covariance, by, by)
    }
}

pub struct Contribution {
    /// By row, nT.
    pub field_nt: Vec<f64>,
    /// The derivative by each parameter, by row.
    pub derivatives: Vec<Vec<f64>>,
}
