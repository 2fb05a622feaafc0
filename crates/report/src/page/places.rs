//! From words to the plots that show what they speak of, and back.

use crate::page::number;
use crate::page::plot::{Interval, Plot, Timeline};
use crate::page::{Cell, Item, Link, Place, Section, Target};

/// Gives words that speak of a place an id and a link to the plot that shows it. Plots of one recording mark its
/// intervals; plots of recordings that overlap in time become one group. `earliest` tells which of some
/// recordings began first.
pub fn link(sections: &mut [Section], earliest: impl Fn(&[String]) -> Option<String>) {
    let (mut shown, mut effects): (Vec<(Timeline, [f64; 2], String)>, Vec<(String, String)>) =
        Default::default();
    for plot in items(sections).filter_map(drawn) {
        effects.extend(plot.toggles.iter().map(|toggle| (toggle.name.clone(), plot.id.clone())));
        let ends = number::ends(plot.series.iter().flat_map(|series| &series.points).map(|point| point.x));
        let (Some(time), Some(ends)) = (&mut plot.time, ends) else { continue };
        let own = ends.map(|end| time.moment(end * time.unit_s));
        let beside = |(known, of, _): &&(Timeline, [f64; 2], String)| {
            known.recording == time.recording
                || (known.epoch_s.and(time.epoch_s).is_some() && own[0] < of[1] && of[0] < own[1])
        };
        if let Some((known, ..)) = shown.iter().find(beside) {
            time.group.clone_from(&known.group);
        }
        shown.push((time.clone(), own, plot.id.clone()));
    }
    let mut marks: Vec<(String, [f64; 2], Interval)> = Vec::new();
    let mut speaking: Vec<(String, String)> = Vec::new();
    let places = sections.iter_mut().flat_map(placed);
    for (number, (words, place)) in places.enumerate() {
        let id = Some(format!("place-{}", number + 1));
        place.link = match &place.of {
            Target::Section(section) => Some(Link { to: section.clone(), ..Link::default() }),
            Target::Effect(name) => effects.iter().find(|(known, _)| known == name).map(|(_, plot)| {
                speaking.extend(id.clone().map(|id| (name.clone(), id)));
                Link { id, to: plot.clone(), shown: None }
            }),
            Target::Interval(recordings, time_s) => earliest(recordings).and_then(|recording| {
                let shows = |(time, ..): &&(Timeline, [f64; 2], String)| time.recording == recording;
                shown.iter().find(shows).map(|(time, _, plot)| {
                    let name = shortened(words);
                    let known = |(of, at, mark): &(String, [f64; 2], Interval)| {
                        *of == recording && at == time_s && mark.name == name
                    };
                    if !marks.iter().any(known) {
                        let id = id.clone().unwrap_or_default();
                        marks.push((recording.clone(), *time_s, Interval { name, from: 0.0, to: 0.0, id }));
                    }
                    Link {
                        id,
                        to: plot.clone(),
                        shown: Some((time.group.clone(), time_s.map(|own| time.moment(own)))),
                    }
                })
            }),
        };
    }
    for plot in items(sections).filter_map(drawn) {
        for toggle in &mut plot.toggles {
            toggle.id = speaking.iter().find(|(name, _)| *name == toggle.name).map(|(_, id)| id.clone());
        }
        let Some(time) = &plot.time else { continue };
        let own = marks.iter().filter(|(recording, ..)| *recording == time.recording);
        plot.marks = own
            .map(|(_, [from, to], mark)| Interval {
                from: from / time.unit_s,
                to: to / time.unit_s,
                ..mark.clone()
            })
            .collect();
    }
}

/// Words that a plot has room for.
fn shortened(words: &str) -> String {
    const MOST: usize = 28;
    match words.char_indices().nth(MOST) {
        Some((end, _)) => format!("{}…", &words[..end]),
        None => words.into(),
    }
}

fn items(sections: &mut [Section]) -> impl Iterator<Item = &mut Item> {
    sections.iter_mut().flat_map(|section| &mut section.items)
}

fn drawn(item: &mut Item) -> Option<&mut Plot> {
    if let Item::Plot(plot) = item { Some(plot.as_mut()) } else { None }
}

/// The words of a section that have a place: findings and cells of tables.
fn placed(section: &mut Section) -> impl Iterator<Item = (&String, &mut Place)> {
    let findings = section.warnings.iter_mut().filter_map(|one| Some((&one.words, one.place.as_mut()?)));
    let tables = section.items.iter_mut().filter_map(|item| match item {
        Item::Table(table) => Some(table),
        _ => None,
    });
    let cells = tables.flat_map(|table| table.rows.iter_mut().flatten());
    findings.chain(cells.filter_map(|cell| match cell {
        Cell::Placed(words, place) => Some((&*words, place)),
        _ => None,
    }))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::page::Table;
    use crate::page::plot::{Series, Toggle};

    #[test]
    fn words_lead_to_a_plot_of_their_recording_alone() {
        let mut section = Section::new("s", "S");
        let mut table = Table::new("Gaps", "gap");
        for recording in ["night", "day"] {
            table.rows.push(vec![Cell::Placed("a gap".into(), Place::new(recording, [7200.0, 10_800.0]))]);
        }
        for target in [Target::Effect("a lag".into()), Target::Section("s".into())] {
            table.rows.push(vec![Cell::Placed("words".into(), target.into())]);
        }
        let time = Timeline { recording: "day".into(), group: "day".into(), unit_s: 3600.0, epoch_s: None };
        let toggle = |name: &str| Toggle { name: name.into(), ..Toggle::default() };
        let toggles = vec![toggle("a step"), toggle("a lag")];
        let plot = Plot { time: Some(time), toggles, ..Plot::new("p", "P") };
        let plot = plot.with(Series::points("field", 0, &[0.0, 24.0], &[0.0; 2]));
        section.items.extend([Item::Table(table), Item::Plot(Box::new(plot))]);
        let mut sections = [section];
        link(&mut sections, |recordings| recordings.first().cloned());
        let [Item::Table(table), Item::Plot(plot)] = sections[0].items.as_slice() else {
            panic!("a table, a plot")
        };
        let link = |row: &Vec<Cell>| match &row[0] {
            Cell::Placed(_, place) => place.link.as_ref().map(|link| link.to.clone()),
            _ => None,
        };
        let links: Vec<Option<String>> = table.rows.iter().map(link).collect();
        assert_eq!(links, [None, Some("p".into()), Some("p".into()), Some("s".into())]);
        let ids: Vec<Option<&str>> = plot.toggles.iter().map(|toggle| toggle.id.as_deref()).collect();
        assert_eq!(ids, [None, Some("place-3")]);
        let mark = Interval { name: "a gap".into(), from: 2.0, to: 3.0, id: "place-2".into() };
        assert_eq!(plot.marks, [mark]);
    }

    #[test]
    fn plots_of_recordings_that_overlap_move_together() {
        let plot = |recording: &str, epoch_s: Option<f64>| {
            let time =
                Timeline { recording: recording.into(), group: recording.into(), unit_s: 3600.0, epoch_s };
            let plot = Plot { time: Some(time), ..Plot::new(recording, recording) };
            Item::Plot(Box::new(plot.with(Series::points("field", 0, &[0.0, 24.0], &[0.0; 2]))))
        };
        let day_s = 86_400.0;
        let mut sections = [Section {
            items: vec![
                plot("first", Some(9.0 * day_s)),
                plot("late", Some(9.5 * day_s)),
                plot("next", Some(10.6 * day_s)),
                plot("undated", None),
            ],
            ..Section::default()
        }];
        link(&mut sections, |_| None);
        let group = |item: &mut Item| drawn(item).and_then(|plot| Some(plot.time.as_ref()?.group.clone()));
        let groups: Vec<_> = items(&mut sections).filter_map(group).collect();
        assert_eq!(groups, ["first", "first", "next", "undated"]);
    }
}
