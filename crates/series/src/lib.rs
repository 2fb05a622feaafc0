//! Recordings of a document as other recordings of it: cut, averaged over windows, resampled, joined to
//! common times, columns renamed. Nothing is estimated here: times are taken as each recording states them.

mod average;
mod cut;
mod join;
mod rename;
mod resample;

use common::{Document, Error, Recording};

pub use average::Average;
pub use cut::{Bound, Cut};
pub use join::Join;

/// What is done.
#[derive(Clone, Debug, PartialEq)]
pub enum Operation {
    /// Rows within an interval.
    Cut(Cut),
    /// Means over windows.
    Average(Average),
    /// Another step, s.
    Resample(f64),
    /// Old names of columns and new ones; a quantity such as `sensor` stands for all that begin with it.
    Rename(Vec<(String, String)>),
    /// Recordings made one.
    Join(Join),
}

/// What came of it.
#[derive(Debug)]
pub struct Outcome {
    /// The document.
    pub document: Document,
    /// Indices of the recordings that changed.
    pub changed: Vec<usize>,
    /// Words for people, a line each.
    pub words: Vec<String>,
}

/// Does something to the recordings with these ids; without any, to all that have readings.
/// Errors: an id that is not there; a recording that it cannot be done to, and why.
pub fn run(mut document: Document, ids: &[String], operation: &Operation) -> Result<Outcome, Error> {
    if let Operation::Join(join) = operation {
        return join.run(document);
    }
    let (mut changed, mut words) = (Vec::new(), Vec::new());
    for id in ids {
        index_of(&document, id)?;
    }
    for (index, recording) in document.recordings.iter_mut().enumerate() {
        let asked = if ids.is_empty() { !recording.columns.is_empty() } else { ids.contains(&recording.id) };
        if !asked {
            continue;
        }
        let path = format!("recordings[{index}]");
        recording.at_hand(&path)?;
        let said = match operation {
            Operation::Cut(cut) => cut.run(recording, &path)?,
            Operation::Average(average) => average.run(recording, &path)?,
            Operation::Resample(step_s) => resample::resample(recording, &path, *step_s)?,
            Operation::Rename(names) => rename::rename(recording, &path, names)?,
            Operation::Join(_) => continue,
        };
        words.push(format!("\"{}\": {said}", recording.id));
        changed.push(index);
    }
    if changed.is_empty() {
        let words = "the document has no recording with readings; expected one, as ingest makes it";
        return Err(Error::Request(words.into()));
    }
    document.check()?;
    Ok(Outcome { document, changed, words })
}

fn index_of(document: &Document, id: &str) -> Result<usize, Error> {
    document.recordings.iter().position(|recording| recording.id == id).ok_or_else(|| {
        let ids: Vec<&str> = document.recordings.iter().map(|one| one.id.as_str()).take(30).collect();
        let ids = ids.join(", ");
        Error::Request(format!("there is no recording \"{id}\" in the document; expected one of: {ids}"))
    })
}

/// The times of a recording: all there, and rising.
fn times<'a>(recording: &'a Recording, path: &str) -> Result<&'a [f64], Error> {
    let refused = |found: String, expected: &str| {
        Err(Error::document(format!("{path}.columns.time_s"), found, expected))
    };
    let Some(time) = recording.column("time_s") else {
        let expected = "the time of each row; ingest writes it where the file says it";
        return refused(format!("none in \"{}\"", recording.id), expected);
    };
    if let Some(row) = time.iter().position(|time| !time.is_finite()) {
        return refused(format!("none in row {row} of \"{}\"", recording.id), "the time of each row");
    }
    match time.windows(2).position(|pair| pair[1] <= pair[0]) {
        Some(row) => refused(
            format!("{} s after {} s in row {} of \"{}\"", time[row + 1], time[row], row + 1, recording.id),
            "increasing times; ingest --sort sorts rows by time",
        ),
        None => Ok(time),
    }
}

/// Where the first window of this length begins before the recording's zero, so that windows begin at whole
/// multiples in UTC; 0 for a recording that does not say when it began.
fn phase_s(recording: &Recording, length_s: f64) -> f64 {
    recording.start().map_or(0.0, |start| start.unix_s.rem_euclid(length_s))
}
