//! Small plots: residuals against time, one panel an axis, as SVG of a few tens of kilobytes.

use std::fmt::Write;

/// Bins along a panel; each keeps its least and its greatest value.
const BINS: usize = 220;
const WIDTH: f64 = 720.0;
const PANEL: f64 = 110.0;
const LEFT: f64 = 62.0;
const TOP: f64 = 26.0;
const BOTTOM: f64 = 34.0;
/// A letter's width in the mean, and what is between two labels.
const LETTER: f64 = 5.4;
const GAP: f64 = 12.0;
const COLOURS: [&str; 3] = ["#c2410c", "#1d4ed8", "#15803d"];

/// One curve of a panel.
#[derive(Clone, Debug)]
pub struct Line {
    /// What it is, in words.
    pub label: String,
    /// x and y, by x; what is not finite is left out.
    pub points: Vec<(f64, f64)>,
}

/// One of the panels that stand one above the other.
#[derive(Clone, Debug)]
pub struct Panel {
    /// What y is, with its unit.
    pub y: String,
    /// The curves; a label that another panel has too is of the same colour if it stands at the same place.
    pub lines: Vec<Line>,
}

/// The least and the greatest of the values in each of `bins` equal parts of x, in the order in which they
/// come: peaks survive.
pub fn thin(points: &[(f64, f64)], bins: usize) -> Vec<(f64, f64)> {
    let points: Vec<(f64, f64)> =
        points.iter().copied().filter(|(x, y)| x.is_finite() && y.is_finite()).collect();
    let (Some(first), Some(last)) = (points.first(), points.last()) else { return Vec::new() };
    if points.len() <= 2 * bins || last.0 <= first.0 {
        return points;
    }
    let bin = |x: f64| (((x - first.0) / (last.0 - first.0) * bins as f64) as usize).min(bins - 1);
    let mut thinned = Vec::new();
    for part in points.chunk_by(|a, b| bin(a.0) == bin(b.0)) {
        let by_y = |a: &&(f64, f64), b: &&(f64, f64)| a.1.total_cmp(&b.1);
        let (Some(least), Some(greatest)) = (part.iter().min_by(by_y), part.iter().max_by(by_y)) else {
            continue;
        };
        let mut pair = [*least, *greatest];
        pair.sort_by(|a, b| a.0.total_cmp(&b.0));
        thinned.extend_from_slice(if least == greatest { &pair[..1] } else { &pair });
    }
    thinned
}

/// The range of values, widened by a share of it.
fn range(share: f64, values: impl Iterator<Item = f64>) -> (f64, f64) {
    let (low, high) = values
        .filter(|value| value.is_finite())
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), value| (low.min(value), high.max(value)));
    let margin = if high > low { share * (high - low) } else { 1.0 };
    (low - margin, high + margin)
}

/// A plot: `x` says what x is, with its unit; `from_x` marks where the part begins that was left out of the
/// fit.
pub fn svg(title: &str, x: &str, panels: &[Panel], from_x: Option<f64>) -> String {
    let all = || panels.iter().flat_map(|panel| &panel.lines);
    let (left, right) = range(0.0, all().flat_map(|line| line.points.iter().map(|point| point.0)));
    let height = TOP + PANEL * panels.len() as f64 + BOTTOM;
    let at_x = |value: f64| LEFT + (value - left) / (right - left) * (WIDTH - LEFT - 10.0);
    let mut svg = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {WIDTH} {height}\" font-family=\"sans-serif\" font-size=\"11\">\n\
         <rect width=\"{WIDTH}\" height=\"{height}\" fill=\"#fff\"/>\n<text x=\"{LEFT}\" y=\"15\" font-size=\"12\">{title}</text>\n"
    );
    let mut put = |text: String| svg.push_str(&text);
    for (number, panel) in panels.iter().enumerate() {
        let top = TOP + PANEL * number as f64;
        let (low, high) =
            range(0.04, panel.lines.iter().flat_map(|line| line.points.iter().map(|point| point.1)));
        let at_y = |value: f64| top + PANEL - 16.0 - (value - low) / (high - low) * (PANEL - 24.0);
        put(format!(
            "<rect x=\"{LEFT}\" y=\"{:.1}\" width=\"{:.1}\" height=\"{:.1}\" fill=\"none\" stroke=\"#ccc\"/>\n\
             <text x=\"{:.1}\" y=\"{:.1}\" text-anchor=\"end\">{}</text>\n<text x=\"{:.1}\" y=\"{:.1}\" text-anchor=\"end\">{}</text>\n\
             <text x=\"12\" y=\"{:.1}\" transform=\"rotate(-90 12 {:.1})\" text-anchor=\"middle\">{}</text>\n",
            top + 8.0,
            WIDTH - LEFT - 10.0,
            PANEL - 24.0,
            LEFT - 4.0,
            top + PANEL - 16.0,
            tick(low),
            LEFT - 4.0,
            top + 17.0,
            tick(high),
            top + PANEL / 2.0,
            top + PANEL / 2.0,
            panel.y,
        ));
        if let Some(from_x) = from_x {
            put(format!(
                "<line x1=\"{0:.1}\" x2=\"{0:.1}\" y1=\"{1:.1}\" y2=\"{2:.1}\" stroke=\"#666\" stroke-dasharray=\"4 3\"/>\n",
                at_x(from_x),
                top + 8.0,
                top + PANEL - 16.0
            ));
        }
        for (line, colour) in panel.lines.iter().zip(COLOURS) {
            put(format!(
                "<path d=\"{}\" fill=\"none\" stroke=\"{colour}\" stroke-width=\"0.8\"/>\n",
                path(&thin(&line.points, BINS), &at_x, &at_y, (right - left) / 20.0)
            ));
        }
    }
    let bottom = TOP + PANEL * panels.len() as f64;
    put(format!(
        "<text x=\"{LEFT}\" y=\"{0:.1}\">{1}</text>\n<text x=\"{2:.1}\" y=\"{0:.1}\" text-anchor=\"end\">{3}</text>\n",
        bottom,
        tick(left),
        WIDTH - 10.0,
        tick(right)
    ));
    put(format!("<text x=\"{:.1}\" y=\"{bottom:.1}\" text-anchor=\"middle\">{x}</text>\n", WIDTH / 2.0));
    let labels = panels.first().map_or(&[][..], |panel| &panel.lines);
    let mut from = LEFT;
    for (line, colour) in labels.iter().zip(COLOURS) {
        put(format!(
            "<text x=\"{from:.1}\" y=\"{:.1}\" fill=\"{colour}\">{}</text>\n",
            bottom + 18.0,
            line.label
        ));
        from += LETTER * line.label.chars().count() as f64 + GAP;
    }
    put("</svg>\n".into());
    svg
}

/// A path in whole tenths, broken where x jumps by more than `gap`.
fn path(points: &[(f64, f64)], x: &impl Fn(f64) -> f64, y: &impl Fn(f64) -> f64, gap: f64) -> String {
    let mut text = String::new();
    for (number, point) in points.iter().enumerate() {
        let broken = number == 0 || point.0 - points[number - 1].0 > gap;
        // Writing to a String cannot fail.
        let _ = write!(text, "{}{:.1} {:.1}", if broken { "M" } else { "L" }, x(point.0), y(point.1));
    }
    text
}

fn tick(value: f64) -> String {
    let digits = (2 - value.abs().max(1e-3).log10().floor() as i32).clamp(0, 4);
    format!("{value:.*}", digits as usize)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn peaks_survive_thinning() {
        let mut points: Vec<(f64, f64)> =
            (0..10_000).map(|k| (f64::from(k), (f64::from(k) / 50.0).sin())).collect();
        points[4321].1 = 9.0;
        points[7000].1 = f64::NAN;
        let thinned = thin(&points, 100);
        assert!(thinned.len() <= 200, "{}", thinned.len());
        assert!(thinned.contains(&(4321.0, 9.0)));
        assert!(thinned.is_sorted_by(|a, b| a.0 <= b.0) && thinned.iter().all(|point| point.1.is_finite()));
        assert_eq!(thin(&points[..50], 100).len(), 50);
        assert_eq!(thin(&[], 100), []);
    }

    #[test]
    fn a_plot_is_small_and_well_formed() {
        let line = |label: &str, scale: f64| Line {
            label: label.into(),
            points: (0..50_000).map(|k| (f64::from(k), scale * f64::from(k * 7919 % 1000))).collect(),
        };
        let panel = || Panel { y: "x, nT".into(), lines: vec![line("before", 1.0), line("after", 0.1)] };
        let svg = svg("a title", "time, s", &[panel(), panel(), panel()], Some(20_000.0));
        assert!(svg.len() < 60_000, "{}", svg.len());
        assert_eq!(svg.matches("<path").count(), 6);
        assert_eq!(svg.matches("stroke-dasharray").count(), 3);
        assert!(svg.starts_with("<svg") && svg.ends_with("</svg>\n") && !svg.contains("NaN"));
    }
}
