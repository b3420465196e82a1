//! The flags of `host-sim som`.

use super::scale::Scale;
use clap::builder::{PossibleValuesParser, TypedValueParser as _};
use files::error::BadInput;
use sim::settings;
use std::path::PathBuf;
use tinysom::{Grid, Neighborhood, SampleOrder, Schedule};

/// Maximum number of neurons.
pub const MAX_NEURONS: usize = 10_000;
/// Maximum number of epochs.
pub const MAX_EPOCHS: u32 = 1_000_000;

/// Trains a self-organizing map on any table of numbers and says how good it is.
#[derive(Debug, Clone, clap::Args)]
#[command(after_help = "\
Examples:
  host-sim som --data flowers.csv
      a 4 x 4 map of the table, and how well it fits
  host-sim som --data flowers.csv --grid chain:32 --epochs 200 --out pictures
      32 neurons in a row, longer training; code vectors and pictures go to a folder
  host-sim som --data flowers.csv --init start.csv --order file --rate 0.5:0.1667:inverse
      everything fixed by hand, nothing random")]
pub struct SomArgs {
    /// Table of numbers: one sample per line, values separated by commas, semicolons or tabs. A
    /// heading in the first line and labels in the last column are recognized and left out
    #[arg(long, value_name = "FILE")]
    pub data: PathBuf,

    /// Neurons: COLUMNSxROWS for a rectangle, chain:COUNT for a row
    #[arg(long, value_name = "SIZE", default_value = "4x4", value_parser = parse_grid)]
    pub grid: Grid,

    /// How often every sample is presented
    #[arg(long, value_name = "N", default_value_t = 50,
        value_parser = clap::value_parser!(u32).range(1..=i64::from(MAX_EPOCHS)))]
    pub epochs: u32,

    /// Where all randomness comes from: the same seed gives the same map
    #[arg(long, value_name = "N", default_value_t = 1)]
    pub seed: u64,

    /// Code vectors to begin with: "samples" (some of the data), "random" (values between each
    /// column's least and greatest), or a table of one line per neuron, row by row, in the units of
    /// the data
    #[arg(long, value_name = "samples|random|FILE", default_value = "samples", value_parser = parse_init)]
    pub init: InitialCode,

    /// Order in which samples are presented
    #[arg(long, value_enum, default_value_t = PresentationOrder::Shuffled)]
    pub order: PresentationOrder,

    /// Who learns with the winner: its "direct" neighbors, or everybody by a "gaussian" of the
    /// distance on the grid
    #[arg(long, alias = "neighborhood", default_value = "gaussian",
        value_parser = PossibleValuesParser::new(["direct", "gaussian"]).map(parse_neighborhood))]
    pub neighborhood: Neighborhood,

    /// Learning rate and how it falls; SHAPE is linear, exponential or inverse
    #[arg(long, value_name = "START:END:SHAPE", default_value = DEFAULT_RATE, value_parser = parse_rate)]
    pub rate: Schedule,

    /// Radius of the gaussian in grid steps and how it falls [default: from 0.3 times the longer
    /// side of the grid, at least 1, to 0.42, exponential]; with direct neighbors their share of
    /// the learning rate [default: 0.5:0.05:exponential]
    #[arg(long, value_name = "START:END:SHAPE", value_parser = parse_radius)]
    pub radius: Option<Schedule>,

    /// Range of the data's values, the same for all columns [default: least and greatest value]
    #[arg(long, value_name = "MIN:MAX", allow_hyphen_values = true)]
    pub scale: Option<Scale>,

    /// Folder for the code vectors and pictures of the map
    #[arg(long, value_name = "FOLDER")]
    pub out: Option<PathBuf>,

    /// Print one JSON object instead of a table
    #[arg(long)]
    pub json: bool,
}

/// The order in which samples are presented.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
pub enum PresentationOrder {
    /// As in the file, epoch by epoch
    File,
    /// Shuffled anew for each epoch
    Shuffled,
}

impl From<PresentationOrder> for SampleOrder {
    fn from(order: PresentationOrder) -> Self {
        match order {
            PresentationOrder::File => Self::AsGiven,
            PresentationOrder::Shuffled => Self::Shuffled,
        }
    }
}

/// Initial code vectors.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum InitialCode {
    /// Random samples.
    Samples,
    /// Random values in each column's range.
    Random,
    /// A table of code vectors.
    File(PathBuf),
}

impl SomArgs {
    /// Schedule of the radius: from the flag, otherwise the default for grid and neighborhood.
    ///
    /// # Errors
    /// A share of the direct neighbors above 1.
    pub fn radius(&self) -> Result<Schedule, BadInput> {
        match (self.radius, self.neighborhood) {
            (Some(radius), Neighborhood::Direct) if radius.start_q16() > 1 << 16 => {
                Err(BadInput::new(
                    "--radius must lie between 0 and 1 with --neighborhood direct: it is the neighbors' share",
                ))
            }
            (Some(radius), _) => Ok(radius),
            (None, neighborhood) => default_radius(neighborhood, self.grid),
        }
    }
}

/// Default schedule of the radius for a grid.
///
/// # Errors
/// None for a grid of at most [`MAX_NEURONS`].
pub fn default_radius(neighborhood: Neighborhood, grid: Grid) -> Result<Schedule, BadInput> {
    parse_radius(&match neighborhood {
        Neighborhood::Direct => "0.5:0.05:exponential".to_owned(),
        Neighborhood::Gaussian => {
            let side = grid.columns().max(grid.rows());
            // A smaller final radius raises the topographic error, a larger one the quantization
            // error.
            format!("{}:0.42:exponential", (0.3 * side as f64).max(1.0))
        }
    })
}

/// Default schedule of the learning rate.
pub const DEFAULT_RATE: &str = "0.9:0.03:exponential";

fn parse_grid(text: &str) -> Result<Grid, BadInput> {
    let syntax_error =
        || BadInput::new("it must be COLUMNSxROWS or chain:COUNT, for example 4x4 or chain:32");
    let count = |text: &str| text.parse::<usize>().map_err(|_| syntax_error());
    let (columns, rows) = match (text.strip_prefix("chain:"), text.split_once('x')) {
        (Some(neurons), _) => (count(neurons)?, 1),
        (None, Some((columns, rows))) => (count(columns)?, count(rows)?),
        (None, None) => return Err(syntax_error()),
    };
    let neurons = columns.saturating_mul(rows);
    match (u16::try_from(columns), u16::try_from(rows)) {
        _ if neurons == 0 => Err(BadInput::new("a map has at least one neuron")),
        (Ok(columns), Ok(rows)) if neurons <= MAX_NEURONS => Ok(Grid::rectangle(columns, rows)),
        _ => Err(BadInput::new(format!(
            "a map has at most {MAX_NEURONS} neurons"
        ))),
    }
}

#[expect(clippy::unnecessary_wraps, reason = "clap expects a Result")]
fn parse_init(text: &str) -> Result<InitialCode, BadInput> {
    Ok(match text {
        "samples" => InitialCode::Samples,
        "random" => InitialCode::Random,
        path => InitialCode::File(path.into()),
    })
}

fn parse_neighborhood(word: String) -> Neighborhood {
    if word == "direct" {
        Neighborhood::Direct
    } else {
        Neighborhood::Gaussian
    }
}

/// Parses the schedule of a learning rate, `START:END:SHAPE`.
///
/// # Errors
/// A rate outside 0 to 1, an end above the start, an unknown shape.
pub fn parse_rate(text: &str) -> Result<Schedule, BadInput> {
    settings::schedule(text, 1.0).map_err(BadInput::new)
}

fn parse_radius(text: &str) -> Result<Schedule, BadInput> {
    settings::schedule(text, MAX_NEURONS as f64).map_err(BadInput::new)
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::{Args as _, FromArgMatches as _};

    fn parse(flags: &str) -> Result<SomArgs, String> {
        let words = ["som"].into_iter().chain(flags.split_whitespace());
        let command = SomArgs::augment_args(clap::Command::new("som"));
        let matches = command.try_get_matches_from(words);
        let args = matches.and_then(|matches| SomArgs::from_arg_matches(&matches));
        args.map_err(|error| error.to_string())
    }

    #[test]
    fn flags_are_parsed() {
        let args = parse("--data a.csv --grid chain:32 --scale -1:1 --init start.csv --order file")
            .unwrap();
        assert_eq!(args.grid, Grid::chain(32));
        assert_eq!(args.init, InitialCode::File("start.csv".into()));
        assert_eq!(args.order, PresentationOrder::File);
        assert_eq!(args.scale.map(Scale::span), Some(2.0));
        assert_eq!(args.radius().unwrap().start_q16(), 629_146); // 9.6
        let direct = parse("--data a.csv --neighborhood direct").unwrap();
        assert_eq!(direct.radius().unwrap().start_q16(), 1 << 15);
        assert_eq!(direct.init, InitialCode::Samples);
    }

    #[test]
    fn errors_name_the_flag() {
        for (flags, expected) in [
            ("--grid 0x4", "at least one neuron"),
            ("--grid chain:0", "at least one neuron"),
            ("--grid 4x", "COLUMNSxROWS"),
            ("--grid 4x4x4", "COLUMNSxROWS"),
            ("--grid=-4x4", "COLUMNSxROWS"),
            ("--grid 101x100", "at most 10000 neurons"),
            ("--grid 4294967296x4294967296", "at most 10000 neurons"),
            ("--grid chain:70000", "at most 10000 neurons"),
            ("--grid round", "COLUMNSxROWS"),
            ("--epochs 0", "1..=1000000"),
            ("--epochs 1000001", "1..=1000000"),
            ("--epochs many", "invalid digit"),
            ("--seed=-1", "invalid digit"),
            ("--scale 1:1", "1 is not below 1"),
            ("--scale 5:2", "5 is not below 2"),
            ("--scale wide", "MIN:MAX"),
            ("--rate 2", "between 0 and 1"),
            ("--rate 0.1:0.5", "above its start"),
            ("--rate 0.5:0.1:cubic", "linear, exponential, inverse"),
            ("--radius NaN", "between 0 and 10000"),
            ("--order sorted", "shuffled"),
            ("--neighborhood bubble", "gaussian"),
        ] {
            let error = parse(&format!("--data a.csv {flags}")).expect_err(flags);
            assert!(error.contains(expected), "{flags}: {error}");
            let flag = flags.split([' ', '=']).next().unwrap();
            assert!(error.contains(flag), "{flags}: {error}");
        }
        assert!(parse("").unwrap_err().contains("--data"));
        let share = parse("--data a.csv --neighborhood direct --radius 2").unwrap();
        assert!(share.radius().unwrap_err().to_string().contains("--radius"));
    }
}
