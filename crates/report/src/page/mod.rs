//! A page of words, tables and plots, and how it is written: HTML or text.
//!
//! A [`Page`] knows nothing of how it is shown; [`html`] and [`text`] write it. A table holds `Cell`s: a
//! value keeps its uncertainty until it is written. Plots are SVG of our own (`plot`: scale, ticks, thinning,
//! shapes), some 600 lines, where a library would bring fonts and colours: ours are classes, so that the
//! page's style sets the theme. The HTML is well-formed XML, which a parser checks.

pub mod html;
mod model;
pub mod number;
mod places;
pub mod plot;
mod table;
pub mod template;
pub mod text;
pub mod words;

pub use model::{Effect, Field, Finding, Item, Link, Page, Place, Section, Target};
pub use places::{diagnosis, link};
pub use table::{Cell, Header, Table};
