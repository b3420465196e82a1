//! Tells the linker where the memory of the micro:bit is.
//!
//! The script is a whole one with a name of its own: the one of `cortex-m-rt` includes a `memory.x`, and the linker would
//! find that of another chip in the folder it runs in first.

use std::env;

fn main() {
    println!("cargo:rerun-if-changed=build.rs");
    println!("cargo:rerun-if-changed=microbit.x");
    if env::var("CARGO_CFG_TARGET_OS").as_deref() != Ok("none") {
        return;
    }
    let package = env::var("CARGO_MANIFEST_DIR").expect("cargo names the package's folder");
    println!("cargo:rustc-link-search={package}");
    for argument in ["--nmagic", "-Tmicrobit.x"] {
        println!("cargo:rustc-link-arg-bins={argument}");
    }
}
