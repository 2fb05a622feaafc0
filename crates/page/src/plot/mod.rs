//! Plots: what is drawn ([`Plot`]), and how it becomes SVG.

mod csv;
mod drawn;
mod ellipse;
mod scale;
mod svg;
mod thin;
mod ticks;

pub use csv::csv;
pub use drawn::{Dimension, Mark, Plot, Point, Series};
pub use ellipse::ellipse;
pub use svg::{STYLES, svg, swatch};
pub use thin::thinned;
