//! How every fluxcal program behaves: its command line with completions and man pages, the document's way through
//! standard streams and files, tables beside the document, and the exit code. Types are `common`'s.

pub mod apart;
pub mod beside;
pub mod manual;
pub mod number;
mod outline;
pub mod pieces;
pub mod pipe;
mod readings;

/// Columns of long series come and go: the system's allocator keeps half as much again of a month of seconds.
#[global_allocator]
static ALLOCATOR: mimalloc::MiMalloc = mimalloc::MiMalloc;
