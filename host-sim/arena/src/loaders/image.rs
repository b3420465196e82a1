//! Reads the image of a map: PGM or PNG, recognized by its first bytes.

use super::graymap::{Graymap, pixel_count};
use super::pgm;

/// How every PNG image begins.
const PNG_SIGNATURE: &[u8] = b"\x89PNG\r\n\x1a\n";
/// Deflate makes data smaller by this factor at most: a short file cannot ask for much memory.
const DEFLATE_RATIO: usize = 1_032;

/// Reads an image; the error says what is wrong with it.
pub(super) fn parse(bytes: &[u8]) -> Result<Graymap, String> {
    if bytes.starts_with(PNG_SIGNATURE) {
        parse_png(bytes)
    } else {
        pgm::parse(bytes)
    }
}

/// Reads a PNG image of any kind, at 8 bits per channel. Gray is the mean of red, green and blue,
/// as for the `map_server`; alpha does not count.
fn parse_png(bytes: &[u8]) -> Result<Graymap, String> {
    let damaged = |error: png::DecodingError| format!("is a damaged PNG image: {error}");
    let mut decoder = png::Decoder::new(std::io::Cursor::new(bytes));
    decoder.set_transformations(png::Transformations::normalize_to_color8());
    decoder.set_ignore_text_chunk(true);
    decoder.set_ignore_iccp_chunk(true);
    let info = decoder.read_header_info().map_err(damaged)?;
    let (width, height) = (info.width as usize, info.height as usize);
    pixel_count(width, height)?;
    if info.raw_bytes() / DEFLATE_RATIO > bytes.len() {
        return Err(format!("is too short for {width} × {height} pixels"));
    }
    let mut reader = decoder.read_info().map_err(damaged)?;
    let size = reader.output_buffer_size();
    let mut channels = vec![0; size.ok_or("is a PNG image that is too large")?];
    reader.next_frame(&mut channels).map_err(damaged)?;
    let (color, _) = reader.output_color_type();
    let (max_value, light): (u16, fn(&[u8]) -> u16) = match color.samples() {
        1 | 2 => (255, |pixel| {
            pixel.first().map_or(0, |gray| u16::from(*gray))
        }),
        _ => (3 * 255, |pixel| {
            pixel.iter().take(3).map(|part| u16::from(*part)).sum()
        }),
    };
    let pixels = channels.chunks_exact(color.samples());
    Ok(Graymap {
        width,
        height,
        max_value,
        pixels: pixels.map(light).collect(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use png::{BitDepth, ColorType};

    fn image([width, height]: [u32; 2], color: ColorType, depth: BitDepth, data: &[u8]) -> Vec<u8> {
        let mut bytes = Vec::new();
        let mut encoder = png::Encoder::new(&mut bytes, width, height);
        encoder.set_color(color);
        encoder.set_depth(depth);
        if color == ColorType::Indexed {
            encoder.set_palette(vec![0, 0, 0, 254, 254, 254]);
        }
        let mut writer = encoder.write_header().unwrap();
        if !data.is_empty() {
            writer.write_image_data(data).unwrap();
        }
        drop(writer);
        bytes
    }

    #[test]
    fn all_kinds_of_png_hold_the_same_grays() {
        let gray = image([2, 1], ColorType::Grayscale, BitDepth::Eight, &[0, 254]);
        let shares = |bytes: &[u8]| {
            let map = parse(bytes).unwrap();
            assert_eq!((map.width, map.height), (2, 1));
            let white = f64::from(map.max_value);
            let share = |pixel: &u16| f64::from(*pixel) / white;
            map.pixels.iter().map(share).collect::<Vec<_>>()
        };
        let expected = shares(b"P5 2 1 255\n\x00\xfe");
        assert_eq!(shares(&gray), expected);
        let (eight, sixteen) = (BitDepth::Eight, BitDepth::Sixteen);
        for (color, depth, data) in [
            (ColorType::GrayscaleAlpha, eight, &[0, 9, 254, 0][..]),
            (ColorType::Rgb, eight, &[0, 0, 0, 254, 254, 254]),
            (ColorType::Rgb, eight, &[0, 0, 0, 252, 255, 255]),
            (ColorType::Rgba, eight, &[0, 0, 0, 0, 254, 254, 254, 7]),
            (ColorType::Grayscale, sixteen, &[0, 0, 254, 254]),
            (ColorType::Indexed, BitDepth::One, &[0b0100_0000]),
        ] {
            let found = shares(&image([2, 1], color, depth, data));
            assert_eq!(found, expected, "{color:?} {depth:?}");
        }
    }

    #[test]
    fn broken_png_images_are_named() {
        let good = image([2, 2], ColorType::Grayscale, BitDepth::Eight, &[0; 4]);
        let mut flipped = good.clone();
        flipped[20] ^= 1;
        let huge = image([1 << 30, 1 << 30], ColorType::Rgba, BitDepth::Sixteen, &[]);
        let large = image([8_192, 8_192], ColorType::Rgba, BitDepth::Sixteen, &[]);
        for (bytes, words) in [
            (&good[..8], "damaged PNG"),
            (&good[..30], "damaged PNG"),
            (&good[..good.len() - 14], "damaged PNG"),
            (&flipped, "damaged PNG"),
            (
                &huge,
                "1073741824 × 1073741824 pixels is empty or too large",
            ),
            (&large, "too short for 8192 × 8192 pixels"),
        ] {
            let error = parse(bytes).unwrap_err();
            assert!(error.contains(words) && !error.contains('\n'), "{error}");
        }
        for cut in 0..good.len() - 12 {
            assert!(parse(&good[..cut]).is_err(), "{cut}");
        }
    }
}
