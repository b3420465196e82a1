use super::*;

fn header() -> ResultsHeader {
    ResultsHeader::new("s", "00", 9, ["world".to_owned()].into_iter())
}

fn rows(numbers: &[u64]) -> String {
    let rows = numbers
        .iter()
        .map(|number| format!("{number},\"a \"\"\nb\"\n"));
    header().text().to_owned() + &rows.collect::<String>()
}

/// Opens a file with this content as that of a shard.
fn open(content: &str, shard: &str) -> Result<(u64, String), String> {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("below/results.csv");
    fs::create_dir(folder.path().join("below")).expect("a folder");
    fs::write(&path, content).expect("a file");
    let shard = shard.parse().expect("a shard");
    let (file, done) =
        ResultsFile::open(&path, &header(), shard).map_err(|error| error.to_string())?;
    file.finish().map_err(|error| error.to_string())?;
    Ok((done, fs::read_to_string(path).expect("text")))
}

#[test]
fn whatever_was_torn_is_cut_off() {
    let full = rows(&[0, 1, 2]);
    let whole = [
        header().text().len(),
        rows(&[0]).len(),
        rows(&[0, 1]).len(),
        full.len(),
    ];
    for length in 0..=full.len() {
        let (done, left) = open(&full[..length], "0/1").expect("a torn file");
        let rows = whole
            .iter()
            .filter(|&&end| end <= length)
            .count()
            .saturating_sub(1);
        assert_eq!(done as usize, rows, "cut at {length}");
        assert_eq!(left, full[..whole[rows]], "cut at {length}");
    }
}

#[test]
fn only_the_first_episodes_of_the_shard_are_taken() {
    assert_eq!(open(&rows(&[1, 4]), "1/3").expect("a shard's").0, 2);
    let say = |numbers: &[u64], shard| open(&rows(numbers), shard).expect_err("not this shard's");
    assert!(
        say(&[1, 4], "0/3")
            .contains("row 1 holds episode 1, but shard 0/3 of this sweep has episode 0")
    );
    assert!(say(&[0, 2], "0/1").contains("row 2 holds episode 2"));
    assert!(say(&[0, 3, 6, 9], "0/3").contains("row 4 holds episode 9"));
    let garbage = rows(&[0]) + "x,\n";
    assert!(
        open(&garbage, "0/1")
            .expect_err("garbage")
            .contains("row 2 holds no episode")
    );
}

#[test]
fn strangers_are_left_alone() {
    let other = rows(&[0]).replace("hash 00", "hash 01");
    let error = open(&other, "0/1").expect_err("another sweep's");
    assert!(
        error.contains("another sweep (host-sim sweep s, hash 01,"),
        "{error}"
    );
    for content in ["a,b\n1,2\n", "x", "\0\0", "# host-sim sweep s\nepisode,\n"] {
        let error = open(content, "0/1").expect_err(content);
        assert!(error.contains("is not a results file"), "{error}");
    }
}

#[test]
fn nobody_else_adds_meanwhile() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("new/results.csv");
    let open = || ResultsFile::open(&path, &header(), Shard::WHOLE);
    let (mut first, _) = open().expect("a new file");
    let error = open().expect_err("a second writer").to_string();
    assert!(error.contains("another process is adding"), "{error}");
    first.add(b"0,a\n").expect("a row");
    drop(first);
    assert_eq!(open().expect("free again").1, 1);
    let error = ResultsFile::open(folder.path(), &header(), Shard::WHOLE).expect_err("a folder");
    assert!(error.to_string().contains("cannot be written"), "{error}");
}

#[test]
fn a_row_holds_the_reports_fields_as_json_writes_them() {
    let report = EpisodeReport {
        world: "a \"b\",\nc".into(),
        behavior: "avoid,nest".into(),
        robot: "nomad200".into(),
        preset: "default".into(),
        sonar: "ideal".into(),
        seed: u64::MAX,
        explore_moves: 100,
        explore_contacts: 0,
        steps: 1_000,
        contacts: 3,
        touched_by: 0,
        distance_m: 250.0,
        shortest_m: Some(2.5),
        min_clearance_m: 0.0123,
        coverage_m2: 1e-4,
        goal_steps: 7,
        shield_stops: 8,
        time_s: 1_234.5,
        success: 0.1,
        success_unit: "share",
    };
    let row = row(5, &["1.5".to_owned(), String::new()], &report).expect("a row");
    let fields = super::super::table::fields(&row).expect("fields");
    assert_eq!(fields.iter().take(3).collect::<Vec<_>>(), ["5", "1.5", ""]);
    let json = serde_json::to_string(&report).expect("JSON");
    let mut place = 0;
    for (name, field) in EpisodeReport::FIELDS.iter().zip(fields.iter().skip(3)) {
        let value: serde_json::Value = serde_json::from_str(&json).expect("JSON");
        let value = value.get(*name).expect(name);
        assert_eq!(
            value.as_str().map_or(value.to_string(), str::to_owned),
            field,
            "{name}"
        );
        let at = json.find(&format!("\"{name}\":")).expect(name);
        assert!(at >= place, "{name} is out of order");
        place = at;
    }
    assert_eq!(fields.len(), 3 + EpisodeReport::FIELDS.len());
    assert_eq!(json.matches("\":").count(), EpisodeReport::FIELDS.len());
}
