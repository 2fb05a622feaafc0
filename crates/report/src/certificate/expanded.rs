//! A result with its expanded uncertainty.

use crate::certificate::sheet::BLANK;
use crate::conformity::NORMAL;
use crate::page::Cell;
use crate::page::number::{as_known, bare, figures, uncertain};
use common::Quantity;

/// `6401.196 ± 0.029` and k: U = k u, the half width of the 95 % interval (JCGM 100, 6.2), with two digits,
/// the value to the same decimal (7.2.6). k is the quantity's own `coverage_factor_95`, else that of the fit it
/// comes from, else the normal one. An interval that is not as far to either side stands in the place of U.
pub fn expanded(quantity: &Quantity, of_the_fit: Option<f64>) -> [Cell; 2] {
    let value = quantity.value();
    if let Quantity::Stated { interval_95: Some([low, high]), .. } = quantity {
        let half = 0.5 * (high - low);
        let [value, low, high] = [value, *low, *high].map(|end| as_known(end, half));
        return [format!("{value} ({low} to {high})").into(), "interval".into()];
    }
    let known = |number: &f64| number.is_finite() && *number > 0.0;
    let factor = quantity.coverage_factor_95().or(of_the_fit).filter(known).unwrap_or(NORMAL);
    let Some(std) = quantity.std().filter(known) else {
        return [bare(value).into(), format!("{BLANK} (7.8.4.1 a)").into()];
    };
    let bound = if quantity.is_at_least() { " (at least)" } else { "" };
    [format!("{}{bound}", uncertain(value, factor * std)).into(), figures(factor, 3).into()]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn u_has_two_digits_and_the_value_its_decimal() {
        let stated = Quantity::new(6401.196031, 0.0146127);
        let lag = Quantity::new(204.2, 73.0).within([120.4, 351.7]);
        for (quantity, of_the_fit, cells) in [
            (stated.clone(), None, ["6401.196 ± 0.029", "1.96"]),
            (stated.clone(), Some(2.26), ["6401.196 ± 0.033", "2.26"]),
            // Its own factor goes before that of the fit.
            (stated.clone().covered_by(3.0), Some(2.26), ["6401.196 ± 0.044", "3.00"]),
            (stated.at_least(), None, ["6401.196 ± 0.029 (at least)", "1.96"]),
            (lag, None, ["200 (120 to 350)", "interval"]),
            (Quantity::Bare(50000.0), None, ["50000", "________________ (7.8.4.1 a)"]),
        ] {
            assert_eq!(expanded(&quantity, of_the_fit).map(|cell| cell.to_string()), cells);
        }
    }
}
