//! One magnetometer against another: matrix, difference, drift, noise, the fourteen parameters.

use common::{
    Axis, DifferentialCalibration, DifferentialFit, Document, DriftForm, EventInstrument, EventKind,
};
use page::words::{counted, sentence};

use super::effects;
use super::{difference, differential_matrix, fourteen, instruments};
use crate::plot::{Dimension, Mark, Plot, Series};
use crate::{Cell, Section, Table, number};

/// The section; None where the document has nothing of it.
pub fn section(document: &Document) -> Option<Section> {
    let found = document.calibration.as_ref()?.differential.as_ref()?;
    let mut section = Section::new("differential", "Two magnetometers side by side");
    let answer = found.fit.as_ref().map(|fit| &fit.answer).filter(|answer| !answer.is_empty());
    section.words.extend(answer.map(|answer| sentence(answer)));
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
        section.warnings.extend(effects::differential::of_fit(fit));
        difference::draw(&mut section, fit);
        section.table(difference::contributions(fit));
        axes(&mut section, found, fit);
        section.plot(allan(fit));
        if let Some(matrix) = &found.matrix {
            differential_matrix::stability(&mut section, fit, matrix);
        }
        instruments::octaves(&mut section, fit);
        instruments::noise(&mut section, fit);
        clock(&mut section, fit);
        kept_out(&mut section, fit);
    }
    if let Some(parameters) = &found.fourteen {
        fourteen::tables(&mut section, parameters);
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

fn axes(section: &mut Section, found: &DifferentialCalibration, fit: &DifferentialFit) {
    let mut table = Table::new(
        "The difference along each axis of the test instrument",
        [
            ("test axis", ""),
            ("mean d", "nT"),
            ("rms of the readings", "nT"),
            ("rms of T − R, offsets removed", "nT"),
            ("rms of d", "nT"),
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
    let figures = |rms: Option<f64>| rms.map_or(Cell::Empty, |rms| Cell::Figures(rms, 3));
    for (axis, one) in fit.axes.iter() {
        table.row([
            axis.letter().into(),
            found.offset_nt.as_ref().and_then(|offset| offset.get(axis)).into(),
            figures(one.rms_of_readings_nt),
            figures(one.rms_of_levels_nt),
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
            let Some(change) = change else { continue };
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

fn clock(section: &mut Section, fit: &DifferentialFit) {
    let Some(clock) = &fit.clock else { return };
    let corrected = if clock.corrected {
        "Its times were corrected for both."
    } else {
        "Its times were left as they are."
    };
    section.say(format!(
        "Clock of the test instrument: {} in the middle of the recording, {}. {corrected}",
        clock.offset_in_words(),
        clock.rate_in_words()
    ));
}

fn kept_out(section: &mut Section, fit: &DifferentialFit) {
    let mut table = Table::new(
        "Events that were excluded or removed",
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
            EventInstrument::Either => "undetermined",
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
