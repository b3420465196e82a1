//! The firmware's images for the board fit their budgets of flash and RAM.
//!
//! `FIRMWARE_ELF` names another image to measure as the first.

use checks::{
    ImageSizes, OLIMEX_H405, OLIMEX_H405_ANY_BODY, OLIMEX_H405_PLACES, board_image, image, sizes,
};
use std::path::Path;

const KIB: u64 = 1_024;

/// An eighth of the flash that may hold code, and an eighth of the RAM.
const LIMITS: ImageSizes = ImageSizes {
    flash: 96 * KIB,
    ram: 16 * KIB,
    // The logger's. The node's state is far larger, but all zeros until it is started.
    initialized: 256,
};

/// With points of echoes, and what finds the sensors of a body.
const ANY_BODY_LIMITS: ImageSizes = ImageSizes {
    flash: 116 * KIB,
    ram: 32 * KIB,
    ..LIMITS
};

/// And with a memory of 256 places.
const PLACES_LIMITS: ImageSizes = ImageSizes {
    flash: 128 * KIB,
    ram: 48 * KIB,
    ..LIMITS
};

// One after the other: the images replace each other.
#[test]
fn the_firmware_fits_its_budgets() {
    check("", &board_image(), &LIMITS);
    check(
        ", any body",
        &image(&OLIMEX_H405_ANY_BODY),
        &ANY_BODY_LIMITS,
    );
    check(", places", &image(&OLIMEX_H405_PLACES), &PLACES_LIMITS);
    // Other tests examine this one.
    let _ = image(&OLIMEX_H405);
}

fn check(name: &str, path: &Path, limits: &ImageSizes) {
    let elf = std::fs::read(path).expect("the image can be read");
    let ImageSizes {
        flash,
        ram,
        initialized,
    } = sizes(&elf).expect("the image is an ELF file");
    println!("| memory{name} | bytes | allowed |\n| --- | ---: | ---: |");
    println!("| flash{name} | {flash} | {} |", limits.flash);
    println!("| static memory{name} | {ram} | {} |", limits.ram);
    println!(
        "| of it kept in flash{name} | {initialized} | {} |\n",
        limits.initialized
    );
    assert!(flash > 0 && ram > 0, "{}: no image", path.display());
    assert!(flash <= limits.flash, "{flash} bytes of flash");
    assert!(ram <= limits.ram, "{ram} bytes of static memory");
    assert!(
        initialized <= limits.initialized,
        "{initialized} bytes of statics are kept in flash"
    );
}
