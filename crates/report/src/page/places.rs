//! From words to the plots that show what they speak of, and back.

use crate::page::plot::{Interval, Plot, Timeline};
use crate::page::{Cell, Item, Place, Section};

/// Gives the words of each place that a plot shows an id and the plot to lead to, and marks it in all plots of
/// its recording. Plots of recordings that began at the same time become one group.
pub fn link(sections: &mut [Section]) {
    let mut shown: Vec<(Timeline, String)> = Vec::new();
    for plot in items(sections).filter_map(drawn) {
        let Some(time) = &mut plot.time else { continue };
        let alike = |known: &&(Timeline, String)| time.epoch_s.is_some() && known.0.epoch_s == time.epoch_s;
        if let Some((known, _)) = shown.iter().find(alike) {
            time.group.clone_from(&known.group);
        }
        shown.push((time.clone(), plot.id.clone()));
    }
    let mut marks: Vec<(String, [f64; 2], Interval)> = Vec::new();
    for (words, place) in items(sections).flat_map(placed) {
        let Some((time, plot)) = shown.iter().find(|(time, _)| time.recording == place.recording) else {
            continue;
        };
        let id = format!("place-{}", marks.len() + 1);
        let mark = Interval { name: shortened(words), from: 0.0, to: 0.0, id: id.clone() };
        marks.push((place.recording.clone(), place.time_s, mark));
        place.link = Some([id, plot.clone(), time.group.clone()]);
    }
    for plot in items(sections).filter_map(drawn) {
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

/// The words of a table that have a place.
fn placed(item: &mut Item) -> Vec<(&String, &mut Place)> {
    let Item::Table(table) = item else { return Vec::new() };
    let cells = table.rows.iter_mut().flatten();
    cells
        .filter_map(|cell| match cell {
            Cell::Placed(words, place) => Some((&*words, place)),
            _ => None,
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::page::Table;

    #[test]
    fn words_lead_to_a_plot_of_their_recording_alone() {
        let mut section = Section::new("s", "S");
        let mut table = Table::new("Gaps", "gap");
        for recording in ["night", "day"] {
            table.rows.push(vec![Cell::Placed("a gap".into(), Place::new(recording, [7200.0, 10_800.0]))]);
        }
        let time = Timeline { recording: "day".into(), group: "day".into(), unit_s: 3600.0, epoch_s: None };
        let plot = Plot { time: Some(time), ..Plot::new("p", "P") };
        section.items.extend([Item::Table(table), Item::Plot(Box::new(plot))]);
        let mut sections = [section];
        link(&mut sections);
        let [Item::Table(table), Item::Plot(plot)] = sections[0].items.as_slice() else {
            panic!("a table, a plot")
        };
        let links: Vec<bool> = table
            .rows
            .iter()
            .map(|row| matches!(&row[0], Cell::Placed(_, place) if place.link.is_some()))
            .collect();
        assert_eq!(links, [false, true]);
        let mark = Interval { name: "a gap".into(), from: 2.0, to: 3.0, id: "place-1".into() };
        assert_eq!(plot.marks, [mark]);
    }
}
