use std::fmt::Write;

use super::drawn::Plot;

/// The points of a plot: a line each, with the name of its series.
pub fn csv(plot: &Plot) -> String {
    let bars = plot.series.iter().flat_map(|series| &series.points).any(|point| point.bar.is_some());
    let mut text = format!("series,{},{}", quoted(&plot.x.text()), quoted(&plot.y.text()));
    text.push_str(if bars { ",low,high\n" } else { "\n" });
    for series in &plot.series {
        for point in series.values() {
            let _ = write!(text, "{},{},{}", quoted(&series.name), number(point.x), number(point.y));
            if bars {
                let [low, high] = point.bar.unwrap_or([f64::NAN; 2]);
                let _ = write!(text, ",{},{}", number(low), number(high));
            }
            text.push('\n');
        }
    }
    text
}

/// Empty where it is missing.
fn number(value: f64) -> String {
    if value.is_finite() { value.to_string() } else { String::new() }
}

fn quoted(text: &str) -> String {
    if text.contains([',', '"', '\n']) { format!("\"{}\"", text.replace('"', "\"\"")) } else { text.into() }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plot::{Dimension, Mark, Series};

    #[test]
    fn names_are_quoted_and_gaps_empty() {
        let mut plot = Plot::new("p", "P", Dimension::linear("t", "s"), Dimension::linear("B", "nT"));
        plot.push(Series::new("a, \"b\"", Mark::Line, 0, &[0.5, 1.0], &[f64::NAN, 2.0]));
        plot.push(Series::new("c", Mark::Points, 0, &[0.0], &[1.0]).with_std(&[0.25]));
        assert_eq!(
            csv(&plot),
            "series,t (s),B (nT),low,high\n\"a, \"\"b\"\"\",0.5,,,\n\"a, \"\"b\"\"\",1,2,,\nc,0,1,0.75,1.25\n"
        );
    }
}
