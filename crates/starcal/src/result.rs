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
use crate::axes::no_axes;
use crate::fit::{Fit, Flight, Kinds};
use crate::heads::{First, Head};
use crate::layout::{Layout, Signal, WARM_C, WARM_K};
use crate::partial::Partial;
use crate::terms::{Follows, Term};
use crate::values::Values;
use crate::words;

const DAY_S: f64 = 86_400.0;
/// Intervals hold in flights of a month, and not in those of up to ten days (docs/starcal.md).
const LONG_DAYS: f64 = 20.0;

/// Writes the calibration into the document. Errors: a stated uncertainty that none can be.
pub fn put(
    document: &mut Document,
    partial: &Partial,
    (flight, first): (&Flight, &First),
    others: &[(Flight, Head)],
    (stated, mut findings): (&Matrix3<f64>, Findings),
) -> Result<(), Error> {
    let layout = &partial.layout;
    let heads: Vec<&Head> = others.iter().map(|(_, head)| head).collect();
    let mut values = Values::of(first, &heads, stated).ok_or_else(no_axes)?;
    let [freedom, _] = flight.freedom();
    let factor = stats::coverage_factor(0.95, freedom);

    let day = DAY_S / flight.half_span_s;
    let (mut at, mut told, mut adopted) = (12, Vec::new(), Vec::new());
    for (term, log_bayes_factor) in &first.terms {
        let names = term.parameters(layout, day);
        let parameters = parameters(&first.fit, at, &names, factor);
        let mut place = at;
        let effects = effects(*term, layout, &parameters);
        held(document, flight, layout, &mut values, (*term, at, &parameters));
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
        findings.extend(words::delay(*term, &one, flight.leap_s));
        told.push(one);
    }
    for (taken, other, factor) in &first.rivals {
        let column = other.column(layout).map_or_else(String::new, |column| format!(", {column}"));
        let words = format!(
            "\"{}\"{column} explains a part as well (ln of the Bayes factor {}), and cannot be separated from \"{}\"; record more of the flight",
            words::term(*other),
            significant(*factor, 2),
            words::term(*taken)
        );
        findings.push(Code::Ambiguous.said(words));
    }
    for (_, head) in others {
        told.extend(head_terms(head, layout, day, factor));
    }
    let own = values.joint();
    let quantity = |place: usize| {
        Quantity::new(values.values[place], own[(place, place)].max(0.0).sqrt()).covered_by(factor)
    };

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
    for axis in Axis::ALL {
        let paths = [uncertainty::sensitivity(axis, "nt"), uncertainty::sensor_offset(axis)];
        let sensor = written.entry(axis).get_or_insert_default();
        sensor.sensitivity_nt_per_nt = Some(quantity(axis.index()));
        sensor.offset_nt = Some(quantity(3 + axis.index()));
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

    let all = partial.rows + partial.missing + partial.blind + partial.odd;
    let rest = [
        (partial.missing, "lack a value"),
        (partial.blind, "have no attitude of the first camera"),
        (
            partial.odd,
            "have a quaternion of another length than 1, or readings whose magnitude is not that of the field",
        ),
    ];
    for (count, what) in rest.into_iter().filter(|(count, _)| *count > 0) {
        findings.push(Code::MissingSamples.said(format!("{count} of {all} rows {what} and are left out")));
    }
    let days = 2.0 * flight.half_span_s / DAY_S;
    if days < LONG_DAYS {
        let days = significant(days, 2);
        let words = format!(
            "the flight lasts {days} days: errors of the field's model may last longer, and are not in the uncertainties then; record a month"
        );
        findings.push(Code::TooFewDegreesOfFreedom.said(words));
    }
    let camera = |number: usize| {
        let other = number.checked_sub(1).map(|other| &others[other]);
        let (rows, variances, place) = match other {
            Some((flight, head)) => (flight.rows(), &head.fit.variances, head.camera),
            None => (flight.rows(), &first.fit.variances, 0),
        };
        let std = |head: &Head| [0, 1, 2].map(|k| head.covariance[(k, k)].sqrt());
        FlightCamera {
            camera: format!("camera_{}", layout.cameras[place]),
            rotation: frames::rows(&values.heads[number]),
            angles_deg: [0, 1, 2].map(|k| quantity(Values::angle(number, k))),
            turn_std_arcsec: values.turn_std(number),
            against_first_std_arcsec: other.map(|(_, head)| std(head)),
            residuals: residuals(&rows, variances),
            ..FlightCamera::default()
        }
    };
    let cameras = (0..=others.len()).map(camera).collect();
    calibration.flight = Some(Box::new(FlightCalibration {
        frame: layout.frame,
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
    if !adopted.is_empty() {
        document.model.get_or_insert_default().effects.extend(adopted);
    }
    Ok(())
}

/// Moves scale factors and offsets to the temperature at which they are to hold: the one that the document states, or the
/// mean of the flight, which is stated then.
fn held(
    document: &mut Document,
    flight: &Flight,
    layout: &Layout,
    values: &mut Values,
    (term, at, parameters): (Term, usize, &[(String, Quantity)]),
) {
    let (follows, is_offset) = match term {
        Term::Offset(follows) => (follows, true),
        Term::Scale(follows) => (follows, false),
        _ => return,
    };
    let Follows::Temperature(number) = follows else { return };
    let references =
        document.calibration.get_or_insert_default().reference_conditions.get_or_insert_default();
    let reference = if layout.temperatures[number].starts_with("electronics") {
        &mut references.electronics_temperature_c
    } else {
        &mut references.sensor_temperature_c
    };
    let mean = || WARM_C + WARM_K * flight.mean(layout, &Signal::Warmth(number));
    let warmer = *reference.get_or_insert_with(mean) - WARM_C;
    for (k, (_, size)) in parameters.iter().enumerate() {
        let rate = if is_offset { -warmer } else { -1e-6 * warmer * values.values[k] };
        values.shift(if is_offset { 3 + k } else { k }, rate * size.value(), at + k, rate);
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

fn head_terms(head: &Head, layout: &Layout, day: f64, factor: f64) -> Vec<FlightTerm> {
    let of = |(number, (follows, log_bayes_factor)): (usize, &(Follows, f64))| FlightTerm {
        term: words::turn(*follows, "this camera", "the first"),
        column: follows.column(layout).map(String::from),
        camera: Some(format!("camera_{}", layout.cameras[head.camera])),
        parameters: (parameters(&head.fit, 4 + 3 * number, &follows.parameters("arcsec", day), factor))
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
        // The first degree is an effect of its own, and there are no higher ones.
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
