//! Pictures of the results of `host-sim learn`, and the page that shows them.

use super::{LearnResults, size};
use crate::cli::CliError;
use datasets::learn::{MapResult, RecallMethod, Score};
use datasets::som::map_quality::u_matrix;
use datasets::som::report::{code_vectors_csv, write_files};
use plots::{Figure, LabeledMap};
use sim::recording::MapRecord;
use std::path::Path;

/// Decimals of code vectors in files: finer than any range finder.
const DECIMALS: usize = 6;

impl LearnResults<'_> {
    /// Writes all pictures.
    ///
    /// # Errors
    /// A folder that cannot be written.
    pub(super) fn pictures(&self, folder: &Path) -> Result<(), CliError> {
        let mut files = Vec::new();
        let mut figures = Vec::new();
        if self.evaluation.maps.len() > 1 {
            files.push(("map_size.svg".to_owned(), self.curve()));
            figures.push(figure("map_size.svg", "Map size", CURVE));
        }
        for map in &self.evaluation.maps {
            let (maps, names) = self.pictures_of(map);
            files.extend(maps);
            figures.extend(names);
        }
        let page = plots::index_html("Learned from a log", &self.facts(), &figures, &[]);
        files.push(("index.html".to_owned(), page));
        let files: Vec<_> = files
            .iter()
            .map(|(name, content)| (name.as_str(), content.clone()))
            .collect();
        Ok(write_files(folder, &files)?)
    }

    fn pictures_of(&self, map: &MapResult) -> (Vec<(String, String)>, Vec<Figure>) {
        let name = |what: &str, ending: &str| match self.evaluation.maps.len() {
            1 => format!("{what}.{ending}"),
            _ => format!("{what}_{}.{ending}", size(map)),
        };
        let record = self.record(map);
        let labels = LabeledMap {
            map: &record,
            labels: &map.labels,
            components: self.components(),
            named: self.is_named(),
        };
        let (svg, csv) = (name("situation_map", "svg"), name("code_vectors", "csv"));
        let title = format!("Situation map, {}", size(map));
        let mut figures = vec![figure(&svg, &title, MAP)];
        let mut files = vec![
            (svg, plots::labeled_map(&labels, &title)),
            (csv, code_vectors_csv(&record, &self.log.names, DECIMALS)),
        ];
        for result in &map.scores {
            let Score::Classes { confusion, .. } = &result.score else {
                continue;
            };
            let svg = name(&format!("confusion_{}", result.method.key()), "svg");
            let [by, with] = result.method.descriptions(true);
            let title = format!("{by}, probed with the {with}, {}", size(map));
            figures.push(figure(&svg, &title, CONFUSION));
            files.push((svg, plots::confusion(&title, self.components(), confusion)));
        }
        (files, figures)
    }

    /// The situation map as nearness; distances in the log's unit.
    fn record(&self, map: &MapResult) -> MapRecord {
        let nearness = |row: &[amp::fixed::Weight32]| {
            let one = f64::from(amp::fixed::FINE_ONE_BITS);
            row.iter()
                .map(|weight| f64::from(weight.to_bits()) / one)
                .collect()
        };
        MapRecord {
            grid: [map.grid.columns(), map.grid.rows()],
            code: map.situations.code_vectors().map(nearness).collect(),
            hits: map.training.hits.clone(),
            u_matrix: u_matrix(&map.situations)
                .iter()
                .map(|distance| distance * self.span())
                .collect(),
        }
    }

    fn curve(&self) -> String {
        let lines = (0..3).filter_map(|index| {
            let value = |map: &MapResult| map.scores.get(index).map(|result| self.headline(result));
            let method = self.evaluation.maps.first()?.scores.get(index)?.method;
            let values = self.evaluation.maps.iter().filter_map(value).collect();
            Some((self.line_name(method), values))
        });
        let levels = self.evaluation.baselines.iter();
        let levels = levels.map(|result| (self.line_name(result.method), self.headline(result)));
        let sizes: Vec<_> = self.evaluation.maps.iter().map(size).collect();
        let measure = if self.is_named() {
            "share of the held-out actions recalled correctly"
        } else {
            "error relative to that of the mean"
        };
        plots::sizes(
            "Recall by map size",
            measure,
            &sizes,
            &lines.collect::<Vec<_>>(),
            &levels.collect::<Vec<_>>(),
        )
    }

    fn line_name(&self, method: RecallMethod) -> String {
        let [by, with] = method.descriptions(self.is_named());
        if with == "nothing" {
            by.to_owned()
        } else {
            format!("{by}, by the {with}")
        }
    }
}

fn figure(file: &str, title: &str, caption: &str) -> Figure {
    Figure {
        file: file.to_owned(),
        title: title.to_owned(),
        caption: vec![caption.to_owned()],
    }
}

const CURVE: &str =
    "Recall of the held-out part by the size of the maps, and of methods without maps.";
const MAP: &str = "Each tile is a neuron: in maps of large tiles bars show the nearness of obstacles \
     around the ring, first column up and the others counter-clockwise; the color is the most \
     frequent action in the situations that the neuron won.";
const CONFUSION: &str = "Rows: true actions; columns: recalled actions; each cell has its share of \
     the row and its count.";
