//! What the clocks differ by, as effects of the catalogue in the document's model.

use common::{AdoptedEffect, ClockDifference, Document, Quantity, procedure};
use physics::{Kind, References};

use joined::Pair;

/// A matrix that was fitted to corrected times says what the test instrument reads only together with its
/// clock: what it stamps t was true at t − δ₀ − r t on the campaign's clock. δ₀ and r go to `model.effects`
/// as `clock_offset` and `clock_rate`, in place of what was stated of them; where times jump, each segment
/// has a δ₀ of its own.
///
/// `pair` is that of the readings before they were corrected.
pub fn clock(document: &mut Document, pair: &Pair, found: &ClockDifference, found_by: &str) {
    let lead_s = lead_s(document);
    let rate = &found.rate_ppm;
    let std = |of: &Quantity| of.std().unwrap_or(0.0);
    let kinds = [Kind::ClockOffset, Kind::ClockRate];
    let effects = &mut document.model.get_or_insert_default().effects;
    effects
        .retain(|effect| effect.recording.is_some() || kinds.iter().all(|kind| effect.effect != kind.name()));
    for (number, segment) in pair.segments.iter().enumerate() {
        let rows = &segment.rows;
        let middle_s = lead_s + 0.5 * (pair.time_s(rows.start) + pair.time_s(rows.end - 1));
        let own = found.segments.get(number).and_then(|own| own.offset_s.as_ref());
        let of = own.filter(|_| segment.late_s != 0.0).unwrap_or(&found.offset_s);
        let at_zero = Quantity::new(
            found.offset_s.value() + segment.late_s - 1e-6 * rate.value() * middle_s,
            std(of).hypot(1e-6 * std(rate) * middle_s),
        );
        let begins = |row: usize| {
            let jump = pair.boundaries.iter().find(|of| of.instrument.is_some() && of.row == row);
            jump.map(|of| of.jump.at_s + lead_s)
        };
        effects.push(AdoptedEffect {
            from_s: begins(rows.start),
            to_s: begins(rows.end),
            ..effect(Kind::ClockOffset, at_zero, found_by)
        });
    }
    effects.push(effect(Kind::ClockRate, rate.clone(), found_by));
}

fn effect(kind: Kind, size: Quantity, found_by: &str) -> AdoptedEffect {
    AdoptedEffect {
        effect: kind.name().into(),
        parameters: [(kind.parameters()[0].name.to_string(), size)].into_iter().collect(),
        extra: [("found_by".to_string(), found_by.into())].into_iter().collect(),
        ..AdoptedEffect::default()
    }
}

/// From the campaign's beginning to that of the pair, s.
fn lead_s(document: &Document) -> f64 {
    let pairs = document.recordings.iter().filter(|r| r.procedure == procedure::DIFFERENTIAL);
    let first = pairs.filter_map(|recording| recording.start()).map(|start| start.unix_s);
    let beginning = References::of(document).beginning_s;
    beginning.map_or(0.0, |beginning| first.fold(f64::INFINITY, f64::min) - beginning)
}
