//! Physics finer than the catalogue's, each piece by itself.

pub mod converter;
pub mod diffusion;
pub mod loop2;
pub mod mains;
pub mod nulling;
pub mod ode;
pub mod plates;
pub mod preisach;
pub mod quartz;
pub mod thermal;
