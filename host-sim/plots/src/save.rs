//! Saves a picture in a folder, as SVG and as PNG.

use super::png;
use files::error::BadInput;
use files::save;
use std::path::{Path, PathBuf};

/// Pixels per page unit of the PNG.
const PNG_SCALE: f32 = 2.0;

/// Writes `NAME.svg` and `NAME.png` into `folder`; returns both paths.
///
/// # Errors
/// The file that cannot be written or rendered.
pub fn save_picture(folder: &Path, name: &str, svg: &str) -> Result<[PathBuf; 2], BadInput> {
    let picture = save(folder, &format!("{name}.svg"), svg.as_bytes())?;
    let bitmap = format!("{name}.png");
    let png = png::render(svg, PNG_SCALE)
        .map_err(|error| BadInput::file(&folder.join(&bitmap), error))?;
    Ok([picture, save(folder, &bitmap, &png)?])
}
