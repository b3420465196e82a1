//! Bad input: exit code 2, one clear sentence that names the cause, no files left behind.

use std::io::{BufRead as _, BufReader, Read as _};
use std::process::Stdio;
use tests::{Program, host_sim, words};

/// A command line, and texts in its sentence.
type Case = (&'static str, &'static [&'static str]);

const WORLDS: &[(&str, &[u8])] = &[
    ("empty.toml", b""),
    ("binary.toml", b"\x89PNG\r\n\x1a\n\0\xff\xfe"),
    ("broken.toml", b"[[circle]]\ncenter_m = [1.0\n"),
    (
        "key.toml",
        b"[[circle]]\ncenter_m = [2, 2]\nradius_mm = 0.3\n",
    ),
    (
        "nan.toml",
        b"[[circle]]\ncenter_m = [2, nan]\nradius_m = 0.3\n",
    ),
    ("infinite.toml", b"[[wall]]\npoints_m = [[1, 1], [inf, 1]]\n"),
    (
        "negative.toml",
        b"[[circle]]\ncenter_m = [2, 2]\nradius_m = -0.3\n",
    ),
    (
        "zero.toml",
        b"[[box]]\ncenter_m = [2, 2]\nsize_m = [0, 1]\n",
    ),
    (
        "inside.toml",
        b"[[circle]]\ncenter_m = [0, 0]\nradius_m = 2\n",
    ),
    ("nothing.toml", b"name = \"nothing\"\n"),
    ("short.toml", b"# two\nsituation = [0.5, 0.5]\n"),
    (
        "deep.toml",
        b"situation = [0, 0, 0, 0, 0, 0, 0, 1.5, 0, 0, 0, 0, 0, 0, 0, 0]\n",
    ),
    ("wish.toml", b"[[sonar]]\nnumbers = [0]\nnearer = 1\n"),
    ("map.yaml", b"image: gone.pgm\nresolution: 0.1\norigin: [0, 0, 0]\nnegate: 0\noccupied_thresh: 0.65\nfree_thresh: 0.2\n"),
    ("image.yaml", b"image: binary.toml\nresolution: 0.1\norigin: [0, 0, 0]\nnegate: 0\noccupied_thresh: 0.65\nfree_thresh: 0.2\n"),
    ("world.txt", b"a wall"),
    (
        "outside.toml",
        b"[start]\nposition_m = [9, 0]\n[[wall]]\npoints_m = [[-2, -2], [2, -2], [2, 2], [-2, 2], [-2, -2]]\n",
    ),
    (
        "notch.toml",
        b"[start]\nposition_m = [2, 2]\n[[wall]]\npoints_m = [[0, 0], [3, 0], [3, 1], [1, 1], [1, 3], [0, 3], [0, 0]]\n[[box]]\ncenter_m = [6, 6]\nsize_m = [1, 1]\n",
    ),
];

const TABLES: &[(&str, &[u8])] = &[
    ("good.csv", b"1,2\n3,4\n5,7\n"),
    ("ragged.csv", b"1,2\n3\n"),
    ("text.csv", b"1,x,2\n2,y,3\n"),
    ("nan.csv", b"1,2\nNaN,3\n"),
    ("empty.csv", b""),
    ("heading.csv", b"length,width\n"),
    ("binary.csv", b"\x89PNG\0\xff"),
    ("file", b"no folder"),
    ("log.csv", b"1,2,left\n3,4,right\n1,x,left\n"),
    ("far_log.csv", b"1,2,left\n1e7,4,right\n1,1,left\n"),
    ("fast_log.csv", b"1,2,0.5\n1,4,0.5\n1,1,-1000001\n"),
    ("short_log.csv", b"1,2,left\n3,4,right\n"),
    ("cells.csv", b"world,ix,iy\n3,0,0\n3,1,0\n"),
    ("key_sweep.toml", b"[grid]\n\nfarr = [1]\n"),
    ("value_sweep.toml", b"[grid]\nsonar = [\"ideal\", \"ideel\"]\n"),
    ("random_sweep.toml", b"[grid]\nfar = [3]\n[random]\npoints = 20\nfar = { min = 1.0, max = 6.0 }\n"),
    ("pair_sweep.toml", b"[grid]\nfar = [3, 1]\nnear = [0.1, 2]\n"),
    ("world_sweep.toml", b"worlds = [\"key.toml\"]\n"),
    ("bad_cells.csv", b"world,ix,iy\n3,0,0\n3,1.5,0\n"),
    ("lengths.csv", b"world,reference_path_length_m\n4,12\n"),
    ("world_3.world", b"<sdf version='1.6'>\n<world name='w'>\n<model name='m'>\n<pose>0 0</pose></model></world></sdf>"),
];

const CASES: &[Case] = &[
    ("run --robot p3dx --tour 5", &["--tour", "home"]),
    ("run --robot p3dx --tour-by avoid", &["--tour-by", "home"]),
    ("run --robot p3dx --turned", &["--turned", "nest"]),
    (
        "run --robot p3dx --ranges nomad --behavior nest --turned",
        &["--turned", "held"],
    ),
    ("run --behavior nest --turned", &["--turned", "held"]),
    (
        "view --robot p3dx --behavior home --places off",
        &["home", "--places off"],
    ),
    (
        "view --nomad tcp:127.0.0.1:1 --behavior home",
        &["home", "--nomad"],
    ),
    ("run --behavior floor:rde", &["floor", "rde", "\"red\""]),
    ("run --behavior scent", &["scent", "strongest"]),
    (
        "run --behavior light:strongest --places off",
        &["--places off", "light:strongest"],
    ),
    (
        "view --behavior floor:red --places off",
        &["floor:red", "--places off"],
    ),
    ("run --robot gone", &["gone", "p3dx"]),
    ("run --robot gone.toml", &["gone.toml"]),
    ("run --robot p3dx --geometry lerned", &["lerned", "learned"]),
    (
        "run --robot lidar16 --geometry learned",
        &["lidar16", "turn"],
    ),
    (
        "run --robot p3dx --actuators learned",
        &["--actuators learned", "--geometry learned"],
    ),
    (
        "run --robot p3dx --geometry learned --actuators lerned",
        &["lerned", "learned"],
    ),
    (
        "run --miswire 1",
        &["--miswire", "another robot than nomad200"],
    ),
    (
        "run --told-radius 0.5",
        &["--told-radius", "another robot than nomad200"],
    ),
    (
        "run --robot p3dx --told-radius 2",
        &["--told-radius", "not from 0.3 to 1.5"],
    ),
    (
        "run --geometry learned",
        &["--geometry", "another robot than nomad200"],
    ),
    (
        "run --robot p3dx --geometry learned --explore 19",
        &["at least 20 random moves", "19"],
    ),
    (
        "bodies --robots p3dx --geometry learned --method cosine",
        &["--geometry learned", "--method"],
    ),
    (
        "bodies --robots p3dx --geometry learned --explore 3",
        &["at least 20 random moves", "3"],
    ),
    ("run --scramble 3", &["--scramble"]),
    // World files.
    ("run --world missing.toml", &["missing.toml"]),
    ("run --world empty.toml", &["empty.toml", "empty"]),
    (
        "run --world binary.toml",
        &["binary.toml", "not a text file"],
    ),
    ("run --world broken.toml", &["broken.toml, line"]),
    (
        "run --world key.toml",
        &[
            "key.toml, line 3",
            "radius_mm",
            "did you mean \"radius_m\"?",
        ],
    ),
    (
        "run --world nan.toml",
        &["nan.toml, line 2", "center_m", "finite"],
    ),
    (
        "run --world infinite.toml",
        &["infinite.toml, line 2", "points_m", "finite"],
    ),
    (
        "run --world negative.toml",
        &["negative.toml, line 3", "-0.3"],
    ),
    ("run --world zero.toml", &["zero.toml, line 3", "positive"]),
    ("run --world inside.toml", &["inside.toml", "start inside"]),
    (
        "run --world outside.toml",
        &["outside.toml, line 2", "position_m", "(9, 0)", "outside"],
    ),
    (
        "run --world notch.toml",
        &["notch.toml, line 2", "position_m", "(2, 2)", "outside"],
    ),
    (
        "run --world nothing.toml",
        &["nothing.toml", "at least one"],
    ),
    ("run --world map.yaml", &["gone.pgm"]),
    (
        "run --world image.yaml",
        &["binary.toml: is a damaged PNG image"],
    ),
    ("run --world world.txt", &["world.txt", ".toml"]),
    ("worlds --world key.toml", &["key.toml, line 3"]),
    // Names and numbers.
    ("run --world paepr", &["paepr", "did you mean \"paper\"?"]),
    ("run --world random:x", &["random:x", "not a seed"]),
    ("run --world random:9..=8", &["random:9..=8", "empty"]),
    ("run --world random:1..=1000000000000", &["at most 1000000"]),
    ("run --behavior avod", &["avod", "did you mean \"avoid\"?"]),
    ("run --steps 0", &["'0'", "--steps"]),
    ("run --steps -5", &["-5"]),
    ("run --steps 99999999999", &["--steps", "10000000"]),
    ("run --explore 0", &["--explore", "1..=1000"]),
    ("run --explore 1000000000000", &["--explore", "1..=1000"]),
    ("run --seed=-1", &["--seed", "-1"]),
    ("run --seed x", &["--seed", "'x'"]),
    (
        "nomad serve --world random:1..=2",
        &["random:1..=2", "one world"],
    ),
    ("nomad serve --world paepr", &["did you mean \"paper\"?"]),
    ("nomad serve --listen nowhere", &["--listen nowhere"]),
    ("nomad serve --speed 0", &["--speed", "1..=1000"]),
    (
        "nomad serve --pty --listen 127.0.0.1:0",
        &["--pty", "--listen"],
    ),
    ("run --threads 0", &["--threads"]),
    ("run --sonar ideel", &["--sonar", "ideel"]),
    ("run --preset best", &["--preset", "best"]),
    ("run --shield maybe", &["--shield", "maybe"]),
    // Behaviors and goal files.
    (
        "run --behavior avoid,",
        &["behavior", "\"\"", "avoid-right"],
    ),
    (
        "run --behavior nest,walll-left",
        &["did you mean \"wall-left\"?"],
    ),
    ("run --behavior seek:", &["seek:FILE"]),
    (
        "run --behavior seek:gone.toml",
        &["gone.toml", "there is no such file"],
    ),
    (
        "run --behavior seek:short.toml",
        &["short.toml, line 2", "16 values"],
    ),
    (
        "run --behavior seek:deep.toml",
        &["deep.toml, line 1", "0..=1", "1.5"],
    ),
    (
        "run --behavior seek:wish.toml",
        &["wish.toml, line 3", "nearer"],
    ),
    (
        "run --behavior avoid,seek:nothing.toml",
        &["nothing.toml", "name"],
    ),
    (
        "run --behavior seek:binary.toml",
        &["binary.toml", "not a text file"],
    ),
    ("capture --out place.toml --at 1", &["--at", "\"1\"", "X,Y"]),
    ("capture --out place.toml --at 1,nan", &["--at", "1,nan"]),
    (
        "capture --out place.toml --at 99,0",
        &["--at 99,0", "no room for the robot"],
    ),
    (
        "capture --out place.toml --at 4.9,0",
        &["--at 4.9,0", "no room for the robot"],
    ),
    (
        "capture --out place.toml --world random:1..=3",
        &["random:1..=3", "one world"],
    ),
    (
        "capture --out place.toml --world paepr",
        &["did you mean \"paper\"?"],
    ),
    ("capture --out file/place.toml", &["file/place.toml"]),
    (
        "patrol --world room --station 1,1",
        &["--station: a round has two stations"],
    ),
    (
        "patrol --world room --station 1,1 --station 2.9,0",
        &["--station 2.9,0", "no room for the robot", "room"],
    ),
    ("patrol --station 1,x", &["--station", "not X,Y in meters"]),
    ("sequence --out file/pictures", &["file/pictures"]),
    ("sequence --seeds 0", &["--seeds"]),
    ("capture", &["required arguments"]),
    ("goal", &["required arguments"]),
    ("goal nest", &["goal nest", "host-sim capture"]),
    ("goal avoid,follow", &["goal avoid,follow"]),
    ("goal wal-left", &["did you mean \"wall-left\"?"]),
    ("goal seek:nothing.toml", &["nothing.toml"]),
    ("goal learn -o x.toml", &["required arguments"]),
    (
        "goal learn --from nothing.mcap -o x.toml",
        &["nothing.mcap"],
    ),
    (
        "goal learn --from nothing.toml -o x.toml",
        &["nothing.toml"],
    ),
    (
        "goal learn --from nothing.toml --from nothing.mcap -o x.toml",
        &["--from", "either logs (.mcap) or captured situations"],
    ),
    ("demonstrations --only nothing", &["--only \"nothing\""]),
    ("demonstrations --drives 0", &["--drives"]),
    ("run --goal nothing.toml", &["nothing.toml"]),
    (
        "run --behavior avoid,follow --goal nothing.toml",
        &["--goal", "a,b,c"],
    ),
    (
        "run --behavior home --goal nothing.toml",
        &["--goal", "home", "places"],
    ),
    ("behaviors --only wal-left", &["--only", "wal-left"]),
    ("behaviors --worlds 0", &["--worlds"]),
    ("behaviors --set farr=1", &["did you mean \"far\"?"]),
    ("repetition --only chain", &["--only", "chain"]),
    ("repetition --times 1", &["--times"]),
    // Settings.
    ("run --set farr=1", &["farr", "did you mean \"far\"?"]),
    ("run --set far=x", &["far", "\"x\"", "not a number"]),
    ("run --set far=nan", &["far", "\"nan\""]),
    ("run --set far=-1", &["far", "\"-1\""]),
    ("run --set far", &["KEY=VALUE", "\"far\""]),
    ("run --set near=3 --set far=2", &["far", "near"]),
    // Tables.
    // Logs.
    ("learn", &["required arguments"]),
    ("learn --log missing.csv", &["missing.csv"]),
    (
        "learn --log log.csv",
        &["log.csv, line 3, column 2", "\"x\" is not a number"],
    ),
    (
        "learn --log far_log.csv",
        &["far_log.csv, line 2, column 1", "\"1e7\"", "1000000"],
    ),
    (
        "learn --log fast_log.csv --velocities 3",
        &["fast_log.csv, line 3, column 3", "\"-1000001\"", "1000000"],
    ),
    ("learn --log short_log.csv", &["short_log.csv", "--stride"]),
    (
        "learn --log short_log.csv --label lable",
        &["--label", "no column \"lable\""],
    ),
    ("learn --log short_log.csv --map 3x3", &["--map", "3x3"]),
    (
        "learn --log short_log.csv --held-out 1",
        &["--held-out", "below 1"],
    ),
    (
        "learn --log short_log.csv --near 5 --far 2",
        &["--near 5", "--far 2"],
    ),
    // Sweeps.
    ("sweep", &["required arguments"]),
    (
        "sweep missing.toml",
        &["missing.toml: there is no such file"],
    ),
    (
        "sweep key_sweep.toml",
        &["key_sweep.toml, line 3", "farr", "did you mean \"far\"?"],
    ),
    (
        "sweep value_sweep.toml",
        &["value_sweep.toml, line 2", "'ideel'", "possible values"],
    ),
    (
        "sweep random_sweep.toml",
        &[
            "random_sweep.toml, line 3",
            "the file has no key \"random\"",
        ],
    ),
    (
        "sweep pair_sweep.toml",
        &["sweep pair_sweep, point 3 (far=1 near=2)", "must lie above"],
    ),
    ("sweep world_sweep.toml", &["key.toml, line 3"]),
    ("sweep short.toml", &["short.toml, line 2", "situation"]),
    ("sweep nothing.toml --shard 2/2", &["--shard", "I/N"]),
    (
        "sweep nothing.toml --out good.csv",
        &["good.csv: is not a results file"],
    ),
    ("sweep nothing.toml --out file/below.csv", &["file"]),
    ("merge", &["required arguments"]),
    ("merge missing.csv", &["missing.csv: there is no such file"]),
    ("merge good.csv", &["good.csv: is not a results file"]),
    ("plot good.csv", &["good.csv: is not a results file"]),
    ("plot binary.csv", &["binary.csv: is not a results file"]),
    ("plot missing.csv", &["missing.csv: there is no such file"]),
    // Worlds of the BARN benchmark.
    (
        "run --world barn:missing.csv#1",
        &["barn:missing.csv#1", "missing.csv: "],
    ),
    (
        "run --world barn:cells.csv#4",
        &["cells.csv", "no world 4", "1 worlds, 3 to 3"],
    ),
    ("run --world barn:cells.csv#x", &["\"x\" is not the number"]),
    (
        "barn --file bad_cells.csv",
        &["bad_cells.csv, line 3, column 2", "1.5"],
    ),
    (
        "barn --file world_3.world",
        &["world_3.world, line 4", "<pose> must hold 6"],
    ),
    (
        "barn --file cells.csv --worlds 5..=2",
        &["--worlds", "empty"],
    ),
    (
        "barn --file cells.csv --lengths lengths.csv",
        &["--lengths", "no length for world 3"],
    ),
    ("barn --file cells.csv --methods vfh", &["--methods", "vfh"]),
    ("som --data missing.csv", &["missing.csv"]),
    ("som --data ragged.csv", &["ragged.csv, line 2", "1 fields"]),
    (
        "som --data text.csv",
        &["text.csv, line 1, column 2", "\"x\""],
    ),
    ("som --data nan.csv", &["nan.csv, line 2, column 1", "NaN"]),
    ("som --data empty.csv", &["empty.csv", "empty"]),
    ("som --data heading.csv", &["heading.csv", "no sample"]),
    ("som --data binary.csv", &["binary.csv", "not a text file"]),
    ("som --data good.csv --grid 0x4", &["--grid", "0x4"]),
    ("som --data good.csv --grid 4", &["--grid", "COLUMNSxROWS"]),
    ("som --data good.csv --epochs 0", &["--epochs"]),
    ("som --data good.csv --rate 0.1:0.5", &["--rate", "0.1:0.5"]),
    ("som --data good.csv --init start.csv", &["start.csv"]),
    (
        "link --to qemu --program all hello",
        &["program \"all\"", "places"],
    ),
    // State files are read before the controller is contacted.
    (
        "link --to tcp:127.0.0.1:1 upload gone.mind",
        &["gone.mind: "],
    ),
    (
        "link --to tcp:127.0.0.1:1 upload binary.toml",
        &["binary.toml: it holds no controller"],
    ),
    ("run --steps 1 --save file/own.mind", &["file/own.mind: "]),
    (
        "run --world random:1..=2 --save own.mind",
        &["--save own.mind", "one world"],
    ),
    // The view.
    ("view --world paepr", &["did you mean \"paper\"?"]),
    ("view --world random:1..=3", &["random:1..=3", "one world"]),
    ("view --speed 0", &["--speed", "0.05 to 1000", "max"]),
    ("view --listen here", &["--listen", "here"]),
    ("view --listen 0.0.0.0:0", &["0.0.0.0:0", "--allow-remote"]),
    ("view --firmware x.elf", &["x.elf", "qemu"]),
    ("view --mind tcp:127.0.0.1:1", &["tcp:127.0.0.1:1"]),
    // Folders that cannot be written.
    ("run --steps 1 --out file", &["file: "]),
    ("run --steps 1 --out file/below", &["file/below"]),
    ("demo --out file/below", &["file/below"]),
    ("paper --out file/below", &["file/below"]),
    ("paper --rooms 0", &["--rooms"]),
    ("paper --times 1", &["--times"]),
    ("worlds --out file/below", &["file/below"]),
    ("som --data good.csv --out file/below", &["file/below"]),
    // The command line itself.
    ("frobnicate", &["frobnicate"]),
    ("runn", &["runn"]),
    ("run --frobnicate", &["--frobnicate"]),
    ("run --world", &["--world"]),
    ("run extra", &["extra"]),
    ("ablation --only nothing-like-it", &["nothing-like-it"]),
    ("ablation --rooms 0", &["--rooms"]),
    ("ablation --neurons 15", &["--neurons", "64"]),
    ("controls --only nothing-like-it", &["nothing-like-it"]),
    ("controls --preset touzet", &["--preset touzet"]),
    ("controls --by moves --explore 5", &["--explore", "--by"]),
    ("controls --json --markdown", &["--json", "--markdown"]),
    ("run --neurons 64 --out page", &["--neurons 64", "--out"]),
    ("run --neurons 9 --robot p3dx", &["--neurons 9", "--robot"]),
    ("completions abacus", &["abacus"]),
];

fn with_files() -> Program {
    let program = host_sim!();
    for (name, content) in WORLDS.iter().chain(TABLES) {
        program.put(name, content);
    }
    program
}

/// The sentence on standard error; for errors of the command line a usage may follow.
fn sentence(stderr: &str) -> &str {
    let (first, rest) = stderr.split_once('\n').unwrap_or((stderr, ""));
    if let Some(sentence) = first.strip_prefix("host-sim: ") {
        assert_eq!(rest, "", "more than one sentence: {stderr}");
        return sentence;
    }
    assert!(rest.contains("--help"), "{stderr}");
    first
        .strip_prefix("error: ")
        .unwrap_or_else(|| panic!("an unexpected message: {stderr}"))
}

#[test]
fn bad_input_is_one_clear_sentence() {
    let program = with_files();
    let mut wrong = Vec::new();
    for (line, names) in CASES {
        let output = program.run(&words(line));
        let sentence = sentence(&output.stderr);
        let named = names.iter().all(|name| sentence.contains(name));
        if output.code != Some(2) || !output.stdout.is_empty() || !named {
            wrong.push(format!("{line}: {names:?}\n{output:#?}"));
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
    let left: Vec<_> = program
        .files("")
        .into_iter()
        .map(|(name, _)| name)
        .collect();
    assert_eq!(
        left.len(),
        WORLDS.len() + TABLES.len(),
        "left behind: {left:?}"
    );
}

#[test]
fn a_mind_that_is_not_whole_or_of_another_version_is_refused() {
    let program = host_sim!();
    let _ = program.ok("run --steps 1 --explore 5 --json --save sound.mind");
    let sound = std::fs::read(program.folder().join("sound.mind")).expect("a file");
    // Byte 3 of the first record is the layout's version; the last record is the checksum of all
    // others.
    let mut later = sound.clone();
    later[6] += 1;
    let end = later.len() - 8;
    let crc = amp::wire::CRC.checksum(&later[..end]).to_le_bytes();
    later[end + 2..end + 6].copy_from_slice(&crc);
    let mut damaged = sound.clone();
    damaged[end / 2] ^= 4;
    let mut continued = sound.clone();
    continued.extend_from_slice(&sound);
    for (bytes, why) in [
        (&sound[..end], "it is cut off or damaged"),
        (&sound[..5], "it is cut off or damaged"),
        (&damaged, "it is cut off or damaged"),
        (&later, "it was written by another version of this program"),
        (&continued, "there are bytes after its end"),
        (b"AMPMIND\0 of before", "it holds no controller"),
        (b"", "it holds no controller"),
    ] {
        program.put("wrong.mind", bytes);
        let output = program.run(&words("link --to tcp:127.0.0.1:1 upload wrong.mind"));
        assert_eq!((output.code, output.stdout.as_str()), (Some(2), ""));
        let told = sentence(&output.stderr);
        assert!(told.starts_with(&format!("wrong.mind: {why}")), "{told}");
    }
}

#[test]
fn bad_input_leaves_no_files_in_the_output_folder() {
    for line in [
        "run --out out --world key.toml",
        "run --out out --world inside.toml",
        "run --out out --set far=x",
        "run --out out --explore 1000000000000",
        "run --out out --world paper --world paepr",
        "worlds --out out --world paper --world nan.toml",
        "capture --out out/place.toml --at 99,0",
        "behaviors --out out --only nothing-like-it",
        "repetition --out out --only nothing-like-it",
        "som --out out --data ragged.csv",
        "som --out out --data good.csv --grid 0x4",
    ] {
        let program = with_files();
        assert_eq!(program.run(&words(line)).code, Some(2), "{line}");
        assert_eq!(program.files("out"), [], "{line}");
    }
}

#[test]
fn the_worlds_before_a_bad_one_are_whole_lines() {
    let program = with_files();
    let output = program.run(&words(
        "run --world random:1..=3 --world key.toml --json --steps 3",
    ));
    assert_eq!(output.code, Some(2));
    assert!(sentence(&output.stderr).contains("key.toml, line 3"));
    for line in output.stdout.lines() {
        serde_json::from_str::<serde_json::Value>(line).expect("a whole line");
    }
}

#[test]
fn a_reader_that_goes_away_ends_the_program_quietly() {
    let program = host_sim!();
    let mut child = program
        .command(&words(
            "run --world random:1..=600 --json --explore 10 --steps 10",
        ))
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .expect("the program starts");
    let mut reader = BufReader::new(child.stdout.take().expect("a pipe"));
    let mut first = String::new();
    reader.read_line(&mut first).expect("a line");
    assert!(first.contains("\"world\":\"random:1\""), "{first}");
    drop(reader);
    let mut stderr = String::new();
    let mut errors = child.stderr.take().expect("a pipe");
    errors.read_to_string(&mut stderr).expect("text");
    let status = child.wait().expect("the program ends");
    assert_eq!(status.code(), Some(0), "{stderr}");
    // Even the final line with the time is missing: the run ended early with more output than a
    // pipe holds.
    assert_eq!(stderr, "");
}
