//! Plots: what is drawn ([`Plot`]), and how it becomes SVG.

mod data;
mod drawn;
mod scale;
mod svg;
mod thin;

pub use data::{data, rows_per_entry};
pub use drawn::{Dimension, Interval, Mark, Plot, Point, Series, Timeline, Toggle};
pub use svg::{STYLES, svg, swatch};
pub use thin::thinned;
