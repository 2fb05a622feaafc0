//! Residuals before and after, against time and what they may follow.

use common::ResidualSeries;
use page::words::{key, slug};

use super::clock::Clock;
use crate::number;
use crate::plot::{Dimension, Mark, Plot, Series};

/// Where what is left spans less than this share of what there was, it also has a plot of its own.
const FLAT: f64 = 0.4;

/// What the plots of one series are called.
pub struct Names<'a> {
    /// Unique within the page, before what the residual is drawn against.
    pub id: String,
    /// Whose residual.
    pub title: String,
    /// The residual, on its axis.
    pub residual: &'a str,
    /// Before, after, and what is fitted.
    pub legend: [&'a str; 3],
}

/// Before and after together, then after alone on a scale of its own where it would lie flat.
pub fn plots(names: &Names<'_>, series: &ResidualSeries, note: &str) -> Vec<Plot> {
    let times = series.along == "time_s";
    let clock = Clock::of(if times { &series.x } else { &[] });
    let (along, unit) = key(&series.along);
    let along = along.replace('_', " ");
    let unit = if times { clock.unit.into() } else { unit };
    let x = if times { clock.times(&series.x) } else { series.x.clone() };
    let points = match series.readings {
        0 | 1 => "Each point is a reading.".to_string(),
        readings => format!("Each point is the mean of {readings} readings."),
    };
    let plot = |id: &str, title: String| {
        let id = format!("{}-{}{id}", names.id, slug(&series.along));
        let (x, y) =
            (Dimension::linear(along.clone(), unit.clone()), Dimension::linear(names.residual, "nT"));
        Plot::new(id, title, x, y).note(format!("{points} {note}").trim_end())
    };
    let [before, after, fitted] = names.legend;
    let left = Series::new(after, Mark::Points, 0, &x, &series.after_nt);
    let title = format!("{} against {along}", names.title);
    let mut both = plot("", title.clone());
    both.push(Series::new(before, Mark::Points, 1, &x, &series.before_nt));
    both.push(left.clone());
    both.push(Series::new(fitted, Mark::Dashes, 5, &x, &series.fitted_nt));
    let span = |values: &[f64]| number::ends(values.iter().copied()).map_or(0.0, |[low, high]| high - low);
    let mut plots = vec![both];
    if span(&series.after_nt) < FLAT * span(&series.before_nt) {
        let mut alone = plot("-left", format!("{title}: {after}"));
        alone.push(left);
        plots.push(alone);
    }
    plots
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_would_lie_flat_has_a_plot_of_its_own() {
        let series = |after_nt: Vec<f64>| ResidualSeries {
            along: "sensor_temperature_c".into(),
            x: vec![1.0, 2.0, 3.0],
            before_nt: vec![10.0, 0.0, -10.0],
            after_nt,
            readings: 5,
            ..ResidualSeries::default()
        };
        let legend = ["before", "after", "fitted"];
        let names = Names { id: "p".into(), title: "T".into(), residual: "d", legend };
        let plots = |after: Vec<f64>| super::plots(&names, &series(after), "");
        assert_eq!(plots(vec![9.0, 0.0, -9.0]).len(), 1);
        let two = plots(vec![0.1, 0.0, -0.1]);
        assert_eq!([two[0].series.len(), two[1].series.len()], [2, 1]);
        assert_eq!(two[1].id, "p-sensor-temperature-c-left");
        assert_eq!(two[1].title, "T against sensor temperature: after");
        assert_eq!(two[0].x.text(), "sensor temperature (°C)");
        assert_eq!(two[0].note, "Each point is the mean of 5 readings.");
    }
}
