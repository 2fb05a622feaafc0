//! What the model left out: each diagnosis with its residuals before and after.

use common::{Diagnosis, Document, ExplainedEffect, FamilyMember, Residual, ResidualSeries, Verdict};
use page::words::{key, rounded, sentence};

use super::residuals::{Names, plots};
use crate::plot::Plot;
use crate::{Cell, Effect, Finding, Section, Table, number};

/// The section; None where the document has nothing of it.
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
        let mut series =
            diagnosis.series.iter().enumerate().map(|(number, series)| {
                residuals(&format!("{}-{}", index + 1, number + 1), series, diagnosis)
            });
        series.next().into_iter().flatten().for_each(|plot| section.plot(plot));
        reasons(&mut section, diagnosis);
        for effect in &diagnosis.effects {
            effect_words(&mut section, effect);
        }
        section.table(effects(diagnosis));
        section.table(parameters(diagnosis));
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
    let mut table = Table::new(
        "Where it shows",
        [
            ("place", ""),
            ("sensors", ""),
            ("frame", ""),
            ("follows", ""),
            ("share of the energy", ""),
            ("what", ""),
        ],
    );
    for place in &diagnosis.places {
        let sensors: Vec<&str> = place.sensors.iter().map(|axis| axis.letter()).collect();
        table.row([
            place.place.clone().into(),
            sensors.join(", ").into(),
            place.frame.clone().into(),
            place.covariates.join(", ").into(),
            place.energy_share.map(|share| number::fixed(share, 3)).into(),
            place.description.as_str().into(),
        ]);
    }
    section.table(table);
}

fn effect_words(section: &mut Section, effect: &ExplainedEffect) {
    let mut words = format!("{}: {}", named(effect), effect.physics);
    if !effect.equation.is_empty() {
        words.push_str(&format!(" Equation: {}.", effect.equation));
    }
    if !effect.source.is_empty() {
        words.push_str(&format!(" Source: {}.", effect.source));
    }
    section.say(words);
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

/// One row an effect: how sure it is, what it accounts for, and what its form leaves.
fn effects(diagnosis: &Diagnosis) -> Table {
    let mut table = Table::new(
        "Effects",
        [
            ("effect", ""),
            ("probability of the effect", ""),
            ("share of the explicable variance", ""),
            ("departure from its equation, share", ""),
            ("p", ""),
            ("gain on held-out readings", "nT"),
            ("visible", ""),
        ],
    );
    for effect in &diagnosis.effects {
        let share = |value: Option<f64>| value.map(|value| number::fixed(value, 3));
        table.row([
            named(effect).into(),
            share(effect.probability).into(),
            share(effect.share).into(),
            share(effect.departure).into(),
            Cell::Probability(effect.p_adjusted),
            Cell::Figures(effect.held_out_gain_nt, 3),
            number::fixed(effect.visible_fraction, 3).into(),
        ]);
    }
    table
}

fn parameters(diagnosis: &Diagnosis) -> Table {
    let columns = [("effect", ""), ("parameter", ""), ("value", ""), ("unit", "")];
    let mut table = Table::new("Parameters of the effects", columns);
    for effect in &diagnosis.effects {
        let parts = effect.list.iter().flat_map(|part| &part.parameters);
        for (name, value) in effect.parameters.iter().chain(parts) {
            let (name, unit) = key(name);
            table.row([named(effect).into(), name.into(), value.into(), unit.into()]);
        }
    }
    table
}

fn residuals(id: &str, series: &ResidualSeries, diagnosis: &Diagnosis) -> Vec<Plot> {
    let of = series.recording.as_ref().map_or("all recordings".into(), |id| id.clone());
    let (column, _) = key(&series.column);
    let noise = diagnosis.fit.as_ref().map(|fit| {
        format!(
            "Noise of a reading: {} nT ({}).",
            number::significant(fit.noise_floor_nt, 3),
            fit.noise_source
        )
    });
    let names = Names {
        id: format!("residual-{id}"),
        title: format!("Residual of {column}, {of},"),
        residual: "residual",
        legend: ["before: stated calibration", "after: with the effects found", "fitted"],
    };
    plots(&names, series, &noise.unwrap_or_default())
}

fn tables(section: &mut Section, diagnosis: &Diagnosis) {
    let mut rms = Table::new(
        "Rms of the residuals",
        [
            ("recording, column", ""),
            ("before", "nT"),
            ("after", "nT"),
            ("held out, before", "nT"),
            ("held out, after", "nT"),
            ("noise", "nT"),
        ],
    );
    if let Some(fit) = &diagnosis.fit {
        section.say(format!(
            "Calibration refitted without any effect: {} nT rms.",
            number::significant(fit.rms_refitted_nt, 4)
        ));
        let figures = |name: String, figures: [f64; 5]| -> [Cell; 6] {
            let [a, b, c, d, e] = figures.map(|figure| Cell::Figures(figure, 4));
            [name.into(), a, b, c, d, e]
        };
        rms.row(figures(
            "all".into(),
            [
                fit.rms_before_nt,
                fit.rms_after_nt,
                fit.held_out_before_nt,
                fit.held_out_after_nt,
                fit.noise_floor_nt,
            ],
        ));
        for one in &fit.by_recording {
            rms.row(figures(
                format!("{}, {}", one.recording, one.column),
                [
                    one.rms_before_nt,
                    one.rms_after_nt,
                    one.held_out_before_nt,
                    one.held_out_after_nt,
                    one.noise_floor_nt,
                ],
            ));
        }
    }
    section.table(rms);
    let mut rivals =
        Table::new("Effects that were rejected, and why", [("effect", ""), ("rival", ""), ("why not", "")]);
    for effect in &diagnosis.effects {
        for rival in &effect.rivals {
            rivals.row([
                named(effect).into(),
                rival.effect.replace('_', " ").into(),
                rival.why_not.as_str().into(),
            ]);
        }
    }
    section.table(rivals);
    let columns =
        [("kind of physics", ""), ("probability", ""), ("share", ""), ("members", ""), ("another form", "")];
    let mut families = Table::new("Kinds of physics, whatever their form", columns);
    for one in &diagnosis.families {
        let member = |member: &FamilyMember| {
            format!("{} {}", member.effect.replace('_', " "), number::probability(member.probability))
        };
        let members: Vec<String> = one.members.iter().map(member).collect();
        families.row([
            one.title.as_str().into(),
            Cell::Probability(one.probability),
            number::fixed(one.share, 3).into(),
            members.join(", ").into(),
            Cell::Probability(one.no_member),
        ]);
    }
    section.table(families);
    let mut energy = Table::new(
        "Shares of the excess of the squared residual over the noise",
        [("by", ""), ("part", ""), ("from", ""), ("to", ""), ("share", "")],
    );
    let figures = |end: Option<f64>| end.map_or(Cell::Empty, |end| Cell::Number(rounded(end)));
    for one in &diagnosis.energy {
        energy.row([
            one.by.as_str().into(),
            one.part.clone().into(),
            figures(one.range.map(|[from, _]| from)),
            figures(one.range.map(|[_, to]| to)),
            number::fixed(one.share, 3).into(),
        ]);
    }
    section.table(energy);
    let mut experiments =
        Table::new("Recordings that would decide", [("what is done", ""), ("expected log odds", "")]);
    for one in &diagnosis.experiments {
        experiments.row([one.what.clone().into(), Cell::Figures(one.log_odds, 2)]);
    }
    section.table(experiments);
    let columns = [("sensor", ""), ("follows", ""), ("how", ""), ("lag", "s"), ("share", "")];
    let mut unnamed = Table::new("Unidentified structure", columns);
    for one in &diagnosis.unnamed {
        unnamed.row([
            one.sensor.map_or(Cell::Empty, |axis| axis.to_string().into()),
            one.follows.clone().into(),
            one.parity.clone().map_or(Cell::Empty, Cell::from),
            one.lag_s.map_or(Cell::Empty, |lag| Cell::Figures(lag, 2)),
            number::fixed(one.share, 3).into(),
        ]);
    }
    section.table(unnamed);
    let columns = [("parameter", ""), ("change", ""), ("stated u", ""), ("unit", ""), ("or", ""), ("p", "")];
    let mut moved = Table::new("The stated calibration no longer holds", columns);
    for one in &diagnosis.calibration_moved {
        let (parameter, unit) = key(&one.parameter);
        moved.row([
            parameter.into(),
            (&one.shift).into(),
            Cell::Figures(one.stated_std, 2),
            unit.into(),
            one.alternatives.join(", ").into(),
            Cell::Probability(one.p_adjusted),
        ]);
    }
    section.table(moved);
    let mut shifts =
        Table::new("Changes of the calibration", [("parameter", ""), ("shift", ""), ("unit", "")]);
    for one in &diagnosis.base_shift {
        let (parameter, unit) = key(&one.parameter);
        shifts.row([parameter.into(), (&one.shift).into(), unit.into()]);
    }
    section.table(shifts);
    let mut detectable = Table::new(
        "Smallest effect that these recordings would show with a probability of 90 %",
        [("effect", ""), ("of", ""), ("parameter", ""), ("smallest", ""), ("unit", ""), ("visible", "")],
    );
    for one in &diagnosis.detectable {
        for (name, size) in &one.smallest {
            let (name, unit) = key(name);
            detectable.row([
                one.effect.replace('_', " ").into(),
                one.target.clone().into(),
                name.into(),
                Cell::Figures(*size, 2),
                unit.into(),
                number::fixed(one.visible_fraction, 3).into(),
            ]);
        }
    }
    section.table(detectable);
}
