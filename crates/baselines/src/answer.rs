//! The answer in the shape of diagnose's.

use common::{Diagnosis, Document, ExplainedEffect, Residual, Verdict};
use diagnose::{Dictionary, Error};

use crate::Choice;
use crate::blocks::Blocks;

/// Pieces of time, dealt out to the parts of the readings that are left out in turn: as diagnose has it.
const PIECES: usize = 24;
const PARTS: usize = 6;

/// Nothing chosen agrees, names explain, smooth structure alone is unexplained. A method that knows no
/// probability prints none; what a diagnosis must hold besides (`p_adjusted`) is one.
pub fn diagnosis(dictionary: &Dictionary, choice: &Choice) -> Result<Diagnosis, Error> {
    let chosen = || choice.groups.iter().map(|group| &dictionary.groups[*group]);
    let effects: Vec<ExplainedEffect> = chosen()
        .filter_map(|group| Some(ExplainedEffect { p_adjusted: 1.0, ..group.effect.clone()? }))
        .collect();
    let nameless = chosen().filter(|group| group.effect.is_none()).map(|group| &group.name);
    let reasons = nameless.map(|name| format!("unidentified structure: {name}"));
    let verdict = match (choice.groups.is_empty(), effects.is_empty()) {
        (true, _) => Verdict::Agrees,
        (false, true) => Verdict::Unexplained,
        (false, false) => Verdict::Explained,
    };
    Ok(Diagnosis {
        verdict,
        reasons: choice.reasons.iter().cloned().chain(reasons).collect(),
        effects,
        fit: Some(fit(dictionary, choice)?),
        ..Diagnosis::default()
    })
}

/// Rms of the readings; of whitened rows, in the noise of a reading.
fn fit(dictionary: &Dictionary, choice: &Choice) -> Result<Residual, Error> {
    let readings: usize = dictionary.channels.iter().map(|channel| channel.rows.len()).sum();
    let rms = |sum: f64| dictionary.noise_nt * (sum / readings.max(1) as f64).sqrt();
    let (refitted, held_out_before) = Blocks::of(dictionary, &[], PIECES).left(PARTS)?;
    let (after, held_out_after) = Blocks::of(dictionary, &choice.columns, PIECES).left(PARTS)?;
    Ok(Residual {
        rms_before_nt: dictionary.before_nt,
        rms_refitted_nt: rms(refitted),
        rms_after_nt: rms(after),
        held_out_before_nt: rms(held_out_before),
        held_out_after_nt: rms(held_out_after),
        noise_floor_nt: dictionary.noise_nt,
        noise_source: dictionary.noise_source.into(),
        ..Residual::default()
    })
}

/// A line for people.
pub fn summary(document: &Document) -> String {
    let Some(entry) = document.diagnosis.iter().flatten().next() else { return String::new() };
    let target = |effect: &ExplainedEffect| {
        let axis = effect.sensor.or(effect.coil).map(|axis| format!(" {axis}"));
        let column = effect.column.as_ref().map(|column| format!(" {column}"));
        format!("{}{}{}", effect.effect, axis.unwrap_or_default(), column.unwrap_or_default())
    };
    let names: Vec<String> = entry.effects.iter().map(target).collect();
    let reasons: String = entry.reasons.iter().map(|reason| format!("  {reason}\n")).collect();
    format!("{}: {}\n{reasons}", entry.verdict.word().replace('_', " "), names.join(", "))
}
