//! The file that `firmware/README.md` writes to the board by USB equals the firmware's image.

use checks::{OLIMEX_H405, TARGET, board_image, project, target_folder};
use object::Endianness;
use object::read::elf::{ElfFile32, ProgramHeader as _};
use std::path::Path;
use std::process::Command;

/// Address of the chip's flash and of the file.
const FLASH: u32 = 0x0800_0000;
/// One word above the highest word of the stack: see `memory.x`.
const STACK_START: u32 = 0x2000_2000;

/// Makes the file by the README's command, from `image` to `file`.
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

/// Content of the image's loadable segments in flash; zeros between them.
fn segments(elf: &[u8]) -> Vec<u8> {
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
fn the_dfu_file_equals_the_image() {
    let image = board_image();
    let file = target_folder().join("firmware.bin");
    make(&image, &file);
    let bytes = std::fs::read(&file).expect("the file");
    let elf = std::fs::read(&image).expect("the image");
    assert!(
        bytes == segments(&elf),
        "the file differs from the image's segments"
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
