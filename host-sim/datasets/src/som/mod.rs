//! Self-organizing maps of any table of numbers: `host-sim som`.
//!
//! Data flow: [`files::table`] (a text file), [`scale`] (weights in [0, 1]), [`init`] (initial code
//! vectors), training by `tinysom`, [`report`] (figures in the data's units, code vectors,
//! pictures).

pub mod args;
pub mod init;
pub mod map_quality;
pub mod report;
pub mod scale;

pub use args::SomArgs;
pub use report::SomReport;

use arena::noise::Noise;
use args::InitialCode;
use files::error::BadInput;
use files::table::Table;
use map_quality::MapQuality;
use scale::Scale;
use std::path::Path;
use tinysom::{DynSom, TrainConfig, Weight32};

/// Runs the command and returns the text for standard output, without a trailing newline.
///
/// # Errors
/// A sentence about a flag, the data, the initial code vectors or the output folder.
pub fn run(args: &SomArgs) -> Result<String, BadInput> {
    let data = Table::load(&args.data)?;
    let scale = match args.scale {
        Some(scale) => scale,
        None => Scale::from_table(&data)?,
    };
    let mut samples = scale.samples(&data)?;
    let config = train_config(args, &data)?;
    let mut noise = Noise::new(args.seed);
    let mut map = init_map(args, scale, &samples, data.columns(), &mut noise)?;
    if let Some(folder) = &args.out {
        // Reports an invalid folder before the training, which may take long.
        report::write_files(folder, &[])?;
    }
    map.train(&mut samples, &config, |below| noise.index(below));
    let quality = MapQuality::measure(&map, &samples);
    if let Some(folder) = &args.out {
        let record = report::record(&map, &quality, scale);
        let code = report::code_vectors_csv(&record, &data.names, scale.decimals());
        let mut files = vec![("code_vectors.csv", code)];
        files.extend(report::pictures(&record, &data));
        report::write_files(folder, &files)?;
    }
    let report = SomReport {
        neurons: map.grid().len(),
        dims: data.columns(),
        samples: data.rows.len(),
        epochs: args.epochs,
        quantization_error: quality.quantization_error * scale.span(),
        topographic_error: quality.topographic_error,
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

fn init_map(
    args: &SomArgs,
    scale: Scale,
    samples: &[Weight32],
    dims: usize,
    noise: &mut Noise,
) -> Result<DynSom, BadInput> {
    match &args.init {
        InitialCode::Samples => init::init_from_samples(args.grid, dims, samples, noise),
        InitialCode::Random => init::init_at_random(args.grid, dims, samples, noise),
        InitialCode::File(path) => init_from_table(args, scale, dims, path),
    }
}

fn init_from_table(
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
    init::new_map(args.grid, dims, scale.code_vectors(&table)?)
}

#[cfg(test)]
mod tests;
