//! What was found, as the document has it.

use common::number::significant;
use common::uncertainty::{self, Block};
use common::{
    AdoptedEffect, Axis, Code, Document, Findings, FlightCalibration, FlightCamera, FlightResidual,
    FlightTerm, Quantity, Uncertainty, covariance,
};
use estimate::stats;
use nalgebra::Matrix3;
use physics::frames;

use crate::Error;
use crate::fit::{Fit, Flight, Kinds};
use crate::heads::{First, Head};
use crate::layout::{Layout, WARM_C};
use crate::partial::Partial;
use crate::terms::{Follows, Term};
use crate::values::Values;
use crate::words;

const DAY_S: f64 = 86_400.0;
/// Fewer windows than this hardly tell an uncertainty.
const FEW: usize = 8;

/// Writes the calibration into the document.
///
/// Errors: a stated uncertainty that none can be.
pub fn put(
    document: &mut Document,
    partial: &Partial,
    (flight, first): (&Flight, &First),
    others: &[(Flight, Head)],
    stated: &Matrix3<f64>,
) -> Result<(), Error> {
    let layout = &partial.layout;
    let heads: Vec<&Head> = others.iter().map(|(_, head)| head).collect();
    let flat =
        || Error::Unanswerable("the sensors lie in a plane by what was found; check the columns".into());
    let mut values = Values::of(first, &heads, stated).ok_or_else(flat)?;
    let [freedom, _] = flight.freedom();
    let factor = stats::coverage_factor(0.95, freedom);
    let own = values.joint();
    let quantity = |place: usize| {
        Quantity::new(values.values[place], own[(place, place)].max(0.0).sqrt()).covered_by(factor)
    };
    let sensors = [0, 1, 2].map(|k| [quantity(k), quantity(3 + k)]);
    let angles: Vec<[Quantity; 3]> =
        (0..=others.len()).map(|camera| [0, 1, 2].map(|k| quantity(Values::angle(camera, k)))).collect();

    // Terms, and those that are effects of the catalogue.
    let day = DAY_S / flight.half_span_s;
    let (mut at, mut told, mut adopted, mut findings) = (12, Vec::new(), Vec::new(), Findings::default());
    for (term, log_bayes_factor) in &first.terms {
        let names = term.parameters(layout, day);
        let parameters = parameters(&first.fit, at, &names, factor);
        let mut place = at;
        let effects = effects(*term, layout, &parameters);
        for effect in &effects {
            for (name, _) in effect.parameters.iter().filter(|(_, size)| size.std().is_some()) {
                values.add(uncertainty::effect(effect, name), place);
                place += 1;
            }
        }
        at += names.len();
        adopted.extend(effects);
        let one = FlightTerm {
            term: words::term(*term),
            effect: term.kind(layout).map(|kind| kind.name().to_string()),
            column: term.column(layout).map(String::from),
            parameters: parameters.into_iter().collect(),
            log_bayes_factor: *log_bayes_factor,
            ..FlightTerm::default()
        };
        findings.extend(words::delay(*term, &one));
        told.push(one);
    }
    for (taken, other, factor) in &first.rivals {
        let column = other.column(layout).map_or_else(String::new, |column| format!(", {column}"));
        let words = format!(
            "\"{}\"{column} explains a part as well (ln of the Bayes factor {}), and cannot be told beside \"{}\"; record more of the flight",
            words::term(*other),
            significant(*factor, 2),
            words::term(*taken)
        );
        findings.push(Code::Ambiguous.said(words));
    }
    for (number, (_, head)) in others.iter().enumerate() {
        told.extend(head_terms(head, layout, number + 1, day, factor));
    }

    let mut joint = Uncertainty::of(document)?;
    let block = Block {
        name: "flight: readings, attitudes and field".into(),
        degrees_of_freedom: freedom,
        covariance: values.joint(),
        parameters: values.names.clone(),
        by: Vec::new(),
    };
    joint
        .put(block)
        .map_err(|wrong| Error::Unanswerable(format!("the covariance of the calibration is {wrong}")))?;
    joint.forget(&Axis::ALL.map(uncertainty::added_offset));

    let calibration = document.calibration.get_or_insert_default();
    let written = calibration.sensors.get_or_insert_default();
    for (axis, [k, offset]) in Axis::ALL.into_iter().zip(sensors) {
        let paths = [uncertainty::sensitivity(axis, "nt"), uncertainty::sensor_offset(axis)];
        let sensor = written.entry(axis).get_or_insert_default();
        sensor.sensitivity_nt_per_nt = Some(k);
        sensor.offset_nt = Some(offset);
        sensor.covariance = Some(covariance::rows(&joint.covariance(&paths)));
        sensor.covariance_order = Some(vec!["sensitivity_nt_per_nt".into(), "offset_nt".into()]);
    }
    let written = calibration.axes.get_or_insert_default();
    let cosines = joint.covariance(&uncertainty::directions("sensors"));
    let mut directions = physics::directions(&Axis::ALL, &first.axes.mu, &cosines);
    directions.extra = written.sensors.take().map(|before| before.extra).unwrap_or_default();
    written.sensors = Some(directions);
    written.offsets_nt = None;
    written.cross_covariance = None;
    calibration.uncertainty = Some(joint);

    let rest = [
        (partial.missing, "lack a value"),
        (partial.blind, "have no attitude of the first camera"),
        (partial.odd, "have no unit quaternion, or a magnitude that is not that of the field"),
    ];
    for (count, what) in rest.into_iter().filter(|(count, _)| *count > 0) {
        let words = format!("{count} of {} rows {what} and are left out", count + partial.rows);
        findings.push(Code::MissingSamples.said(words));
    }
    if flight.windows() < FEW {
        let count = flight.windows();
        let words = format!("{count} windows of time are few for an uncertainty; record more of the flight");
        findings.push(Code::TooFewDegreesOfFreedom.said(words));
    }
    let camera = |(number, angles_deg): (usize, [Quantity; 3])| {
        let other = number.checked_sub(1).map(|other| &others[other]);
        let (rows, variances) = match other {
            Some((flight, head)) => (flight.rows(), &head.fit.variances),
            None => (flight.rows(), &first.fit.variances),
        };
        let std = |head: &Head| [0, 1, 2].map(|k| head.covariance[(k, k)].sqrt());
        FlightCamera {
            camera: format!("camera_{}", layout.cameras[number]),
            rotation: frames::rows(&values.heads[number]),
            angles_deg,
            turn_std_arcsec: values.turns(number),
            against_first_std_arcsec: other.map(|(_, head)| std(head)),
            residuals: residuals(&rows, variances),
            ..FlightCamera::default()
        }
    };
    let cameras = angles.into_iter().enumerate().map(camera).collect();
    calibration.flight = Some(Box::new(FlightCalibration {
        frame: layout.frame.clone(),
        field: layout.field.clone(),
        rows: partial.rows,
        windows: flight.windows() as u64,
        window_s: partial.width_s(),
        degrees_of_freedom: freedom,
        cameras,
        terms: told,
        rms_without_terms_nt: rms(&flight.rows(), &first.without.variances),
        rms_nt: rms(&flight.rows(), &first.fit.variances),
        findings,
        ..FlightCalibration::default()
    }));
    adopt(document, adopted);
    Ok(())
}

/// Puts effects into the model. Constants hold at 20 °C, or are moved to the temperature that the document states.
fn adopt(document: &mut Document, adopted: Vec<AdoptedEffect>) {
    let calibration = document.calibration.get_or_insert_default();
    for effect in &adopted {
        let Some(of) = effect.effect.strip_suffix("_temperature") else { continue };
        let references = calibration.reference_conditions.get_or_insert_default();
        let reference = if of.ends_with("_electronics") {
            &mut references.electronics_temperature_c
        } else {
            &mut references.sensor_temperature_c
        };
        let warmer = *reference.get_or_insert(WARM_C) - WARM_C;
        let sensor = effect.sensor.zip(calibration.sensors.as_mut());
        let (Some((axis, sensors)), Some(size)) = (sensor, effect.parameters.values().next()) else {
            continue;
        };
        let sensor = sensors.entry(axis).get_or_insert_default();
        let (by, is_offset) = (warmer * size.value(), of.starts_with("offset"));
        let place = if is_offset { &mut sensor.offset_nt } else { &mut sensor.sensitivity_nt_per_nt };
        if let Some(before) = place.take() {
            let value = before.value();
            let value = if is_offset { value - by } else { value / (1.0 + 1e-6 * by) };
            let factor = before.coverage_factor_95().unwrap_or(1.96);
            *place = Some(Quantity::new(value, before.std().unwrap_or(0.0)).covered_by(factor));
        }
    }
    if !adopted.is_empty() {
        let model = &mut document.model.get_or_insert_default().effects;
        let of = |one: &AdoptedEffect| (one.effect.clone(), one.sensor, one.column.clone());
        model.retain(|one| !adopted.iter().any(|other| of(one) == of(other)));
        model.extend(adopted);
    }
}

/// Values of a fit from a place on, by names and units.
fn parameters(fit: &Fit, at: usize, names: &[(String, f64)], factor: f64) -> Vec<(String, Quantity)> {
    let of = |(k, (name, unit)): (usize, &(String, f64))| {
        let std = fit.covariance[(at + k, at + k)].sqrt() * unit;
        (name.clone(), Quantity::new(fit.values[at + k] * unit, std).covered_by(factor))
    };
    names.iter().enumerate().map(of).collect()
}

/// The terms of another head.
fn head_terms(head: &Head, layout: &Layout, camera: usize, day: f64, factor: f64) -> Vec<FlightTerm> {
    let of = |(number, (follows, log_bayes_factor)): (usize, &(Follows, f64))| FlightTerm {
        term: words::turn(*follows, "this camera", "the first"),
        column: follows.column(layout).map(String::from),
        camera: Some(format!("camera_{}", layout.cameras[camera])),
        parameters: parameters(&head.fit, 4 + 3 * number, &follows.parameters("arcsec", day), factor)
            .into_iter()
            .collect(),
        log_bayes_factor: *log_bayes_factor,
        ..FlightTerm::default()
    };
    head.terms.iter().enumerate().map(of).collect()
}

/// The effects of the catalogue that a term is.
fn effects(term: Term, layout: &Layout, parameters: &[(String, Quantity)]) -> Vec<AdoptedEffect> {
    let Some(kind) = term.kind(layout) else { return Vec::new() };
    let of = |sensor: Option<Axis>, column: Option<&str>, own: &[(String, Quantity)]| AdoptedEffect {
        effect: kind.name().into(),
        sensor,
        column: column.map(String::from),
        parameters: own.iter().cloned().collect(),
        extra: [("found_by".to_string(), "starcal".into())].into_iter().collect(),
        ..AdoptedEffect::default()
    };
    let names = kind.parameters().iter().map(|info| info.name.to_string());
    match term {
        Term::Offset(_) | Term::Scale(_) => {
            let name = kind.parameters()[0].name.to_string();
            let single = Axis::ALL.into_iter().zip(parameters);
            single.map(|(axis, (_, size))| of(Some(axis), None, &[(name.clone(), size.clone())])).collect()
        }
        Term::Current(_) => vec![of(None, term.column(layout), parameters)],
        // The first degree is an effect of its own.
        Term::SunBeyond => {
            let known = |name: String| {
                let found = parameters.iter().find(|(own, _)| *own == name);
                found.cloned().unwrap_or((name, Quantity::Bare(0.0)))
            };
            vec![of(None, None, &names.map(known).collect::<Vec<_>>())]
        }
        _ => vec![of(None, None, parameters)],
    }
}

fn residuals(rows: &Kinds, variances: &Kinds) -> Vec<FlightResidual> {
    let of = |(place, name): (usize, &str)| {
        let [along, across, towards] = variances[place].map(f64::sqrt);
        FlightResidual {
            place: name.into(),
            rows: rows[place][0] as u64,
            along_nt: along,
            across_nt: across,
            towards_boresight_nt: towards,
        }
    };
    ["quiet", "disturbed"].into_iter().enumerate().map(of).filter(|one| one.rows > 0).collect()
}

/// Rms of the residual in quiet rows, all directions.
fn rms(rows: &Kinds, variances: &Kinds) -> f64 {
    let place = usize::from(rows[0][0] == 0.0);
    let squares: f64 =
        variances[place].iter().zip(&rows[place]).map(|(variance, rows)| variance * rows).sum();
    (squares / rows[place].iter().sum::<f64>().max(1.0)).sqrt()
}
