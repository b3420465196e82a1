//! The `host-sim` command as a program of this package.

use std::process::ExitCode;

fn main() -> ExitCode {
    host_sim::cli::main()
}
