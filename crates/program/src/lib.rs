//! How every fluxcal program behaves: its command line with completions and man pages, the document's way through
//! standard streams and files, tables beside the document, and the exit code. Types are `common`'s.

pub mod apart;
pub mod beside;
pub mod manual;
pub mod number;
mod outline;
pub mod pipe;
mod readings;
