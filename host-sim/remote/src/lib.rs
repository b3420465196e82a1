//! Controllers elsewhere: the [link] to one on a chip or behind a socket, and the [log] of what one did.

pub mod link;
pub mod listen;
pub mod log;
