//! Stepwise regression: the form that lowers the criterion most comes in, any that raises it goes, until
//! neither helps.
//!
//! A form is all columns of a group at one value of its grid or at one moment, or one of these columns alone.
//! Several forms of a group may come in.

use diagnose::{Dictionary, Error};
use estimate::screen::Screen;
use rayon::prelude::*;

use crate::Choice;
use crate::criterion::{Criterion, SEARCH};

/// Most forms.
const MOST: usize = 60;

/// What may come in: columns, and ln of among how many candidates it is one.
#[derive(Clone, Debug)]
struct Form {
    group: usize,
    columns: Vec<usize>,
    log_candidates: f64,
}

/// Chooses forms of a dictionary.
pub fn choose(dictionary: &Dictionary, screen: &Screen) -> Result<Choice, Error> {
    let groups = dictionary.groups.len() as f64;
    let forms: Vec<Form> = (dictionary.groups.iter().enumerate())
        .flat_map(|(group, own)| {
            let all = own.forms.iter().flat_map(|form| {
                let single =
                    form.columns.iter().filter(|_| form.columns.len() > 1).map(|column| vec![*column]);
                single.chain([form.columns.clone()])
            });
            let all: Vec<Vec<usize>> = all.collect();
            let log_candidates = (groups * all.len() as f64).ln();
            all.into_iter().map(move |columns| Form { group, columns, log_candidates })
        })
        .collect();
    let criterion = Criterion { rows: screen.freedom(), search: SEARCH };
    let (chosen, value) = stepwise(screen, &forms, criterion)?;
    let mut groups: Vec<usize> = Vec::new();
    for form in &chosen {
        if !groups.contains(&forms[*form].group) {
            groups.push(forms[*form].group);
        }
    }
    let columns = chosen.iter().flat_map(|form| &forms[*form].columns).map(|column| vec![(*column, 1.0)]);
    let nothing = criterion.of(screen.sum_of_squares(), 0.0, 0.0);
    let reasons = vec![format!(
        "{} forms among {} lower the extended Bayesian information criterion by {:.1}",
        chosen.len(),
        forms.len(),
        nothing - value
    )];
    Ok(Choice { groups, columns: columns.collect(), reasons })
}

/// The forms chosen, in the order in which they came, and the criterion.
fn stepwise(screen: &Screen, forms: &[Form], criterion: Criterion) -> Result<(Vec<usize>, f64), Error> {
    let mut chosen: Vec<usize> = Vec::new();
    let mut least = criterion.of(screen.sum_of_squares(), 0.0, 0.0);
    let mut left = screen.clone();
    while chosen.len() < MOST {
        let search = |chosen: &[usize]| chosen.iter().map(|form| forms[*form].log_candidates).sum::<f64>();
        let (inside, searched) = (rank(screen, forms, &chosen)?, search(&chosen));
        let more = (0..forms.len()).into_par_iter().filter(|form| !chosen.contains(form)).map(|form| {
            let gain = left.gain(&forms[form].columns)?;
            let rest = left.sum_of_squares() - gain.gain;
            let cost = searched + forms[form].log_candidates;
            Ok((criterion.of(rest, (inside + gain.rank) as f64, cost), form))
        });
        let more: Vec<(f64, usize)> = more.collect::<Result<_, Error>>()?;
        let best = more.into_iter().min_by(|a, b| a.0.total_cmp(&b.0));
        let fewer = chosen.par_iter().map(|gone| {
            let kept: Vec<usize> = chosen.iter().copied().filter(|form| form != gone).collect();
            let gain = screen.gain(&columns(forms, &kept))?;
            let rest = screen.sum_of_squares() - gain.gain;
            Ok((criterion.of(rest, gain.rank as f64, search(&kept)), *gone))
        });
        let fewer: Vec<(f64, usize)> = fewer.collect::<Result<_, Error>>()?;
        let worst = fewer.into_iter().min_by(|a, b| a.0.total_cmp(&b.0));
        match (best, worst) {
            (best, Some((value, gone))) if value < least && best.is_none_or(|(other, _)| value <= other) => {
                least = value;
                chosen.retain(|form| *form != gone);
                left = screen.given(&columns(forms, &chosen))?;
            }
            (Some((value, form)), _) if value < least => {
                least = value;
                chosen.push(form);
                left = left.given(&forms[form].columns)?;
            }
            _ => break,
        }
    }
    Ok((chosen, least))
}

fn columns(forms: &[Form], chosen: &[usize]) -> Vec<usize> {
    chosen.iter().flat_map(|form| forms[*form].columns.iter().copied()).collect()
}

fn rank(screen: &Screen, forms: &[Form], chosen: &[usize]) -> Result<usize, Error> {
    Ok(screen.gain(&columns(forms, chosen))?.rank)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::thresholded::reference;
    use estimate::screen::Products;
    use faer::Mat;

    /// A stepwise search in NumPy on the same columns: fixtures/reference/baselines_pysindy.py.
    #[test]
    fn the_same_columns_as_a_search_in_numpy() {
        for case in reference::cases() {
            let (columns, response) = (&case.columns, &case.response);
            let width = columns.len();
            let mut products = Products::of(width + 1);
            let value = |i: usize, j: usize| match j {
                0 => 1.0,
                j if j <= width => columns[j - 1][i],
                _ => response[i],
            };
            products.push(Mat::from_fn(response.len(), width + 2, value).as_ref());
            let screen = Screen::of(&products).given(&[0]).expect("finite");
            let form = |column| Form { group: column, columns: vec![column + 1], log_candidates: 1.0 };
            let forms: Vec<Form> = (0..width).map(form).collect();
            // n is the number of rows there; the constant counts once in every model.
            let criterion = Criterion { rows: response.len() as f64, search: 0.0 };
            let (mut found, _) = stepwise(&screen, &forms, criterion).expect("finite");
            found.sort_unstable();
            assert_eq!(found, case.stepwise);
        }
    }
}
