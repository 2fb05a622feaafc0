//! Cases of `concealed` made and sealed, answered by the programs as they are shipped, opened once and
//! scored.
//!
//! `steps` are the three runs: make, answer, score. `folder` has documents and answers, `seal` the digests of
//! the truths and their opening, `verdict` an answer against its truth, `reliability` whether printed
//! probabilities hold, `score` and `page` the rest. For development `tally` makes and scores at once, a line
//! a case; with `--removed` the concealed effect is taken out of diagnose's catalogue. `hosts` asks diagnose
//! which real recordings show nothing before anything is added to them; `hosted` counts the results in those.

mod arguments;
mod campaigns;
mod folder;
mod history;
mod hosted;
mod hosts;
mod methods;
mod page;
mod reliability;
mod score;
mod seal;
mod steps;
mod tally;
mod verdict;
mod wilson;

pub use arguments::{Answer, Make, Scoring};
pub use campaigns::{Campaign, month, orbit};
pub use steps::{answer, make, score, summary};
pub use tally::{Arguments as Tally, run as tally};
pub use testkit::programs::Error;
