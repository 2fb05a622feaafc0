//! Instruments in recordings of their own, as one recording: what looks at one recording at a time then finds
//! them together.

use common::number::counted;
use common::{Axis, Code, Column, Columns, Document, Finding, Recording, procedure};

use super::grid::Grid;
use super::piece::Piece;
use super::{
    Error, Instrument, LEAST, NAMES, Result, earliest, of_procedure, onto, order, read, reads, times,
};

const SCALAR: &str = "reference_nt";

/// A document in which instruments that were recorded apart stand together.
#[derive(Clone, Debug)]
pub struct Gathered {
    /// The document.
    pub document: Document,
    /// What was done, in words.
    pub told: Vec<Finding>,
}

/// Joins reference and test instrument in recordings of their own, and vector and scalar magnetometer in
/// recordings of their own; None where nothing is apart.
/// Refused: recordings that have no moment in common; columns that are missing; times that are none.
pub fn gathered(document: &Document) -> Result<Option<Gathered>> {
    let pair = pair(document)?;
    let with_scalar = scalar(pair.as_ref().map_or(document, |pair| &pair.document))?;
    Ok(match (pair, with_scalar) {
        (Some(pair), Some(scalar)) => Some(Gathered { told: [pair.told, scalar.told].concat(), ..scalar }),
        (one, other) => one.or(other),
    })
}

fn pair(document: &Document) -> Result<Option<Gathered>> {
    let found = of_procedure(document, procedure::DIFFERENTIAL);
    if found.iter().all(|(_, recording)| reads(recording, NAMES[0]) == reads(recording, NAMES[1])) {
        return Ok(None);
    }
    let pair = read(document)?;
    let at = pair.times_s();
    let mut columns = Columns::new();
    columns.insert("time_s".into(), Column::from(at.clone()));
    for (name, read) in [(NAMES[0], &pair.reference[..]), (NAMES[1], &pair.test[..])] {
        for axis in Axis::ALL {
            let values = read[axis.index()].iter().zip(&pair.whole);
            let values = values.map(|(value, whole)| if *whole { *value } else { f64::NAN });
            columns.insert(format!("{name}_{axis}_nt"), values.collect());
        }
    }
    let test = found.iter().find(|(_, recording)| reads(recording, NAMES[1])).map_or(found[0], |test| *test);
    Ok(Some(put(document, &found, test.1, &at, columns, pair.told)?))
}

fn scalar(document: &Document) -> Result<Option<Gathered>> {
    let vector_unit = |recording: &Recording| {
        let all = |unit: &&str| {
            Axis::ALL.into_iter().all(|axis| recording.axis_column("sensor", axis, unit).is_some())
        };
        ["nt", "v"].into_iter().find(all)
    };
    let free = of_procedure(document, procedure::FREE_RUN);
    // In a coil, or in a field that is known, it is predicted by itself.
    let given = |recording: &Recording| {
        recording.columns.keys().any(|name| name.starts_with("coil_"))
            || Axis::ALL.into_iter().any(|axis| {
                let name = format!("ambient_{axis}_nt");
                recording.column(&name).is_some() || recording.conditions.extra.contains_key(&name)
            })
    };
    let only = |wanted: &dyn Fn(&Recording) -> bool| -> Vec<(usize, &Recording)> {
        free.iter().filter(|(_, of)| wanted(of)).copied().collect()
    };
    let vectors = only(&|of| vector_unit(of).is_some() && of.column(SCALAR).is_none() && !given(of));
    let scalars = only(&|of| of.column(SCALAR).is_some() && vector_unit(of).is_none());
    let (Some((_, first)), false) = (vectors.first(), scalars.is_empty()) else { return Ok(None) };
    let unit = vector_unit(first).unwrap_or("nt");
    let names = Axis::ALL.map(|axis| {
        let name = format!("sensor_{axis}_{unit}");
        let expected = format!("`{name}`, as in \"{}\"", first.id);
        (name, expected)
    });
    let all = [&vectors[..], &scalars[..]].concat();
    let start = earliest(&all)?;
    let instrument =
        |name: &'static str, of: &[(usize, &Recording)], names: &[(String, String)]| -> Result<Instrument> {
            let mut instrument = Instrument { name, pieces: Vec::new() };
            for (index, recording) in of {
                let path = format!("recordings[{index}]");
                let time = times(recording, &path, start)?;
                instrument.pieces.extend(Piece::of(recording, &path, names, &time)?);
            }
            order(&mut instrument)?;
            Ok(instrument)
        };
    let vector = instrument("vector", &vectors, &names)?;
    let expected = format!("`{SCALAR}`, the readings of the scalar magnetometer");
    let scalar = instrument("scalar", &scalars, &[(SCALAR.to_string(), expected)])?;
    let grid = Grid::of(&scalar, &vector).ok_or_else(|| scalar.apart_from(&vector))?;
    let reads = [grid.read(&scalar), grid.read(&vector)];
    let together = grid.whole(&reads).iter().filter(|whole| **whole).count();
    if together < LEAST {
        let found =
            format!("{} in which the vector and the scalar magnetometer read", counted(together, "row"));
        let expected = "at least five: do the two recordings overlap in time?";
        let path = format!("recordings[{}].columns", scalars[0].0);
        return Err(Error::document(path, found, expected));
    }
    let [of_scalar, of_vector] = reads;
    let at: Vec<f64> = (0..grid.rows).map(|row| grid.time_s(row)).collect();
    let mut columns = Columns::new();
    columns.insert("time_s".into(), Column::from(at.clone()));
    for ((name, _), values) in names.iter().zip(of_vector.columns) {
        columns.insert(name.clone(), values);
    }
    columns.extend(of_scalar.columns.into_iter().map(|values| (SCALAR.to_string(), values)));
    let mut told = [of_scalar.told, of_vector.told].concat();
    told.dedup();
    Ok(Some(put(document, &all, first, &at, columns, told)?))
}

/// The document with one recording in the place of several.
fn put(
    document: &Document,
    found: &[(usize, &Recording)],
    kept: &Recording,
    at: &[f64],
    mut columns: Columns,
    mut told: Vec<Finding>,
) -> Result<Gathered> {
    let start = earliest(found)?;
    let first = found.iter().find(|(_, of)| of.start().map(|own| own.unix_s) == start.map(|all| all.unix_s));
    let base = *first.unwrap_or(&found[0]);
    for other in found {
        let wanted = |name: &str| !instrument(name);
        for (name, read) in onto(base, *other, at, wanted)?.columns {
            let column = columns.entry(name).or_insert_with(|| Column::from(vec![f64::NAN; at.len()]));
            let missing = column.iter_mut().zip(&read).filter(|(value, _)| !value.is_finite());
            missing.for_each(|(value, read)| *value = *read);
        }
    }
    let ids: Vec<&str> = found.iter().map(|(_, recording)| recording.id.as_str()).collect();
    let joined = Recording {
        id: ids.join(" + "),
        start: start.and_then(|start| start.text()),
        columns,
        table: None,
        ..kept.clone()
    };
    let (recordings, moments) = (counted(ids.len(), "recording"), at.len());
    told.insert(
        0,
        Code::Joined
            .said(format!("\"{}\": {recordings} joined at {moments} moments by their times", joined.id)),
    );
    let mut document = document.clone();
    let first = found.iter().map(|(index, _)| *index).min().unwrap_or(0);
    document.recordings[first] = joined;
    let mut index = 0;
    document.recordings.retain(|_| {
        index += 1;
        index - 1 == first || found.iter().all(|(other, _)| *other != index - 1)
    });
    Ok(Gathered { document, told })
}

/// Whether a column is the reading of an instrument that is joined otherwise.
fn instrument(name: &str) -> bool {
    ["reference_", "test_", "third_", "sensor_"].iter().any(|prefix| name.starts_with(prefix))
        && (name.ends_with("_nt") || name.ends_with("_v"))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn field(t: f64) -> [f64; 3] {
        [
            20_000.0 + 30.0 * (t / 90.0).sin(),
            900.0 + 25.0 * (t / 70.0).cos(),
            43_000.0 + 20.0 * (t / 50.0).sin(),
        ]
    }

    fn recording(id: &str, procedure: &str, names: [&str; 3], time: &[f64]) -> Recording {
        let mut recording = Recording { id: id.into(), procedure: procedure.into(), ..Recording::default() };
        recording.columns.insert("time_s".into(), Column::from(time.to_vec()));
        for (axis, name) in names.iter().enumerate() {
            let values = time.iter().map(|t| field(*t)[axis]);
            recording.columns.insert((*name).into(), values.collect());
        }
        recording
    }

    fn even(rows: usize, step: f64, phase: f64) -> Vec<f64> {
        (0..rows).map(|row| phase + step * row as f64).collect()
    }

    fn document(recordings: Vec<Recording>) -> Document {
        Document { fluxcal: 1, recordings, ..Document::default() }
    }

    const REFERENCE: [&str; 3] = ["reference_x_nt", "reference_y_nt", "reference_z_nt"];
    const TEST: [&str; 3] = ["test_x_nt", "test_y_nt", "test_z_nt"];
    const SENSOR: [&str; 3] = ["sensor_x_nt", "sensor_y_nt", "sensor_z_nt"];

    #[test]
    fn a_pair_of_two_rates_and_phases_is_one_recording_at_the_slower_ones_moments() {
        let reference = recording("a", procedure::DIFFERENTIAL, REFERENCE, &even(2000, 0.4, 0.13));
        let mut test = recording("b", procedure::DIFFERENTIAL, TEST, &even(700, 1.0, 30.5));
        test.columns.insert("test_temperature_c".into(), Column::from(even(700, 0.01, 20.0)));
        let found = gathered(&document(vec![reference, test])).expect("joined").expect("apart");
        let [joined] = &found.document.recordings[..] else { panic!("one recording") };
        assert_eq!(joined.id, "a + b");
        let time = joined.column("time_s").expect("times");
        assert_eq!(time[0], 30.5);
        for (row, t) in time.iter().enumerate() {
            for axis in Axis::ALL {
                for name in ["reference", "test"] {
                    let read = joined.axis_column(name, axis, "nt").expect("readings")[row];
                    let known = field(*t)[axis.index()];
                    let near = read.is_nan() || (read - known).abs() < 2e-3;
                    assert!(near, "{name} {axis} {row}: {read} {known}");
                }
            }
            let warm = joined.column("test_temperature_c").expect("temperatures")[row];
            assert!((warm - 20.0 - 0.01 * (t - 30.5)).abs() < 1e-9);
        }
        let together = recording("a", procedure::DIFFERENTIAL, REFERENCE, &even(50, 1.0, 0.0));
        let mut both = together.clone();
        both.columns.extend(recording("b", procedure::DIFFERENTIAL, TEST, &even(50, 1.0, 0.0)).columns);
        assert!(gathered(&document(vec![both])).expect("read").is_none());
    }

    #[test]
    fn a_scalar_magnetometer_of_its_own_times_joins_the_vector() {
        let vector = recording("v", procedure::FREE_RUN, SENSOR, &even(600, 1.0, 0.0));
        let scalar = |phase: f64| {
            let mut scalar = recording("s", procedure::FREE_RUN, SENSOR, &even(120, 5.0, phase));
            scalar.columns.retain(|name, _| name == "time_s");
            let length = |t: &f64| field(*t).iter().map(|b| b * b).sum::<f64>().sqrt();
            scalar.columns.insert(SCALAR.into(), even(120, 5.0, phase).iter().map(length).collect());
            scalar
        };
        let found = gathered(&document(vec![vector.clone(), scalar(2.3)])).expect("joined").expect("apart");
        let joined = &found.document.recordings[0];
        assert_eq!(found.document.recordings.len(), 1);
        let (time, length) =
            (joined.column("time_s").expect("times"), joined.column(SCALAR).expect("scalar"));
        assert!((time[1] - time[0] - 5.0).abs() < 1e-9, "the slower one's");
        let known =
            |row: usize| (0..3).map(|axis| joined.column(SENSOR[axis]).expect("x")[row].powi(2)).sum::<f64>();
        let off = (0..time.len()).map(|row| known(row).sqrt() - length[row]).filter(|off| off.is_finite());
        assert!(off.map(f64::abs).fold(0.0, f64::max) < 0.05);
        let never = gathered(&document(vec![vector, scalar(5000.0)])).expect_err("never together");
        let said = "readings of the vector instrument from 0 s to 9.983 min, of the scalar from 83.33 min";
        assert!(never.to_string().contains(said), "{never}");
    }
}
