//! The page as one document, assembled at compile time; it loads nothing else.

/// The document.
pub const PAGE: &str = concat!(
    include_str!("page/head.html"),
    "<style>\n",
    include_str!("page/style.css"),
    "</style>\n",
    include_str!("page/body.html"),
    "<script>\n\"use strict\";\n",
    include_str!("page/draw.js"),
    include_str!("page/link.js"),
    include_str!("page/arena.js"),
    include_str!("page/places.js"),
    include_str!("page/sources.js"),
    include_str!("page/ring.js"),
    include_str!("page/body.js"),
    include_str!("page/maps.js"),
    include_str!("page/memory.js"),
    include_str!("page/trail.js"),
    include_str!("page/controls.js"),
    include_str!("page/main.js"),
    "</script>\n</body>\n</html>\n",
);

/// Content security policy: only inline script and style, and the page's own socket.
pub const POLICY: &str = "default-src 'none'; script-src 'unsafe-inline'; style-src 'unsafe-inline'; \
connect-src 'self'; img-src data:; base-uri 'none'; form-action 'none'; frame-ancestors 'none'";

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_page_is_small_and_asks_for_nothing_from_elsewhere() {
        assert!(PAGE.len() <= 300_000, "{} bytes", PAGE.len());
        let local = PAGE.replace("http://www.w3.org/2000/svg", "");
        for outside in ["http://", "https://", "@import", "url(", "import("] {
            assert!(!local.contains(outside), "{outside}");
        }
        // Values are shown as text, never as markup.
        for markup in ["innerHTML", "insertAdjacentHTML", "document.write", "eval("] {
            assert!(!local.contains(markup), "{markup}");
        }
    }
}
