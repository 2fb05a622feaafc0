//! Whether the calibration fitted again leaves as little as plain linear least squares of the same constants.

use common::PlainRegression;
use common::number::significant;

use crate::Error;
use crate::fit::{Fit, Fitter};
use crate::model::{Model, State};
use crate::projection::Projection;
use crate::whitening::NoiseModel;

/// What is to be said of a fit from a start that leaves more than linear least squares at the start, under the same
/// noise.
pub fn worse(
    model: &Model<'_>,
    start: &State,
    (fit, noise): (&Fit, &NoiseModel),
) -> Result<Option<String>, Error> {
    let begun = Fitter { model, noise }.at(start)?;
    let linear = Projection::of(&begun)?.screen().sum_of_squares();
    let ratio = if linear > 0.0 { (fit.cost / linear).sqrt() } else { 1.0 };
    Ok((ratio > PlainRegression::WORSE).then(|| {
        format!(
            "the calibration fitted again leaves {} times the residual of linear least squares of the same constants: it did not converge; give a calibration nearer to the true one",
            significant(ratio, 3)
        )
    }))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fit::settled;
    use crate::observed::Observed;
    use common::Document;

    #[test]
    fn a_fit_that_stays_where_it_began_is_told() {
        let document =
            Document::parse(&testkit::read_fixture("diagnose/warm/input.json")).expect("a document");
        let (model, start) = Model::of(&document, Observed::of(&document).expect("read")).expect("a model");
        let (fit, noise) = settled(&document, &model, &start).expect("fitted");
        assert_eq!(worse(&model, &start, (&fit, &noise)).expect("compared"), None);
        let stays = Fitter { model: &model, noise: &noise }.at(&start).expect("finite");
        let words = worse(&model, &start, (&stays, &noise)).expect("compared").expect("words");
        assert!(words.contains("did not converge"), "{words}");
    }
}
