//! What windows and disturbed times say of the matrix, in words.

use common::number::{counted, duration, p_value, signed, significant, uncertain};
use common::{Axis, Code, Finding, Matrix3x3, MatrixWindows, Quantity, QuietDisturbed};
use physics::frames::ARCSEC;

use crate::words::p_of_one;
use paired::TOLD_BELOW;

pub fn findings(found: &MatrixWindows) -> Vec<Finding> {
    let mut findings = Vec::new();
    let (moved, trend) = (p_of_one(&found.one_matrix), p_of_one(&found.no_trend));
    if moved < TOLD_BELOW {
        let change = &found.largest_change;
        findings.push(Code::NotConstant.said(format!(
            "the matrix is not constant: {} do not share one η ({}); the largest change is {} by {} at {}",
            counted(found.windows.len(), "window"),
            p_value(moved),
            named(&change.element),
            amount(&change.element, &change.change_ppm),
            duration(change.at_s),
        )));
    }
    if trend < TOLD_BELOW
        && let Some((element, change)) = largest(&found.trend_per_day, &found.trend_std_per_day)
    {
        findings.push(Code::SteadyChange.about(&element).said(format!(
            "the matrix changes steadily ({}): {} by {} a day most clearly; a settling pillar or a changing temperature could cause this",
            p_value(trend),
            named(&element),
            amount(&element, &change),
        )));
    }
    findings
}

pub fn quiet_findings(found: &QuietDisturbed) -> Vec<Finding> {
    let (Some(quiet), Some(disturbed), Some(test)) = (&found.quiet, &found.disturbed, &found.one_matrix)
    else {
        return vec![Code::NotDetermined.said(format!(
            "the field is nearly as active in quiet as in disturbed times (a factor of {}): this recording cannot show whether the matrix differs between them",
            significant(found.activity_ratio, 2)
        ))];
    };
    let p = p_of_one(test);
    if p >= TOLD_BELOW {
        return Vec::new();
    }
    let of = |matrix: &dyn Fn(usize, usize) -> f64| -> Matrix3x3 {
        std::array::from_fn(|i| std::array::from_fn(|j| matrix(i, j)))
    };
    let (a, b) = (&quiet.estimate, &disturbed.estimate);
    let difference = of(&|i, j| b.matrix[i][j] - a.matrix[i][j]);
    let std = of(&|i, j| a.std[i][j].hypot(b.std[i][j]));
    let Some((element, change)) = largest(&difference, &std) else { return Vec::new() };
    let mut longest: Vec<[f64; 2]> = disturbed.times_s.clone();
    longest.sort_by(|a, b| (b[1] - b[0]).total_cmp(&(a[1] - a[0])));
    let when = longest.first().map_or(String::new(), |[from, to]| {
        format!(", the longest from {} to {}", duration(*from), duration(*to))
    });
    vec![Code::DiffersWhenDisturbed.about(&element).said(format!(
        "disturbed times ({} of them{when}) have a different matrix from quiet ones ({}), {} by {} most clearly; induced currents that differ between the sites would cause this",
        disturbed.times_s.len(),
        p_value(p),
        named(&element),
        amount(&element, &change)
    ))]
}

/// The element that is farthest from zero for its uncertainty, by name and in 1e-6.
fn largest(values: &Matrix3x3, std: &Matrix3x3) -> Option<(String, Quantity)> {
    let all = Axis::ALL.into_iter().flat_map(|from| Axis::ALL.into_iter().map(move |to| (from, to)));
    let far =
        |(from, to): &(Axis, Axis)| (values[from.index()][to.index()] / std[from.index()][to.index()]).abs();
    let (from, to) = all.max_by(|a, b| far(a).total_cmp(&far(b)))?;
    let (value, std) = (values[from.index()][to.index()], std[from.index()][to.index()]);
    Some((format!("{from}{to}"), Quantity::new(1e6 * value, 1e6 * std)))
}

/// `xz`: z from x.
fn named(element: &str) -> String {
    let (from, to) = element.split_at(element.len().min(1));
    format!("{to} from {from}")
}

/// A scale in ppm, a direction in arcsec.
fn amount(element: &str, change_ppm: &Quantity) -> String {
    let (from, to) = element.split_at(element.len().min(1));
    let (unit, size) = if from == to { ("ppm", 1.0) } else { ("arcsec", 1e-6 / ARCSEC) };
    let (value, std) = (change_ppm.value() * size, change_ppm.std().unwrap_or(0.0) * size);
    format!("{} {unit}", signed(&uncertain(value, std)))
}
