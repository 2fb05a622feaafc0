//! η and what is made of it: the regression, whether it holds still and at which periods, the fourteen
//! parameters.

pub mod across;
pub mod alike;
pub mod bands;
pub mod constancy;
pub mod fourteen;
pub mod mutual;
pub mod regression;
pub mod stability;
pub mod windows;
