//! Controllers outside this process, over a [link], and [log]s of what a controller received and
//! answered.

pub mod link;
pub mod listen;
pub mod log;
