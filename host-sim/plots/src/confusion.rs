//! Draws a confusion matrix.

use crate::draw::color::{self, GRAY, INK};
use crate::draw::layout::{MARGIN, PAGE, TOP, heading, shortened};
use crate::draw::svg::{Anchor, Font, Svg, decimal, fill, filled};

/// Space for the classes' names on the left, px.
const NAMES: f64 = 150.0;
/// Space for the classes' names above, px.
const ABOVE: f64 = 44.0;

/// Draws a confusion matrix: rows are the true classes, columns the recalled ones. A cell's color
/// is its share of its row; its text is that share and the count.
///
/// Returns an SVG document.
#[must_use]
pub fn confusion(title: &str, names: &[String], counts: &[Vec<u32>]) -> String {
    let classes = names.len().max(1);
    let width = ((PAGE - 2.0 * MARGIN - NAMES) / classes as f64).min(120.0);
    let height = width.min(64.0);
    let [left, top] = [MARGIN + NAMES, TOP + ABOVE];
    let mut svg = Svg::new(PAGE, top + height * classes as f64 + MARGIN);
    let subtitle = "Rows: what was done · columns: what was recalled · shares of each row";
    heading(&mut svg, title, subtitle);
    let font = Font::new(11.5).color(INK);
    let room = (width / 6.2) as usize;
    for (place, name) in names.iter().enumerate() {
        let middle = left + (place as f64 + 0.5) * width;
        for (line, words) in lines(name, room).iter().enumerate() {
            let y = top - 24.0 + 14.0 * line as f64;
            svg.text([middle, y], font.at(Anchor::Middle), words);
        }
        let y = top + (place as f64 + 0.5) * height;
        svg.text(
            [left - 8.0, y + 4.0],
            font.at(Anchor::End),
            &shortened(name, 22),
        );
    }
    for (row, counts) in counts.iter().enumerate() {
        let all: u32 = counts.iter().sum();
        for (column, &count) in counts.iter().enumerate() {
            let share = f64::from(count) / f64::from(all.max(1));
            let corner = [left + column as f64 * width, top + row as f64 * height];
            cell(&mut svg, corner, [width, height], share, count);
        }
    }
    svg.finish(title, subtitle)
}

/// A name in at most two lines, broken at a hyphen or a space.
fn lines(name: &str, room: usize) -> Vec<String> {
    let middle = name.chars().count() / 2;
    let breaks = name
        .char_indices()
        .filter(|(_, c)| matches!(c, '-' | ' ' | '_'));
    let nearest = breaks.min_by_key(|(at, _)| at.abs_diff(middle));
    match nearest {
        Some((at, _)) if name.chars().count() > room => {
            let (first, second) = name.split_at(at + 1);
            vec![shortened(first, room), shortened(second, room)]
        }
        _ => vec![String::new(), shortened(name, room)],
    }
}

fn cell(svg: &mut Svg, [x, y]: [f64; 2], [width, height]: [f64; 2], share: f64, count: u32) {
    svg.rect(
        [x, y, width, height],
        &filled(&color::value(share), "#ffffff", 1.5),
    );
    let ink = color::text_on_value(share);
    let middle = x + width / 2.0;
    if width >= 40.0 && height >= 36.0 {
        let text = format!("{}\u{a0}%", decimal(100.0 * share, 1));
        svg.text(
            [middle, y + height / 2.0 - 1.0],
            Font::new(13.0).color(ink).at(Anchor::Middle),
            &text,
        );
        let below = [middle, y + height / 2.0 + 15.0];
        svg.text(
            below,
            Font::new(11.0).color(ink).at(Anchor::Middle),
            &count.to_string(),
        );
    } else if count > 0 {
        svg.circle([middle, y + height / 2.0], 2.0, &fill(GRAY));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fixture::assert_well_formed;

    #[test]
    fn every_cell_has_its_share_and_count() {
        let names = ["left", "sharp-right-turn"].map(str::to_owned);
        let picture = confusion("A & B", &names, &[vec![3, 1], vec![0, 0]]);
        assert_well_formed(&picture);
        assert!(picture.contains("75.0\u{a0}%") && picture.contains(">3</text>"));
        let many: Vec<String> = (0..40).map(|i| format!("class {i}")).collect();
        assert_well_formed(&confusion("many", &many, &vec![vec![1; 40]; 40]));
        assert_well_formed(&confusion("none", &[], &[]));
    }
}
