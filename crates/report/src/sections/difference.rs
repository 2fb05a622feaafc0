//! The difference of two magnetometers: what adds to it, and what it follows.

use common::{Axis, Contribution, ContributionCause, DifferentialFit, PerAxis, ResidualSeries};

use super::residuals::{Names, plots};
use crate::plot::Plot;
use crate::{Cell, Section, Table};

/// Plots against time, the field's rate of change and each housekeeping column, the axes side by side.
pub fn draw(section: &mut Section, fit: &DifferentialFit) {
    let mut along: Vec<&str> = Vec::new();
    for series in &fit.series {
        if !along.contains(&series.along.as_str()) {
            along.push(&series.along);
        }
    }
    for along in along {
        let of = |axis: Axis| -> Vec<Plot> {
            let column = format!("test_{axis}_nt");
            let own = fit.series.iter().filter(|series| series.along == along && series.column == column);
            own.flat_map(|series| one(axis, series)).collect()
        };
        section.plots_side_by_side(Axis::ALL.into_iter().map(of).collect());
    }
}

fn one(axis: Axis, series: &ResidualSeries) -> Vec<Plot> {
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
    let title = format!("Difference along test axis {axis}");
    plots(&Names { id: format!("difference-{axis}"), title, residual: "difference", legend }, series, note)
}

/// What adds to the difference, the largest first, with the rms with it and without.
pub fn contributions(fit: &DifferentialFit) -> Table {
    let mut table = Table::new(
        "Contributions to the difference: rms with and without each, all else equal",
        [
            ("what", ""),
            ("taken off", ""),
            ("x with", "nT"),
            ("x without", "nT"),
            ("y with", "nT"),
            ("y without", "nT"),
            ("z with", "nT"),
            ("z without", "nT"),
        ],
    );
    for one in &fit.contributions {
        let taken_off = if one.taken_off { "yes" } else { "no" };
        let rms = |of: &PerAxis<f64>, axis| of.get(axis).map_or(Cell::Empty, |rms| Cell::Figures(*rms, 3));
        let both = |axis| [rms(&one.rms_with_nt, axis), rms(&one.rms_without_nt, axis)];
        let [[a, b], [c, d], [e, f]] = Axis::ALL.map(both);
        table.row([named(one).into(), taken_off.into(), a, b, c, d, e, f]);
    }
    table
}

fn named(one: &Contribution) -> String {
    let name = match one.cause {
        ContributionCause::Clock => "difference of the clocks",
        ContributionCause::Steps => "steps",
        ContributionCause::Disturbances => "spikes and disturbed intervals",
        ContributionCause::Drift => "drift",
        ContributionCause::ShortPeriods => "periods excluded from the matrix",
        ContributionCause::Column => "what follows",
    };
    one.column.as_ref().map_or_else(|| name.to_string(), |column| format!("{name} {column}"))
}
