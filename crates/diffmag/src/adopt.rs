//! What the clocks differ by, as effects of the catalogue in the document's model.

use common::{AdoptedEffect, ClockDifference, Document, Quantity, procedure};
use physics::{Kind, References};

use crate::series::Pair;

/// A matrix that was fitted to corrected times says what the test instrument reads only together with its clock: what it stamps t was true at
/// t − δ₀ − r t on the campaign's clock. δ₀ and r go to `model.effects` as `clock_offset` and `clock_rate`, in place of what was stated of them.
pub fn clock(document: &mut Document, pair: &Pair, found: &ClockDifference) {
    let middle_s = pair.time_s(0) - pair.since_middle_s(0) + lead_s(document);
    let (offset, rate) = (&found.offset_s, &found.rate_ppm);
    let std = |of: &Quantity| of.std().unwrap_or(0.0);
    let at_zero = Quantity::new(
        offset.value() - 1e-6 * rate.value() * middle_s,
        std(offset).hypot(1e-6 * std(rate) * middle_s),
    );
    let effects = &mut document.model.get_or_insert_default().effects;
    for (kind, size) in [(Kind::ClockOffset, at_zero), (Kind::ClockRate, rate.clone())] {
        effects.retain(|effect| effect.effect != kind.name() || effect.recording.is_some());
        effects.push(AdoptedEffect {
            effect: kind.name().into(),
            sensor: None,
            coil: None,
            column: None,
            recording: None,
            parameters: [(kind.parameters()[0].name.to_string(), size)].into_iter().collect(),
            extra: [("found_by".to_string(), "diffmag".into())].into_iter().collect(),
        });
    }
}

/// From the campaign's beginning to that of the pair, s.
fn lead_s(document: &Document) -> f64 {
    let pairs = document.recordings.iter().filter(|r| r.procedure == procedure::DIFFERENTIAL);
    let first = pairs.filter_map(|recording| recording.start()).map(|start| start.unix_s);
    let beginning = References::of(document).beginning_s;
    beginning.map_or(0.0, |beginning| first.fold(f64::INFINITY, f64::min) - beginning)
}
