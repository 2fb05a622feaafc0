//! How every fluxcal program behaves: its command line with completions and man pages, the document's way through
//! standard streams and files, tables beside the document, and the exit code. Types are `common`'s.

pub mod apart;
pub mod beside;
mod dropped;
pub mod manual;
pub mod number;
mod outline;
pub mod pieces;
pub mod pipe;
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
