//! From words to the plots that show what they speak of, and back.

use crate::page::number;
use crate::page::plot::{Interval, Plot, Timeline};
use crate::page::{Cell, Item, Link, Place, Section, Target};

struct Shown {
    time: Timeline,
    /// Its ends as moments, s.
    ends: [f64; 2],
    plot: String,
}

impl Shown {
    /// Of the same recording, or of one that overlaps in time.
    fn is_beside(&self, other: &Self) -> bool {
        let dated = self.time.epoch_s.is_some() && other.time.epoch_s.is_some();
        let overlap = self.ends[0] < other.ends[1] && other.ends[0] < self.ends[1];
        self.time.recording == other.time.recording || (dated && overlap)
    }
}

#[derive(Default)]
struct Links {
    shown: Vec<Shown>,
    /// Effects that can be switched off, with their plots.
    effects: Vec<(String, String)>,
    /// Intervals that are spoken of, by their recordings, in its time.
    marks: Vec<(String, Interval)>,
    /// Effects that are spoken of, by number of the diagnosis and name, with the ids of the words.
    named: Vec<(usize, String, String)>,
}

/// Gives words that speak of a place an id and a link to the plot that shows it. Plots of one recording mark its
/// intervals; plots of recordings that overlap in time become one group. `earliest` tells which of some
/// recordings began first.
pub fn link(sections: &mut [Section], earliest: impl Fn(&[String]) -> Option<String>) {
    let mut links = Links::default();
    items(sections).filter_map(drawn).for_each(|plot| links.add(plot));
    for (number, (words, place)) in sections.iter_mut().flat_map(placed).enumerate() {
        let id = format!("place-{}", number + 1);
        place.link = match &place.of {
            Target::Section(section) => Some(Link { to: section.clone(), ..Link::default() }),
            Target::Effect(number, name) => links.effect(*number, name, id),
            Target::Interval(_, time_s) if !time_s.iter().all(|time| time.is_finite()) => None,
            Target::Interval(recordings, time_s) => {
                earliest(recordings).and_then(|recording| links.interval(recording, *time_s, words, id))
            }
        };
    }
    items(sections).filter_map(drawn).for_each(|plot| links.mark(plot));
}

impl Links {
    /// Knows a plot, and puts it into its group.
    fn add(&mut self, plot: &Plot) {
        self.effects.extend(plot.toggles.iter().map(|toggle| (toggle.name.clone(), plot.id.clone())));
        let ends = number::ends(plot.series.iter().flat_map(|series| &series.points).map(|point| point.x));
        let (Some(time), Some(ends)) = (&plot.time, ends) else { return };
        let ends = ends.map(|end| time.moment(end * time.unit_s));
        let shown = Shown { time: time.clone(), ends, plot: plot.id.clone() };
        // It may bridge several groups, which become the first of them.
        let beside = self.shown.iter().filter(|known| known.is_beside(&shown));
        let groups: Vec<String> = beside.map(|known| known.time.group.clone()).collect();
        self.shown.push(shown);
        let Some(first) = groups.first() else { return };
        let own = self.shown.len() - 1;
        for (number, known) in self.shown.iter_mut().enumerate() {
            if number == own || groups.contains(&known.time.group) {
                known.time.group.clone_from(first);
            }
        }
    }

    fn effect(&mut self, number: usize, name: &str, id: String) -> Option<Link> {
        let (_, plot) = self.effects.iter().find(|(known, plot)| known == name && is_of(plot, number))?;
        self.named.push((number, name.into(), id.clone()));
        Some(Link { id: Some(id), to: plot.clone(), shown: None })
    }

    fn interval(&mut self, recording: String, [from, to]: [f64; 2], words: &str, id: String) -> Option<Link> {
        let Shown { time, plot, .. } = self.shown.iter().find(|shown| shown.time.recording == recording)?;
        let mark = Interval { name: shortened(words), from, to, id: id.clone() };
        let same = |known: &Interval| (&known.name, known.from, known.to) == (&mark.name, from, to);
        if !self.marks.iter().any(|(of, known)| *of == recording && same(known)) {
            self.marks.push((recording, mark));
        }
        let shown = (time.group.clone(), [from, to].map(|own| time.moment(own)));
        Some(Link { id: Some(id), to: plot.clone(), shown: Some(shown) })
    }

    /// Marks in a plot what is spoken of.
    fn mark(&self, plot: &mut Plot) {
        for toggle in &mut plot.toggles {
            let speaks = |(number, name, _): &&(usize, String, String)| {
                *name == toggle.name && is_of(&plot.id, *number)
            };
            toggle.id = self.named.iter().find(speaks).map(|(.., id)| id.clone());
        }
        let Some(Timeline { recording, unit_s, group, .. }) = &mut plot.time else { return };
        if let Some(shown) = self.shown.iter().find(|shown| shown.plot == plot.id) {
            group.clone_from(&shown.time.group);
        }
        let own = self.marks.iter().filter(|(of, _)| of == recording);
        plot.marks = own
            .map(|(_, mark)| Interval { from: mark.from / *unit_s, to: mark.to / *unit_s, ..mark.clone() })
            .collect();
    }
}

/// The beginning of the ids of a diagnosis' plots.
pub fn diagnosis(number: usize) -> String {
    format!("residual-{number}")
}

fn is_of(plot: &str, number: usize) -> bool {
    plot.strip_prefix(&diagnosis(number)).is_some_and(|rest| rest.starts_with('-'))
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

    /// A plot of a day of a recording, in hours.
    fn plot(id: &str, recording: &str, epoch_s: Option<f64>) -> Item {
        let time = Timeline { recording: recording.into(), group: recording.into(), unit_s: 3600.0, epoch_s };
        let plot = Plot { time: Some(time), ..Plot::new(id, id) };
        Item::Plot(Box::new(plot.with(Series::points("field", 0, &[0.0, 24.0], &[0.0; 2]))))
    }

    #[test]
    fn words_lead_to_a_plot_of_their_recording_alone() {
        let mut section = Section::new("s", "S");
        let mut table = Table::new("Gaps", "gap");
        let gap = |recording: &str| Target::Interval(vec![recording.into()], [7200.0, 10_800.0]);
        for target in
            [gap("night"), gap("day"), Target::Effect(1, "a lag".into()), Target::Section("s".into())]
        {
            table.rows.push(vec![Cell::Placed("a gap".into(), target.into())]);
        }
        let toggle = |name: &str| Toggle { name: name.into(), ..Toggle::default() };
        let toggles = vec![toggle("a step"), toggle("a lag")];
        section.items.push(Item::Table(table));
        let Item::Plot(plot) = plot("residual-1-1", "day", None) else { panic!("a plot") };
        section.items.push(Item::Plot(Box::new(Plot { toggles, ..*plot })));
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
        let plot_id = || Some("residual-1-1".to_string());
        assert_eq!(links, [None, plot_id(), plot_id(), Some("s".into())]);
        let ids: Vec<Option<&str>> = plot.toggles.iter().map(|toggle| toggle.id.as_deref()).collect();
        assert_eq!(ids, [None, Some("place-3")]);
        let mark = Interval { name: "a gap".into(), from: 2.0, to: 3.0, id: "place-2".into() };
        assert_eq!(plot.marks, [mark]);
    }

    #[test]
    fn plots_of_recordings_that_overlap_move_together() {
        let days = [("first", 9.0), ("late", 9.5), ("next", 10.6), ("far", 12.0), ("bridge", 11.3)];
        let dated = days.map(|(recording, day)| plot(recording, recording, Some(86_400.0 * day)));
        let items = dated.into_iter().chain([plot("undated", "undated", None)]).collect();
        let mut sections = [Section { items, ..Section::default() }];
        link(&mut sections, |_| None);
        let group = |item: &mut Item| drawn(item).and_then(|plot| Some(plot.time.as_ref()?.group.clone()));
        let groups: Vec<_> = super::items(&mut sections).filter_map(group).collect();
        assert_eq!(groups, ["first", "first", "next", "next", "next", "undated"]);
    }
}
