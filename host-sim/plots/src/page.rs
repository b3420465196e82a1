//! The HTML page that shows and explains all pictures of a demo.

use std::fmt::Write as _;

use crate::draw::svg::escape;

/// A picture on the page.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Figure {
    /// Name of the SVG file beside the page.
    pub file: String,
    /// Headline.
    pub title: String,
    /// Explanation: one or more paragraphs.
    pub caption: Vec<String>,
}

const STYLE: &str = include_str!("page.css");

/// The HTML page of `figures` with a summary table of (label, value) rows and commands to try next.
///
/// It refers to the picture files by name only, so the folder can be moved. It supports dark mode,
/// small screens and print.
#[must_use]
pub fn index_html(
    title: &str,
    summary: &[(String, String)],
    figures: &[Figure],
    next: &[&str],
) -> String {
    let mut html = opening(title);
    table(&mut html, summary);
    for (i, figure) in figures.iter().enumerate() {
        picture(&mut html, &format!("{}. ", i + 1), figure);
    }
    commands(&mut html, next);
    html.push_str(CLOSING);
    html
}

/// End of every page.
pub const CLOSING: &str = "</main>\n</body>\n</html>\n";

/// Start of every page, up to its headline.
pub fn opening(title: &str) -> String {
    let heading = escape(title);
    format!(
        "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
         <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n\
         <meta name=\"color-scheme\" content=\"light dark\">\n<title>{heading}</title>\n\
         <style>\n{STYLE}</style>\n</head>\n<body>\n<main>\n<h1>{heading}</h1>\n"
    )
}

fn table(html: &mut String, summary: &[(String, String)]) {
    if summary.is_empty() {
        return;
    }
    html.push_str("<table>\n");
    for (label, value) in summary {
        let _ = writeln!(
            html,
            "<tr><th scope=\"row\">{}</th><td>{}</td></tr>",
            escape(label),
            escape(value)
        );
    }
    html.push_str("</table>\n");
}

/// One figure; `number` stands before its title.
pub fn picture(html: &mut String, number: &str, figure: &Figure) {
    let (file, title) = (escape(&figure.file), escape(&figure.title));
    let _ = write!(
        html,
        "<figure>\n<h2>{number}{title}</h2>\n<div class=\"card\"><a href=\"{file}\"><img src=\"{file}\" \
         alt=\"{title}\"></a></div>\n<figcaption>\n"
    );
    for paragraph in &figure.caption {
        let _ = writeln!(html, "<p>{}</p>", escape(paragraph));
    }
    html.push_str("</figcaption>\n</figure>\n");
}

/// Commands to try next.
pub fn commands(html: &mut String, next: &[&str]) {
    if next.is_empty() {
        return;
    }
    html.push_str("<section>\n<h2>What to try next</h2>\n<ul>\n");
    for command in next {
        let _ = writeln!(html, "<li><code>{}</code></li>", escape(command));
    }
    html.push_str("</ul>\n</section>\n");
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn everything_passed_in_is_on_the_page_and_escaped() {
        let figure = Figure {
            file: "a\"b.svg".into(),
            title: "<T>".into(),
            caption: vec!["1 < 2".into()],
        };
        let summary = [("contacts & more".to_string(), "<0>".to_string())];
        let html = index_html("A & B", &summary, &[figure], &["run --x <seed>"]);
        for part in [
            "<title>A &amp; B</title>",
            "<th scope=\"row\">contacts &amp; more</th><td>&lt;0&gt;</td>",
            "src=\"a&quot;b.svg\"",
            "1. &lt;T&gt;",
            "<p>1 &lt; 2</p>",
            "<code>run --x &lt;seed&gt;</code>",
        ] {
            assert_eq!(html.matches(part).count(), 1, "{part} in {html}");
        }
    }

    #[test]
    fn empty_parts_are_left_out() {
        let html = index_html("nothing", &[], &[], &[]);
        assert!(!html.contains("<table>") && !html.contains("<ul>") && !html.contains("<figure>"));
    }
}
