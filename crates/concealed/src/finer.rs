//! Physics finer than the catalogue's, each piece by itself.

pub mod average;
pub mod bandgap;
pub mod beside;
pub mod bodies;
pub mod clip;
pub mod convection;
pub mod converter;
pub mod diffusion;
pub mod dipole;
pub mod jiles;
pub mod loop2;
pub mod mains;
pub mod nulling;
pub mod ode;
pub mod plates;
pub mod plays;
pub mod poles;
pub mod preisach;
pub mod quartz;
pub mod relaxation;
pub mod thermal;
pub mod turns;
pub mod wall;
