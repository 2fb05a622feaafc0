//! How every fluxcal program behaves: its command line with completions and man pages, the document's way
//! through standard streams and files, tables beside the document, and the exit code. Types are `common`'s.
//!
//! Every option's value may begin with a minus sign. Every help text and man page begins with what the
//! program does and an example. Long work is shown on a terminal ([`progress`]) without a line in the
//! programs. Where a document is expected and a file of readings is given, the message names the command that
//! reads it (`readings`). The allocator is mimalloc: with the system's, a month of seconds takes half as much
//! memory again.
//!
//! Only `main.rs` and what writes files use this crate, so that `physics`, `noise` and the libraries of the
//! stages are not compiled again when it changes.

pub mod apart;
pub mod beside;
mod dropped;
mod keys;
pub mod manual;
pub mod number;
mod outline;
pub mod pieces;
pub mod pipe;
pub mod place;
pub mod progress;
mod readings;
mod sink;

/// Bytes as hexadecimal digits.
fn hexadecimal(bytes: &[u8]) -> String {
    bytes.iter().map(|byte| format!("{byte:02x}")).collect()
}

/// Columns of long series come and go: the system's allocator keeps half as much again of a month of seconds.
#[global_allocator]
static ALLOCATOR: mimalloc::MiMalloc = mimalloc::MiMalloc;
