//! Three instruments in one field: the noise of each.

use common::{Column, ThreeCornered};
use estimate::cross_spectrum::CrossSpectra;
use estimate::sources::{self, Mixture};
use physics::frames;

use super::correct::by_third;
use super::frame::{Frame, invert};
use super::own::of_axes;
use crate::Error;
use crate::regression;
use joined::Pair;

/// Widest bin of the spectra, as a share of its frequency.
const WIDEST: f64 = 0.05;

/// Splits the differences T η⁻¹ − R and C ζ⁻¹ − R into the noise of three instruments, `frame` with η as the
/// third instrument corrects it. ζ is found in the same way with the test instrument as the third.
pub fn split(pair: &Pair, third: &[Column; 3], frame: &Frame) -> Result<ThreeCornered, Error> {
    let turned = Pair { test: third.to_vec(), third: pair.test.clone().try_into().ok(), ..pair.clone() };
    let fits = regression::fit(&turned, &[])?;
    let turned = regression::without_exponentials(&turned, &fits);
    let other = by_third(&turned, &Frame::start(&turned, &fits)?)?.frame;
    let inverses = [invert(&frame.eta)?, invert(&other.eta)?];
    let mut columns = vec![vec![0.0; 6]; 9];
    for i in 0..3 {
        for (place, inverse) in inverses.iter().enumerate() {
            columns[i][3 * place + i] = -1.0;
            (0..3).for_each(|j| columns[3 + 3 * place + j][3 * place + i] = inverse[(j, i)]);
        }
    }
    let rest: Vec<&[f64]> = frame.rest.iter().chain(&other.rest).map(Vec::as_slice).collect();
    let spectra = CrossSpectra::of_whole(&rest, pair.step_s, WIDEST)?;
    let mixture = Mixture { spectra: &spectra, step_s: pair.step_s, columns, known: Vec::new() };
    let found = sources::fit(&mixture)?;
    Ok(ThreeCornered {
        reference: of_axes(&found.sources[..3]),
        test: of_axes(&found.sources[3..6]),
        third: of_axes(&found.sources[6..]),
        third_matrix: frames::rows(&other.eta),
        goodness_p: found.goodness,
    })
}
