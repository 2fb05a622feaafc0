//! The integration tests of `physics`: one program, a module for each subject.

mod by_hand;
mod catalogue;
mod inverse;
