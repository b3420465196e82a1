//! Renders pictures as PNG with the bundled font only: the same bytes on every machine.

use std::fmt;
use std::sync::{Arc, OnceLock};

use resvg::tiny_skia::{Pixmap, Transform};
use resvg::usvg::{Options, Tree, fontdb};

/// Why a picture could not be rendered.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum RenderError {
    /// The text is not an SVG document, for this reason.
    NotSvg(String),
    /// A bitmap of this size (px) is not possible.
    Size {
        /// Width, px.
        width: u32,
        /// Height, px.
        height: u32,
    },
    /// The bitmap could not be encoded, for this reason.
    Encoding(String),
}

impl fmt::Display for RenderError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NotSvg(what) => write!(f, "not an SVG picture: {what}"),
            Self::Size { width, height } => write!(f, "no bitmap of {width} × {height} px"),
            Self::Encoding(what) => write!(f, "cannot encode the PNG: {what}"),
        }
    }
}

impl std::error::Error for RenderError {}

/// Largest number of pixels of a bitmap.
const MAX_PIXELS: u64 = 100_000_000;

/// Renders an SVG document as a PNG file, `scale` pixels per page unit.
///
/// # Errors
/// When `svg` is no SVG document, or the bitmap would be empty or larger than 100 megapixels.
pub fn render(svg: &str, scale: f32) -> Result<Vec<u8>, RenderError> {
    let tree = parse(svg)?;
    let side = |length: f32| (length * scale).ceil().max(0.0) as u32;
    let (width, height) = (side(tree.size().width()), side(tree.size().height()));
    let mut pixels = Some((width, height))
        .filter(|_| u64::from(width) * u64::from(height) <= MAX_PIXELS)
        .and_then(|(width, height)| Pixmap::new(width, height))
        .ok_or(RenderError::Size { width, height })?;
    resvg::render(
        &tree,
        Transform::from_scale(scale, scale),
        &mut pixels.as_mut(),
    );
    pixels
        .encode_png()
        .map_err(|error| RenderError::Encoding(error.to_string()))
}

/// Checks that a browser shows this picture: well-formed, and no number is NaN or infinite.
///
/// # Errors
/// The first fault found.
pub fn check(svg: &str) -> Result<(), String> {
    parse(svg).map_err(|error| error.to_string())?;
    match ["NaN", "inf\"", "-0\""]
        .into_iter()
        .find(|wrong| svg.contains(wrong))
    {
        Some(wrong) => Err(format!("{wrong} in it")),
        None => Ok(()),
    }
}

/// The document as parsed by the renderer.
fn parse(svg: &str) -> Result<Tree, RenderError> {
    let options = Options {
        fontdb: fonts(),
        ..Options::default()
    };
    Tree::from_str(svg, &options).map_err(|error| RenderError::NotSvg(error.to_string()))
}

/// The bundled fonts; every generic family maps to the first of them.
fn fonts() -> Arc<fontdb::Database> {
    static FONTS: OnceLock<Arc<fontdb::Database>> = OnceLock::new();
    FONTS
        .get_or_init(|| {
            let mut fonts = fontdb::Database::new();
            fonts.load_font_data(epaint_default_fonts::UBUNTU_LIGHT.to_vec());
            fonts.load_font_data(epaint_default_fonts::HACK_REGULAR.to_vec());
            let first = fonts
                .faces()
                .next()
                .and_then(|face| face.families.first())
                .map(|(name, _)| name.clone());
            if let Some(name) = first {
                fonts.set_sans_serif_family(name.clone());
                fonts.set_serif_family(name);
            }
            Arc::new(fonts)
        })
        .clone()
}

#[cfg(test)]
mod tests {
    use super::*;

    const PICTURE: &str = r##"<svg xmlns="http://www.w3.org/2000/svg" width="40" height="20"
        font-family="Ubuntu, 'Segoe UI', sans-serif"><rect width="40" height="20" fill="#ffffff"/>
        <text x="2" y="15" font-size="14">Δ→</text></svg>"##;

    #[test]
    fn a_bitmap_has_the_size_of_the_page_times_the_scale() {
        let png = render(PICTURE, 2.5).unwrap();
        let pixels = Pixmap::decode_png(&png).unwrap();
        assert_eq!((pixels.width(), pixels.height()), (100, 50));
    }

    #[test]
    fn text_is_drawn_with_the_bundled_font() {
        let pixels = Pixmap::decode_png(&render(PICTURE, 1.0).unwrap()).unwrap();
        assert!(pixels.pixels().iter().any(|pixel| pixel.red() < 100));
    }

    #[test]
    fn what_is_no_picture_is_refused() {
        assert!(matches!(render("<svg", 1.0), Err(RenderError::NotSvg(_))));
        assert!(matches!(
            render(PICTURE, 1e6),
            Err(RenderError::Size { .. })
        ));
        assert!(matches!(
            render(PICTURE, 0.0),
            Err(RenderError::Size { .. })
        ));
    }
}
