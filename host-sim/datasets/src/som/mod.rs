//! Self-organizing maps of any table of numbers: `host-sim som`.
//!
//! Data flows from [`files::table`] (a text file) through [`scale`] (weights in [0, 1]), [`start`]
//! and a training of `tinysom` to [`report`] (figures in the data's units, code vectors, pictures).

pub mod args;
pub mod measures;
pub mod report;
pub mod scale;
pub mod start;

pub use args::SomArgs;
pub use report::Report;

use arena::noise::Noise;
use args::Init;
use files::error::BadInput;
use files::table::Table;
use measures::Measures;
use scale::Scale;
use std::path::Path;
use tinysom::{DynSom, TrainConfig, Weight32};

/// Does what the flags say and returns the text for standard output, without a newline at its end.
///
/// # Errors
/// One sentence about a flag, the data, the starting code vectors or the folder for the results.
pub fn run(args: &SomArgs) -> Result<String, BadInput> {
    let data = Table::load(&args.data)?;
    let scale = match args.scale {
        Some(scale) => scale,
        None => Scale::of(&data)?,
    };
    let mut samples = scale.samples(&data)?;
    let config = train_config(args, &data)?;
    let mut noise = Noise::new(args.seed);
    let mut map = start_map(args, scale, &samples, data.columns(), &mut noise)?;
    if let Some(folder) = &args.out {
        // A folder that cannot be made is better known before the training than after it.
        report::write_files(folder, &[])?;
    }
    map.train(&mut samples, &config, |below| noise.index(below));
    let measures = Measures::of(&map, &samples);
    if let Some(folder) = &args.out {
        let record = report::record(&map, &measures, scale);
        let code = report::code_vectors_csv(&record, &data.names, scale.decimals());
        let mut files = vec![("code_vectors.csv", code)];
        files.extend(report::pictures(&record, &data));
        report::write_files(folder, &files)?;
    }
    let report = Report {
        neurons: map.grid().len(),
        dims: data.columns(),
        samples: data.rows.len(),
        epochs: args.epochs,
        quantization_error: measures.quantization_error * scale.span(),
        topographic_error: measures.topographic_error,
    };
    Ok(if args.json {
        report.to_json()
    } else {
        report.to_string()
    })
}

fn train_config(args: &SomArgs, data: &Table) -> Result<TrainConfig, BadInput> {
    let samples = data.rows.len();
    if samples as u64 * u64::from(args.epochs) > u64::from(u32::MAX) {
        return Err(BadInput::new(format!(
            "--epochs {} of the {samples} samples in {} are more than {} presentations",
            args.epochs,
            data.source,
            u32::MAX
        )));
    }
    Ok(TrainConfig {
        neighborhood: args.neighborhood,
        rate: args.rate,
        radius: args.radius()?,
        epochs: args.epochs,
        order: args.order.into(),
    })
}

fn start_map(
    args: &SomArgs,
    scale: Scale,
    samples: &[Weight32],
    dims: usize,
    noise: &mut Noise,
) -> Result<DynSom, BadInput> {
    match &args.init {
        Init::Samples => start::start_at_samples(args.grid, dims, samples, noise),
        Init::Random => start::start_at_random(args.grid, dims, samples, noise),
        Init::File(path) => start_at_table(args, scale, dims, path),
    }
}

fn start_at_table(
    args: &SomArgs,
    scale: Scale,
    dims: usize,
    path: &Path,
) -> Result<DynSom, BadInput> {
    if !path.exists() {
        let what = "there is no such file (--init takes samples, random or a file)";
        return Err(BadInput::file(path, what));
    }
    let table = Table::load(path)?;
    let (rows, columns) = (table.rows.len(), table.columns());
    if (rows, columns) != (args.grid.len(), dims) {
        let what = format!(
            "{rows} x {columns} values where the map has {} neurons of {dims} components",
            args.grid.len()
        );
        return Err(BadInput::file(path, what));
    }
    start::map_of(args.grid, dims, scale.code(&table)?)
}

#[cfg(test)]
mod tests;
