//! The integration tests of `recorded`.

mod real;
