//! What the model left out: each diagnosis with its residuals before and after.

use common::{Diagnosis, Document, ExplainedEffect, FamilyMember, Residual, ResidualSeries, Verdict};
use page::words::{key, rounded, sentence};

use super::residuals::{Names, plots};
use crate::plot::Plot;
use crate::{Cell, Effect, Finding, Section, Table, number};

pub fn section(document: &Document) -> Option<Section> {
    let all = document.diagnosis.as_ref().filter(|all| !all.is_empty())?;
    let mut section = Section::new("diagnosis", "Diagnosis");
    for (index, diagnosis) in all.iter().enumerate() {
        if all.len() > 1 {
            section.items.push(crate::Item::Heading(format!("Diagnosis {} of {}", index + 1, all.len())));
        }
        if !diagnosis.answer.is_empty() {
            section.say(sentence(&diagnosis.answer));
        }
        section.say(answer(diagnosis));
        section.warnings.extend(diagnosis.fit.as_ref().and_then(absurd));
        // The picture first: the recording before, and with what was found.
        let drawn = |(number, series)| {
            let id = format!("residual-{}-{}", index + 1, number + 1);
            residuals(id, series, diagnosis)
        };
        let mut series = diagnosis.series.iter().enumerate().map(drawn);
        series.next().into_iter().flatten().for_each(|plot| section.plot(plot));
        reasons(&mut section, diagnosis);
        effects(&mut section, diagnosis);
        series.flatten().for_each(|plot| section.plot(plot));
        tables(&mut section, diagnosis);
    }
    Some(section)
}

/// That a fit leaves more than there was.
fn absurd(fit: &Residual) -> Option<Finding> {
    fit.is_absurd().then(|| {
        let words = format!(
            "The fit increases the residual: rms {} nT with the stated calibration, {} nT after refitting it, {} nT with the effects found. Do not use it.",
            number::significant(fit.rms_before_nt, 3),
            number::significant(fit.rms_refitted_nt, 3),
            number::significant(fit.rms_after_nt, 3)
        );
        Finding::of(words, Effect::nt(fit.rms_refitted_nt.max(fit.rms_after_nt) - fit.rms_before_nt))
    })
}

fn answer(diagnosis: &Diagnosis) -> &'static str {
    match diagnosis.verdict {
        Verdict::Agrees => "Agrees: the model agrees with the recordings to the noise.",
        Verdict::Explained if diagnosis.effects.is_empty() => {
            "Explained: constants of the calibration changed, and nothing else remains."
        }
        Verdict::Explained => {
            "Explained: named effects explain the difference, except for the departure from their equations."
        }
        Verdict::PartlyExplained => "Partly explained: named effects explain a part of the difference.",
        Verdict::Ambiguous => "Ambiguous: several effects explain the difference equally well.",
        Verdict::Unexplained => "Unexplained: there is structure that no effect explains.",
    }
}

fn reasons(section: &mut Section, diagnosis: &Diagnosis) {
    if !diagnosis.reasons.is_empty() {
        section.say(sentence(&diagnosis.reasons.join("; ")));
    }
    if !diagnosis.ambiguity.is_empty() {
        let sets: Vec<String> = diagnosis.ambiguity.iter().map(|set| set.join(" with ")).collect();
        section.say(format!("These do equally well: {}.", sets.join("; or ")));
    }
    if let Some(remaining) = diagnosis.remaining.as_ref().filter(|remaining| !remaining.white) {
        let words = format!("The residuals are not noise alone: {}", remaining.structure);
        // What the noise does not explain.
        let beyond = |fit: &Residual| (fit.rms_after_nt.powi(2) - fit.noise_floor_nt.powi(2)).max(0.0).sqrt();
        section.warnings.push(Finding::of(words, Effect::nt(diagnosis.fit.as_ref().map(beyond))));
    }
    if let Some(next) = &diagnosis.next_experiment {
        section.say(sentence(&format!("what would decide: {next}")));
    }
    let places = diagnosis.places.iter().map(|place| {
        let sensors: Vec<&str> = place.sensors.iter().map(|axis| axis.letter()).collect();
        let (sensors, follows) = (sensors.join(", "), place.covariates.join(", "));
        let share = place.energy_share.map(share);
        (&place.place, sensors, &place.frame, follows, share, &place.description)
    });
    let headers = "place | sensors | frame | follows | share of the energy | what";
    section.rows("Where it shows", headers, places);
}

fn share(share: f64) -> String {
    number::fixed(share, 3)
}

fn named(effect: &ExplainedEffect) -> String {
    let targets = [
        effect.sensor.map(|axis| format!("sensor {axis}")),
        effect.coil.map(|axis| format!("coil {axis}")),
        effect.column.clone(),
    ];
    let targets: Vec<String> = targets.into_iter().flatten().collect();
    let name = effect.effect.replace('_', " ");
    if targets.is_empty() { name } else { format!("{name}, {}", targets.join(", ")) }
}

/// In words, how sure each is, what it accounts for, what its form leaves, and its parameters.
fn effects(section: &mut Section, diagnosis: &Diagnosis) {
    let mut table = Table::new(
        "Effects",
        "effect | probability of the effect | share of the explicable variance | departure from its equation, share | p | \
         gain on held-out readings [nT] | visible",
    );
    let mut parameters = Table::new("Parameters of the effects", "effect | parameter | value | unit");
    for effect in &diagnosis.effects {
        let name = named(effect);
        let mut words = format!("{name}: {}", effect.physics);
        for (of, text) in [("Equation", &effect.equation), ("Source", &effect.source)] {
            if !text.is_empty() {
                words.push_str(&format!(" {of}: {text}."));
            }
        }
        section.say(words);
        table.row((
            &name,
            effect.probability.map(share),
            effect.share.map(share),
            effect.departure.map(share),
            Cell::Probability(effect.p_adjusted),
            Cell::Figures(effect.held_out_gain_nt, 3),
            share(effect.visible_fraction),
        ));
        let parts = effect.list.iter().flat_map(|part| &part.parameters);
        for (parameter, value) in effect.parameters.iter().chain(parts) {
            let (parameter, unit) = key(parameter);
            parameters.row((&name, parameter, value, unit));
        }
    }
    section.table(table);
    section.table(parameters);
}

fn residuals(id: String, series: &ResidualSeries, diagnosis: &Diagnosis) -> Vec<Plot> {
    let of = series.recording.as_deref().unwrap_or("all recordings");
    let (column, _) = key(&series.column);
    let noise = diagnosis.fit.as_ref().map(|fit| {
        let floor = number::significant(fit.noise_floor_nt, 3);
        format!("Noise of a reading: {floor} nT ({}).", fit.noise_source)
    });
    let title = format!("Residual of {column}, {of},");
    let legend = ["before: stated calibration", "after: with the effects found", "fitted"];
    plots(&Names { id, title, residual: "residual", legend }, series, &noise.unwrap_or_default())
}

fn tables(section: &mut Section, diagnosis: &Diagnosis) {
    let mut rms = Table::new(
        "Rms of the residuals",
        "recording, column | before [nT] | after [nT] | held out, before [nT] | held out, after [nT] | noise [nT]",
    );
    if let Some(fit) = &diagnosis.fit {
        section.say(format!(
            "Calibration refitted without any effect: {} nT rms.",
            number::significant(fit.rms_refitted_nt, 4)
        ));
        let mut row = |name: String, figures: [f64; 5]| {
            let [a, b, c, d, e] = figures.map(|rms| Cell::Figures(rms, 4));
            rms.row((name, a, b, c, d, e));
        };
        let [before, after] = [fit.held_out_before_nt, fit.held_out_after_nt];
        row("all".into(), [fit.rms_before_nt, fit.rms_after_nt, before, after, fit.noise_floor_nt]);
        for one in &fit.by_recording {
            let [before, after] = [one.held_out_before_nt, one.held_out_after_nt];
            let figures = [one.rms_before_nt, one.rms_after_nt, before, after, one.noise_floor_nt];
            row(format!("{}, {}", one.recording, one.column), figures);
        }
    }
    section.table(rms);
    let all =
        diagnosis.effects.iter().flat_map(|effect| effect.rivals.iter().map(move |rival| (effect, rival)));
    let rivals = all.map(|(effect, rival)| (named(effect), rival.effect.replace('_', " "), &rival.why_not));
    section.rows("Effects that were rejected, and why", "effect | rival | why not", rivals);
    let families = diagnosis.families.iter().map(|one| {
        let member = |member: &FamilyMember| {
            format!("{} {}", member.effect.replace('_', " "), number::probability(member.probability))
        };
        let members: Vec<String> = one.members.iter().map(member).collect();
        let [probability, other] = [one.probability, one.no_member].map(Cell::Probability);
        (&one.title, probability, share(one.share), members.join(", "), other)
    });
    section.rows(
        "Kinds of physics, whatever their form",
        "kind of physics | probability | share | members | another form",
        families,
    );
    let energy = diagnosis.energy.iter().map(|one| {
        let [from, to] = [0, 1].map(|end| one.range.map(|range| rounded(range[end])));
        (&one.by, &one.part, from, to, share(one.share))
    });
    section.rows(
        "Shares of the excess of the squared residual over the noise",
        "by | part | from | to | share",
        energy,
    );
    let experiments = diagnosis.experiments.iter().map(|one| (&one.what, Cell::Figures(one.log_odds, 2)));
    section.rows("Recordings that would decide", "what is done | expected log odds", experiments);
    let unnamed = diagnosis
        .unnamed
        .iter()
        .map(|one| (one.sensor, &one.follows, &one.parity, Cell::figures(one.lag_s, 2), share(one.share)));
    section.rows("Unidentified structure", "sensor | follows | how | lag [s] | share", unnamed);
    let moved = diagnosis.calibration_moved.iter().map(|one| {
        let (parameter, unit) = key(&one.parameter);
        let (stated, p) = (Cell::Figures(one.stated_std, 2), Cell::Probability(one.p_adjusted));
        (parameter, &one.shift, stated, unit, one.alternatives.join(", "), p)
    });
    let headers = "parameter | change | stated u | unit | or | p";
    section.rows("The stated calibration no longer holds", headers, moved);
    let shifts = diagnosis.base_shift.iter().map(|one| {
        let (parameter, unit) = key(&one.parameter);
        (parameter, &one.shift, unit)
    });
    section.rows("Changes of the calibration", "parameter | shift | unit", shifts);
    let mut detectable = Table::new(
        "Smallest effect that these recordings would show with a probability of 90 %",
        "effect | of | parameter | smallest | unit | visible",
    );
    for one in &diagnosis.detectable {
        let (effect, visible) = (one.effect.replace('_', " "), share(one.visible_fraction));
        for (name, size) in &one.smallest {
            let (name, unit) = key(name);
            detectable.row((&effect, &one.target, name, Cell::Figures(*size, 2), unit, &visible));
        }
    }
    section.table(detectable);
}
