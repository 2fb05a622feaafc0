//! Small pictures of shares with their intervals, as SVG.

use crate::wilson::Share;

const WIDTH: f64 = 560.0;
const HEIGHT: f64 = 260.0;
const LEFT: f64 = 50.0;
const RIGHT: f64 = 12.0;
const TOP: f64 = 30.0;
const BOTTOM: f64 = 44.0;

/// One share of a picture.
#[derive(Clone, Debug)]
pub struct Point {
    /// What stands below it.
    pub label: String,
    /// The share.
    pub share: Share,
    /// What was wanted or printed, where there is such a figure.
    pub wanted: Option<f64>,
}

/// Shares side by side: a dot with its 95 % interval each, and a bar at what was wanted.
pub fn shares(title: &str, below: &str, points: &[Point]) -> String {
    let y = |share: f64| TOP + (1.0 - share) * (HEIGHT - TOP - BOTTOM);
    let x =
        |number: usize| LEFT + (number as f64 + 0.5) * (WIDTH - LEFT - RIGHT) / points.len().max(1) as f64;
    let mut svg = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {WIDTH} {HEIGHT}\" font-family=\"sans-serif\" font-size=\"11\">\n\
         <rect width=\"{WIDTH}\" height=\"{HEIGHT}\" fill=\"#fff\"/>\n<text x=\"{LEFT}\" y=\"16\" font-size=\"12\">{title}</text>\n"
    );
    for percent in [0, 20, 40, 60, 80, 100] {
        let at = y(f64::from(percent) / 100.0);
        svg += &format!(
            "<line x1=\"{LEFT}\" x2=\"{:.1}\" y1=\"{at:.1}\" y2=\"{at:.1}\" stroke=\"#ddd\"/>\n\
             <text x=\"{:.1}\" y=\"{:.1}\" text-anchor=\"end\">{percent} %</text>\n",
            WIDTH - RIGHT,
            LEFT - 6.0,
            at + 4.0
        );
    }
    for (number, point) in points.iter().enumerate() {
        let at = x(number);
        let [low, high] = point.share.interval();
        if let Some(wanted) = point.wanted {
            svg += &format!(
                "<line x1=\"{:.1}\" x2=\"{:.1}\" y1=\"{2:.1}\" y2=\"{2:.1}\" stroke=\"#c2410c\" stroke-width=\"2\"/>\n",
                at - 16.0,
                at + 16.0,
                y(wanted)
            );
        }
        svg += &format!(
            "<line x1=\"{at:.1}\" x2=\"{at:.1}\" y1=\"{:.1}\" y2=\"{:.1}\" stroke=\"#1d4ed8\"/>\n\
             <circle cx=\"{at:.1}\" cy=\"{:.1}\" r=\"4\" fill=\"#1d4ed8\"/>\n\
             <text x=\"{at:.1}\" y=\"{:.1}\" text-anchor=\"middle\">{}</text>\n",
            y(low),
            y(high),
            y(point.share.value()),
            HEIGHT - BOTTOM + 16.0,
            point.label
        );
    }
    svg + &format!(
        "<text x=\"{:.1}\" y=\"{:.1}\" text-anchor=\"middle\">{below}</text>\n</svg>\n",
        (WIDTH + LEFT) / 2.0,
        HEIGHT - 10.0
    )
}

/// Courses one over the other: x and y of each with its words, and what x and y are.
pub fn courses(title: &str, [below, beside]: [&str; 2], lines: &[(String, Vec<[f64; 2]>)]) -> String {
    let range = |k: usize| {
        let all = || lines.iter().flat_map(|(_, points)| points).map(|point| point[k]);
        let (low, high) = (all().fold(f64::INFINITY, f64::min), all().fold(f64::NEG_INFINITY, f64::max));
        if high > low { [low, high] } else { [low - 1.0, low + 1.0] }
    };
    let ([left, right], [low, high]) = (range(0), range(1));
    let x = |value: f64| LEFT + (value - left) / (right - left) * (WIDTH - LEFT - RIGHT);
    let y = |value: f64| TOP + (high - value) / (high - low) * (HEIGHT - TOP - BOTTOM);
    let mut svg = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {WIDTH} {HEIGHT}\" font-family=\"sans-serif\" font-size=\"11\">\n\
         <rect width=\"{WIDTH}\" height=\"{HEIGHT}\" fill=\"#fff\"/>\n<text x=\"{LEFT}\" y=\"16\" font-size=\"12\">{title}</text>\n"
    );
    for value in [low, high] {
        svg += &format!(
            "<line x1=\"{LEFT}\" x2=\"{:.1}\" y1=\"{1:.1}\" y2=\"{1:.1}\" stroke=\"#ddd\"/>\n\
             <text x=\"{2:.1}\" y=\"{3:.1}\" text-anchor=\"end\">{value:.2}</text>\n",
            WIDTH - RIGHT,
            y(value),
            LEFT - 6.0,
            y(value) + 4.0
        );
    }
    for ((words, points), (number, colour)) in
        lines.iter().zip(["#c2410c", "#1d4ed8", "#15803d"].iter().enumerate())
    {
        let path: Vec<String> = points.iter().map(|[a, b]| format!("{:.1},{:.1}", x(*a), y(*b))).collect();
        svg += &format!(
            "<polyline points=\"{}\" fill=\"none\" stroke=\"{colour}\"/>\n<text x=\"{:.1}\" y=\"{:.1}\" fill=\"{colour}\">{words}</text>\n",
            path.join(" "),
            LEFT + 180.0 * number as f64,
            HEIGHT - 10.0
        );
    }
    svg + &format!(
        "<text x=\"{:.1}\" y=\"{1:.1}\" text-anchor=\"middle\">{below}</text>\n<text x=\"4\" y=\"{2:.1}\">{beside}</text>\n</svg>\n",
        (WIDTH + LEFT) / 2.0,
        HEIGHT - BOTTOM + 18.0,
        TOP - 6.0
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_course_goes_from_edge_to_edge() {
        let line = ("before".to_string(), vec![[0.0, -1.0], [2.0, 3.0], [4.0, 1.0]]);
        let svg = courses("a title", ["time, h", "nT"], &[line]);
        assert!(svg.contains("points=\"50.0,216.0 299.0,30.0 548.0,123.0\""), "{svg}");
        assert!(svg.starts_with("<svg") && svg.ends_with("</svg>\n") && !svg.contains("NaN"));
    }

    #[test]
    fn a_share_stands_at_its_height() {
        let point = Point { label: "1 ×".into(), share: Share { hits: 5, trials: 10 }, wanted: Some(0.95) };
        let svg = shares("a title", "strength", &[point]);
        // Half way between 100 % at 30 and 0 % at 216.
        assert!(svg.contains("cy=\"123.0\""), "{svg}");
        assert!(svg.starts_with("<svg") && svg.ends_with("</svg>\n") && !svg.contains("NaN"));
    }
}
