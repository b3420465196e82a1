//! Results of a training: figures, code vectors and pictures.

use super::map_quality::{MapQuality, u_matrix};
use super::scale::Scale;
use files::error::BadInput;
use files::table::Table;
use serde::Serialize;
use sim::recording::MapRecord;
use std::fmt;
use std::path::Path;
use tinysom::DynSom;

/// Figures of a trained map; distances in the units of the data.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct SomReport {
    /// Number of neurons.
    pub neurons: usize,
    /// Components of a sample.
    pub dims: usize,
    /// Number of samples.
    pub samples: usize,
    /// Presentations of every sample.
    pub epochs: u32,
    /// Mean Euclidean distance of a sample to its best-matching unit.
    pub quantization_error: f64,
    /// Share of the samples whose best two neurons are not direct neighbors (left, right, above,
    /// below), 0 to 1.
    pub topographic_error: f64,
}

impl SomReport {
    /// One JSON object on one line.
    #[must_use]
    pub fn to_json(&self) -> String {
        serde_json::to_string(self).unwrap_or_default()
    }
}

impl fmt::Display for SomReport {
    /// A table with one figure per line.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "neurons             {:>10}", self.neurons)?;
        writeln!(f, "components          {:>10}", self.dims)?;
        writeln!(f, "samples             {:>10}", self.samples)?;
        writeln!(f, "epochs              {:>10}", self.epochs)?;
        let (distance, share) = (self.quantization_error, 100.0 * self.topographic_error);
        writeln!(
            f,
            "quantization error  {distance:>10.4}  mean distance to the best neuron, in the data's units"
        )?;
        write!(
            f,
            "topographic error   {share:>8.2} %  samples whose best two neurons are not neighbors"
        )
    }
}

/// The map in the units of the data, in the form that pictures are drawn from.
#[must_use]
pub fn record(map: &DynSom, quality: &MapQuality, scale: Scale) -> MapRecord {
    let values = |row: &[_]| row.iter().map(|&weight| scale.value(weight)).collect();
    MapRecord {
        grid: [map.grid().columns(), map.grid().rows()],
        code: map.code_vectors().map(values).collect(),
        hits: quality.hits.clone(),
        u_matrix: u_matrix(map)
            .iter()
            .map(|distance| distance * scale.span())
            .collect(),
    }
}

/// The code vectors as a table, one line per neuron, row by row, in the units of the data;
/// `--init` accepts it.
#[must_use]
pub fn code_vectors_csv(map: &MapRecord, names: &[String], decimals: usize) -> String {
    let heading = names
        .iter()
        .map(|name| quoted(name))
        .collect::<Vec<_>>()
        .join(",");
    let row = |values: &Vec<f64>| {
        let fields: Vec<_> = values
            .iter()
            .map(|value| format!("{value:.decimals$}"))
            .collect();
        fields.join(",")
    };
    let heading = (!names.is_empty()).then_some(heading);
    let lines = heading.into_iter().chain(map.code.iter().map(row));
    lines.map(|line| line + "\n").collect()
}

fn quoted(name: &str) -> String {
    if name.contains([',', ';', '\t', '#']) {
        format!("\"{name}\"")
    } else {
        name.to_owned()
    }
}

/// Pictures of a map and its data: file names and SVG documents. Data with two or three columns get
/// a scatter plot with the map in it.
#[must_use]
pub fn pictures(map: &MapRecord, data: &Table) -> Vec<(&'static str, String)> {
    let scatter = plots::scatter(map, &data.rows, &data.names, "Samples and map");
    let mut pictures = vec![
        (
            "code_vectors.svg",
            plots::code_vectors(map, &data.names, "Code vectors"),
        ),
        ("u_matrix.svg", plots::u_matrix(map, "U-matrix and hits")),
    ];
    pictures.extend(scatter.map(|picture| ("samples.svg", picture)));
    pictures
}

/// Writes files into a folder and creates the folder if it does not exist. Each file appears under
/// its name only when it is complete.
///
/// # Errors
/// A sentence that names the folder or file that cannot be written.
pub fn write_files(folder: &Path, contents: &[(&str, String)]) -> Result<(), BadInput> {
    std::fs::create_dir_all(folder).map_err(|error| BadInput::file(folder, error))?;
    for (name, content) in contents {
        let path = folder.join(name);
        files::write(&path, content.as_bytes()).map_err(|error| BadInput::file(&path, error))?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn json_has_exactly_these_keys() {
        let report = SomReport {
            neurons: 16,
            dims: 3,
            samples: 100,
            epochs: 50,
            quantization_error: 0.25,
            topographic_error: 0.03,
        };
        assert_eq!(
            report.to_json(),
            "{\"neurons\":16,\"dims\":3,\"samples\":100,\"epochs\":50,\"quantization_error\":0.25,\"topographic_error\":0.03}"
        );
        let table = report.to_string();
        assert!(table.contains("quantization error      0.2500 "), "{table}");
        assert!(table.contains("topographic error       3.00 %"), "{table}");
    }

    #[test]
    fn code_vectors_can_be_read_back() {
        let map = MapRecord {
            grid: [2, 1],
            code: vec![vec![0.5, -1.0], vec![2.0, 0.125]],
            hits: vec![1, 1],
            u_matrix: vec![1.0, 1.0],
        };
        let names = ["a, b".to_owned(), "c".to_owned()];
        let text = code_vectors_csv(&map, &names, 3);
        assert_eq!(text, "\"a, b\",c\n0.500,-1.000\n2.000,0.125\n");
        let table = Table::parse("t.csv", &text).unwrap();
        assert_eq!(
            (table.rows, table.names),
            (map.code.clone(), names.to_vec())
        );
        assert!(code_vectors_csv(&map, &[], 1).starts_with("0.5,-1.0\n"));
    }

    #[test]
    fn files_are_complete_or_absent() {
        let folder = tempfile::tempdir().unwrap();
        let out = folder.path().join("a/b");
        write_files(&out, &[("x.csv", "1\n".to_owned())]).unwrap();
        assert_eq!(std::fs::read_to_string(out.join("x.csv")).unwrap(), "1\n");
        assert_eq!(std::fs::read_dir(&out).unwrap().count(), 1);
        let error = write_files(&out.join("x.csv"), &[])
            .unwrap_err()
            .to_string();
        assert!(error.contains("x.csv"), "{error}");
        // A folder has this name: the rename fails and the temporary file is deleted.
        std::fs::create_dir(out.join("y.csv")).unwrap();
        let error = write_files(&out, &[("y.csv", "1\n".to_owned())])
            .unwrap_err()
            .to_string();
        assert!(error.contains("y.csv"), "{error}");
        assert_eq!(std::fs::read_dir(&out).unwrap().count(), 2);
    }
}
