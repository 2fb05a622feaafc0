//! Residuals before and after, against time and what they may follow; the difference of two magnetometers
//! likewise.

use crate::page::words::{key, slug};
use crate::page::{Cell, Place};
use common::{Axis, Diagnosis, DifferentialFit, Document, DoubtfulValue, Recording, ResidualSeries};
use minijinja::{Value, context};

use super::time::{Clock, earliest};
use super::{Plots, side_by_side};
use crate::number;
use crate::plot::{Dimension, Mark, Plot, Series, Toggle};

/// Where what is left spans less than this share of what there was, it also has a plot of its own.
const FLAT: f64 = 0.4;

/// What the plots of one series are called.
pub struct Names<'a> {
    /// Unique within the page, before what the residual is drawn against.
    pub id: String,
    pub title: String,
    pub residual: &'a str,
    /// Before, after, and what is fitted.
    pub legend: [&'a str; 3],
    /// The recording whose times these are.
    pub recording: Option<&'a Recording>,
    /// The diagnosis whose effects can be switched off.
    pub diagnosis: Option<&'a Diagnosis>,
}

/// Before and after together, then after alone on a scale of its own where it would lie flat; along time first
/// the readings with what the model has of them, and last what each effect explains.
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
        let plot = Plot::new(id, title).axes(x, y).note(format!("{points} {note}").trim_end());
        let of = names.recording.filter(|_| times);
        let held_out_nt = names.diagnosis.and_then(|of| of.fit.as_ref()).map(|fit| fit.held_out_after_nt);
        Plot { time: of.map(|of| clock.timeline(of)), held_out_nt, ..plot }
    };
    let [before, after, fitted] = names.legend;
    let left = Series::points(after, 0, &x, &series.after_nt);
    let title = format!("{} against {along}", names.title);
    let both = plot("", title.clone())
        .with(Series::points(before, 1, &x, &series.before_nt))
        .with(left.clone())
        .with(Series::new(fitted, Mark::Dashes, 5, &x, &series.fitted_nt));
    let mut plots = Vec::new();
    if !series.recorded_nt.is_empty() {
        let pairs = series.recorded_nt.iter().zip(&series.before_nt);
        let model: Vec<f64> = pairs.map(|(recorded, before)| recorded - before).collect();
        let of = series.recording.as_deref().unwrap_or_default();
        let recorded = plot("-recorded", format!("{}, {of}: recording and model", key(&series.column).0));
        plots.push(
            Plot { y: "field [nT]".into(), ..recorded }
                .with(Series::points("recording", 1, &x, &series.recorded_nt))
                .with(Series::new("model: stated calibration", Mark::Dashes, 5, &x, &model)),
        );
    }
    // What each effect makes of a covariate.
    let curves = series.contributions_nt.iter().filter(|_| !times).enumerate();
    let curves =
        curves.map(|(number, (effect, values))| Series::new(effect, Mark::Dashes, 2 + number, &x, values));
    plots.push(curves.fold(both, Plot::with));
    let span = |values: &[f64]| number::span(values.iter().copied());
    if span(&series.after_nt) < FLAT * span(&series.before_nt) {
        plots.push(plot("-left", format!("{title}: {after}")).with(left));
    }
    if times && !series.contributions_nt.is_empty() {
        let explained = plot("-explained", format!("{title}: what each effect explains"));
        let effects = series.contributions_nt.iter().enumerate();
        plots.push(effects.fold(explained, |plot, (style, (effect, values))| {
            plot.with(Series::new(effect, Mark::Line, style, &x, values))
        }));
    }
    let stacked = times && !series.recorded_nt.is_empty();
    let switched = |plot: Plot| {
        let toggles = toggles(&plot, after, series, names.diagnosis);
        Plot { stacked, spectrum: times && !toggles.is_empty(), toggles, ..plot }
    };
    plots.into_iter().map(switched).collect()
}

/// Each effect, to be switched off in what is left.
fn toggles(plot: &Plot, after: &str, series: &ResidualSeries, diagnosis: Option<&Diagnosis>) -> Vec<Toggle> {
    let Some(number) = plot.series.iter().position(|one| one.name == after) else { return Vec::new() };
    let held_out = |name: &str| {
        let of = diagnosis?;
        // Those of one label are switched off together.
        let own = of.effects.iter().filter(|effect| effect.label() == name);
        let gain: f64 = own.map(|effect| effect.held_out_gain_nt).sum();
        Some(of.fit.as_ref()?.held_out_after_nt + gain)
    };
    let toggle = |(name, y): (&String, &Vec<f64>)| Toggle {
        name: name.clone(),
        id: None,
        series: number,
        y: y.clone(),
        held_out_nt: held_out(name),
    };
    series.contributions_nt.iter().map(toggle).collect()
}

/// Against time, the field's rate of change and each housekeeping column, the axes side by side.
pub fn of_difference(fit: &DifferentialFit, document: &Document) -> Vec<Plot> {
    let recording = earliest(document, &fit.recordings);
    let mut along: Vec<&str> = Vec::new();
    for series in &fit.series {
        if !along.contains(&series.along.as_str()) {
            along.push(&series.along);
        }
    }
    let of_each = along.into_iter().map(|along| {
        Axis::ALL.map(|axis| {
            let column = format!("test_{axis}_nt");
            let own = fit.series.iter().filter(|series| series.along == along && series.column == column);
            own.flat_map(|series| one(axis, series, recording)).collect()
        })
    });
    of_each.flat_map(|axes| side_by_side(axes.into())).collect()
}

fn one(axis: Axis, series: &ResidualSeries, recording: Option<&Recording>) -> Vec<Plot> {
    let (legend, note) = match series.along.as_str() {
        "time_s" => (["offsets removed: T − R", "left: T − R η − d", "fitted"], "Both less their means."),
        "field_rate_nt_per_s" => (
            ["with the clocks' difference", "without it", "the clocks' difference"],
            "The rate of change is that of the field along the test axis; a clock that is late by δ shows as −δ times it.",
        ),
        _ => (
            ["the drift left in", "left: T − R η − d", "fitted"],
            "What follows the column is not taken off.",
        ),
    };
    let (id, title) = (format!("difference-{axis}"), format!("Difference along test axis {axis}"));
    plots(&Names { id, title, residual: "difference", legend, recording, diagnosis: None }, series, note)
}

/// Each diagnosis: the first of its series, then the others.
pub fn of_diagnosis(all: &mut Plots, document: &Document) {
    for (index, diagnosis) in document.diagnosis.iter().flatten().enumerate() {
        let drawn = |(number, series)| {
            let id = format!("{}-{}", crate::page::diagnosis(index + 1), number + 1);
            residuals(id, series, diagnosis, document)
        };
        let mut series = diagnosis.series.iter().enumerate().map(drawn);
        let first = series.next().unwrap_or_default();
        all.insert(format!("diagnosis-{}-first", index + 1), first);
        all.insert(format!("diagnosis-{}-others", index + 1), series.flatten().collect());
    }
}

/// Of each diagnosis the rows of the table of single readings that are off.
pub fn single_readings(document: &Document) -> Vec<Vec<Value>> {
    let row = |one: &DoubtfulValue| {
        let recording = document.recordings.iter().find(|recording| recording.id == one.recording);
        let time = recording.and_then(|recording| recording.column("time_s")?.get(one.row).copied());
        let (column, _) = key(&one.column);
        let cell = match time {
            Some(time) => Cell::Placed(column, Place::new(&one.recording, [time; 2])),
            None => column.into(),
        };
        let off = Value::from_serialize(&one.departure_nt);
        context! { reading => Value::from_object(cell), recording => one.recording, row => one.row, off }
    };
    let of =
        |diagnosis: &Diagnosis| diagnosis.places.iter().flat_map(|place| &place.readings).map(row).collect();
    document.diagnosis.iter().flatten().map(of).collect()
}

fn residuals(id: String, series: &ResidualSeries, diagnosis: &Diagnosis, document: &Document) -> Vec<Plot> {
    // Those of a pair are not one recording.
    let own = |id: &String| earliest(document, std::slice::from_ref(id));
    let recording = series
        .recording
        .as_ref()
        .and_then(|id| own(id).or_else(|| earliest(document, &diagnosis.recordings)));
    let of = series.recording.as_deref().unwrap_or("all recordings");
    let (column, _) = key(&series.column);
    let noise = diagnosis.fit.as_ref().map(|fit| {
        let floor = number::significant(fit.noise_floor_nt, 3);
        format!("Noise of a reading: {floor} nT ({}).", fit.noise_source)
    });
    let title = format!("Residual of {column}, {of},");
    let legend = ["before: stated calibration", "after: with the effects found", "fitted"];
    plots(
        &Names { id, title, residual: "residual", legend, recording, diagnosis: Some(diagnosis) },
        series,
        &noise.unwrap_or_default(),
    )
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
        let (id, title, legend) = ("p".into(), "T".into(), ["before", "after", "fitted"]);
        let names = Names { id, title, residual: "d", legend, recording: None, diagnosis: None };
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
