//! Refuses what no facility can do and no machine can hold, with the place in the plan.

use common::{Axis, Error, PerAxis};
use physics::Basic;

use crate::plan::{AxesProcedure, Drive, FreeRun, Orientations, Plan, Procedure};

/// Rows that a campaign may have in all its recordings together.
const MOST_ROWS: f64 = 2e7;

/// Checks a whole plan before any recording is made.
pub fn plan(plan: &Plan, stated: &Basic) -> Result<(), Error> {
    if plan.procedures.is_empty() {
        return Err(Error::document("procedures", "an empty list", "at least one procedure"));
    }
    noise(plan)?;
    let mut rows = 0.0;
    for (index, procedure) in plan.procedures.iter().enumerate() {
        let path = format!("procedures[{index}]");
        rows += match procedure {
            Procedure::AxesOrientation(axes) => axes_orientation(axes, plan, stated, &path)?,
            Procedure::FreeRun(run) => free_run(run, plan, stated, &path)?,
        };
        if rows > MOST_ROWS {
            return Err(Error::document(
                path,
                format!("{rows:.3e} rows so far"),
                format!("at most {MOST_ROWS:.0e} in all"),
            ));
        }
    }
    Ok(())
}

fn positive(path: String, value: f64) -> Result<(), Error> {
    if value.is_finite() && value > 0.0 {
        Ok(())
    } else {
        Err(Error::document(path, value.to_string(), "a positive number"))
    }
}

fn noise(plan: &Plan) -> Result<(), Error> {
    let noise = plan.instrument.iter().flat_map(|instrument| Axis::ALL.map(|axis| instrument.noise_of(axis)));
    if noise.flatten().any(|noise| noise.flicker_nt2_per_hz_at_1hz.unwrap_or(0.0) > 0.0) {
        return Err(Error::document(
            "instrument.noise.flicker_nt2_per_hz_at_1hz",
            "flicker noise",
            "white noise only, which is what this version simulates; leave the flicker part out of the plan",
        ));
    }
    Ok(())
}

/// Rows of the procedure.
fn axes_orientation(axes: &AxesProcedure, plan: &Plan, stated: &Basic, path: &str) -> Result<f64, Error> {
    positive(format!("{path}.drive_nt"), axes.drive_nt)?;
    positive(format!("{path}.repeats"), axes.repeats as f64)?;
    if axes.drives.is_empty() {
        return Err(Error::document(format!("{path}.drives"), "an empty list", "at least one drive"));
    }
    let path_of = |key: &str| format!("{path}.{key}");
    if axes.fixture_std_arcmin < 0.0 {
        return Err(Error::document(
            path_of("fixture_std_arcmin"),
            "a negative number",
            "a standard deviation",
        ));
    }
    if axes.sensors.as_ref().is_some_and(Vec::is_empty) {
        return Err(Error::document(path_of("sensors"), "an empty list", "at least one sensor"));
    }
    if matches!(&axes.orientations, Orientations::List(list) if list.is_empty()) {
        return Err(Error::document(path_of("orientations"), "an empty list", "at least one orientation"));
    }
    let settings = match &axes.orientations {
        Orientations::Named(_) => 24.0,
        Orientations::List(list) => list.len() as f64,
    };
    let dither = axes.ac.as_ref().map_or(0.0, |ac| ac.dither_nt.abs());
    let rows = match &axes.ac {
        None => axes.repeats as f64,
        Some(ac) => {
            positive(format!("{path}.ac.hz"), ac.hz)?;
            positive(format!("{path}.ac.cycles"), ac.cycles)?;
            positive(format!("{path}.ac.rate_hz"), ac.rate_hz)?;
            let rows = ac.cycles / ac.hz * ac.rate_hz;
            if !(5.0..=MOST_ROWS).contains(&rows) {
                let found = format!("{rows:.3e} samples in one recording");
                return Err(Error::document(
                    format!("{path}.ac"),
                    found,
                    format!("at least 5 and at most {MOST_ROWS:.0e}"),
                ));
            }
            rows
        }
    };
    let zero = |drive: &Drive| matches!(drive, Drive::Named(name) if name == "zero");
    if axes.ac.is_some() && (axes.repeats != 1 || axes.drives.iter().any(zero)) {
        return Err(Error::document(
            path_of("ac"),
            "repeats or a drive \"zero\" beside ac",
            "neither; cycles repeat by themselves",
        ));
    }
    for axis in Axis::ALL {
        let named = axes.drives.iter().map(|drive| drive_on(drive, axis, axes.drive_nt)).fold(0.0, f64::max);
        within(plan, stated, axis, named.max(dither), &format!("{path}.drive_nt"))?;
    }
    Ok(rows * settings * axes.drives.len() as f64)
}

fn drive_on(drive: &Drive, axis: Axis, drive_nt: f64) -> f64 {
    match drive {
        Drive::Vector(vector) => vector[axis.index()].abs(),
        Drive::Named(name) if name.ends_with(axis.letter()) => drive_nt,
        Drive::Named(_) => 0.0,
    }
}

/// Rows of the run.
fn free_run(run: &FreeRun, plan: &Plan, stated: &Basic, path: &str) -> Result<f64, Error> {
    if let Some(name) =
        run.columns.keys().find(|name| name.starts_with("sensor_") && !name.contains("temperature"))
    {
        let path = format!("{path}.columns.{name}");
        return Err(Error::document(
            path,
            "a column of readings",
            "drive, times and temperatures only; the readings are simulated",
        ));
    }
    for axis in Axis::ALL {
        let Some(column) = run.columns.get(&format!("coil_{axis}_a")) else { continue };
        let largest = column.0.iter().map(|current| current.abs()).fold(0.0, f64::max);
        let constant = stated.coils[axis.index()].constant_nt_per_a;
        let field = if constant == 0.0 { largest } else { largest * constant.abs() };
        within(plan, stated, axis, field, &format!("{path}.columns.coil_{axis}_a"))?;
    }
    Ok(run.columns.values().map(|column| column.0.len()).max().unwrap_or(0) as f64)
}

/// The coil has a constant, and makes no more than the facility says.
fn within(plan: &Plan, stated: &Basic, axis: Axis, field_nt: f64, path: &str) -> Result<(), Error> {
    if field_nt > 0.0 && stated.coils[axis.index()].constant_nt_per_a == 0.0 {
        return Err(Error::document(
            path,
            format!("a drive of coil {axis}, whose constant is not stated"),
            format!("calibration.coils.{axis}.constant_nt_per_a in the plan"),
        ));
    }
    let coils = plan.facility.as_ref().and_then(|facility| facility.coils.as_ref());
    let max = coils.and_then(|coils: &PerAxis<_>| coils.get(axis)).and_then(|coil| coil.max_nt);
    match max.filter(|max| field_nt > *max) {
        Some(max) => Err(Error::document(
            path,
            format!("{field_nt} nT on coil {axis}"),
            format!("at most {max} nT, which is what facility.coils.{axis}.max_nt allows"),
        )),
        None => Ok(()),
    }
}
