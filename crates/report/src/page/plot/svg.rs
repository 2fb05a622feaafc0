use std::fmt::Write;

use super::drawn::{Mark, Plot, Point, Series};
use super::scale::{Scale, Tick, moment_text};
use crate::page::words::escape;

/// Size of a drawing; a map is as high as it must be.
const WIDTH: f64 = 400.0;
const HEIGHT: f64 = 270.0;
/// Room above for the vertical axis's label, right, and below for the horizontal axis.
const ABOVE: f64 = 24.0;
const RIGHT: f64 = 16.0;
const BELOW: f64 = 44.0;
/// Width of a character of a tick's label.
const CHARACTER: f64 = 7.4;
pub const STYLES: usize = 6;

/// The drawing as an SVG element; colours and theme come from the page's style. Without a point that can be
/// drawn: a sentence.
pub fn svg(plot: &Plot) -> String {
    let xs = plot.points().map(|point| point.x);
    let ys = plot.points().flat_map(|point| [point.y].into_iter().chain(point.bar.into_iter().flatten()));
    let (Some(mut x), Some(mut y)) = (Scale::over(xs, plot.x.log), Scale::over(ys, plot.y.log)) else {
        return "<p class=\"nothing\">No value that can be drawn.</p>".into();
    };
    if plot.map {
        // One step along x is as long as one along y, on a square.
        let half = (x.high - x.low).max(y.high - y.low) / 2.0;
        for scale in [&mut x, &mut y] {
            let middle = (scale.low + scale.high) / 2.0;
            (scale.low, scale.high) = (middle - half, middle + half);
        }
    }
    let ticks = y.ticks(6);
    let longest = ticks.iter().map(|tick| tick.label.chars().count()).max().unwrap_or(0);
    let left = 12.0 + CHARACTER * longest as f64;
    let right = WIDTH - RIGHT;
    let bottom = if plot.map { ABOVE + right - left } else { HEIGHT - BELOW };
    let height = bottom + BELOW;
    let (x, y) = (x.at([left, right]), y.at([bottom, ABOVE]));
    let id = &plot.id;
    let mut out = format!(
        "<svg viewBox=\"0 0 {WIDTH} {height:.0}\" role=\"img\" aria-labelledby=\"{id}_title\">\
         <title id=\"{id}_title\">{}</title>\
         <clipPath id=\"{id}_clip\"><rect x=\"{left:.1}\" y=\"{ABOVE}\" width=\"{:.1}\" height=\"{:.1}\"/></clipPath>",
        escape(&plot.title),
        right - left,
        bottom - ABOVE
    );
    // A minor mark has no label.
    let grid = |tick: &Tick| if tick.label.is_empty() { "minor" } else { "grid" };
    for tick in spaced(&x, plot) {
        if let Some(at) = x.place(tick.at) {
            path(&mut out, grid(&tick), &format!("M{at:.1} {ABOVE}V{bottom:.1}"));
            label(&mut out, "x", at, bottom + 20.0, &tick.label);
        }
    }
    for tick in ticks {
        if let Some(at) = y.place(tick.at) {
            path(&mut out, grid(&tick), &format!("M{left:.1} {at:.1}H{right:.1}"));
            label(&mut out, "y", left - 6.0, at + 4.0, &tick.label);
        }
    }
    let _ = write!(out, "<path class=\"frame\" d=\"M{left:.1} {ABOVE}V{bottom:.1}H{right:.1}\"/>");
    label(&mut out, "label", 2.0, 13.0, &shortened(plot.y.text()));
    label(&mut out, "label x", (left + right) / 2.0, bottom + 38.0, &shortened(below(&x, plot)));
    let _ = write!(out, "<g clip-path=\"url(#{id}_clip)\">");
    let marked = plot.series.len() > 1;
    for series in &plot.series {
        out.push_str(&drawn(series, &x, &y, marked));
    }
    out.push_str("</g></svg>");
    out
}

pub fn swatch(series: &Series) -> String {
    let style = series.style % STYLES;
    let mut out =
        format!("<svg class=\"swatch\" viewBox=\"0 0 26 14\" aria-hidden=\"true\"><g class=\"s{style}\">");
    if series.mark != Mark::Points {
        path(&mut out, stroke(series.mark), "M1 7H25");
    }
    if series.mark != Mark::Dashes {
        let mut d = String::new();
        shape(&mut d, series.style, [13.0, 7.0], 3.6);
        path(&mut out, "points", &d);
    }
    out.push_str("</g></svg>");
    out
}

fn label(out: &mut String, class: &str, x: f64, y: f64, text: &str) {
    if !text.is_empty() {
        let _ = write!(out, "<text class=\"{class}\" x=\"{x:.1}\" y=\"{y:.1}\">{}</text>", escape(text));
    }
}

/// A label that the drawing has room for.
fn shortened(text: String) -> String {
    const MOST: usize = 44;
    match text.char_indices().nth(MOST) {
        Some((end, _)) => format!("{}…", &text[..end]),
        None => text,
    }
}

/// As many marks along x as have room for their labels.
fn spaced(x: &Scale, plot: &Plot) -> Vec<Tick> {
    let end = |tick: &Tick, side: f64| {
        Some(x.place(tick.at)? + side * (CHARACTER / 2.0 * tick.label.chars().count() as f64 + 4.0))
    };
    let fits = |ticks: &Vec<Tick>| {
        let labelled: Vec<&Tick> = ticks.iter().filter(|tick| !tick.label.is_empty()).collect();
        labelled.windows(2).all(|pair| end(pair[0], 1.0) < end(pair[1], -1.0))
    };
    let dated = |wanted| plot.time.as_ref().and_then(|time| x.moments(time, wanted));
    let ticks = |wanted| dated(wanted).unwrap_or_else(|| x.ticks(wanted));
    let mut found = (2..=7).rev().map(ticks).find(fits).unwrap_or_else(|| ticks(1));
    // A date at the edge would be cut.
    found.retain(|tick| end(tick, 1.0) < Some(WIDTH + 4.0));
    found
}

/// What runs along x; of times with the date where the drawing begins.
fn below(x: &Scale, plot: &Plot) -> String {
    let begins = plot.time.as_ref().and_then(|time| moment_text(time.epoch_s? + x.low * time.unit_s));
    begins.map_or_else(|| plot.x.text(), |text| format!("{} (UTC, {})", plot.x.label, &text[..10]))
}

fn drawn(series: &Series, x: &Scale, y: &Scale, marked: bool) -> String {
    let place = |point: &Point| Some([x.place(point.x)?, y.place(point.y)?]);
    let mut out = format!("<g class=\"s{}\">", series.style % STYLES);
    match series.mark {
        Mark::Points => {
            let radius = match series.points.len() {
                0..=60 => 3.4,
                61..=300 => 2.4,
                _ => 1.6,
            };
            let mut bars = String::new();
            let mut shapes = String::new();
            for point in &series.points {
                let Some(at) = place(point) else { continue };
                shape(&mut shapes, series.style, at, radius);
                if let Some([low, high]) = ends(point, y) {
                    let _ = write!(bars, "M{:.1} {low:.1}V{high:.1}", at[0]);
                }
            }
            path(&mut out, "bars", &bars);
            path(&mut out, "points", &shapes);
        }
        Mark::Line | Mark::Dashes => {
            path(&mut out, "band", &band(series, x, y));
            path(&mut out, stroke(series.mark), &line_through(series.points.iter().map(place)));
            // A few shapes along a line, so that lines are told apart without colour.
            if marked && series.mark == Mark::Line {
                let mut shapes = String::new();
                let stride = (series.points.len() / 7).max(1);
                let some = series.points.iter().skip(stride / 2).step_by(stride);
                some.filter_map(place).for_each(|at| shape(&mut shapes, series.style, at, 3.0));
                path(&mut out, "points", &shapes);
            }
        }
    }
    out.push_str("</g>");
    out
}

/// The ends of a bar; a lower end that has no place on a logarithmic axis is at its foot.
fn ends(point: &Point, y: &Scale) -> Option<[f64; 2]> {
    let [low, high] = point.bar?;
    let high = y.place(high)?;
    let low = if low.is_nan() { return None } else { y.place(low).unwrap_or(y.places[0]) };
    Some([low, high])
}

fn band(series: &Series, x: &Scale, y: &Scale) -> String {
    let ends = |point: &Point| {
        let [low, high] = ends(point, y)?;
        Some([x.place(point.x)?, low, high])
    };
    let ends: Vec<[f64; 3]> = series.points.iter().filter_map(ends).collect();
    let there = ends.iter().map(|[x, _, high]| Some([*x, *high]));
    let back = ends.iter().rev().map(|[x, low, _]| Some([*x, *low]));
    line_through(there.chain(back))
}

/// A line that is parted where there is no place.
fn line_through(places: impl Iterator<Item = Option<[f64; 2]>>) -> String {
    let (mut line, mut step) = (String::new(), "M");
    for place in places {
        if let Some([x, y]) = place {
            let _ = write!(line, "{step}{x:.1} {y:.1}");
        }
        step = if place.is_some() { "L" } else { "M" };
    }
    line
}

fn stroke(mark: Mark) -> &'static str {
    if mark == Mark::Dashes { "dashes" } else { "line" }
}

fn path(out: &mut String, class: &str, d: &str) {
    if !d.is_empty() {
        let _ = write!(out, "<path class=\"{class}\" d=\"{d}\"/>");
    }
}

/// Circle, square, triangle, diamond, plus and cross.
fn shape(d: &mut String, style: usize, [x, y]: [f64; 2], r: f64) {
    let style = style % STYLES;
    let r = r * [1.0, 0.9, 1.0, 1.25, 1.0, 1.0][style];
    let (left, up, two) = (x - r, y - r, 2.0 * r);
    let _ = match style {
        0 => write!(d, "M{left:.1} {y:.1}a{r} {r} 0 1 0 {two:.1} 0a{r} {r} 0 1 0 {:.1} 0", -two),
        1 => write!(d, "M{left:.1} {up:.1}h{two:.1}v{two:.1}h{:.1}z", -two),
        2 => write!(d, "M{x:.1} {:.1}l{:.1} {two:.1}h{:.1}z", y - 1.2 * r, 1.15 * r, -2.3 * r),
        3 => write!(d, "M{x:.1} {up:.1}l{r:.1} {r:.1}l{0:.1} {r:.1}l{0:.1} {0:.1}z", -r),
        4 => write!(d, "M{left:.1} {y:.1}h{two:.1}M{x:.1} {up:.1}v{two:.1}"),
        _ => write!(d, "M{left:.1} {up:.1}l{two:.1} {two:.1}m{0:.1} 0l{two:.1} {0:.1}", -two),
    };
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::page::plot::Dimension;

    fn drawn(series: Series) -> String {
        svg(&Plot::new("p", "P").axes(Dimension::log("f [Hz]"), Dimension::log("P [nT²/Hz]")).with(series))
    }

    fn paths<'a>(svg: &'a str, class: &str) -> Vec<&'a str> {
        let start = format!("<path class=\"{class}\" d=\"");
        svg.split(&start).skip(1).filter_map(|rest| rest.split('"').next()).collect()
    }

    #[test]
    fn a_gap_parts_a_line_and_what_has_no_place_is_left_out() {
        let mut series = Series::new("s", Mark::Line, 0, &[1.0, 10.0], &[1.0, 2.0]);
        series.append(&[20.0, 30.0, 40.0], &[3.0, -1.0, 4.0]);
        let svg = drawn(series);
        let lines = paths(&svg, "line");
        assert_eq!(lines.len(), 1);
        assert_eq!((lines[0].matches('M').count(), lines[0].matches('L').count()), (3, 1), "{}", lines[0]);
    }

    #[test]
    fn a_bar_to_below_zero_ends_at_the_foot_of_a_logarithmic_axis() {
        let series = Series::points("s", 0, &[1.0, 2.0], &[1.0, 10.0]).between(&[-1.0, 5.0], &[2.0, 20.0]);
        let svg = drawn(series);
        let foot = HEIGHT - BELOW;
        assert!(paths(&svg, "bars")[0].contains(&format!(" {foot:.1}V")), "{svg}");
    }

    #[test]
    fn a_map_has_the_same_length_of_a_step_both_ways() {
        let series = Series::new("s", Mark::Line, 0, &[0.0, 3.0, 0.0], &[0.0, 0.0, 1.0]);
        let svg = svg(&Plot { map: true, ..Plot::new("p", "P").axes("x", "y").with(series) });
        let places: Vec<f64> =
            paths(&svg, "line")[0].split(['M', 'L', ' ']).filter_map(|number| number.parse().ok()).collect();
        let [x0, y0, x1, _, _, y2] = places[..] else { panic!("{places:?}") };
        assert!(((x1 - x0) - 3.0 * (y0 - y2)).abs() < 0.3, "{places:?}");
    }
}
