//! What diagnose weighs, as the columns of a linear model: for other methods that choose among the same
//! explanations.
//!
//! With r the residual of the calibration fitted again, J the derivatives by its constants and xₖ what a
//! candidate does for a unit of its size, all whitened by the noise, a choice among candidates is a choice
//! among the columns of
//!
//! ```text
//! r = J a + Σ xₖ cₖ + e,  e independent with variance one where the noise is as told
//! ```
//!
//! What diagnose searches along a grid (time constants, levels, inflections) stands
//! here at each value of the grid. What it finds by a search of its own (a line's frequency, single readings,
//! steps, frozen stretches, passes, the period and the width of codes) stands here where that search finds it
//! in r, if it stands out of all that was looked at. Left out is what diagnose does beyond a linear model:
//! shapes between the values of the grid, searches again in what is left when something came in, a second
//! linearisation about the constants that go with what was found, and what is known of sizes beforehand.

use common::{Axis, Document, ExplainedEffect};
use estimate::screen::Screen;
use faer::Mat;
use physics::{EffectInstance, Kind};
use std::ops::Range;

use crate::additions::columns_of;
use crate::algebra::square;
use crate::candidates::{Candidate, Pool};
use crate::covariates::on_coil;
use crate::fit::{Fitter, settled};
use crate::level::Rest;
use crate::model::Model;
use crate::observed::Observed;
use crate::products::{Products, Projection};
use crate::proposal::{Addition, Proposal};
use crate::search::Searcher;
use crate::what::{What, named};
use crate::{Error, Options};

/// The linear model.
#[derive(Clone, Debug)]
pub struct Dictionary {
    /// Whitened residual, the rows of prior knowledge of constants behind the readings.
    pub residual: Vec<f64>,
    /// Whitened derivatives by the calibration's constants, with the same rows.
    pub base: Mat<f64>,
    /// What may explain.
    pub groups: Vec<Group>,
    /// The readings of each sensor in each recording, in the order of their rows.
    pub channels: Vec<Readings>,
    /// Mean standard deviation of a reading by the noise, nT: what one is in whitened rows.
    pub noise_nt: f64,
    /// `declared`, or `residuals` where the noise was estimated.
    pub noise_source: &'static str,
    /// Rms of the residual as the document came, nT.
    pub before_nt: f64,
    products: Products,
    projection: Projection,
}

/// The readings of one sensor in one recording.
#[derive(Clone, Debug)]
pub struct Readings {
    /// Their rows in the residual.
    pub rows: Range<usize>,
    /// For each the number of its moment, which the sensors of a recording share: recordings one after the
    /// other, rows in time order.
    pub moments: Vec<usize>,
}

/// All columns of one name on one target.
#[derive(Clone, Debug)]
pub struct Group {
    /// Name with its target.
    pub name: String,
    /// Effect and target alone; None for smooth structure, which has no name.
    pub effect: Option<ExplainedEffect>,
    /// The values of its grid, or the moments at which it was found.
    pub forms: Vec<Form>,
}

/// A group's columns at one value of its grid, or at one moment.
#[derive(Clone, Debug)]
pub struct Form {
    /// The value of the grid.
    pub shape: Option<f64>,
    /// The columns' numbers.
    pub columns: Vec<usize>,
}

/// Of a document, some effects apart.
///
/// # Errors
///
/// As [`crate::run`]: a document that cannot be predicted, or a calibration that cannot be fitted.
pub fn dictionary(document: &Document, without: &[Kind]) -> Result<Dictionary, Error> {
    let options = Options { without: without.to_vec(), ..Options::default() };
    let (model, start) = Model::of(document, Observed::of(document)?)?;
    let before = model.residual(&start)?;
    let (fit, noise) = settled(document, &model, &start)?;
    let pool = Pool::of(&model, &fit.state, &options.without)?;
    let fitter = Fitter { model: &model, noise: &noise };
    let rest = Rest {
        sum_of_squares: fit.cost,
        freedom: fit.white.len().saturating_sub(fit.rank) as f64,
        known: noise.known,
    };
    let (_, found) = Searcher::new(&pool, options.seed, options.level).events(&fitter, &fit, &rest)?;
    let mut groups: Vec<Group> = pool.candidates.iter().map(of_candidate).collect();
    let mut products = Products::of(&model.observed);
    let mut raw = pool.columns.clone();
    for proposal in &found {
        let Some((columns, _)) = columns_of(&model, &fit.state, proposal)? else { continue };
        add(&mut groups, proposal, (raw.len()..raw.len() + columns.len()).collect());
        raw.extend(columns);
    }
    products.push(&noise, &raw);
    Ok(Dictionary {
        channels: channels(&model.observed),
        noise_nt: noise.variance().sqrt(),
        noise_source: noise.source,
        before_nt: (square(&before) / before.len().max(1) as f64).sqrt(),
        projection: Projection::of(&fit)?,
        residual: fit.white,
        base: fit.jacobian,
        groups,
        products,
    })
}

impl Dictionary {
    /// How many columns there are.
    pub fn columns(&self) -> usize {
        self.products.len()
    }

    /// A whitened column at the readings of a channel; None where it is zero throughout.
    pub fn part(&self, column: usize, channel: usize) -> Option<&[f64]> {
        self.products.column(column).part(channel)
    }

    /// Products of all columns and of the residual, the calibration's derivatives projected out.
    pub fn screen(&self) -> Screen {
        let mut projection = self.projection.clone();
        let mut screen = projection.screen();
        projection.extend(&mut screen, &self.products);
        screen
    }
}

fn channels(observed: &Observed<'_>) -> Vec<Readings> {
    let mut first = 0;
    let mut of_runs = Vec::new();
    for run in &observed.runs {
        of_runs.push(first);
        first += run.setting.context.rows;
    }
    let of = |channel: &crate::channel::Channel| Readings {
        rows: channel.range(),
        moments: channel.rows.iter().map(|row| of_runs[channel.run] + row).collect(),
    };
    observed.channels.iter().map(of).collect()
}

fn of_candidate(candidate: &Candidate) -> Group {
    let effect = match &candidate.what {
        What::Physics(effect) => Some(alone(effect)),
        What::Smooth { .. } => None,
    };
    let forms = candidate.trials.iter().map(|t| Form { shape: t.shape, columns: t.columns.clone() });
    Group { name: candidate.what.name(), effect, forms: forms.collect() }
}

/// Adds what was found by a search of its own to the group of its name and target.
fn add(groups: &mut Vec<Group>, found: &Proposal, columns: Vec<usize>) {
    let (name, effect) = match &found.addition {
        Addition::Effect(effect) => (named(effect), Some(alone(effect))),
        // A single reading of a scalar magnetometer, which no effect of the catalogue names.
        Addition::Single(single) => (single.what.clone(), None),
    };
    let form = Form { shape: None, columns };
    match groups.iter_mut().find(|group| group.name == name) {
        Some(group) => group.forms.push(form),
        None => groups.push(Group { name, effect, forms: vec![form] }),
    }
}

/// Name and target of an effect, without sizes.
fn alone(effect: &EffectInstance) -> ExplainedEffect {
    let on = |coil: bool| -> Option<Axis> { effect.axis.filter(|_| on_coil(effect) == coil) };
    let about = effect.kind.about();
    ExplainedEffect {
        effect: effect.kind.name().into(),
        sensor: on(false),
        coil: on(true),
        column: effect.column.clone(),
        title: about.title.into(),
        physics: about.physics.into(),
        equation: about.equation.into(),
        source: about.source.into(),
        ..ExplainedEffect::default()
    }
}
