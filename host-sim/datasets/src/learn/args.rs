//! The flags of `host-sim learn`.

use super::dataset::DatasetOptions;
use super::evaluation::TrainOptions;
use super::log::LogColumns;
use crate::som::args::MAX_EPOCHS;
use files::error::BadInput;
use std::path::PathBuf;
use std::str::FromStr;
use tinysom::Grid;

/// Learns both maps from a logged run of a real robot and says how well they recall what it did
#[derive(Debug, Clone, clap::Args)]
#[command(after_help = "\
Examples:
  host-sim learn --log run.csv
      4 x 4 maps from the first 70 % of the rows, asked about the rest; the last column names the action
  host-sim learn --log run.csv --map 4x4..=20x20 --far 5 --out pictures
      accuracy by map size; maps, confusion matrices and the curve go to a folder
  host-sim learn --log run.csv --ranges 2-17 --velocities v,omega --unit mm
      ranges in mm in columns 2 to 17, velocities in the columns v and omega")]
pub struct LearnArgs {
    /// Log of a run: one moment per line in the order of time, values separated by commas,
    /// semicolons or tabs
    #[arg(long, value_name = "FILE")]
    pub log: PathBuf,

    /// Neurons of each map: COLUMNSxROWS, each 4 to 20; several sizes (4x4,8x8) or all squares from
    /// one to another (4x4..=20x20) give a curve
    #[arg(long, value_name = "SIZES", default_value = "4x4")]
    pub map: MapSizes,

    /// Share of the rows held out at the end of the run: the maps do not learn from them and are
    /// asked about them
    #[arg(long, value_name = "SHARE", default_value = "0.3", value_parser = parse_share)]
    pub held_out: f64,

    /// How often every sample is presented
    #[arg(long, value_name = "N", default_value_t = 50,
        value_parser = clap::value_parser!(u32).range(1..=i64::from(MAX_EPOCHS)))]
    pub epochs: u32,

    /// Where all randomness comes from: the same seed gives the same maps
    #[arg(long, value_name = "N", default_value_t = 1)]
    pub seed: u64,

    /// Columns that hold ranges, by heading or number from 1: 1-24 or left,front,right [default:
    /// all columns of numbers but the action's]
    #[arg(long, value_name = "COLUMNS")]
    pub ranges: Option<String>,

    /// Column that names the action [default: the last]
    #[arg(long, value_name = "COLUMN", conflicts_with = "velocities")]
    pub label: Option<String>,

    /// Columns that hold velocities, instead of a label
    #[arg(long, value_name = "COLUMNS")]
    pub velocities: Option<String>,

    /// Whether the first line is a heading [default: yes if it holds no number]
    #[arg(long, value_name = "YES|NO", value_enum)]
    pub heading: Option<YesNo>,

    /// Unit of the ranges
    #[arg(long, value_name = "UNIT", default_value = "m", value_enum)]
    pub unit: RangeUnit,

    /// Range at which a situation's value is 1, in the log's unit
    #[arg(long, value_name = "RANGE", default_value_t = 0.0)]
    pub near: f64,

    /// Range from which on a situation's value is 0, in the log's unit [default: the greatest in
    /// the log]
    #[arg(long, value_name = "RANGE")]
    pub far: Option<f64>,

    /// A change of situation is that over so many rows
    #[arg(long, value_name = "ROWS", default_value_t = 1, value_parser = clap::value_parser!(u16).range(1..))]
    pub stride: u16,

    /// Weight of the action beside a range when the action map learns, above 0, at most 1
    #[arg(long, value_name = "WEIGHT", default_value = "1", value_parser = parse_weight)]
    pub action_weight: f64,

    /// Folder for pictures, a page and the code vectors
    #[arg(long, value_name = "FOLDER")]
    pub out: Option<PathBuf>,

    /// Print one JSON object per map size instead of tables
    #[arg(long)]
    pub json: bool,
}

/// Yes or no.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
pub enum YesNo {
    /// Yes.
    Yes,
    /// No.
    No,
}

/// Units of ranges.
#[derive(Debug, Clone, Copy, PartialEq, Eq, clap::ValueEnum)]
pub enum RangeUnit {
    /// Meters
    M,
    /// Centimeters
    Cm,
    /// Millimeters
    Mm,
    /// Inches
    In,
}

impl RangeUnit {
    /// Symbol of the unit.
    #[must_use]
    pub fn symbol(self) -> &'static str {
        match self {
            Self::M => "m",
            Self::Cm => "cm",
            Self::Mm => "mm",
            Self::In => "in",
        }
    }
}

/// Sizes of the maps.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct MapSizes(pub Vec<Grid>);

/// Allowed neurons along a side.
const SIDES: std::ops::RangeInclusive<u16> = 4..=20;

impl FromStr for MapSizes {
    type Err = BadInput;

    fn from_str(text: &str) -> Result<Self, BadInput> {
        let mut grids = Vec::new();
        for word in text.split(',') {
            let Some((first, last)) = word.split_once("..=") else {
                grids.push(parse_grid(word)?);
                continue;
            };
            let (first, last) = (parse_grid(first)?, parse_grid(last)?);
            let is_square = |grid: Grid| grid.columns() == grid.rows();
            if !(is_square(first) && is_square(last) && first.columns() <= last.columns()) {
                return Err(BadInput::new(format!(
                    "\"{word}\" must go from a square to one at least as large, for example 4x4..=20x20"
                )));
            }
            let sides = first.columns() as u16..=last.columns() as u16;
            grids.extend(sides.map(|side| Grid::rectangle(side, side)));
        }
        Ok(Self(grids))
    }
}

fn parse_grid(text: &str) -> Result<Grid, BadInput> {
    let sides = text.split_once('x').and_then(|(columns, rows)| {
        let side = |digits: &str| {
            digits
                .trim()
                .parse()
                .ok()
                .filter(|side| SIDES.contains(side))
        };
        Some((side(columns)?, side(rows)?))
    });
    let (columns, rows) = sides.ok_or_else(|| {
        BadInput::new(format!(
            "\"{text}\" must be COLUMNSxROWS, each {} to {}, for example 4x4",
            SIDES.start(),
            SIDES.end()
        ))
    })?;
    Ok(Grid::rectangle(columns, rows))
}

fn parse_share(text: &str) -> Result<f64, BadInput> {
    let share = text
        .parse()
        .ok()
        .filter(|share| *share > 0.0 && *share < 1.0);
    share.ok_or_else(|| BadInput::new("it must be above 0 and below 1"))
}

fn parse_weight(text: &str) -> Result<f64, BadInput> {
    let weight = text
        .parse()
        .ok()
        .filter(|weight| *weight >= 0.001 && *weight <= 1.0);
    weight.ok_or_else(|| BadInput::new("it must lie between 0.001 and 1"))
}

impl LearnArgs {
    /// The columns of the log.
    #[must_use]
    pub fn columns(&self) -> LogColumns {
        LogColumns {
            ranges: self.ranges.clone(),
            label: self.label.clone(),
            velocities: self.velocities.clone(),
            has_heading: self.heading.map(|choice| choice == YesNo::Yes),
        }
    }

    /// Options for making the dataset.
    #[must_use]
    pub fn dataset_options(&self) -> DatasetOptions {
        DatasetOptions {
            near: self.near,
            far: self.far,
            held_out: self.held_out,
            stride: usize::from(self.stride),
        }
    }

    /// Options for training the maps.
    #[must_use]
    pub fn train_options(&self) -> TrainOptions {
        TrainOptions {
            epochs: self.epochs,
            seed: self.seed,
            action_weight: self.action_weight,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sizes_are_lists_and_ranges() {
        let sides = |text: &str| -> Vec<_> {
            let MapSizes(grids) = text.parse().expect(text);
            grids
                .iter()
                .map(|grid| (grid.columns(), grid.rows()))
                .collect()
        };
        assert_eq!(sides("4x4"), [(4, 4)]);
        assert_eq!(sides("4x8,20x20"), [(4, 8), (20, 20)]);
        assert_eq!(sides("4x4..=6x6"), [(4, 4), (5, 5), (6, 6)]);
        for text in [
            "3x4",
            "21x4",
            "4",
            "4x",
            "x",
            "",
            "4x4,",
            "6x6..=4x4",
            "4x5..=6x6",
            "-4x4",
        ] {
            assert!(text.parse::<MapSizes>().is_err(), "{text}");
        }
    }
}
