//! Pictures of the paper's experiments, as SVG.

mod chain;
mod flow;
mod flow_values;
pub mod paper;
mod paper_page;
mod situation_values;

pub use chain::chains;
pub use flow::flow;
pub use situation_values::situation_values;

/// Fails unless `svg` is a well-formed SVG document.
#[cfg(test)]
pub(crate) fn assert_well_formed(svg: &str) {
    plots::png::check(svg).unwrap_or_else(|error| panic!("{error}\n{svg}"));
}
