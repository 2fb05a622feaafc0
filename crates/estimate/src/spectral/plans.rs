//! Fourier transforms whose plans each thread keeps: where the same few lengths come again and again on all
//! threads.

use std::cell::RefCell;

use fourier::{Forward, Inverse, Planner};

thread_local! {
    static PLANNER: RefCell<Planner> = RefCell::new(Planner::new());
}

/// The forward transform of `points` real numbers.
pub fn forward(points: usize) -> Forward {
    PLANNER.with_borrow_mut(|planner| planner.forward(points))
}

/// The inverse transform to `points` real numbers.
pub fn inverse(points: usize) -> Inverse {
    PLANNER.with_borrow_mut(|planner| planner.inverse(points))
}
