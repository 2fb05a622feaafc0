//! Plots: what is drawn ([`Plot`]), and how it becomes SVG.

mod drawn;
mod scale;
mod svg;
mod thin;

pub use drawn::{Dimension, Mark, Plot, Point, Series};
pub use svg::{STYLES, svg, swatch};
pub use thin::thinned;
