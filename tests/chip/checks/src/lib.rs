//! Builds and runs the programs of this workspace, and reads the sizes of images.

pub mod stack;

use object::{Object as _, ObjectSection as _, SectionFlags, SectionKind};
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

/// The target of the F405 boards.
pub const TARGET: &str = "thumbv7em-none-eabihf";

/// A board for which the firmware is built.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct BoardImage {
    /// Package in the project's workspace.
    pub package: &'static str,
    /// Program in the package.
    pub program: &'static str,
    /// Target.
    pub target: &'static str,
    /// Features to enable. Images that differ in these only replace each other.
    pub features: &'static str,
}

/// The F405 board whose image is examined; the other one differs only in its pins.
pub const OLIMEX_H405: BoardImage = BoardImage {
    package: "stm32f405",
    program: "olimex_h405",
    target: TARGET,
    features: "",
};

/// The same for sensors anywhere on the body.
pub const OLIMEX_H405_ANY_BODY: BoardImage = BoardImage {
    features: "any-body",
    ..OLIMEX_H405
};

/// And with a memory of places.
pub const OLIMEX_H405_PLACES: BoardImage = BoardImage {
    features: "places",
    ..OLIMEX_H405
};

/// The board with the least memory.
pub const MICROBIT: BoardImage = BoardImage {
    package: "microbit",
    program: "microbit",
    target: "thumbv6m-none-eabi",
    features: "",
};

/// Addresses of the F405's RAM.
const SRAM: std::ops::Range<u64> = 0x2000_0000..0x2002_0000;

/// Sizes of an image, bytes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ImageSizes {
    /// Flash: code, constants and initial values of statics.
    pub flash: u64,
    /// RAM: all statics, without the stack.
    pub ram: u64,
    /// Statics that do not start as zeros; they take RAM and flash.
    pub initialized: u64,
}

/// The folder of this workspace.
#[must_use]
pub fn workspace() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..")
}

/// The project's folder.
#[must_use]
pub fn project() -> PathBuf {
    workspace().join("../..")
}

/// Runs cargo in `folder`, with this workspace's target folder. What programs are linked from is
/// shared with the main workspace.
///
/// # Panics
/// There is no cargo.
#[must_use]
pub fn cargo(folder: &Path, line: &str) -> Output {
    let mut cargo = Command::new(env!("CARGO"));
    cargo
        .args(line.split_whitespace())
        .current_dir(folder)
        .env("CARGO_TARGET_DIR", target_folder())
        .env("CARGO_BUILD_BUILD_DIR", project().join("target"));
    cargo.output().expect("cargo starts")
}

/// The folder of the built programs.
#[must_use]
pub fn target_folder() -> PathBuf {
    match std::env::var_os("CARGO_TARGET_DIR") {
        Some(folder) => project().join(folder),
        None => workspace().join("target"),
    }
}

/// The firmware's image for the Olimex board, or the one that `FIRMWARE_ELF` names.
///
/// # Panics
/// The build fails.
#[must_use]
pub fn board_image() -> PathBuf {
    if let Some(path) = std::env::var_os("FIRMWARE_ELF") {
        return project().join(path);
    }
    image(&OLIMEX_H405)
}

/// Builds a board's image.
///
/// # Panics
/// The build fails.
#[must_use]
pub fn image(board: &BoardImage) -> PathBuf {
    let BoardImage {
        package,
        program,
        target,
        features,
    } = board;
    let features = if features.is_empty() {
        String::new()
    } else {
        format!(" --features {features}")
    };
    let line = format!(
        "build --locked --package {package} --bin {program} --profile chip --target {target}{features}"
    );
    let output = cargo(&project(), &line);
    let stderr = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{stderr}");
    target_folder().join(target).join("chip").join(program)
}

/// Sizes of an image, by the sections of its ELF file.
///
/// # Errors
/// The file is not valid ELF.
pub fn sizes(elf: &[u8]) -> Result<ImageSizes, object::Error> {
    let mut sizes = ImageSizes {
        flash: 0,
        ram: 0,
        initialized: 0,
    };
    for section in object::File::parse(elf)?.sections() {
        let SectionFlags::Elf { sh_flags } = section.flags() else {
            continue;
        };
        if sh_flags & u64::from(object::elf::SHF_ALLOC) == 0 {
            continue;
        }
        // Sections with content are in flash, even if start-up code copies them to RAM.
        let has_content = section.kind() != SectionKind::UninitializedData;
        if has_content {
            sizes.flash += section.size();
        }
        if SRAM.contains(&section.address()) {
            sizes.ram += section.size();
            sizes.initialized += if has_content { section.size() } else { 0 };
        }
    }
    Ok(sizes)
}

/// A row of the table of instruction counts.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct CountRow {
    /// The counted call.
    pub call: String,
    /// Instructions, mean.
    pub mean: u64,
    /// Instructions of the longest call.
    pub most: u64,
    /// Allowed instructions.
    pub allowed: u64,
}

/// The rows of the table that `counts` prints.
#[must_use]
pub fn rows(table: &str) -> Vec<CountRow> {
    table.lines().filter_map(row).collect()
}

fn row(line: &str) -> Option<CountRow> {
    let mut cells = line.strip_prefix('|')?.split('|').map(str::trim);
    let (call, _calls) = (cells.next()?, cells.next()?);
    Some(CountRow {
        call: call.to_owned(),
        mean: cells.next()?.parse().ok()?,
        most: cells.next()?.parse().ok()?,
        allowed: cells.next()?.parse().ok()?,
    })
}

#[cfg(test)]
mod tests {
    use super::{CountRow, rows};

    #[test]
    fn only_rows_with_counts_are_rows() {
        let table = "| call | calls | mean | most | allowed |\n| --- | ---: | ---: | ---: | ---: |\n\
                     | one, two | 3 | 40 | 50 | 60 |\n\n| what | bytes |\n| `State` | 7 |";
        let row = CountRow {
            call: "one, two".to_owned(),
            mean: 40,
            most: 50,
            allowed: 60,
        };
        assert_eq!(rows(table), [row]);
    }
}
