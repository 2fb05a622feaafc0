//! Series by their times: whether they are even, made even, at other times, one behind the other, fewer
//! points for plots.

pub mod cadence;
pub mod even;
pub mod grouped;
pub mod lag;
pub mod resample;
