//! Pictures: figures as curves, and recalled sequences as rows of bits.

use super::method::{Learned, flip};
use super::situations::Drive;
use super::{BITS, Draw, ELEMENTS, Elements, FLIPPED, Measure, Method, Row, SIZES};
use amp::sequence::Pattern;
use arena::noise::Noise;
use files::error::BadInput;
use plots::draw::color::{GRAY, INK, PALE, VERMILLION};
use plots::draw::layout::{MARGIN, PAGE, TOP, heading};
use plots::draw::svg::{Anchor, Font, Svg, fill, stroke};
use plots::{CurveKey, Curves, curves};

/// Bits of the drawn cue that are turned around, percent.
const DAMAGE: u32 = 15;

/// The longest sequence by the number of bits.
#[must_use]
pub fn longest(rows: &[Row], about: &str) -> String {
    let methods = &Method::ALL[..5];
    let key = CurveKey {
        subtitle: about.to_owned(),
        along: "bits".to_owned(),
        ticks: SIZES.iter().map(ToString::to_string).enumerate().collect(),
        names: names(methods),
    };
    let panels = Elements::ALL.map(|elements| Curves {
        title: title(elements),
        measure: "elements recalled without an error".to_owned(),
        within: [0.0, f64::INFINITY],
        lines: lines(rows, elements, Measure::Longest, methods),
    });
    curves("Longest sequence that is recalled", &key, &panels)
}

/// Recall against noise in the cue, and in every step.
#[must_use]
pub fn noise(rows: &[Row], elements: Elements, about: &str) -> String {
    // One clean-up recalls about as much as two.
    let methods = Method::ALL
        .into_iter()
        .filter(|method| !matches!(method, Method::OneCleanUp | Method::Guess));
    let methods: Vec<_> = methods.collect();
    let tick = |(index, percent): (usize, &u32)| (index, percent.to_string());
    let key = CurveKey {
        subtitle: about.to_owned(),
        along: "bits turned around, %".to_owned(),
        ticks: FLIPPED.iter().enumerate().step_by(2).map(tick).collect(),
        names: names(&methods),
    };
    let panels = [
        (Measure::Cue, "Damaged cue"),
        (Measure::Steps, "Damage in every step"),
    ];
    let panels = panels.map(|(measure, title)| Curves {
        title: title.to_owned(),
        measure: "sequences recalled wholly, %".to_owned(),
        within: [0.0, 100.0],
        lines: lines(rows, elements, measure, &methods),
    });
    let title = format!("Recall under noise: {}", title(elements).to_lowercase());
    curves(&title, &key, &panels)
}

fn title(elements: Elements) -> String {
    match elements {
        Elements::Random => "Random bits".to_owned(),
        Elements::Situations => "Situations of a drive".to_owned(),
    }
}

fn names(methods: &[Method]) -> Vec<(String, bool)> {
    let name = |method: &Method| (method.name().to_owned(), method.is_corrected());
    methods.iter().map(name).collect()
}

fn lines(
    rows: &[Row],
    elements: Elements,
    measure: Measure,
    methods: &[Method],
) -> Vec<Vec<sim::statistics::Mean>> {
    let line = |method: &Method| {
        let of_line = rows
            .iter()
            .filter(|row| (row.elements, row.measure, row.method) == (elements, measure, *method));
        let figure = |row: &Row| match measure {
            Measure::Longest => row.figure(),
            _ => row.figure().percent(),
        };
        of_line.map(figure).collect()
    };
    methods.iter().map(line).collect()
}

/// Height of a row of bits, and between rows and blocks, px.
const ROW: f64 = 13.0;
const BLOCK: f64 = 30.0;
/// Width of the labels left of the bits, px.
const LABELS: f64 = 96.0;

/// A sequence of situations as it was learned, and as it is recalled from a damaged cue.
///
/// # Errors
/// When the robot cannot be driven around.
pub fn recalled(seed: u64) -> Result<String, BadInput> {
    let drive = Drive::of_seed(seed)?;
    let mut svg = Svg::new(PAGE, TOP);
    let about = format!(
        "{ELEMENTS} elements of {BITS} bits; black: a bit is set, vermillion: it is wrong; {DAMAGE} % of the cue is turned around"
    );
    heading(&mut svg, "A recalled sequence", &about);
    let mut top = TOP + 14.0;
    for elements in Elements::ALL {
        let draw = Draw {
            elements,
            drive: &drive,
            seed,
        };
        let sequence = draw.elements::<BITS>(ELEMENTS);
        let learned = Learned::of(&[&sequence], true);
        svg.text([MARGIN, top], Font::new(12.5).bold(), &title(elements));
        top = block(&mut svg, top + 8.0, "learned", &sequence, &sequence);
        for method in [Method::Hetero, Method::Pair, Method::PairCorrected] {
            let mut noise = draw.noise(9);
            let all = from_cue(&learned, method, &sequence, &mut noise);
            top = block(&mut svg, top, method.name(), &all, &sequence);
        }
        top += BLOCK;
    }
    svg.grow(top);
    Ok(svg.finish("A recalled sequence", &about))
}

/// The damaged cue, and what is recalled after it.
fn from_cue(
    learned: &Learned<BITS>,
    method: Method,
    sequence: &[Pattern<BITS>],
    noise: &mut Noise,
) -> Vec<Pattern<BITS>> {
    let mut all = Vec::new();
    let Some(first) = sequence.first() else {
        return all;
    };
    let mut element = *first;
    flip(&mut element, DAMAGE, noise);
    for _ in sequence {
        all.push(element);
        element = learned.step(method, &element, noise);
    }
    all
}

/// Draws rows of bits with their numbers; returns the top of the next block.
fn block(
    svg: &mut Svg,
    top: f64,
    name: &str,
    rows: &[Pattern<BITS>],
    expected: &[Pattern<BITS>],
) -> f64 {
    svg.grow(top + ROW * rows.len() as f64 + BLOCK);
    let left = MARGIN + LABELS;
    let width = (PAGE - MARGIN - left) / BITS as f64;
    let font = Font::new(11.0);
    svg.text([MARGIN, top + ROW - 3.0], font.color(INK), name);
    for (index, (row, expected)) in rows.iter().zip(expected).enumerate() {
        let y = top + ROW * index as f64;
        let number = (index + 1).to_string();
        let at = [left - 5.0, y + ROW - 3.0];
        svg.text(at, font.color(GRAY).at(Anchor::End), &number);
        for (bit, (is, wanted)) in row.bits().into_iter().zip(expected.bits()).enumerate() {
            let area = [left + width * bit as f64, y, width, ROW - 2.0];
            match (is, wanted) {
                (true, true) => svg.rect(area, &fill(INK)),
                (false, false) => {}
                _ => svg.rect(area, &fill(VERMILLION)),
            }
        }
        let frame = [left, y, width * BITS as f64, ROW - 2.0];
        svg.rect(frame, &stroke(PALE, 1.0));
    }
    top + ROW * rows.len() as f64 + 8.0
}
