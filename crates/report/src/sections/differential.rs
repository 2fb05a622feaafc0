//! One magnetometer against another: matrix, difference, drift, noise, the fourteen parameters.

use common::{
    Axis, DifferentialCalibration, DifferentialFit, Document, DriftForm, EventInstrument, EventKind,
    FourteenParameters, Magnetometer,
};
use page::words::{counted, sentence};

use super::{effects, instruments, residuals};
use crate::plot::{Dimension, Plot, Series};
use crate::{Cell, Section, Table, number};

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
        residuals::draw(&mut section, fit);
        residuals::contributions(&mut section, fit);
        axes(&mut section, found, fit);
        section.plot(allan(fit));
        if let Some(matrix) = &found.matrix {
            instruments::stability(&mut section, fit, matrix);
        }
        instruments::octaves(&mut section, fit);
        instruments::noise(&mut section, fit);
        if let Some(clock) = &fit.clock {
            let corrected = match clock.corrected {
                true => "Its times were corrected for both.",
                false => "Its times were left as they are.",
            };
            section.say(format!(
                "Clock of the test instrument: {} in the middle of the recording, {}. {corrected}",
                clock.offset_in_words(),
                clock.rate_in_words()
            ));
        }
        kept_out(&mut section, fit);
    }
    if let Some(parameters) = &found.fourteen {
        fourteen(&mut section, parameters);
    }
    (!section.items.is_empty()).then_some(section)
}

fn matrix(found: &DifferentialCalibration) -> Table {
    let mut table = Table::new(
        "Matrix η, element by element",
        "element | η | least squares alone | its std if errors were independent | its std by Newey and West | \
         its std under the fitted noise",
    );
    let Some(matrix) = &found.matrix else { return table };
    let variance = |i: usize, j: usize| {
        let name = format!("matrix[{i}][{j}]");
        let place = found.covariance_order.as_ref()?.iter().position(|key| *key == name)?;
        found.covariance.as_ref()?.get(place)?.get(place).copied()
    };
    for test in Axis::ALL {
        for reference in Axis::ALL {
            let (i, j) = (reference.index(), test.index());
            let value = matrix[i][j];
            let whole = variance(i, j)
                .map_or(Cell::Number(value), |variance| Cell::Uncertain { value, std: variance.sqrt() });
            let element = found.fit.as_ref().and_then(|fit| fit.elements.get(&format!("{reference}{test}")));
            table.row((
                format!("reference {reference} to test {test}"),
                whole,
                element.map(|element| element.least_squares),
                Cell::figures(element.map(|element| element.std_independent), 2),
                Cell::figures(element.and_then(|element| element.std_newey_west), 2),
                Cell::figures(element.map(|element| element.std_noise), 2),
            ));
        }
    }
    table
}

fn axes(section: &mut Section, found: &DifferentialCalibration, fit: &DifferentialFit) {
    let mut table = Table::new(
        "The difference along each axis of the test instrument",
        "test axis | mean d [nT] | rms of the readings [nT] | rms of T − R, offsets removed [nT] | rms of d [nT] | \
         white, of a reading [nT] | √A at 1 Hz [nT/√Hz] | α | goodness, p",
    );
    let mut drifts = Table::new(
        "Drift of the difference",
        "test axis | demanded | straight [nT/day] | straight, p | exponential, p | exponential [nT] | time constant [s]",
    );
    let mut changes = Table::new(
        "How much the difference changes over a span after the recording; 95 % interval from drift and noise",
        "test axis | over a | by the drift [nT] | by noise, rms [nT] | from [nT] | to [nT] | longer than the recording",
    );
    for (axis, one) in fit.axes.iter() {
        table.row((
            axis,
            found.offset_nt.as_ref().and_then(|offset| offset.get(axis)),
            Cell::figures(one.rms_of_readings_nt, 3),
            Cell::figures(one.rms_of_levels_nt, 3),
            Cell::Figures(one.rms_nt, 3),
            &one.white_rms_nt,
            &one.density_at_1hz_nt_per_sqrt_hz,
            &one.flicker_exponent,
            Cell::Probability(one.goodness_p),
        ));
        let drift = &one.drift;
        let demanded = match drift.demanded {
            DriftForm::None => "none",
            DriftForm::Straight => "straight",
            DriftForm::Exponential => "exponential",
            DriftForm::Both => "both",
        };
        let [straight_p, exponential_p] = [drift.straight_p, drift.exponential_p].map(Cell::Probability);
        let joint = drift.joint.as_ref();
        let (amplitude, time) = joint.map(|joint| (&joint.amplitude_nt, &joint.time_constant_s)).unzip();
        drifts.row((axis, demanded, &drift.straight_nt_per_day, straight_p, exponential_p, amplitude, time));
        for (span, change) in
            [("day", &drift.per_day), ("month", &drift.per_month), ("year", &drift.per_year)]
        {
            let Some(change) = change else { continue };
            let noise = Cell::Figures(change.noise_rms_nt, 2);
            let [from, to] = change.interval_nt.map(|end| Cell::Figures(end, 3));
            changes.row((axis, span, &change.drift_nt, noise, from, to, change.extrapolated));
        }
    }
    section.table(table);
    section.table(drifts);
    section.table(changes);
}

fn allan(fit: &DifferentialFit) -> Plot {
    let mut plot = Plot::new("difference-allan", "Allan deviation of the difference")
        .axes(Dimension::log("averaging time [s]"), Dimension::log("Allan deviation [nT]"))
        .note("Bars: 95 % intervals.");
    for (axis, one) in fit.axes.iter() {
        let (allan, name) = (&one.allan, format!("test axis {axis}"));
        let points = Series::points(name, axis.index(), &allan.averaging_s, &allan.deviation_nt);
        plot.push(points.between(&allan.low_nt, &allan.high_nt));
    }
    plot
}

fn kept_out(section: &mut Section, fit: &DifferentialFit) {
    let events = fit.kept_out.events.iter().map(|event| {
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
        (kind, instrument, event.axis, event.time_s, first, last, &event.size_nt)
    });
    let headers = "event | instrument | axis | at [s] | first row | last row | size [nT]";
    section.rows("Events that were excluded or removed", headers, events);
    let gaps = fit.kept_out.gaps.iter().map(|gap| (gap.from_s, gap.to_s, gap.samples));
    section.rows("Gaps", "from [s] | to [s] | samples", gaps);
}

/// The fourteen parameters of two magnetometers side by side: angles, ratios and angles between axes.
fn fourteen(section: &mut Section, fourteen: &FourteenParameters) {
    let assumed =
        if fourteen.assumed { "; not stated: assumed orthogonal, with equal scale factors" } else { "" };
    let known = match fourteen.known {
        Magnetometer::Reference => "reference",
        Magnetometer::Test => "test instrument",
    };
    section.say(format!("The fourteen parameters, five of the {known} known{assumed}."));
    let angles = fourteen.angles.iter().map(|(name, angle)| {
        let (value, std) = (number::fixed(angle.value_deg, 6), Cell::Figures(angle.std_arcsec, 2));
        (name.replace('_', " "), value, std, angle.off_nominal_arcsec)
    });
    let headers = "angle | value [deg] | standard uncertainty [arcsec] | from nominal [arcsec]";
    section.rows("Angles of the axes", headers, angles);
    let ratios = fourteen.ratios.iter().map(|(name, ratio)| (name.replace('_', " over "), ratio));
    section.rows("Ratios of scale factors, reading per nT", "ratio | value", ratios);
    let of_test = &fourteen.test_non_orthogonality_arcsec;
    let each = fourteen.reference_non_orthogonality_arcsec.iter();
    let angles = each.map(|(pair, angle)| (pair, angle, of_test.get(pair)));
    section.rows("90° less the angle between two axes", "axes | reference [arcsec] | test [arcsec]", angles);
}
