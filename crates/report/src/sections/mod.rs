//! The sections of the page; `PARTS` has the function of each.

mod answer;
mod axes;
mod axes_map;
mod coils;
mod conditions;
mod diagnosis;
mod differential;
mod effects;
mod instruments;
mod noise;
mod recordings;
mod residuals;
mod scalar;
mod sensors;
mod shared;
mod stated;

use common::Document;
use page::words;
use std::collections::HashSet;

use crate::{Effect, Finding, Item, Page, Section, Table, number};

/// How a part of a document is shown; None where the document does not have it.
type Part = fn(&Document) -> Option<Section>;

/// The parts in the order of the page.
const PARTS: [Part; 17] = [
    stated::section,
    coils::section,
    coils::gradients,
    noise::nulling,
    sensors::section,
    noise::section,
    sensors::drift,
    conditions::temperature,
    conditions::cross_field,
    axes::section,
    scalar::section,
    differential::section,
    diagnosis::section,
    stated::model,
    recordings::corrected,
    recordings::section,
    stated::history,
];

/// The page of a document whose text has this hash, the statement of conformity first.
pub fn page(document: &Document, conformity: Option<Section>, sha256: Option<&str>) -> Page {
    let parts = PARTS.iter().filter_map(|part| part(document));
    let mut sections: Vec<Section> = conformity.into_iter().chain(parts).collect();
    tell_apart(&mut sections);
    sections.iter_mut().for_each(|part| Finding::sort(&mut part.warnings, |finding| finding));
    let listed = ranked(&sections);
    let first = sections.iter().take_while(|section| section.id == conformity::ID).count();
    sections.splice(first..first, listed);
    let named = document.instrument.as_ref().and_then(|instrument| instrument.name.clone());
    let title = document.title.clone().or(named).unwrap_or_else(|| "A document without a title".into());
    Page { title, summary: summary(document, &sections, sha256), sections }
}

/// So many findings stand at the head of the page whatever there is.
const FIRST: usize = 8;

/// All findings in one list, by what they do to the result.
fn ranked<'a>(sections: &'a [Section]) -> Option<Section> {
    let of = |section: &'a Section| section.warnings.iter().map(|finding| (finding, &section.title));
    let mut all: Vec<(&Finding, &String)> = sections.iter().flat_map(of).collect();
    Finding::sort(&mut all, |(finding, _)| finding);
    let table = |caption| Table::new(caption, "changes the result by | finding | where");
    let (mut first, mut others) =
        (table("Findings, largest change of the result first"), table("The others"));
    for (place, (finding, title)) in all.into_iter().enumerate() {
        let table = if place < FIRST { &mut first } else { &mut others };
        let figures = |size| number::significant(size, 2);
        let effect = match finding.effect {
            Effect::Nt(size) => format!("{} nT", figures(size)),
            Effect::Arcsec(size) => format!("{} arcsec", figures(size)),
            Effect::Std(size) => format!("{} standard uncertainties", figures(size)),
            Effect::Unstated(reason) => format!("– ({reason})"),
        };
        table.row((effect, finding.words.replace('`', ""), title));
    }
    let mut section = Section::new("findings", "What stands out");
    section.table(first);
    section.table(others);
    (!section.items.is_empty()).then(|| {
        section.words.push(
            "How much a finding changes the result, from numbers in the document: a field or an offset in nT, a direction in arcsec, or a parameter in its \
             standard uncertainties. Rotations and changes of a sensitivity count in a field of 50 000 nT, where 1 arcsec is 0.24 nT. Findings in standard uncertainties follow, then those without a number, with the reason."
                .into(),
        );
        section
    })
}

/// What the stages found striking, a sentence each.
pub fn findings(document: &Document) -> Vec<String> {
    let warnings = PARTS.iter().filter_map(|part| part(document)).flat_map(|section| section.warnings);
    warnings.map(|finding| finding.words).collect()
}

fn summary(document: &Document, sections: &[Section], sha256: Option<&str>) -> Vec<String> {
    let mut summary = Vec::new();
    if sections.iter().all(|section| section.id == conformity::ID) {
        summary.push(
            "There is nothing in this document: no recording, no calibration, no diagnosis. A document is begun by `ingest` from \
             files of a logger, or by `simulate`; the calibrating programs then add to it."
                .into(),
        );
        return summary;
    }
    summary.extend(answer::answer(document));
    summary.extend(answers(document));
    let conformity = sections.iter().find(|section| section.id == conformity::ID);
    summary.extend(
        conformity.and_then(|section| section.words.first()).map(|words| format!("Conformity: {words}")),
    );
    let rows: usize = document.recordings.iter().map(common::Recording::rows).sum();
    let stages: Vec<&str> = document.history.iter().map(|entry| entry.stage.as_str()).collect();
    let been =
        if stages.is_empty() { String::new() } else { format!(" It went through {}.", stages.join(", ")) };
    summary.push(format!(
        "The document holds {} with {}.{been}",
        words::counted(document.recordings.len(), "recording"),
        words::counted(rows, "row")
    ));
    summary.push(
        "Each ±, each error bar without another note and each stated accuracy is one standard uncertainty, to two figures. 95 % intervals are named as such."
            .into(),
    );
    summary.extend(sha256.map(|hash| format!("SHA-256 of the document: {hash}")));
    summary
}

/// What it comes to, first of all; what cannot be right is marked.
fn answers(document: &Document) -> Vec<String> {
    let pair =
        document.calibration.as_ref().and_then(|calibration| calibration.differential.as_ref()?.fit.as_ref());
    let of_pair = pair.map(|fit| {
        let absurd = fit.axes.iter().any(|(_, axis)| axis.exceeded_nt().is_some());
        ("Two magnetometers", fit.answer.as_str(), absurd)
    });
    let of_diagnosis = document.diagnosis.iter().flatten().map(|entry| {
        let absurd = entry.fit.as_ref().is_some_and(common::Residual::is_absurd);
        ("Diagnosis", entry.answer.as_str(), absurd)
    });
    let all = of_pair.into_iter().chain(of_diagnosis).filter(|(_, answer, _)| !answer.is_empty());
    let told = |(of, answer, absurd): (&str, &str, bool)| {
        let mark = if absurd { "△ " } else { "" };
        words::sentence(&format!("{mark}{of}: {answer}"))
    };
    all.map(told).collect()
}

/// Ids of recordings may come to the same id of a plot; the later ones are numbered.
fn tell_apart(sections: &mut [Section]) {
    let mut seen = HashSet::new();
    for item in sections.iter_mut().flat_map(|section| &mut section.items) {
        let Item::Plot(plot) = item else { continue };
        let first = plot.id.clone();
        let mut number = 1;
        while !seen.insert(plot.id.clone()) {
            number += 1;
            plot.id = format!("{first}-{number}");
        }
    }
}
