//! What explains this residual? Recorded columns, time and clocks, weighed together with the noise.
//!
//! A [`Problem`] has channels that are read at the same moments, the base that makes them up in any case, and
//! what was recorded beside them. [`explain`] gives the set of causes that explains them best, with its
//! probability and that of its rivals, amplitudes with their uncertainties, and what is left. It knows nothing of
//! documents.
//!
//! What acts without having been recorded is a [`Course`]: its columns come with the problem.
//!
//! - `form` has the forms of a cause: at once, late by a relaxation or by whole samples, bent. `stack` puts all
//!   columns side by side, whitens them under each form of noise (`noises`) and forms their products.
//! - `sweep` is the evidence of a regression, `search` the search over sets, `select` the search as a whole:
//!   screened on thinned rows, decided on all.
//! - `reference` takes the noise of the readings that the others are regressed on out of the products; a name
//!   that does not stand then is none.
//! - `amplitude` fits. `held_out` says what fit and noise predict of readings that are left out: a name that does
//!   not lower that is none; and what plain rivals do.

mod amplitude;
mod explained;
mod fit;
mod form;
mod held_out;
mod noises;
mod problem;
mod reference;
mod search;
mod select;
mod stack;
mod sweep;

pub use amplitude::Amplitude;
pub use explained::{Explained, explain};
pub use fit::Fit;
pub use form::{Form, sampled, smoothed};
pub use held_out::{HeldOut, Plain};
pub use noises::{filter, power_law};
pub use problem::{Cause, Course, Covariate, Problem, Term};
pub use search::{Rival, odds};
pub use select::{thinned, weigh};
