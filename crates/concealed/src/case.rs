//! A case: a document of the public format, and the truth apart.

use serde::{Deserialize, Serialize};
use serde_json::{Map, Value, json};
use std::collections::BTreeSet;

use crate::base;
use crate::document;
use crate::draw::Draw;
use crate::effect::Effect;
use crate::noise::Noise;
use crate::scene::{AXES, Campaign, Readings};
use crate::scenes::Length;

/// What is true of one effect.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct TrueEffect {
    /// Its name in scores.
    pub name: String,
    /// The finer physics in words.
    pub physics: String,
    /// The catalogue's names that are right; decided here, before anything is diagnosed.
    pub accepted: Vec<String>,
    /// The sensors that show it; empty where it is in the field.
    pub sensors: Vec<String>,
    /// What the catalogue's parameters should come out as.
    pub parameters: Map<String, Value>,
    /// Rms of its form error, relative.
    #[serde(default, skip_serializing_if = "exact")]
    pub form_error: f64,
    /// Rms that is left of it when the basic model is fitted, in the sensor that keeps most of it, nT.
    pub left_nt: f64,
}

fn exact(form_error: &f64) -> bool {
    *form_error == 0.0
}

/// What is sealed.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Truth {
    /// The case.
    pub case: String,
    /// `clean`, `old`, `single`, `pairs`, `triples`, `ambiguous`, `outside`, `swarm`, `pillar`, or one of the
    /// long sets.
    pub set: String,
    /// The seed of the set.
    pub seed: u64,
    /// Its number in the set.
    pub number: usize,
    /// So many times the noise each effect is.
    pub strength: f64,
    /// `short`, `medium`, `long`, `campaign`, `day` or `longest`.
    pub length: String,
    /// `apart` or `together`: how the thermometers go.
    pub covariates: String,
    /// How it was recorded.
    pub scene: String,
    /// Readings in all.
    pub readings: usize,
    /// How the document was written, where it is not as clean as it could be: gaps, noise declared wrongly.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub recorded: Vec<String>,
    /// Rms of the noise that was drawn, with that of the codes, nT.
    pub noise_nt: f64,
    /// What was concealed.
    pub effects: Vec<TrueEffect>,
    /// Effects that are taken out of the finder's catalogue for this case.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub without: Vec<String>,
    /// Random digits: without them a seal of a short truth could be guessed open.
    pub nonce: String,
}

impl Truth {
    /// The same with the names that would be right taken out of the finder's catalogue: right is then no name
    /// at all.
    pub fn take_names(&mut self) {
        let names = self.effects.iter_mut().flat_map(|effect| std::mem::take(&mut effect.accepted));
        let kinds: BTreeSet<String> =
            names.filter_map(|name| name.split(' ').next().map(str::to_string)).collect();
        self.without = kinds.into_iter().collect();
    }
}

/// A document with its truth.
#[derive(Clone, Debug)]
pub struct Case {
    /// The document.
    pub document: Value,
    /// The truth.
    pub truth: Truth,
}

/// How large an effect is and how it is called in scores.
pub struct Concealed {
    /// Name in scores.
    pub name: String,
    /// The effect.
    pub effect: Effect,
    /// Times the noise that is left of it after the basic model is fitted.
    pub strength: f64,
    /// Rms of its form error, relative.
    pub form_error: f64,
}

/// What the recordings are labelled with in the truth.
pub struct Labels {
    /// The case.
    pub case: String,
    /// The set.
    pub set: String,
    /// The seed of the set.
    pub seed: u64,
    /// The number in the set.
    pub number: usize,
    /// The strength of the design.
    pub strength: f64,
    /// The length of the design.
    pub length: Length,
}

/// Ways that noise is made of, total rms about 0.3 nT: white, f^−1, f^−1.5.
pub fn noise_of(draw: &mut Draw, step_s: f64) -> Noise {
    let size = draw.between(0.2, 0.4);
    match draw.below(3) {
        0 => Noise { white_nt: size, flicker_nt2_per_hz: 0.0, exponent: 1.0, old: false },
        1 => flicker(draw),
        _ => Noise {
            white_nt: 0.85 * size,
            flicker_nt2_per_hz: 0.009 * size * size / step_s.sqrt(),
            exponent: 1.5,
            old: false,
        },
    }
}

/// White noise with flicker noise of f^−1: of some hundred readings it has the variance A ln n, about 6 A,
/// whatever the step.
pub fn flicker(draw: &mut Draw) -> Noise {
    let size = draw.between(0.2, 0.4);
    Noise { white_nt: 0.85 * size, flicker_nt2_per_hz: 0.03 * size * size, exponent: 1.0, old: false }
}

/// The size at which so many nT are left of an effect after the basic model is fitted; `left` says how many
/// are left of a size.
pub fn sized(left: impl Fn(f64) -> f64, wanted_nt: f64) -> f64 {
    let mut size = 1.0_f64;
    for _ in 0..12 {
        let now = left(size);
        if now <= 0.0 || (now / wanted_nt - 1.0).abs() < 1e-3 {
            break;
        }
        size *= (wanted_nt / now).clamp(1e-3, 1e3);
    }
    size
}

/// Conceals effects in a campaign, adds the noise, and writes document and truth.
pub fn make(
    campaign: &Campaign,
    noise: Noise,
    concealed: Vec<Concealed>,
    labels: Labels,
    draw: &mut Draw,
) -> Case {
    let long = !Length::ALL.contains(&labels.length);
    let plain = campaign.plain();
    let mut readings = plain.clone();
    let mut drawn: Readings = Vec::new();
    for (run, readings) in campaign.runs.iter().zip(&mut readings) {
        let series = if long { Noise::long_series } else { Noise::series };
        let of_run = [0; 3].map(|_| series(&noise, run.times.len(), run.step_s(), draw));
        readings.iter_mut().zip(&of_run).for_each(|(column, noise)| add(column, noise));
        drawn.push(of_run);
    }
    // The rounding to codes, which the document declares, is noise as well.
    let noise_nt = rms_of_all(&drawn).hypot(campaign.code_nt / 12.0_f64.sqrt());
    let mut effects = Vec::new();
    let mut of_codes = Vec::new();
    for one in concealed {
        let left = |size: f64| base::size_left(campaign, &(one.effect.act)(campaign, &plain, size));
        let size = sized(left, one.strength * noise_nt);
        let added = (one.effect.act)(campaign, &plain, size);
        let parameters = (one.effect.parameters)(size).into_iter();
        effects.push(TrueEffect {
            name: one.name,
            physics: one.effect.physics.into(),
            accepted: one.effect.accepted.clone(),
            sensors: one.effect.sensors.iter().map(|sensor| AXES[*sensor].to_string()).collect(),
            parameters: parameters.map(|(name, value)| (name.to_string(), json!(value))).collect(),
            form_error: one.form_error,
            left_nt: base::size_left(campaign, &added),
        });
        if one.effect.on_codes {
            of_codes.push((one.effect, size));
        } else {
            for (readings, added) in readings.iter_mut().zip(added) {
                readings.iter_mut().zip(&added).for_each(|(column, added)| add(column, added));
            }
        }
    }
    for (effect, size) in of_codes {
        let added = (effect.act)(campaign, &readings, size);
        for (readings, added) in readings.iter_mut().zip(added) {
            readings.iter_mut().zip(&added).for_each(|(column, added)| add(column, added));
        }
    }
    let count = campaign.runs.iter().map(|run| 3 * run.times.len()).sum();
    let document = document::of(campaign, noise, &readings, &labels.case, draw);
    let truth = Truth {
        case: labels.case.clone(),
        set: labels.set,
        seed: labels.seed,
        number: labels.number,
        strength: labels.strength,
        length: labels.length.word().into(),
        covariates: if campaign.apart { "apart" } else { "together" }.into(),
        scene: campaign.kind.words().into(),
        readings: count,
        recorded: Vec::new(),
        noise_nt,
        effects,
        without: Vec::new(),
        nonce: nonce(draw),
    };
    Case { document, truth }
}

/// Random digits.
pub fn nonce(draw: &mut Draw) -> String {
    (0..32).map(|_| char::from_digit(draw.below(16) as u32, 16).unwrap_or('0')).collect()
}

fn add(column: &mut [f64], added: &[f64]) {
    column.iter_mut().zip(added).for_each(|(value, added)| *value += added);
}

fn rms_of_all(noise: &Readings) -> f64 {
    let all = || noise.iter().flatten().flatten();
    (all().map(|v| v * v).sum::<f64>() / all().count().max(1) as f64).sqrt()
}
