//! What others would answer in the place of diagnose: three ways to choose among the columns of a linear
//! model, each with the whole of diagnose's dictionary ([`diagnose::dictionary`]): lags, events, lines and
//! grids of shapes, whitened by the same noise, the calibration's constants projected out. Their answers have
//! the shape of diagnose's and are scored by the same code.

mod answer;
mod blocks;
mod criterion;
mod ensemble;
mod lasso;
mod reduced;
mod stability;
mod stepwise;
mod thresholded;

pub use answer::summary;

use clap::ValueEnum;
use common::Document;
use diagnose::{Dictionary, Error, dictionary};
use physics::Kind;

/// How effects are chosen.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Method {
    /// Forward and backward steps by the extended Bayesian information criterion
    Stepwise,
    /// Group lasso, what half-samples agree on (stability selection)
    Lasso,
    /// Sequentially thresholded least squares, what most bags agree on (SINDy's ensemble)
    Ensemble,
}

impl Method {
    /// Its name on the command line.
    pub fn name(self) -> &'static str {
        match self {
            Method::Stepwise => "stepwise",
            Method::Lasso => "lasso",
            Method::Ensemble => "ensemble",
        }
    }
}

/// What is asked for.
#[derive(Clone, Debug)]
pub struct Options {
    /// The method.
    pub method: Method,
    /// Seed of half-samples and bags.
    pub seed: u64,
    /// Effects that the dictionary is without.
    pub without: Vec<Kind>,
}

/// A weighted sum of the dictionary's columns: their numbers and weights.
type Combination = Vec<(usize, f64)>;

/// What a method chose.
#[derive(Clone, Debug, Default)]
struct Choice {
    /// Numbers of groups, those first that came first or are chosen most often.
    groups: Vec<usize>,
    /// What of their columns is fitted.
    columns: Vec<Combination>,
    /// How it came to that, in words.
    reasons: Vec<String>,
}

/// Writes the answer of a method to `diagnosis`; the model stays as it is.
///
/// # Errors
///
/// As [`diagnose::dictionary`].
pub fn run(mut document: Document, options: &Options) -> Result<Document, Error> {
    let dictionary = dictionary(&document, &options.without)?;
    let choice = choose(&dictionary, options)?;
    document.diagnosis = Some(vec![answer::diagnosis(&dictionary, &choice)?]);
    Ok(document)
}

fn choose(dictionary: &Dictionary, options: &Options) -> Result<Choice, Error> {
    let screen = dictionary.screen();
    match options.method {
        Method::Stepwise => stepwise::choose(dictionary, &screen),
        Method::Lasso => stability::choose(dictionary, &screen, options.seed),
        Method::Ensemble => ensemble::choose(dictionary, &screen, options.seed),
    }
}
