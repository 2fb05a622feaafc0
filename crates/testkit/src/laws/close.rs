//! How alike two answers have to be.

use serde_json::Value;

use super::canonical::canonical;
use super::walk::{is_apart, is_prose, matrix};

/// How alike two answers have to be, whatever the order of what has none ([`canonical`]).
#[derive(Clone, Copy, Debug)]
pub struct Close {
    /// How far a quantity may be off, and its standard uncertainty: parts of that standard uncertainty.
    pub of_std: f64,
    /// How far any other number may be off: a part of itself, of a list of numbers a part of the largest of
    /// them. Probabilities: a part of one.
    pub relative: f64,
    /// How far an entry of a matrix of directions may be off.
    pub direction: f64,
    /// Whether standard uncertainties are compared too.
    pub stds: bool,
    /// Whether what is said in words has to be the same.
    pub words: bool,
    /// What is not compared, by the end or the middle of its path.
    pub apart: &'static [&'static str],
}

impl Close {
    /// The same, to the last digit and word.
    pub const EXACT: Close =
        Close { of_std: 0.0, relative: 0.0, direction: 0.0, stds: true, words: true, apart: &[] };

    /// The same sums in another order. Fields of 50 000 nT have a last digit of 1e-11 nT, a billionth of the
    /// uncertainties and residuals that are looked at here (0.01 nT and more), and some thousand terms are
    /// summed.
    pub const SUMMED: Close =
        Close { of_std: 1e-6, relative: 1e-6, direction: 1e-11, stds: true, words: false, apart: &[] };

    /// Another way to the same minimum: a search ends where a further step would be a small part of the
    /// uncertainty.
    pub const SOLVED: Close =
        Close { of_std: 1e-3, relative: 1e-3, direction: 1e-9, stds: true, words: false, apart: &[] };

    /// The same, less what stands at these paths.
    pub const fn but(self, apart: &'static [&'static str]) -> Self {
        Self { apart, ..self }
    }

    /// Fails with all differences.
    pub fn check(&self, law: &str, found: &Value, expected: &Value) {
        let mut differences = Vec::new();
        self.compare("", &canonical(found), &canonical(expected), &mut differences);
        let all = differences.len();
        differences.truncate(40);
        assert!(all == 0, "{law}: {all} differences\n{}", differences.join("\n"));
    }

    fn compare(&self, path: &str, found: &Value, expected: &Value, out: &mut Vec<String>) {
        if is_apart(path, self.apart) {
            return;
        }
        let mut off = |by: f64, allowed: f64| {
            // What is not a number differs from everything.
            if by.is_nan() || allowed.is_nan() || by > allowed {
                out.push(format!(
                    "{path}: {found} where {expected} is expected: off by {by:.2e}, allowed {allowed:.2e}"
                ));
            }
        };
        let number = |value: &Value, key: &str| value.get(key).and_then(Value::as_f64);
        if let (Some(a), Some(b), Some(u), Some(v)) =
            (number(found, "value"), number(expected, "value"), number(found, "std"), number(expected, "std"))
        {
            // A constant that is known is only rounded.
            off((a - b).abs(), self.of_std * v + if self.of_std > 0.0 { 1e-12 * b.abs() } else { 0.0 });
            if self.stds {
                off((u - v).abs(), self.of_std * v);
            }
            return;
        }
        match (found, expected) {
            (Value::Number(_), Value::Number(_)) => {
                let (a, b) = (found.as_f64().unwrap_or(f64::NAN), expected.as_f64().unwrap_or(f64::NAN));
                let key = path.rsplit('.').next().unwrap_or(path);
                let probability = key == "p" || key.starts_with("p_") || key.ends_with("_p");
                off((a - b).abs(), self.relative * if probability { 1.0 } else { b.abs() + 1e-6 });
            }
            (Value::Array(a), Value::Array(b)) if a.len() == b.len() => {
                if let (Some(a), Some(b)) = (flat(found), flat(expected)) {
                    let allowed = self.of_list(path, expected, &b);
                    for (place, ((a, b), allowed)) in a.iter().zip(&b).zip(allowed).enumerate() {
                        let by = if a.is_nan() && b.is_nan() { 0.0 } else { (a - b).abs() };
                        if by.is_nan() || by > allowed {
                            let off = format!("{a} where {b} is expected, allowed {allowed:.2e}");
                            out.push(format!("{path}[{place}]: {off}"));
                        }
                    }
                    return;
                }
                for (place, (a, b)) in a.iter().zip(b).enumerate() {
                    self.compare(&format!("{path}.{place}"), a, b, out);
                }
            }
            (Value::Object(a), Value::Object(b)) => {
                for key in a.keys().chain(b.keys().filter(|key| !a.contains_key(*key))) {
                    let [a, b] = [a, b].map(|object| object.get(key).unwrap_or(&Value::Null));
                    self.compare(&format!("{path}.{key}"), a, b, out);
                }
            }
            (Value::String(a), Value::String(b)) if is_prose(a) && is_prose(b) && !self.words => {}
            (a, b) if a == b => {}
            (a, b) if is_said(a, b) && !self.words => {}
            (a, b) => out.push(format!("{path}: {a} where {b} is expected")),
        }
    }

    /// How far each entry of a list may be off.
    fn of_list(&self, path: &str, expected: &Value, flat: &[f64]) -> Vec<f64> {
        if path.ends_with(".matrix") || path.ends_with(".orientation") {
            return vec![self.direction; flat.len()];
        }
        if let Some(matrix) = Some(expected).filter(|_| path.ends_with(".covariance")).and_then(matrix) {
            let entry = |place: usize| {
                let (i, j) = (place / matrix.nrows(), place % matrix.nrows());
                self.relative * (matrix[(i, i)] * matrix[(j, j)]).abs().sqrt()
            };
            return (0..flat.len()).map(entry).collect();
        }
        let largest = flat.iter().filter(|x| x.is_finite()).fold(0.0_f64, |most, x| most.max(x.abs()));
        vec![self.relative * largest; flat.len()]
    }
}

/// Whether two lists of sentences, or one and none.
fn is_said(a: &Value, b: &Value) -> bool {
    let said = |value: &Value| match value {
        Value::Null => true,
        Value::Array(list) => list.iter().all(|text| text.as_str().is_some_and(is_prose)),
        _ => false,
    };
    said(a) && said(b)
}

/// All numbers of a list, of lists too; none where it holds anything else.
fn flat(value: &Value) -> Option<Vec<f64>> {
    match value {
        Value::Number(number) => Some(vec![number.as_f64()?]),
        Value::Null => Some(vec![f64::NAN]),
        Value::Array(list) => list.iter().map(flat).collect::<Option<Vec<_>>>().map(|parts| parts.concat()),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    fn differences(close: &Close, found: &Value, expected: &Value) -> usize {
        let mut out = Vec::new();
        close.compare("", found, expected, &mut out);
        out.len()
    }

    #[test]
    fn a_quantity_by_its_uncertainty_and_everything_else_by_itself() {
        let expected = json!({"k": {"value": 6400.0, "std": 0.1}, "p_value": 1e-9, "list_nt": [100.0, 0.0], "model": "line", "note": "in words"});
        let mut found = expected.clone();
        found["note"] = "in other words".into();
        found["p_value"] = 1e-8.into();
        found["list_nt"][1] = 1e-5.into();
        found["k"]["value"] = (6400.0 + 0.5e-7).into();
        assert_eq!(differences(&Close::SUMMED, &found, &expected), 0);
        assert_eq!(differences(&Close::EXACT, &found, &expected), 4);
        found["k"]["value"] = (6400.0 + 2e-7).into();
        found["list_nt"][1] = 1e-3.into();
        found["model"] = "curve".into();
        assert_eq!(differences(&Close::SUMMED, &found, &expected), 3);
        assert_eq!(differences(&Close::SUMMED.but(&["k", "list_nt"]), &found, &expected), 1);
    }
}
