//! The tests of normality and of runs against SciPy and statsmodels, and how often they reject what is true.

use estimate::normality::{anderson_darling, runs};
use noise::Stream;
use testkit::reference::{list, number, numbers, reference};

use crate::made::white;

fn normal(seed: u64, count: usize, std: f64) -> Vec<f64> {
    white(&mut Stream::new(seed, "normality"), count, std)
}

/// Signs as values: `+` is 1, `-` is −1, `0` is 0.
fn signs(text: &str) -> Vec<f64> {
    text.chars()
        .map(|sign| if sign == '0' { 0.0 } else { f64::from(i8::from(sign == '+') * 2 - 1) })
        .collect()
}

#[test]
fn statistic_and_probability_of_scipy() {
    for set in list(&reference("normality_scipy")["sets"]) {
        let values = numbers(&set["values"]);
        let (found, p) = anderson_darling(&values).unwrap_or_else(|| panic!("{}", set["name"]));
        let n = values.len() as f64;
        let expected = number(&set["a_squared"]) * (1.0 + 0.75 / n + 2.25 / (n * n));
        let off = (found / expected - 1.0).abs();
        assert!(off < 1e-10, "{}: {found}, {expected}", set["name"]);
        let expected_p = number(&set["p"]);
        if expected_p == 0.0 {
            assert!(expected > 13.0 && p < 5e-31, "{}: {p}", set["name"]);
        } else {
            let off_p = (p / expected_p - 1.0).abs();
            // statsmodels takes 1 − Φ, which has few digits left far above the mean.
            assert!(off_p < 1e-9, "{}: {p}, {expected_p}", set["name"]);
        }
    }
}

#[test]
fn runs_of_statsmodels() {
    let (mut exact, mut normal) = (0, 0);
    for set in list(&reference("normality_scipy")["sets"]) {
        let expected = &set["runs"];
        let found = runs(&numbers(&set["values"]));
        if expected.is_null() {
            assert_eq!(found, None, "{}", set["name"]);
            continue;
        }
        let (z, p) = found.unwrap_or_else(|| panic!("{}", set["name"]));
        let off_z = (z - number(&expected["z"])).abs();
        assert!(off_z < 1e-12, "{}: {z}, {}", set["name"], expected["z"]);
        let off = (p / number(&expected["p"]) - 1.0).abs();
        let counted = number(&expected["above"]).min(number(&expected["below"])) < 20.0;
        let (branch, most) = if counted { (&mut exact, 1e-13) } else { (&mut normal, 1e-9) };
        assert!(off < most, "{}: {p}, {}", set["name"], expected["p"]);
        *branch += 1;
    }
    assert!(exact > 8 && normal > 8);
}

#[test]
fn normal_samples_are_rejected_as_often_as_said() {
    let mut stream = Stream::new(9, "normality");
    let trials = 2000;
    let (mut forms, mut orders) = (0, 0);
    for _ in 0..trials {
        let sample = white(&mut stream, 101, 0.3);
        forms += usize::from(anderson_darling(&sample).expect("a test").1 < 0.05);
        orders += usize::from(runs(&sample).expect("a test").1 < 0.05);
    }
    let share = |count: usize| count as f64 / f64::from(trials);
    assert!((0.04..=0.06).contains(&share(forms)), "{}", share(forms));
    // The runs are whole numbers: at most the level, and less by what the next number would add.
    assert!((0.02..=0.06).contains(&share(orders)), "{}", share(orders));
}

#[test]
fn no_form_without_values_or_scatter() {
    let sample = normal(10, 8, 1.0);
    assert!(anderson_darling(&sample).is_some());
    assert_eq!(anderson_darling(&sample[..7]), None);
    assert_eq!(anderson_darling(&[]), None);
    assert_eq!(anderson_darling(&[0.1; 30]), None);
    assert_eq!(anderson_darling(&[50_000.1; 31]), None);
    for spoilt in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        let mut sample = sample.clone();
        sample[3] = spoilt;
        assert_eq!(anderson_darling(&sample), None, "{spoilt}");
    }
}

#[test]
fn unit_offset_and_order_do_not_change_the_form() {
    let sample = normal(11, 60, 1.0);
    let (expected, _) = anderson_darling(&sample).expect("a test");
    let mut mirrored: Vec<f64> = sample.iter().map(|x| -8.0 * x + 4096.0).collect();
    mirrored.reverse();
    let (found, _) = anderson_darling(&mirrored).expect("a test");
    assert!((found - expected).abs() < 1e-9, "{found}, {expected}");
}

#[test]
fn runs_by_hand() {
    // Three of either sign have 20 orders: 2, 3, 4, 5, 6 runs in 2, 4, 8, 4, 2 of them.
    for (order, p) in [("+++---", 0.2), ("++---+", 0.6), ("+-+--+", 0.6), ("+--++-", 1.0), ("-+-+-+", 0.2)] {
        let (_, found) = runs(&signs(order)).expect("a test");
        assert!((found - p).abs() < 1e-15, "{order}: {found}");
    }
    // μ = 4 and σ² = 6/5.
    let (z, _) = runs(&signs("0+++00---")).expect("a test");
    assert!((z + 1.5 / 1.2_f64.sqrt()).abs() < 1e-15, "{z}");
    assert_eq!(runs(&signs("+-")), Some((0.0, 1.0)));
    assert_eq!(runs(&signs("-0+")), Some((0.0, 1.0)));
    // Many of one sign and a single other one, in the middle: three runs, as in nearly all orders.
    let mut many = vec![1.0; 100_001];
    many[50_000] = -1.0;
    assert_eq!(runs(&many).expect("a test").1, 1.0);
}

#[test]
fn no_runs_of_one_sign() {
    for order in ["", "0", "+", "----", "00+0"] {
        assert_eq!(runs(&signs(order)), None, "{order}");
    }
    assert_eq!(runs(&[1.0, f64::NAN, -1.0]), None);
}
