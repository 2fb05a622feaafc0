//! Cases of `concealed` made and sealed, answered by the programs as they are shipped, opened once and scored.

mod arguments;
mod campaigns;
mod error;
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
pub use error::Error;
pub use steps::{answer, make, score, summary};
pub use tally::{Arguments as Tally, run as tally};
