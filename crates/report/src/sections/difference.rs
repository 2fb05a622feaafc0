//! The difference of two magnetometers as it was recorded.

use common::{Axis, DifferenceAxis, DriftForm, Matrix3x3, Recording};

use super::clock::Clock;
use crate::plot::{Dimension, Mark, Plot, Series};

/// d less its mean as it was recorded, with the fitted drift.
pub fn plot(
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
    let mean = mean_of(&d);
    d.iter_mut().for_each(|d| *d -= mean);
    let clock = Clock::of(time_s);
    let times = clock.times(time_s);
    let mut plot = Plot::new(
        format!("difference-{test}"),
        format!("Difference along test axis {test}"),
        Dimension::linear("time", clock.unit),
        Dimension::linear("d less its mean", "nT"),
    )
    .note("d = T − R η as recorded, readings that were kept out included.");
    plot.push(Series::new("difference", Mark::Points, test.index(), &times, &d));
    if let Some(found) = found {
        let first = time_s.iter().copied().find(|time| time.is_finite())?;
        let drift: Vec<f64> = time_s.iter().map(|time| drift(found, time - first)).collect();
        let level = mean_of(&drift);
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

fn mean_of(values: &[f64]) -> f64 {
    let finite = values.iter().filter(|value| value.is_finite());
    let count = finite.clone().count();
    finite.sum::<f64>() / count as f64
}
