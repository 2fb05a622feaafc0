//! Linear least squares against the certified values of the NIST Statistical Reference Datasets.

use faer::Mat;
use serde_json::Value;

/// Digits asked of every coefficient, of its standard deviation and of the residual standard deviation.
///
/// Filip, a polynomial of degree 10, has a condition of 1.8e15 in its raw powers and of 5e9 with columns of unit
/// length: rounding the powers alone leaves 7.6 digits, however they are solved.
const FLOORS: [(&str, f64); 9] = [
    ("Norris", 10.0),
    ("Pontius", 9.0),
    ("Filip", 6.0),
    ("Longley", 9.0),
    ("Wampler1", 6.0),
    ("Wampler2", 6.0),
    ("Wampler3", 6.0),
    ("Wampler4", 6.0),
    ("Wampler5", 6.0),
];

fn numbers(value: &Value) -> Vec<f64> {
    let list = value.as_array().expect("a list");
    list.iter().map(|number| number.as_f64().expect("a number")).collect()
}

/// Intercept and powers of x, or intercept and columns.
fn design(set: &Value) -> Mat<f64> {
    match set["model"].as_str().expect("a model") {
        "polynomial" => {
            let x = numbers(&set["x"]);
            let degree = set["degree"].as_u64().expect("a degree") as usize;
            Mat::from_fn(x.len(), degree + 1, |i, j| x[i].powi(j as i32))
        }
        "linear" => {
            let columns: Vec<Vec<f64>> =
                set["columns"].as_array().expect("columns").iter().map(numbers).collect();
            Mat::from_fn(columns[0].len(), columns.len() + 1, |i, j| match j {
                0 => 1.0,
                _ => columns[j - 1][i],
            })
        }
        other => panic!("model {other}"),
    }
}

/// Log relative error: how many digits agree, at most the 15 that are certified.
fn digits(found: f64, certified: f64) -> f64 {
    let unit = if certified == 0.0 { 1.0 } else { certified.abs() };
    let digits = -((found - certified).abs() / unit).log10();
    // The smaller of NaN and 15 would be 15.
    if digits.is_nan() { f64::NEG_INFINITY } else { digits.min(15.0) }
}

fn fewest_digits(found: &[f64], certified: &[f64]) -> f64 {
    assert_eq!(found.len(), certified.len());
    found.iter().zip(certified).map(|(f, c)| digits(*f, *c)).fold(f64::INFINITY, f64::min)
}

#[test]
fn certified_digits() {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../../fixtures/reference/nist_linear.json");
    let text = std::fs::read_to_string(path).unwrap_or_else(|error| panic!("{path}: {error}"));
    let fixture: Value = serde_json::from_str(&text).expect("certified values");
    let sets = fixture["sets"].as_array().expect("sets");
    assert_eq!(sets.len(), FLOORS.len());
    let mut short = Vec::new();
    for (name, floor) in FLOORS {
        let set = sets.iter().find(|set| set["name"] == name).unwrap_or_else(|| panic!("no set {name}"));
        let (design, y) = (design(set), numbers(&set["y"]));
        let unknowns = design.ncols();
        let fit = estimate::linear::fit(design.as_ref(), &y, None)
            .unwrap_or_else(|error| panic!("{name}: {error}"));

        let variance = fit.sum_of_squares / fit.freedom;
        let stds: Vec<f64> = (0..unknowns).map(|i| (fit.covariance[(i, i)] * variance).sqrt()).collect();
        let residual_std = set["residual_std"].as_f64().expect("a number");
        let coefficients = fewest_digits(&fit.coefficients, &numbers(&set["coefficients"]));
        let stds = fewest_digits(&stds, &numbers(&set["std"]));
        let residual = digits(variance.sqrt(), residual_std);

        // Wampler1 and Wampler2 leave no residuals: what is found there is rounding.
        let exact = residual_std == 0.0;
        let fewest = if exact { coefficients } else { coefficients.min(stds).min(residual) };
        let mut line = format!(
            "{name}: {fewest:.1} digits of {floor} (coefficients {coefficients:.1}, std {stds:.1}, residual std {residual:.1})"
        );
        let rank = y.len() as f64 - fit.freedom;
        if rank < unknowns as f64 {
            line +=
                &format!("; rank {rank} of {unknowns}: the solution of least norm, not the certified one");
        }
        println!("{line}");
        if fewest < floor {
            short.push(line);
        }
    }
    assert!(short.is_empty(), "{}", short.join("\n"));
}
