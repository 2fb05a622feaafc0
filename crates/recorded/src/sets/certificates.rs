//! Makers' certificates: do their figures agree with one another, and how large are real angles?

use std::collections::BTreeMap;
use std::fs;

use crate::Error;
use crate::page::{Page, three};
use crate::stages::Stages;

/// Field in which an angle is told as nT.
const FIELD_NT: f64 = 50_000.0;

/// What rounding a resistor to 0.1 kohm and a scale to 0.1 nT/V makes at most.
const ROUNDING_NT_PER_V: f64 = 1.5;

/// The figures of a certificate's table by name.
fn figures(text: &str) -> BTreeMap<String, f64> {
    let cells = |line: &str| -> Vec<String> {
        line.trim().trim_matches('|').split('|').map(|cell| cell.trim().to_string()).collect()
    };
    let figure = |line: &str| -> Option<(String, f64)> {
        let cells = cells(line);
        Some((cells.first()?.clone(), cells.get(2)?.parse().ok()?))
    };
    text.lines().filter_map(figure).collect()
}

/// nT/V that a coil of so many nT/mA gives with a resistor of so many kohm: V/kohm is mA.
fn scale_nt_per_v(figures: &BTreeMap<String, f64>, axis: &str) -> Option<f64> {
    Some(figures.get(&format!("{axis}-coil"))? / figures.get("res")?)
}

/// Reads the four certificates.
pub fn run(stages: &Stages) -> Result<Page, Error> {
    let mut page = Page::default();
    page.say(
        "No recordings: coil constants, angles and resistors as the makers measured them. The scale in nT/V is the coil's constant over the resistor; where a certificate prints it, the two are compared.",
    );
    let (mut compared, mut agree) = (0, 0);
    let (mut scales, mut angles, mut largest) = (Vec::new(), Vec::new(), 0.0_f64);
    for path in stages.files("geonet-fge-constants", ".const.md")? {
        let text = fs::read_to_string(&path).map_err(|source| Error::file(&path, "read", source))?;
        let figures = figures(&text);
        let name =
            path.file_name().map(|name| name.to_string_lossy().replace(".const.md", "")).unwrap_or_default();
        for axis in ["X", "Y", "Z"] {
            let Some(own) = scale_nt_per_v(&figures, axis) else { continue };
            let printed = figures.get(&format!("{axis}-scale"));
            compared += usize::from(printed.is_some());
            agree += usize::from(printed.is_some_and(|printed| (printed - own).abs() <= ROUNDING_NT_PER_V));
            let apart = printed.map_or("".into(), |printed| {
                format!("{:+.1}", (10.0 * (printed - own)).round() / 10.0 + 0.0)
            });
            scales.push(vec![
                format!("{name} {axis}"),
                format!("{own:.1}"),
                printed.map_or("not printed".into(), |printed| format!("{printed:.1}")),
                apart,
            ]);
        }
        let all: Vec<f64> = (0..5).filter_map(|k| figures.get(&format!("ε{k}")).copied()).collect();
        largest = all.iter().fold(largest, |largest, mrad| largest.max(mrad.abs()));
        angles.push(vec![name, all.iter().map(|mrad| format!("{mrad}")).collect::<Vec<_>>().join(", ")]);
    }
    page.head(format!(
        "Of {compared} printed scales {agree} agree with the coil's constant over the resistor."
    ));
    page.table(&["instrument", "coil over resistor, nT/V", "printed, nT/V", "apart, nT/V"], &scales);
    page.table(&["instrument", "ε0 to ε4, mrad"], &angles);
    page.say(format!(
        "The largest angle, {largest} mrad ({:.0}″), is {} nT in {} µT: what `axescal` and `diffmag` state to arcseconds is of this size in instruments of the best make.",
        largest * 206.265,
        three(1e-3 * largest * FIELD_NT),
        FIELD_NT / 1000.0
    ));
    page.undecided(
        "which angle is which and of which sign: the files do not say it, and without a recording no fit can; so they are not turned into a matrix here. Where scale and constant \
         disagree, which of the two is misprinted.",
    );
    Ok(page)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_certificate_is_read_by_its_rows() {
        let figures = figures(
            "| Field | Units | Value | sn |\n| ---| --- | --- | --- |\n| date | | 2021-03-01 | S |\n| X-coil | nT/mA | 40000 | S |\n| res | kohm | 40 | E |\n| ε0 | mrad | -0.2 | S |\n",
        );
        assert_eq!(figures.len(), 3);
        assert_eq!(scale_nt_per_v(&figures, "X"), Some(1000.0));
        assert_eq!((figures["ε0"], scale_nt_per_v(&figures, "Y")), (-0.2, None));
    }
}
