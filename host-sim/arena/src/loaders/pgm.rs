//! Portable graymap images (Netpbm): P2 (text) and P5 (binary), 8 or 16 bits.

use super::graymap::{Graymap, pixel_count};

/// Reads an image; the error says what is wrong with it.
pub(super) fn parse(bytes: &[u8]) -> Result<Graymap, String> {
    let mut tokens = Tokens { bytes, at: 0 };
    let binary = match tokens.next() {
        Some(b"P2") => false,
        Some(b"P5") => true,
        _ => return Err("is neither a PGM image (P2 or P5) nor a PNG image".into()),
    };
    let (width, height, max_value) = header(&mut tokens)?;
    let count = width * height;
    let pixels = if binary {
        // Exactly one white space character stands between the header and the pixels.
        let data = bytes.get(tokens.at + 1..).unwrap_or_default();
        binary_pixels(data, count, max_value)
    } else {
        text_pixels(&mut tokens, count)?
    };
    if pixels.len() != count {
        return Err(format!("holds {} of {count} pixels", pixels.len()));
    }
    if let Some(pixel) = pixels.iter().find(|&&pixel| pixel > max_value) {
        return Err(format!(
            "a pixel of {pixel} is above the maximum value {max_value}"
        ));
    }
    Ok(Graymap {
        width,
        height,
        max_value,
        pixels,
    })
}

/// Width, height and the value of white; the image is neither empty nor too large.
fn header(tokens: &mut Tokens<'_>) -> Result<(usize, usize, u16), String> {
    let width = tokens.number("width")? as usize;
    let height = tokens.number("height")? as usize;
    let max_value = tokens.number("maximum value")?;
    pixel_count(width, height)?;
    match u16::try_from(max_value) {
        Ok(max_value) if max_value > 0 => Ok((width, height, max_value)),
        _ => Err(format!(
            "the maximum value must lie in 1..=65535, not be {max_value}"
        )),
    }
}

fn binary_pixels(data: &[u8], count: usize, max_value: u16) -> Vec<u16> {
    if max_value < 256 {
        data.iter()
            .take(count)
            .map(|&byte| u16::from(byte))
            .collect()
    } else {
        let pairs = data.chunks_exact(2).take(count);
        pairs
            .map(|pair| u16::from_be_bytes([pair[0], pair[1]]))
            .collect()
    }
}

fn text_pixels(tokens: &mut Tokens<'_>, count: usize) -> Result<Vec<u16>, String> {
    let mut pixels = Vec::new();
    while pixels.len() < count && !tokens.is_at_end() {
        let pixel = tokens.number("pixel")?;
        pixels.push(u16::try_from(pixel).map_err(|_| format!("a pixel of {pixel} is too large"))?);
    }
    Ok(pixels)
}

/// Words between white space; `#` starts a comment up to the end of its line.
struct Tokens<'a> {
    bytes: &'a [u8],
    at: usize,
}

impl<'a> Tokens<'a> {
    fn skip_space(&mut self) {
        while let Some(&byte) = self.bytes.get(self.at) {
            if byte == b'#' {
                let rest = &self.bytes[self.at..];
                self.at += rest.iter().position(|&b| b == b'\n').unwrap_or(rest.len());
            } else if byte.is_ascii_whitespace() {
                self.at += 1;
            } else {
                break;
            }
        }
    }

    fn is_at_end(&mut self) -> bool {
        self.skip_space();
        self.at >= self.bytes.len()
    }

    fn next(&mut self) -> Option<&'a [u8]> {
        self.skip_space();
        let rest = self.bytes.get(self.at..)?;
        let length = rest
            .iter()
            .position(|b| b.is_ascii_whitespace() || *b == b'#');
        let word = &rest[..length.unwrap_or(rest.len())];
        self.at += word.len();
        (!word.is_empty()).then_some(word)
    }

    fn number(&mut self, what: &str) -> Result<u32, String> {
        let word = self
            .next()
            .ok_or_else(|| format!("ends before its {what}"))?;
        let text = core::str::from_utf8(word).unwrap_or("");
        text.parse().map_err(|_| format!("has no proper {what}"))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn both_forms_give_the_same_image() {
        let text = parse(b"P2 # made by hand\n3 2\n255\n0 1 2\n253 254 255\n").unwrap();
        let binary = parse(b"P5\n3 2\n255\n\x00\x01\x02\xfd\xfe\xff").unwrap();
        assert_eq!(text, binary);
        assert_eq!(text.pixels, [0, 1, 2, 253, 254, 255]);
        let wide = parse(b"P5 2 1 65535\n\x01\x00\xff\xff").unwrap();
        assert_eq!(wide.pixels, [256, 65535]);
    }

    #[test]
    fn broken_images_are_named() {
        for (bytes, words) in [
            (&b""[..], "neither a PGM"),
            (b"P6 1 1 255\n...", "nor a PNG"),
            (b"P5 2", "height"),
            (b"P5 2 2 255\n\x00", "1 of 4 pixels"),
            (b"P5 0 2 255\n", "empty or too large"),
            (b"P5 4000000000 4000000000 255\n", "empty or too large"),
            (b"P2 1 1 0\n0", "1..=65535"),
            (b"P2 1 1 10\n11", "above the maximum"),
            (b"P2 1 1 255\nx", "no proper pixel"),
            (b"P5 -1 1 255\n", "width"),
        ] {
            let error = parse(bytes).unwrap_err();
            assert!(error.contains(words), "{error}");
        }
    }
}
