//! The firmware's image for the board fits its budget of flash and RAM.
//!
//! `FIRMWARE_ELF` names another image to measure.

use checks::{ImageSizes, board_image, sizes};

const KIB: u64 = 1_024;

/// An eighth of the flash that may hold code, and an eighth of the RAM.
const LIMITS: ImageSizes = ImageSizes {
    flash: 96 * KIB,
    ram: 16 * KIB,
    // The logger's. The node's state is far larger, but all zeros until it is started.
    initialized: 256,
};

#[test]
fn the_firmware_fits_its_budget() {
    let path = board_image();
    let elf = std::fs::read(&path).expect("the image can be read");
    let ImageSizes {
        flash,
        ram,
        initialized,
    } = sizes(&elf).expect("the image is an ELF file");
    println!("| memory | bytes | allowed |\n| --- | ---: | ---: |");
    println!("| flash | {flash} | {} |", LIMITS.flash);
    println!("| static memory | {ram} | {} |", LIMITS.ram);
    println!(
        "| of it kept in flash | {initialized} | {} |",
        LIMITS.initialized
    );
    assert!(flash > 0 && ram > 0, "{}: no image", path.display());
    assert!(flash <= LIMITS.flash, "{flash} bytes of flash");
    assert!(ram <= LIMITS.ram, "{ram} bytes of static memory");
    assert!(
        initialized <= LIMITS.initialized,
        "{initialized} bytes of statics are kept in flash"
    );
}
