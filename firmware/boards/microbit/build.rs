//! Passes the memory layout of the micro:bit to the linker.
//!
//! The script is complete and has its own name: that of `cortex-m-rt` includes `memory.x`, and the
//! linker would first find the one of another chip in its working folder.

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
