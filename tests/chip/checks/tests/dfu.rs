//! What `firmware/README.md` has written to the board by USB is the firmware.

use checks::{OLIMEX_H405, TARGET, board_image, project, target_folder};
use object::Endianness;
use object::read::elf::{ElfFile32, ProgramHeader as _};
use std::path::Path;
use std::process::Command;

/// Where the chip's flash begins, and the file is written to.
const FLASH: u32 = 0x0800_0000;
/// Behind the highest word of the stack: see `memory.x`.
const STACK_START: u32 = 0x2000_2000;

/// Makes the file as the README says, of another image and elsewhere.
fn make(image: &Path, file: &Path) {
    let readme = std::fs::read_to_string(project().join("firmware/README.md")).expect("a README");
    let line = readme.lines().find(|line| line.starts_with("objcopy "));
    let mut words: Vec<_> = line.expect("the command").split_whitespace().collect();
    let documented = format!("target/{TARGET}/chip/{}", OLIMEX_H405.program);
    assert_eq!(
        words.split_off(words.len() - 2),
        [documented.as_str(), "target/firmware.bin"]
    );
    let made = Command::new(words[0])
        .args(&words[1..])
        .args([image, file])
        .status();
    assert!(made.expect("objcopy (binutils) starts").success());
}

/// What the image wants in flash, from its beginning on; zeros between.
fn wanted(elf: &[u8]) -> Vec<u8> {
    let file = ElfFile32::<Endianness>::parse(elf).expect("an ELF file");
    let endian = file.endian();
    let mut flash = Vec::new();
    for segment in file.elf_program_headers() {
        let content = segment.data(endian, elf).expect("its content");
        if segment.p_type(endian) != object::elf::PT_LOAD || content.is_empty() {
            continue;
        }
        let start = (segment.p_paddr(endian) - FLASH) as usize;
        let end = start + content.len();
        flash.resize(flash.len().max(end), 0);
        flash[start..end].copy_from_slice(content);
    }
    flash
}

#[test]
fn the_file_for_dfu_is_the_image() {
    let image = board_image();
    let file = target_folder().join("firmware.bin");
    make(&image, &file);
    let bytes = std::fs::read(&file).expect("the file");
    let elf = std::fs::read(&image).expect("the image");
    assert!(
        bytes == wanted(&elf),
        "the file is not what the image's segments are"
    );
    let word = |index: usize| {
        let bytes = bytes[4 * index..].first_chunk().expect("a vector");
        u32::from_le_bytes(*bytes)
    };
    let (stack_pointer, reset) = (word(0), word(1));
    assert_eq!(stack_pointer, STACK_START);
    let code = FLASH..FLASH + bytes.len() as u32;
    assert!(
        reset % 2 == 1 && code.contains(&reset),
        "reset vector {reset:#x}: not Thumb code of this file"
    );
    println!("{} bytes, reset vector {reset:#x}", bytes.len());
}
