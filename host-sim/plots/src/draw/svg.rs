//! A small SVG writer: shapes in page units, numbers with two decimals, escaped text.

use std::fmt::Write as _;

/// Font families for browsers; bitmaps use the bundled first one.
pub const FONT_FAMILY: &str = "Ubuntu, 'Segoe UI', Helvetica, Arial, sans-serif";

/// Alignment of a text relative to its x.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Anchor {
    /// x is the left end.
    Start,
    /// x is the middle.
    Middle,
    /// x is the right end.
    End,
}

/// Size, color, alignment and weight of a text.
#[derive(Debug, Clone, Copy)]
pub struct Font {
    size: f64,
    color: &'static str,
    anchor: Anchor,
    bold: bool,
    halo: bool,
}

impl Font {
    /// Dark text of `size` px that starts at its x.
    pub const fn new(size: f64) -> Self {
        Self {
            size,
            color: super::color::INK,
            anchor: Anchor::Start,
            bold: false,
            halo: false,
        }
    }

    /// The same in another color.
    pub const fn color(self, color: &'static str) -> Self {
        Self { color, ..self }
    }

    /// The same, anchored elsewhere.
    pub const fn at(self, anchor: Anchor) -> Self {
        Self { anchor, ..self }
    }

    /// The same, bold (drawn with a thin outline, which needs no second font).
    pub const fn bold(self) -> Self {
        Self { bold: true, ..self }
    }

    /// The same with a white rim, readable on top of a drawing.
    pub const fn halo(self) -> Self {
        Self { halo: true, ..self }
    }
}

/// A picture under construction; `finish` gives the document.
#[derive(Debug)]
pub struct Svg {
    width: f64,
    height: f64,
    body: String,
}

impl Svg {
    /// An empty white page of this size, px.
    pub fn new(width: f64, height: f64) -> Self {
        Self {
            width,
            height,
            body: String::new(),
        }
    }

    /// Makes the page at least `height` px high.
    pub fn grow(&mut self, height: f64) {
        self.height = self.height.max(height);
    }

    /// Adds one element verbatim; its text must already be escaped.
    pub fn raw(&mut self, element: &str) {
        self.body.push_str(element);
        self.body.push('\n');
    }

    /// A rectangle `[left, top, width, height]`.
    pub fn rect(&mut self, [x, y, w, h]: [f64; 4], style: &str) {
        self.raw(&format!(
            r#"<rect x="{}" y="{}" width="{}" height="{}" {style}/>"#,
            num(x),
            num(y),
            num(w.max(0.0)),
            num(h.max(0.0)),
        ));
    }

    /// A circle.
    pub fn circle(&mut self, [x, y]: [f64; 2], radius: f64, style: &str) {
        let (x, y, r) = (num(x), num(y), num(radius.max(0.0)));
        self.raw(&format!(r#"<circle cx="{x}" cy="{y}" r="{r}" {style}/>"#));
    }

    /// A straight line.
    pub fn line(&mut self, [x1, y1]: [f64; 2], [x2, y2]: [f64; 2], style: &str) {
        let (x1, y1, x2, y2) = (num(x1), num(y1), num(x2), num(y2));
        self.raw(&format!(
            r#"<line x1="{x1}" y1="{y1}" x2="{x2}" y2="{y2}" {style}/>"#
        ));
    }

    /// An open line through `points`; nothing for fewer than two.
    pub fn polyline(&mut self, points: &[[f64; 2]], style: &str) {
        if points.len() > 1 {
            let points = joined(points);
            self.raw(&format!(r#"<polyline points="{points}" {style}/>"#));
        }
    }

    /// A closed outline through `points`.
    pub fn polygon(&mut self, points: &[[f64; 2]], style: &str) {
        let points = joined(points);
        self.raw(&format!(r#"<polygon points="{points}" {style}/>"#));
    }

    /// One line of text on the baseline y; what is not allowed in XML is replaced.
    pub fn text(&mut self, [x, y]: [f64; 2], font: Font, content: &str) {
        let place = format!(r#"x="{}" y="{}""#, num(x), num(y));
        self.text_element(&place, font, content);
    }

    /// Text that reads upward, centered on (x, y).
    pub fn text_upwards(&mut self, [x, y]: [f64; 2], font: Font, content: &str) {
        let place = format!(
            r#"transform="translate({} {}) rotate(-90)""#,
            num(x),
            num(y)
        );
        self.text_element(&place, font.at(Anchor::Middle), content);
    }

    fn text_element(&mut self, place: &str, font: Font, content: &str) {
        let mut style = format!(r#"font-size="{}" fill="{}""#, num(font.size), font.color);
        match font.anchor {
            Anchor::Start => {}
            Anchor::Middle => style.push_str(r#" text-anchor="middle""#),
            Anchor::End => style.push_str(r#" text-anchor="end""#),
        }
        if font.halo {
            style.push_str(
                r##" paint-order="stroke" stroke="#ffffff" stroke-width="3" stroke-linejoin="round""##,
            );
        } else if font.bold {
            let weight = num(font.size * 0.04);
            let _ = write!(style, r#" stroke="{}" stroke-width="{weight}""#, font.color);
        }
        let content = escape(content);
        self.raw(&format!("<text {place} {style}>{content}</text>"));
    }

    /// Clips what `draw` adds at the rectangle `[left, top, width, height]`; `id` must be unique in
    /// the picture.
    pub fn clipped(&mut self, id: &str, area: [f64; 4], draw: impl FnOnce(&mut Self)) {
        self.raw(&format!(r#"<clipPath id="{id}">"#));
        self.rect(area, "");
        self.raw(&format!(r#"</clipPath><g clip-path="url(#{id})">"#));
        draw(self);
        self.raw("</g>");
    }

    /// The document, with a title and a description for people who cannot see it.
    pub fn finish(self, title: &str, description: &str) -> String {
        let (w, h) = (num(self.width), num(self.height));
        let (title, description) = (escape(title), escape(description));
        format!(
            "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{w}\" height=\"{h}\" viewBox=\"0 0 {w} {h}\" \
             role=\"img\" font-family=\"{FONT_FAMILY}\">\n<title>{title}</title>\n<desc>{description}</desc>\n\
             <rect width=\"{w}\" height=\"{h}\" fill=\"#ffffff\"/>\n{}</svg>\n",
            self.body,
        )
    }
}

/// Style of a filled shape without an outline.
pub fn fill(color: &str) -> String {
    format!(r#"fill="{color}""#)
}

/// Style of an outline without fill.
pub fn stroke(color: &str, width: f64) -> String {
    let width = num(width);
    format!(r#"fill="none" stroke="{color}" stroke-width="{width}" stroke-linejoin="round""#)
}

/// Style of a filled shape with an outline.
pub fn filled(color: &str, outline: &str, width: f64) -> String {
    let width = num(width);
    format!(r#"fill="{color}" stroke="{outline}" stroke-width="{width}" stroke-linejoin="round""#)
}

/// A coordinate with two decimals; NaN becomes 0.
pub fn num(value: f64) -> String {
    let value = if value.is_finite() { value } else { 0.0 };
    let text = format!("{value:.2}");
    let short = text.trim_end_matches('0').trim_end_matches('.');
    if short == "-0" {
        "0".into()
    } else {
        short.into()
    }
}

/// A value for readers, with a true minus sign; NaN becomes 0.
pub fn decimal(value: f64, decimals: usize) -> String {
    let value = if value.is_finite() { value } else { 0.0 };
    let text = format!("{:.decimals$}", value.abs());
    let minus = value < 0.0 && text.contains(|c| ('1'..='9').contains(&c));
    if minus { format!("−{text}") } else { text }
}

/// `text` as XML character data or attribute value; characters XML does not allow become U+FFFD.
pub fn escape(text: &str) -> String {
    let mut escaped = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '&' => escaped.push_str("&amp;"),
            '<' => escaped.push_str("&lt;"),
            '>' => escaped.push_str("&gt;"),
            '"' => escaped.push_str("&quot;"),
            '\n' | '\t' | '\r' => escaped.push(' '),
            c if c.is_control() || matches!(c, '\u{fffe}' | '\u{ffff}') => escaped.push('\u{fffd}'),
            c => escaped.push(c),
        }
    }
    escaped
}

fn joined(points: &[[f64; 2]]) -> String {
    let mut text = String::new();
    for &[x, y] in points {
        let _ = write!(text, "{},{} ", num(x), num(y));
    }
    text.truncate(text.trim_end().len());
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_have_fixed_decimals_and_are_never_nan() {
        for (value, text) in [
            (1.0, "1"),
            (0.126, "0.13"),
            (-0.001, "0"),
            (100.0, "100"),
            (f64::NAN, "0"),
            (f64::INFINITY, "0"),
            (-2.5, "-2.5"),
        ] {
            assert_eq!(num(value), text);
        }
    }

    #[test]
    fn people_read_a_true_minus_and_no_negative_zero() {
        assert_eq!(decimal(-1.26, 1), "−1.3");
        assert_eq!(decimal(-0.01, 1), "0.0");
        assert_eq!(decimal(-0.0, 0), "0");
        assert_eq!(decimal(f64::NAN, 2), "0.00");
    }

    #[test]
    fn text_is_escaped_for_xml() {
        assert_eq!(
            escape("a<b & \"c\">\u{1b}"),
            "a&lt;b &amp; &quot;c&quot;&gt;\u{fffd}"
        );
        let mut svg = Svg::new(10.0, 10.0);
        svg.text([0.0, 0.0], Font::new(11.0), "</text><script>&\u{0}");
        let document = svg.finish("<t>", "d & e");
        assert!(!document.contains("<script>"));
        crate::fixture::assert_well_formed(&document);
    }
}
