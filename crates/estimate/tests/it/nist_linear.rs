//! Linear least squares against the certified values of the NIST Statistical Reference Datasets.

use estimate::cosine::{Cosine, Errors};
use estimate::{cosine, spectral, tsqr::Tsqr};
use faer::Mat;
use testkit::reference::{list, number, numbers, reference};

/// Digits asked of every coefficient, of its standard deviation and of the residual standard deviation.
///
/// Filip, a polynomial of degree 10, has a condition of 1.8e15 in its raw powers and of 5e9 with columns of
/// unit length: rounding the powers alone leaves 7.6 digits, however they are solved.
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

/// Columns beside the constant, the response, and what is certified of the fit, the constant first.
struct Set {
    columns: Vec<Vec<f64>>,
    y: Vec<f64>,
    coefficients: Vec<f64>,
    stds: Vec<f64>,
    residual_std: f64,
}

fn set(name: &str) -> Set {
    let fixture = reference("nist_linear");
    let set = list(&fixture["sets"]).iter().find(|set| set["name"] == name);
    let set = set.unwrap_or_else(|| panic!("no set {name}"));
    let columns = if set["model"] == "polynomial" {
        let x = numbers(&set["x"]);
        let degree = number(&set["degree"]) as i32;
        (1..=degree).map(|power| x.iter().map(|x| x.powi(power)).collect()).collect()
    } else {
        list(&set["columns"]).iter().map(numbers).collect()
    };
    Set {
        columns,
        y: numbers(&set["y"]),
        coefficients: numbers(&set["coefficients"]),
        stds: numbers(&set["std"]),
        residual_std: number(&set["residual_std"]),
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
    assert_eq!(list(&reference("nist_linear")["sets"]).len(), FLOORS.len());
    for (name, floor) in FLOORS {
        let set = set(name);
        let unknowns = set.columns.len() + 1;
        let design =
            Mat::from_fn(set.y.len(), unknowns, |i, j| if j == 0 { 1.0 } else { set.columns[j - 1][i] });
        let fit = estimate::linear::fit(design.as_ref(), &set.y, None)
            .unwrap_or_else(|error| panic!("{name}: {error}"));
        let variance = fit.sum_of_squares / fit.freedom;
        let stds: Vec<f64> = (0..unknowns).map(|i| (fit.covariance[(i, i)] * variance).sqrt()).collect();
        let coefficients = fewest_digits(&fit.coefficients, &set.coefficients);
        let stds = fewest_digits(&stds, &set.stds);
        let residual = digits(variance.sqrt(), set.residual_std);
        // Wampler1 and Wampler2 leave no residuals: what is found there is rounding.
        let exact = set.residual_std == 0.0;
        let fewest = if exact { coefficients } else { coefficients.min(stds).min(residual) };
        assert!(
            fewest >= floor,
            "{name}: {fewest:.1} digits of {floor}: {coefficients:.1}, std {stds:.1}, residual std {residual:.1}"
        );
    }
}

impl Set {
    /// The fewest digits of coefficients, their uncertainties and the residual standard deviation, from
    /// coefficients without a constant and (X°ᵀX°)⁻¹: the constant is that through the means, the residuals
    /// are those of it.
    fn fewest(&self, coefficients: &[f64], inverse: &Mat<f64>) -> f64 {
        let mean = |values: &[f64]| values.iter().sum::<f64>() / values.len() as f64;
        let means: Vec<f64> = self.columns.iter().map(|column| mean(column)).collect();
        let explained =
            |at: &dyn Fn(usize) -> f64| coefficients.iter().enumerate().map(|(k, b)| b * at(k)).sum::<f64>();
        let middle = mean(&self.y);
        let constant = middle - explained(&|k| means[k]);
        let squares: f64 = (0..self.y.len())
            .map(|row| (self.y[row] - middle - explained(&|k| self.columns[k][row] - means[k])).powi(2))
            .sum();
        let variance = squares / (self.y.len() - self.columns.len() - 1) as f64;
        let stds: Vec<f64> = (0..coefficients.len()).map(|k| (inverse[(k, k)] * variance).sqrt()).collect();
        let found: Vec<f64> = [constant].into_iter().chain(coefficients.iter().copied()).collect();
        let stds = fewest_digits(&stds, &self.stds[1..]);
        fewest_digits(&found, &self.coefficients).min(stds).min(digits(variance.sqrt(), self.residual_std))
    }
}

#[test]
fn longley_in_pieces() {
    let longley = set("Longley");
    let all: Vec<&[f64]> = longley.columns.iter().chain([&longley.y]).map(Vec::as_slice).collect();
    let width = all.len();
    let piece = |from: usize, to: usize| {
        let mut factor = Tsqr::new(width);
        factor.push(&all.iter().map(|column| &column[from..to]).collect::<Vec<_>>());
        factor
    };
    let rows = longley.y.len();
    let mut joined = piece(11, rows);
    joined.merge(&piece(0, 3));
    joined.merge(&piece(3, 11));
    let predictors: Vec<usize> = (0..width - 1).collect();
    for (name, factor) in [("at once", piece(0, rows)), ("joined", joined)] {
        let fit = factor.regress(&predictors, &[width - 1]).expect("a fit");
        assert!(longley.fewest(&fit.coefficients[0], &fit.inverse) > 12.0, "{name}");
        assert!(digits((fit.squares[0] / fit.freedom).sqrt(), longley.residual_std) > 12.0, "{name}");
    }
}

/// Under errors without memory the regressions by transforms are ordinary least squares.
#[test]
fn longley_by_transforms() {
    let longley = set("Longley");
    let fit = spectral::regress(&longley.columns, &longley.y, 1.0, &|_| 2.0).expect("a fit");
    for (name, found) in [("spectral", &fit.least_squares), ("spectral, weighted", &fit.weighted)] {
        assert!(longley.fewest(found, &fit.independent) > 10.0, "{name}");
    }
    let cosine = Cosine::new(longley.y.len(), 1.0);
    let columns: Vec<Vec<f64>> = longley.columns.iter().map(|column| cosine.transform(column)).collect();
    let columns: Vec<&[f64]> = columns.iter().map(Vec::as_slice).collect();
    let y = cosine.transform(&longley.y);
    let fit = cosine::regress(&columns, &y, &Errors::independent(&cosine)).expect("a fit");
    for (name, found) in [("cosine", &fit.least_squares), ("cosine, weighted", &fit.weighted)] {
        assert!(longley.fewest(found, &fit.weighted_covariance) > 10.0, "{name}");
    }
}
