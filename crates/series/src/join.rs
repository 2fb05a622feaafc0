//! Recordings with times of their own made one with common times.

use common::number::{bare, counted};
use common::{Document, Error};

use joined::onto;

use crate::resample::said;
use crate::{Outcome, index_of, times};

/// Recordings that become one.
#[derive(Clone, Debug, PartialEq)]
pub struct Join {
    /// Their ids; the times are those of the first.
    pub ids: Vec<String>,
    /// The id of what they become; None: that of the first.
    pub id: Option<String>,
    /// Its procedure; None: that of the first.
    pub procedure: Option<String>,
}

impl Join {
    /// Joins recordings: the columns of the others are read at the times of the first, and the others go.
    pub fn run(&self, mut document: Document) -> Result<Outcome, Error> {
        let mut places = Vec::new();
        for id in &self.ids {
            let place = index_of(&document, id)?;
            if places.contains(&place) {
                return Err(Error::Request(format!("\"{id}\" twice; expected each recording once")));
            }
            document.recordings[place].at_hand(&format!("recordings[{place}]"))?;
            places.push(place);
        }
        let [first, others @ ..] = places.as_slice() else { return Err(too_few()) };
        if others.is_empty() {
            return Err(too_few());
        }
        let base = &document.recordings[*first];
        let at = times(base, &format!("recordings[{first}]"))?.to_vec();
        let mut joined = base.clone();
        let mut words = Vec::new();
        for place in others {
            let (path, other) = (format!("recordings[{place}]"), &document.recordings[*place]);
            for name in other.columns.keys().filter(|name| *name != "time_s") {
                if joined.columns.contains_key(name) {
                    let found = format!("{name}, which \"{}\" has too", base.id);
                    let (id, head) =
                        (&other.id, name.split_once('_').map_or(name.as_str(), |(head, _)| head));
                    let expected = format!(
                        "each name once; rename them first: series rename --recording {id} {head}=NEW"
                    );
                    return Err(Error::document(format!("{path}.columns"), found, expected));
                }
            }
            let read = onto((*first, base), (*place, other), &at, |_| true)?;
            if read.there == 0 {
                let message = format!(
                    "\"{}\" and \"{}\" have no time in common; expected recordings that overlap. Are both clocks in UTC?",
                    base.id, other.id
                );
                return Err(Error::Request(message));
            }
            let rate = read.own_step_s.map_or(String::new(), |own_s| format!(" of {} s", bare(own_s)));
            let (there, times, ways) = (read.there, counted(at.len(), "time"), said(&read.ways));
            words.push(format!(
                "\"{}\"{rate} read at {there} of the {times} of \"{}\"{ways}; its clock is taken as it is",
                other.id, base.id
            ));
            joined.columns.extend(read.columns);
        }
        joined.id = self.id.clone().unwrap_or(joined.id);
        joined.procedure = self.procedure.clone().unwrap_or(joined.procedure);
        document.recordings[*first] = joined;
        let mut gone = others.to_vec();
        gone.sort_unstable();
        gone.iter().rev().for_each(|place| drop(document.recordings.remove(*place)));
        let place = first - gone.iter().filter(|place| place < &first).count();
        document.check()?;
        Ok(Outcome { document, changed: vec![place], words })
    }
}

fn too_few() -> Error {
    Error::Request(
        "fewer than two recordings; expected the ids of those that become one, as in: series join one two"
            .into(),
    )
}
