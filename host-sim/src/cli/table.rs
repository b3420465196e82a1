//! Formats tables: aligned for a terminal, or Markdown for the documentation.

/// An aligned table with a line under its head; the columns in `right` are right-aligned.
#[must_use]
pub fn plain(heads: &[&str], rows: &[Vec<String>], right: &[usize]) -> String {
    let widths = widths(heads, rows);
    let mut text = line(heads, &widths, right);
    let rules: Vec<_> = widths.iter().map(|&width| "─".repeat(width)).collect();
    text += &format!("{}\n", rules.join("  "));
    for row in rows {
        text += &line(row, &widths, right);
    }
    text
}

/// A Markdown table.
#[must_use]
pub fn markdown(heads: &[&str], rows: &[Vec<String>], right: &[usize]) -> String {
    let rule = |column: usize| {
        if right.contains(&column) {
            "---:"
        } else {
            "---"
        }
    };
    let rules: Vec<_> = (0..heads.len()).map(rule).collect();
    let mut text = format!("| {} |\n| {} |\n", heads.join(" | "), rules.join(" | "));
    for row in rows {
        text += &format!("| {} |\n", row.join(" | "));
    }
    text
}

fn widths(heads: &[&str], rows: &[Vec<String>]) -> Vec<usize> {
    let width = |column: usize, head: &str| {
        let cells = rows
            .iter()
            .filter_map(|row| row.get(column))
            .map(|cell| cell.chars().count());
        cells.max().unwrap_or(0).max(head.chars().count())
    };
    heads
        .iter()
        .enumerate()
        .map(|(column, head)| width(column, head))
        .collect()
}

fn line<T: AsRef<str>>(cells: &[T], widths: &[usize], right: &[usize]) -> String {
    let mut text = String::new();
    for (column, (cell, &width)) in cells.iter().zip(widths).enumerate() {
        let cell = cell.as_ref();
        let padding = " ".repeat(width.saturating_sub(cell.chars().count()));
        let (before, after) = if right.contains(&column) {
            (padding, String::new())
        } else {
            (String::new(), padding)
        };
        text += &format!("{before}{cell}{after}  ");
    }
    format!("{}\n", text.trim_end())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn columns_line_up() {
        let rows = vec![
            vec!["a".to_owned(), "1".to_owned()],
            vec!["größer".to_owned(), "22".to_owned()],
        ];
        assert_eq!(
            plain(&["name", "n"], &rows, &[1]),
            "name     n\n──────  ──\na        1\ngrößer  22\n"
        );
        assert_eq!(
            markdown(&["name", "n"], &rows[..1], &[1]),
            "| name | n |\n| --- | ---: |\n| a | 1 |\n"
        );
    }
}
