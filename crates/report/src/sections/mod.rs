//! The page: its head, by `head.jinja`, the list of all findings, and the sections that `sections.jinja` makes of a
//! document, each with its findings.

mod absolute;
mod axes;
mod axes_map;
mod coils;
mod conditions;
mod events;
mod findings;
mod noise;
mod recordings;
mod residuals;
mod scalar;
mod time;

use crate::page::template;
use common::{Diagnosis, Document, Error, Residual};
use minijinja::{Value, context};
use std::collections::{HashMap, HashSet};

use crate::page::{Cell, Target};
use crate::plot::Plot;
use crate::{Effect, Finding, Item, Options, Page, Section, Table, number};

/// Plots with the name that `sections.jinja` calls them by.
type Plots = HashMap<String, Vec<Plot>>;

/// The page of a document, the statement of conformity first; an error where a template is wrong.
pub fn page(document: &Document, conformity: Option<Section>, options: &Options) -> Result<Page, Error> {
    let stated = conformity.as_ref().and_then(|section| section.words.first()).cloned();
    let (context, plots) = given(document);
    let parts = parts(document, context.clone(), plots)?;
    let nothing = parts.is_empty();
    let mut sections: Vec<Section> = conformity.into_iter().chain(parts).collect();
    tell_apart(&mut sections);
    sections.iter_mut().for_each(|part| Finding::sort(&mut part.warnings, |finding| finding));
    let listed = ranked(&sections);
    let first = sections.iter().take_while(|section| section.id == crate::conformity::ID).count();
    sections.splice(first..first, listed);
    let context = context! {
        nothing,
        conformity => template::part(&stated),
        name => template::part(&options.name),
        sha256 => template::part(&options.document_sha256),
        ..context
    };
    let earliest = |ids: &[String]| time::earliest(document, ids).map(|recording| recording.id.clone());
    crate::page::link(&mut sections, earliest);
    let head =
        template::sections(template::environment(), include_str!("../head.jinja"), context, Plots::new())?;
    let Section { title, words, .. } = head.into_iter().next().unwrap_or_default();
    Ok(Page { title, summary: words, sections })
}

/// What the templates are given of a document, and the plots that they call by their names.
fn given(document: &Document) -> (Value, Plots) {
    let mut plots = Plots::new();
    let calibration = document.calibration.as_ref();
    if let Some(calibration) = calibration {
        coils::plots(&mut plots, calibration);
        noise::plots(&mut plots, calibration);
        conditions::plots(&mut plots, calibration);
        axes::plots(&mut plots, calibration);
        scalar::plots(&mut plots, calibration);
    }
    absolute::plots(&mut plots, document);
    residuals::of_diagnosis(&mut plots, document);
    let pair = calibration.and_then(|found| found.differential.as_ref()?.fit.as_ref());
    let difference = pair.map(|fit| residuals::of_difference(fit, document));
    plots.insert("difference".into(), difference.unwrap_or_default());
    let clock = pair.and_then(|fit| fit.clock.as_ref());
    let clock = clock.map(|clock| [clock.offset_in_words(), clock.rate_in_words()]);
    let middles = pair.and_then(|fit| fit.stability.as_ref()).map(time::middles);
    let is_absurd = |diagnosis: &Diagnosis| diagnosis.fit.as_ref().is_some_and(Residual::is_absurd);
    let absurd = context! {
        pair => pair.is_some_and(|fit| fit.axes.iter().any(|(_, axis)| axis.exceeded_nt().is_some())),
        diagnoses => document.diagnosis.iter().flatten().map(is_absurd).collect::<Vec<bool>>(),
    };
    let context = context! {
        title => template::part(&document.title),
        instrument => template::part(&document.instrument),
        facility => template::part(&document.facility),
        calibration => template::part(&document.calibration),
        model => template::part(&document.model),
        diagnosis => template::part(&document.diagnosis),
        history => document.history,
        clock => template::part(&clock),
        middles => template::part(&middles),
        absurd,
        single_readings => residuals::single_readings(document),
        procedures => recordings::procedures(document),
        recordings => recordings::list(document),
        corrected => recordings::corrected(&mut plots, document),
        unread => recordings::unread(&mut plots, document),
    };
    (context, plots)
}

/// The sections of what the document has, in the order of the page.
fn parts(document: &Document, context: Value, plots: Plots) -> Result<Vec<Section>, Error> {
    let mut sections =
        template::sections(template::environment(), include_str!("../sections.jinja"), context, plots)?;
    sections.iter_mut().for_each(|section| section.warnings = findings::of(&section.id, document));
    // These two say something by words and findings alone.
    let alone = |section: &Section| {
        ["stated", "axes"].contains(&section.id.as_str())
            && !(section.words.is_empty() && section.warnings.is_empty())
    };
    sections.retain_mut(|section| section.complete() || alone(section));
    Ok(sections)
}

/// The plots of several sensors, the first of each, then the second of each, and so on.
fn side_by_side(of_each: Vec<Vec<Plot>>) -> Vec<Plot> {
    let numbered = of_each.into_iter().flat_map(|plots| plots.into_iter().enumerate());
    let mut all: Vec<(usize, Plot)> = numbered.collect();
    all.sort_by_key(|(number, _)| *number);
    all.into_iter().map(|(_, plot)| plot).collect()
}

/// What the stages found striking, a sentence each.
///
/// # Errors
///
/// As [`page`].
pub fn findings(document: &Document) -> Result<Vec<String>, Error> {
    let (context, plots) = given(document);
    let warnings = parts(document, context, plots)?.into_iter().flat_map(|section| section.warnings);
    Ok(warnings.map(|finding| finding.words).collect())
}

/// So many findings stand at the head of the page whatever there is.
const FIRST: usize = 8;

/// All findings in one list, by what they do to the result.
fn ranked<'a>(sections: &'a [Section]) -> Option<Section> {
    let of = |section: &'a Section| section.warnings.iter().map(move |finding| (finding, section));
    let mut all: Vec<(&Finding, &Section)> = sections.iter().flat_map(of).collect();
    Finding::sort(&mut all, |(finding, _)| finding);
    let table = |caption| Table::new(caption, "changes the result by | finding | where");
    let (mut first, mut others) =
        (table("Findings, largest change of the result first"), table("The others"));
    for (place, (finding, section)) in all.into_iter().enumerate() {
        let table = if place < FIRST { &mut first } else { &mut others };
        let in_unit = |size, unit: &str| format!("{} {unit}", number::significant(size, 2));
        let effect = match finding.effect {
            Effect::Nt(size) => in_unit(size, "nT"),
            Effect::Arcsec(size) => in_unit(size, "arcsec"),
            Effect::Std(size) => in_unit(size, "standard uncertainties"),
            Effect::Unstated(reason) => format!("– ({reason})"),
        };
        let words = finding.words.replace('`', "");
        let words = match &finding.place {
            Some(place) => Cell::Placed(words, place.clone()),
            None => words.into(),
        };
        let section = Cell::Placed(section.title.clone(), Target::Section(section.id.clone()).into());
        table.rows.push(vec![effect.into(), words, section]);
    }
    let mut section = Section::new("findings", "What stands out");
    section.items.extend([first, others].map(Item::Table));
    section.complete().then(|| {
        section.words.push(
            "How much a finding changes the result, from numbers in the document: a field or an offset in nT, a direction in arcsec, or a parameter in its \
             standard uncertainties. Rotations and changes of a sensitivity count in a field of 50 000 nT, where 1 arcsec is 0.24 nT. Findings in standard uncertainties follow, then those without a number, with the reason."
                .into(),
        );
        section
    })
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
