//! Which recordings reach a target in the least time, and which orientations are best: `axescal design`.
//!
//! `given` is what facility and instrument err by, `information` what an orientation says by the derivatives
//! of the fit, `least` the search, `limits` what limits it, `basis` the plan before and after, `report` the
//! answer. With `--number` sets of orientations are ranked alone: `ranking`.

mod basis;
mod command;
mod given;
mod information;
mod least;
mod limits;
mod radius;
mod ranking;
mod report;

pub use basis::{given, ordinary, proof};
pub use command::{Arguments, main};
pub use ranking::{ErrorModel, worst_arcsec};
pub use report::{Request, plan};
