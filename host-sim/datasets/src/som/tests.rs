use super::*;
use clap::{Args as _, FromArgMatches as _};
use tempfile::TempDir;
use tinysom::Grid;

/// A folder with `data.csv`: 60 samples of 3 values between 10 and 30, with heading and labels.
fn data_folder() -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    let mut noise = Noise::new(5);
    let mut text = "width,height,depth,kind\n".to_owned();
    for index in 0..60 {
        let center = if index % 2 == 0 { 13.0 } else { 27.0 };
        let value = |noise: &mut Noise| center + noise.uniform_in(-3.0, 3.0);
        let [a, b, c] = [(); 3].map(|()| value(&mut noise));
        text += &format!("{a:.3},{b:.3},{c:.3},kind {}\n", index % 2);
    }
    std::fs::write(folder.path().join("data.csv"), text).unwrap();
    folder
}

/// Runs `som --data data.csv …` in a folder; `@` stands for the folder.
fn som(folder: &TempDir, flags: &str) -> Result<String, String> {
    let flags =
        format!("som --data @/data.csv {flags}").replace('@', &folder.path().display().to_string());
    let command = SomArgs::augment_args(clap::Command::new("som"));
    let matches = command
        .try_get_matches_from(flags.split_whitespace())
        .unwrap();
    run(&SomArgs::from_arg_matches(&matches).unwrap()).map_err(|error| error.to_string())
}

#[test]
fn figures_have_the_units_of_the_data() {
    let folder = data_folder();
    let text = som(&folder, "--grid 3x2 --epochs 30 --json --out @/out").unwrap();
    let report: serde_json::Value = serde_json::from_str(&text).unwrap();
    assert_eq!(
        (&report["neurons"], &report["dims"]),
        (&6.into(), &3.into())
    );
    assert_eq!(
        (&report["samples"], &report["epochs"]),
        (&60.into(), &30.into())
    );
    // Computes the quantization error in floats from the written code vectors.
    let data = Table::load(&folder.path().join("data.csv")).unwrap();
    let code = Table::load(&folder.path().join("out/code_vectors.csv")).unwrap();
    assert_eq!(code.names, ["width", "height", "depth"]);
    for picture in ["code_vectors.svg", "u_matrix.svg", "samples.svg"] {
        let svg = std::fs::read_to_string(folder.path().join("out").join(picture)).unwrap();
        assert!(svg.contains("<svg") && svg.contains("</svg>"), "{picture}");
    }
    let distance = |a: &[f64], b: &[f64]| {
        a.iter()
            .zip(b)
            .map(|(a, b)| (a - b).powi(2))
            .sum::<f64>()
            .sqrt()
    };
    let nearest = |sample: &Vec<f64>| {
        code.rows
            .iter()
            .map(|row| distance(row, sample))
            .fold(f64::INFINITY, f64::min)
    };
    let mean = data.rows.iter().map(nearest).sum::<f64>() / 60.0;
    let reported = report["quantization_error"].as_f64().unwrap();
    assert!(
        (reported - mean).abs() < 0.01 && mean > 0.5 && mean < 3.5,
        "{reported} {mean}"
    );
    assert!((0.0..=1.0).contains(&report["topographic_error"].as_f64().unwrap()));
}

#[test]
fn results_depend_only_on_the_seed() {
    let folder = data_folder();
    let code = |out: &str| {
        std::fs::read_to_string(folder.path().join(out).join("code_vectors.csv")).unwrap()
    };
    let table = som(&folder, "--out @/a --seed 7 --init random").unwrap();
    assert_eq!(
        table,
        som(&folder, "--out @/b --seed 7 --init random").unwrap()
    );
    assert_eq!(code("a"), code("b"));
    som(&folder, "--out @/c --seed 8 --init random").unwrap();
    assert_ne!(code("a"), code("c"));
    // With given code vectors and order, the seed has no effect.
    som(
        &folder,
        "--out @/d --seed 1 --init @/a/code_vectors.csv --order file",
    )
    .unwrap();
    som(
        &folder,
        "--out @/e --seed 2 --init @/a/code_vectors.csv --order file",
    )
    .unwrap();
    assert_eq!(code("d"), code("e"));
}

#[test]
fn written_code_vectors_can_be_read_back() {
    let folder = data_folder();
    som(&folder, "--out @/a").unwrap();
    // With a learning rate of 0 the map does not change.
    som(&folder, "--out @/b --init @/a/code_vectors.csv --rate 0").unwrap();
    let read = |out: &str| std::fs::read(folder.path().join(out).join("code_vectors.csv")).unwrap();
    assert_eq!(read("a"), read("b"));
}

#[test]
fn errors_name_the_bad_input() {
    let folder = data_folder();
    let write = |name: &str, text: &str| std::fs::write(folder.path().join(name), text).unwrap();
    write("short.csv", "1,2,3\n4,5,6\n");
    write("far.csv", &"1,2,300\n".repeat(16));
    for (flags, expected) in [
        (
            "--init @/short.csv",
            "short.csv: 2 x 3 values where the map has 16 neurons of 3 components",
        ),
        (
            "--init @/far.csv",
            "far.csv, line 1, column 3: 300 lies outside",
        ),
        (
            "--init sample",
            "sample: there is no such file (--init takes samples, random or a file)",
        ),
        ("--scale 0:20", "lies outside 0 to 20"),
        ("--out @/data.csv", "data.csv: "),
        ("--out @/data.csv/x", "data.csv/x: "),
        (
            "--neighborhood direct --radius 3:1:linear",
            "--radius must lie between 0 and 1",
        ),
    ] {
        let error = som(&folder, flags).expect_err(flags);
        assert!(error.contains(expected), "{flags}: {error}");
        assert!(!error.contains('\n'), "{error}");
    }
    write("data.csv", &"1,2\n".repeat(5_000));
    let error = som(&folder, "--epochs 1000000").unwrap_err();
    assert!(
        error.contains("--epochs 1000000 of the 5000 samples"),
        "{error}"
    );
    std::fs::remove_file(folder.path().join("data.csv")).unwrap();
    assert!(som(&folder, "").unwrap_err().contains("data.csv: "));
}

#[test]
fn the_smallest_maps_and_tables_work() {
    let folder = data_folder();
    std::fs::write(folder.path().join("data.csv"), "5\n").unwrap();
    for flags in [
        "--grid 1x1",
        "--grid chain:3",
        "--grid 3x3 --neighborhood direct",
        "--init random",
    ] {
        let text = som(&folder, &format!("{flags} --json")).unwrap();
        assert!(
            text.contains("\"quantization_error\":0.0,"),
            "{flags}: {text}"
        );
    }
}

#[test]
fn initial_code_vectors_lie_within_the_samples() {
    let bits = [100, 7_000, 300, 8_000, 200, 7_500];
    let samples: Vec<_> = bits.map(Weight32::from_bits).to_vec();
    let map = init::init_from_samples(Grid::chain(3), 2, &samples, &mut Noise::new(1)).unwrap();
    let mut rows: Vec<_> = map.code_vectors().map(<[_]>::to_vec).collect();
    rows.sort();
    assert_eq!(
        rows.concat(),
        [100, 7_000, 200, 7_500, 300, 8_000].map(Weight32::from_bits)
    );
    let map = init::init_at_random(Grid::chain(100), 2, &samples, &mut Noise::new(1)).unwrap();
    for row in map.code_vectors() {
        assert!(
            (100..=300).contains(&row[0].to_bits()) && (7_000..=8_000).contains(&row[1].to_bits())
        );
    }
}

#[test]
fn too_many_columns_are_rejected() {
    let folder = data_folder();
    let line = vec!["1"; 4_096].join(",");
    std::fs::write(folder.path().join("data.csv"), format!("{line}\n")).unwrap();
    let error = som(&folder, "--grid 1x1").unwrap_err();
    assert!(
        error.contains("4096 components are more than 4095"),
        "{error}"
    );
}
