//! What is said of a flight.

use common::number::{bare, counted, significant};
use common::{Code, Document, Finding, FlightTerm, Quantity};

use crate::terms::{Follows, Term};

pub fn term(term: Term) -> String {
    match term {
        Term::Turn(what) => turn(what, "the first camera", "the sensors"),
        Term::Offset(what) => format!("the offsets change {}", follows(what)),
        Term::Scale(what) => format!("the scale factors change {}", follows(what)),
        Term::Current(_) => "the field of a current".into(),
        Term::Sun => "a field that depends on the direction of the Sun".into(),
        Term::SunBeyond => "the same to the second degree".into(),
        Term::Readings => "the readings are shifted in time".into(),
        Term::Attitude => "the attitudes are shifted in time".into(),
        Term::Earth => "the times are not UTC".into(),
    }
}

pub fn turn(what: Follows, turned: &str, against: &str) -> String {
    format!("{turned} turns {} against {against}", follows(what))
}

fn follows(what: Follows) -> &'static str {
    match what {
        Follows::Temperature(_) => "with the temperature",
        Follows::Time => "with time",
    }
}

pub fn delay(term: Term, found: &FlightTerm, leap_s: Option<f64>) -> Option<Finding> {
    let (_, size) = found.parameters.first()?;
    let late = if size.value() > 0.0 { "late" } else { "early" };
    let by = abs(size);
    let words = match term {
        Term::Readings => format!(
            "the readings are {by} s {late} against field and attitude: correct `time_s` of the readings and run again; the fit allows for it to first order"
        ),
        Term::Attitude => format!(
            "the attitudes are {by} s {late}: correct their times and run again; the fit allows for it to first order"
        ),
        Term::Earth => {
            // GPS time had that of TAI less UTC in 1980, 19 s.
            let scales = leap_s.map(|leap| [(leap - 19.0, "GPS time"), (leap, "TAI")]);
            let scale = scales.iter().flatten().find(|(s, _)| (size.value() + s).abs() < 1.0);
            let scale = scale.map_or_else(
                || "check the time scale, and UT1 less UTC".to_string(),
                |(s, name)| format!("they seem to be {name}, {s} s more than UTC"),
            );
            format!(
                "the Earth's rotation is that of {by} s {} the stated times: {scale}",
                if size.value() > 0.0 { "after" } else { "before" }
            )
        }
        _ => return None,
    };
    Some(Code::ClockOffset.said(words))
}

fn abs(size: &Quantity) -> String {
    Quantity::new(size.value().abs(), size.std().unwrap_or(0.0)).to_string()
}

/// Words for people.
pub fn summary(document: &Document) -> String {
    let flight = document.calibration.as_ref().and_then(|calibration| calibration.flight.as_ref());
    let Some(flight) = flight else { return String::new() };
    let (rows, windows) = (counted(flight.rows as usize, "row"), counted(flight.windows as usize, "window"));
    let (field, hours) = (&flight.field, significant(flight.window_s / 3600.0, 2));
    let rms = significant(flight.rms_nt, 3);
    let without = match flight.terms.iter().all(|term| term.camera.is_some()) {
        true => String::new(),
        false => format!(", {} without what follows", significant(flight.rms_without_terms_nt, 3)),
    };
    let head = format!(
        "starcal: {rows} in {windows} of {hours} h, field of {field}; residual {rms} nT rms{without}"
    );
    let mut lines = vec![head];
    for camera in &flight.cameras {
        let angles = camera.angles_deg.each_ref().map(ToString::to_string).join(", ");
        let turns = camera.turn_std_arcsec.map(|std| significant(std, 2)).join(", ");
        lines.push(format!("  SEN to {}: {angles}° (± {turns}″ about its axes)", camera.camera));
    }
    let sensors = document.calibration.iter().filter_map(|calibration| calibration.sensors.as_ref());
    for (axis, sensor) in sensors.flat_map(|sensors| sensors.iter()) {
        if let (Some(k), Some(offset)) = (&sensor.sensitivity_nt_per_nt, &sensor.offset_nt) {
            lines.push(format!("  sensor {axis}: scale factor {k} nT/nT, offset {offset} nT"));
        }
    }
    for term in &flight.terms {
        let first = term.parameters.iter().take(3).map(|(name, size)| format!("{name} {size}"));
        let first = first.collect::<Vec<_>>().join(", ");
        let rest = term.parameters.len().saturating_sub(3);
        let rest = if rest > 0 { format!(" and {} more", bare(rest as f64)) } else { String::new() };
        let of = |one: &Option<String>| one.as_ref().map_or_else(String::new, |one| format!(", {one}"));
        let (camera, column, factor) =
            (of(&term.camera), of(&term.column), significant(term.log_bayes_factor, 2));
        lines.push(format!(
            "  {}{camera}{column}: {first}{rest} (ln of the Bayes factor {factor})",
            term.term
        ));
    }
    lines.extend(flight.findings.iter().map(|finding| format!("  {finding}")));
    lines.join("\n")
}
