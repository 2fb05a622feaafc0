//! One magnetometer against another: matrix, difference, drift, noise, the fourteen parameters.

use common::{
    Axis, DifferenceAxis, DifferentialCalibration, DifferentialFit, Document, DriftForm, EventInstrument,
    EventKind, FourteenParameters, Matrix3x3, Recording,
};

use super::clock::Clock;
use super::common_words::{counted, sentence};
use super::differential_matrix;
use crate::plot::{Dimension, Mark, Plot, Series};
use crate::{Cell, Section, Table, number};

pub fn section(document: &Document) -> Option<Section> {
    let found = document.calibration.as_ref()?.differential.as_ref()?;
    let mut section = Section::new("differential", "Two magnetometers side by side");
    section.words.push("T = R η + d: what the test instrument reads, from what the reference reads.".into());
    section.table(matrix(found));
    if let Some(fit) = &found.fit {
        section.words.push(format!(
            "{} of {} s in {}, {} left out. {}",
            counted(fit.samples, "sample"),
            number::bare(fit.step_s),
            fit.recordings.join(", "),
            fit.missing,
            sentence(&fit.quoted)
        ));
        section.warnings.extend(fit.findings.iter().cloned());
        if let (Some(matrix), [id]) = (&found.matrix, fit.recordings.as_slice()) {
            let recording = document.recordings.iter().find(|recording| recording.id == *id);
            let difference = |axis| difference(recording?, matrix, axis, fit.axes.get(axis));
            Axis::ALL.into_iter().filter_map(difference).for_each(|plot| section.plot(plot));
        }
        axes(&mut section, found, fit);
        section.plot(allan(fit));
        if let Some(matrix) = &found.matrix {
            differential_matrix::stability(&mut section, fit, matrix);
        }
        reference_noise(&mut section, fit);
        clock(&mut section, fit);
        kept_out(&mut section, fit);
    }
    if let Some(fourteen) = &found.fourteen {
        self::fourteen(&mut section, fourteen);
    }
    (!section.items.is_empty()).then_some(section)
}

fn matrix(found: &DifferentialCalibration) -> Table {
    let mut table = Table::new(
        "Matrix η, element by element",
        [
            ("element", ""),
            ("η", ""),
            ("least squares alone", ""),
            ("its std if errors were independent", ""),
            ("its std by Newey and West", ""),
            ("its std under the fitted noise", ""),
        ],
    );
    let Some(matrix) = &found.matrix else { return table };
    let variance = |i: usize, j: usize| {
        let place =
            found.covariance_order.as_ref()?.iter().position(|key| *key == format!("matrix[{i}][{j}]"))?;
        found.covariance.as_ref()?.get(place)?.get(place).copied()
    };
    let figures = |std: Option<f64>| std.map_or(Cell::Empty, |std| Cell::Figures(std, 2));
    for test in Axis::ALL {
        for reference in Axis::ALL {
            let (i, j) = (reference.index(), test.index());
            let value = matrix[i][j];
            let whole = variance(i, j)
                .map_or(Cell::Number(value), |variance| Cell::Uncertain { value, std: variance.sqrt() });
            let element = found.fit.as_ref().and_then(|fit| fit.elements.get(&format!("{reference}{test}")));
            table.row([
                format!("reference {reference} to test {test}").into(),
                whole,
                element.map(|element| element.least_squares).into(),
                figures(element.map(|element| element.std_independent)),
                figures(element.and_then(|element| element.std_newey_west)),
                figures(element.map(|element| element.std_noise)),
            ]);
        }
    }
    table
}

/// d less its mean as it was recorded, with the fitted drift.
fn difference(
    recording: &Recording,
    matrix: &Matrix3x3,
    test: Axis,
    found: Option<&DifferenceAxis>,
) -> Option<Plot> {
    let time_s = recording.column("time_s")?;
    let reading = recording.axis_column("test", test, "nt")?;
    let mut d = reading.to_vec();
    for reference in Axis::ALL {
        let column = recording.axis_column("reference", reference, "nt")?;
        d.iter_mut().zip(column).for_each(|(d, r)| *d -= r * matrix[reference.index()][test.index()]);
    }
    let mean = mean(&d);
    d.iter_mut().for_each(|d| *d -= mean);
    let clock = Clock::of(time_s);
    let times = clock.times(time_s);
    let mut plot = Plot::new(
        format!("difference-{test}"),
        format!("Difference d along test axis {test}, less its mean"),
        Dimension::linear("time", clock.unit),
        Dimension::linear("T − R η less its mean", "nT"),
    )
    .note("As recorded, readings that were kept out included.");
    plot.push(Series::new("difference", Mark::Points, test.index(), &times, &d));
    if let Some(found) = found {
        let first = time_s.iter().copied().find(|time| time.is_finite())?;
        let drift: Vec<f64> = time_s.iter().map(|time| drift(found, time - first)).collect();
        let level = self::mean(&drift);
        let drift: Vec<f64> = drift.iter().map(|drift| drift - level).collect();
        plot.push(Series::new("fitted drift", Mark::Dashes, 5, &times, &drift));
    }
    Some(plot)
}

/// The straight drift of the fit, or both parts where an exponential one is demanded.
fn drift(found: &DifferenceAxis, time_s: f64) -> f64 {
    let days = time_s / 86_400.0;
    match &found.drift.joint {
        Some(joint) if matches!(found.drift.demanded, DriftForm::Exponential | DriftForm::Both) => {
            joint.straight_nt_per_day.value() * days
                + joint.amplitude_nt.value() * (-time_s / joint.time_constant_s.value()).exp()
        }
        _ => found.drift.straight_nt_per_day.value() * days,
    }
}

fn mean(values: &[f64]) -> f64 {
    let finite = values.iter().filter(|value| value.is_finite());
    let count = finite.clone().count();
    finite.sum::<f64>() / count as f64
}

fn axes(section: &mut Section, found: &DifferentialCalibration, fit: &DifferentialFit) {
    let mut table = Table::new(
        "The difference along each axis of the test instrument",
        [
            ("test axis", ""),
            ("mean d", "nT"),
            ("rms about it", "nT"),
            ("white, of a reading", "nT"),
            ("√A at 1 Hz", "nT/√Hz"),
            ("α", ""),
            ("goodness, p", ""),
        ],
    );
    let mut drifts = Table::new(
        "Drift of the difference",
        [
            ("test axis", ""),
            ("demanded", ""),
            ("straight", "nT/day"),
            ("straight, p", ""),
            ("exponential, p", ""),
            ("exponential", "nT"),
            ("time constant", "s"),
        ],
    );
    let mut changes = Table::new(
        "How much the difference changes over a span after the recording; 95 % interval from drift and noise",
        [
            ("test axis", ""),
            ("over a", ""),
            ("by the drift", "nT"),
            ("by noise, rms", "nT"),
            ("from", "nT"),
            ("to", "nT"),
            ("longer than the recording", ""),
        ],
    );
    for (axis, one) in fit.axes.iter() {
        table.row([
            axis.letter().into(),
            found.offset_nt.as_ref().and_then(|offset| offset.get(axis)).into(),
            Cell::Figures(one.rms_nt, 3),
            (&one.white_rms_nt).into(),
            (&one.density_at_1hz_nt_per_sqrt_hz).into(),
            (&one.flicker_exponent).into(),
            Cell::Probability(one.goodness_p),
        ]);
        let drift = &one.drift;
        let demanded = match drift.demanded {
            DriftForm::None => "none",
            DriftForm::Straight => "straight",
            DriftForm::Exponential => "exponential",
            DriftForm::Both => "both",
        };
        drifts.row([
            axis.letter().into(),
            demanded.into(),
            (&drift.straight_nt_per_day).into(),
            Cell::Probability(drift.straight_p),
            Cell::Probability(drift.exponential_p),
            drift.joint.as_ref().map(|joint| &joint.amplitude_nt).into(),
            drift.joint.as_ref().map(|joint| &joint.time_constant_s).into(),
        ]);
        for (span, change) in
            [("day", &drift.per_day), ("month", &drift.per_month), ("year", &drift.per_year)]
        {
            let [from, to] = change.interval_nt;
            changes.row([
                axis.letter().into(),
                span.into(),
                (&change.drift_nt).into(),
                Cell::Figures(change.noise_rms_nt, 2),
                Cell::Figures(from, 3),
                Cell::Figures(to, 3),
                if change.extrapolated { "yes" } else { "no" }.into(),
            ]);
        }
    }
    section.table(table);
    section.table(drifts);
    section.table(changes);
}

fn allan(fit: &DifferentialFit) -> Plot {
    let mut plot = Plot::new(
        "difference-allan",
        "Allan deviation of the difference",
        Dimension::log("averaging time", "s"),
        Dimension::log("Allan deviation", "nT"),
    )
    .note("Bars: 95 % intervals.");
    for (axis, one) in fit.axes.iter() {
        let allan = &one.allan;
        plot.push(
            Series::new(
                format!("test axis {axis}"),
                Mark::Points,
                axis.index(),
                &allan.averaging_s,
                &allan.deviation_nt,
            )
            .between(&allan.low_nt, &allan.high_nt),
        );
    }
    plot
}

fn reference_noise(section: &mut Section, fit: &DifferentialFit) {
    let Some(noise) = &fit.reference_noise else { return };
    section.warnings.extend(noise.findings.iter().cloned());
    let mut table = Table::new(
        "What noise of the reference does to each element",
        [("element", ""), ("pulled", ""), ("corrected", ""), ("largest pull", ""), ("over its std", "")],
    );
    for (place, one) in &noise.elements {
        table.row([
            place.as_str().into(),
            Cell::Uncertain { value: one.pulled, std: one.pulled_std },
            one.corrected.as_ref().into(),
            Cell::Figures(one.largest_pull, 2),
            Cell::Figures(one.largest_pull_over_std, 2),
        ]);
    }
    if !noise.ascribed.is_empty() {
        section.say(sentence(&noise.ascribed));
    }
    section.table(table);
}

fn clock(section: &mut Section, fit: &DifferentialFit) {
    let Some(clock) = &fit.clock else { return };
    let corrected = if clock.corrected {
        "Its times were corrected for both."
    } else {
        "Its times were left as they are."
    };
    section.say(format!(
        "Clock of the test instrument (positive: late): {} s, rate {} ppm. {corrected}",
        number::cell(&(&clock.offset_s).into()),
        number::cell(&(&clock.rate_ppm).into())
    ));
}

fn kept_out(section: &mut Section, fit: &DifferentialFit) {
    let mut table = Table::new(
        "Events that were kept out or taken off",
        [
            ("event", ""),
            ("instrument", ""),
            ("axis", ""),
            ("at", "s"),
            ("first row", ""),
            ("last row", ""),
            ("size", "nT"),
        ],
    );
    for event in &fit.kept_out.events {
        let kind = match event.kind {
            EventKind::Step => "step",
            EventKind::Spike => "spike",
            EventKind::Interval => "interval",
        };
        let instrument = match event.instrument {
            EventInstrument::Test => "test",
            EventInstrument::Reference => "reference",
            EventInstrument::Either => "not to be told",
        };
        let [first, last] = event.rows;
        table.row([
            kind.into(),
            instrument.into(),
            event.axis.letter().into(),
            event.time_s.into(),
            first.into(),
            last.into(),
            (&event.size_nt).into(),
        ]);
    }
    section.table(table);
    let mut gaps = Table::new("Gaps", [("from", "s"), ("to", "s"), ("samples", "")]);
    for gap in &fit.kept_out.gaps {
        gaps.row([gap.from_s.into(), gap.to_s.into(), gap.samples.into()]);
    }
    section.table(gaps);
}

fn fourteen(section: &mut Section, fourteen: &FourteenParameters) {
    let assumed =
        if fourteen.assumed { "; nobody stated them: taken as orthogonal, with equal scales" } else { "" };
    let known = match fourteen.known {
        common::Magnetometer::Reference => "reference",
        common::Magnetometer::Test => "test instrument",
    };
    section.say(format!("The fourteen parameters, five of the {known} known{assumed}."));
    let mut angles = Table::new(
        "Angles of the axes",
        [
            ("angle", ""),
            ("value", "deg"),
            ("standard uncertainty", "arcsec"),
            ("from where it is meant", "arcsec"),
        ],
    );
    for (name, angle) in &fourteen.angles {
        angles.row([
            name.replace('_', " ").into(),
            Cell::Text(number::fixed(angle.value_deg, 6)),
            Cell::Figures(angle.std_arcsec, 2),
            angle.off_nominal_arcsec.into(),
        ]);
    }
    section.table(angles);
    let mut ratios = Table::new("Ratios of scale factors, reading per nT", [("ratio", ""), ("value", "")]);
    for (name, ratio) in &fourteen.ratios {
        ratios.row([name.replace('_', " over ").into(), ratio.into()]);
    }
    section.table(ratios);
    let mut orthogonality = Table::new(
        "90° less the angle between two axes",
        [("axes", ""), ("reference", "arcsec"), ("test", "arcsec")],
    );
    for (pair, angle) in &fourteen.reference_non_orthogonality_arcsec {
        orthogonality.row([
            pair.as_str().into(),
            angle.into(),
            fourteen.test_non_orthogonality_arcsec.get(pair).into(),
        ]);
    }
    section.table(orthogonality);
}
