//! The `host-sim` command: see `host-sim --help`.

use std::process::ExitCode;

fn main() -> ExitCode {
    host_sim::cli::main()
}
