//! Components of the field in the frame of the document: X north, Y east, Z down.
//!
//! H horizontal, D declination (east), I inclination (down), F magnitude: X = H cos D, Y = H sin D, Z = H tan
//! I, H = F cos I. D and I are in minutes of arc. E is the component across H, nT: H, E, Z (and U, V, W) are
//! axes of the sensor and are left as they are.

use indexmap::IndexMap;
use tables::Place;

use crate::piece::Piece;
use crate::text::Source;
use crate::{Error, Options};

/// What may be a component: X, Y, Z, H, D, I, E and F as usual; S scalar, G = |vector| − scalar, U, V and W
/// sensor axes.
pub const LETTERS: &str = "XYZHDIEFSGUVW";
const ARCMIN: f64 = std::f64::consts::PI / 10_800.0;

/// The component of which a name is the letter.
pub fn letter(name: &str) -> Option<char> {
    let mut letters = name.chars();
    letters.next().filter(|letter| LETTERS.contains(*letter) && letters.next().is_none())
}

/// Puts components into a piece that has its rows: columns of the document, and in the header what was done.
/// Errors: no row, or nothing but missing values.
pub fn put(
    piece: &mut Piece,
    source: &Source,
    (letters, columns): (&[char], Vec<Vec<f64>>),
    base_arcmin: Option<f64>,
    options: &Options,
) -> Result<(), Error> {
    if piece.lines.is_empty() {
        return Err(source.no_row());
    }
    let converted = convert(letters, columns, base_arcmin, &options.quantity);
    if converted.columns.is_empty() {
        let expected = "a reading in one row at least";
        return Err(source.fault(Place::Whole, "nothing but missing values", expected));
    }
    piece.columns = converted.columns;
    piece.header.insert("components".into(), letters.iter().collect::<String>().into());
    piece.header.extend(converted.words.map(|words| ("converted".to_string(), words.into())));
    Ok(())
}

/// Columns of the document, and what was done in words.
pub struct Converted {
    /// By name, in the order x, y, z, scalar, the rest. Components without any value are left out.
    pub columns: IndexMap<String, Vec<f64>>,
    pub words: Option<String>,
}

/// Components as a file has them, by letter.
struct Components<'a> {
    letters: &'a [char],
    columns: Vec<Option<Vec<f64>>>,
}

impl Components<'_> {
    fn place(&self, letter: char) -> Option<usize> {
        self.letters.iter().position(|known| *known == letter)
    }

    fn get(&self, letter: char) -> Option<&[f64]> {
        self.columns[self.place(letter)?].as_deref()
    }

    fn take(&mut self, letter: char) -> Option<Vec<f64>> {
        let place = self.place(letter)?;
        self.columns[place].take()
    }
}

/// Brings components into the document's columns `{quantity}_x_nt`, …, and the scalar to `reference_nt`.
/// `base_arcmin` is added to D.
pub fn convert(
    letters: &[char],
    columns: Vec<Vec<f64>>,
    base_arcmin: Option<f64>,
    quantity: &str,
) -> Converted {
    let there = |values: Vec<f64>| values.iter().any(|value| !value.is_nan()).then_some(values);
    let mut all = Components { letters, columns: columns.into_iter().map(there).collect() };
    let mut words = Vec::new();
    let base = base_arcmin.unwrap_or(0.0);
    let horizontal = match (all.get('H'), all.get('F').or(all.get('S')), all.get('I')) {
        (Some(h), ..) => Some(h.to_vec()),
        (None, Some(f), Some(i)) => Some(each(f, i, |f, i| f * (i * ARCMIN).cos())),
        _ => None,
    };
    let mut vector: [Option<Vec<f64>>; 3] = [None, None, None];
    if let (Some(h), Some(d)) = (&horizontal, all.get('D')) {
        vector[0] = Some(each(h, d, |h, d| h * ((d + base) * ARCMIN).cos()));
        vector[1] = Some(each(h, d, |h, d| h * ((d + base) * ARCMIN).sin()));
        words.push(match base_arcmin {
            Some(base) => format!("X and Y from H and D, {base}' (declination base) added to D"),
            None => "X and Y from H and D".into(),
        });
    }
    if let (None, Some(i)) = (all.get('Z'), all.get('I')) {
        vector[2] = match (all.get('F').or(all.get('S')), &horizontal) {
            (Some(f), _) => Some(each(f, i, |f, i| f * (i * ARCMIN).sin())),
            (None, Some(h)) => Some(each(h, i, |h, i| h * (i * ARCMIN).tan())),
            _ => None,
        };
        words.extend(vector[2].as_ref().map(|_| "Z from I".to_string()));
    }
    // H and D, and I, are spent where all came of them that can.
    let turned = vector[0].is_some();
    let spent: &[char] = if turned { &['H', 'D'] } else { &[] };
    spent.iter().for_each(|letter| drop(all.take(*letter)));
    if vector[2].is_some() && turned {
        all.take('I');
    }
    if !turned && all.get('E').is_some() && all.get('H').is_some() {
        (vector[0], vector[1]) = (all.take('H'), all.take('E'));
        words.push("H and E are taken as the sensor's x and y".into());
    }
    for (axis, names) in [['X', 'U'], ['Y', 'V'], ['Z', 'W']].into_iter().enumerate() {
        for name in names {
            if vector[axis].is_none() {
                vector[axis] = all.take(name);
                if vector[axis].is_some() && "UVW".contains(name) {
                    words.push(format!("{name} is taken as the sensor's {}", ["x", "y", "z"][axis]));
                }
            }
        }
    }
    let mut scalar = all.take('S').or_else(|| all.take('F'));
    if let (None, Some(g), [Some(x), Some(y), Some(z)]) = (&scalar, all.get('G'), &vector) {
        let values = g.iter().zip(x.iter().zip(y.iter().zip(z)));
        scalar = Some(values.map(|(g, (x, (y, z)))| (x * x + y * y + z * z).sqrt() - g).collect());
        words.push("the scalar from G, which is |vector| - scalar".into());
        all.take('G');
    }
    let mut columns = IndexMap::new();
    for (axis, values) in ["x", "y", "z"].into_iter().zip(vector) {
        if let Some(values) = values.and_then(there) {
            columns.insert(format!("{quantity}_{axis}_nt"), values);
        }
    }
    if let Some(values) = scalar.and_then(there) {
        columns.insert("reference_nt".into(), values);
    }
    for (letter, values) in letters.iter().zip(all.columns) {
        let Some(values) = values else { continue };
        let (name, values) = match letter {
            'D' => ("declination_deg".to_string(), values.iter().map(|value| value / 60.0).collect()),
            'I' => ("inclination_deg".to_string(), values.iter().map(|value| value / 60.0).collect()),
            letter => (format!("{}_nt", letter.to_ascii_lowercase()), values),
        };
        columns.insert(name, values);
    }
    Converted { columns, words: (!words.is_empty()).then(|| words.join("; ")) }
}

fn each(a: &[f64], b: &[f64], of: impl Fn(f64, f64) -> f64) -> Vec<f64> {
    a.iter().zip(b).map(|(a, b)| of(*a, *b)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// X 20000, Y 1000, Z 45000 in whatever components.
    #[test]
    fn one_field_in_all_components() {
        let (x, y, z) = (20_000.0_f64, 1000.0_f64, 45_000.0_f64);
        let (h, f) = (x.hypot(y), (x * x + y * y + z * z).sqrt());
        let all = "XYZF XYZG HDZF HDZG DHZF DHIF DIF HDI UVWF XYZS UVZF HDZF";
        for (number, text) in all.split(' ').enumerate() {
            let base = (number == 11).then_some(552.7);
            let value = |letter: &char| match letter {
                'X' | 'U' => x,
                'Y' | 'V' => y,
                'Z' | 'W' => z,
                'H' => h,
                'D' => y.atan2(x) / ARCMIN - base.unwrap_or(0.0),
                'I' => z.atan2(h) / ARCMIN,
                'G' => 2.5,
                _ => f,
            };
            let letters: Vec<char> = text.chars().collect();
            let columns = letters.iter().map(|letter| vec![value(letter), f64::NAN]).collect();
            let mut columns = convert(&letters, columns, base, "sensor").columns;
            let scalar = columns.shift_remove("reference_nt");
            assert_eq!(scalar.is_some(), text.contains(['F', 'S', 'G']), "{text}");
            let due = if text.contains('G') { f - 2.5 } else { f };
            assert!(scalar.is_none_or(|found| (found[0] - due).abs() < 1e-8), "{text}");
            assert!(columns.keys().eq(["sensor_x_nt", "sensor_y_nt", "sensor_z_nt"]), "{text}");
            for (values, due) in columns.values().zip([x, y, z]) {
                assert!((values[0] - due).abs() < 1e-8 && values[1].is_nan(), "{text}: {values:?}");
            }
        }
    }

    #[test]
    fn what_cannot_be_converted_is_kept() {
        let of = |letters: &str| -> Vec<(String, f64)> {
            let letters: Vec<char> = letters.chars().collect();
            let columns = letters.iter().map(|_| vec![60.0]).collect();
            let columns = convert(&letters, columns, None, "test").columns.into_iter();
            columns.map(|(name, values)| (name, values[0])).collect()
        };
        assert_eq!(of("DZ"), [("test_z_nt".to_string(), 60.0), ("declination_deg".to_string(), 1.0)]);
        let names: Vec<String> = of("HEZF").into_iter().map(|(name, _)| name).collect();
        assert_eq!(names, ["test_x_nt", "test_y_nt", "test_z_nt", "reference_nt"]);
        assert_eq!(of("HZ")[1].0, "h_nt");
    }
}
