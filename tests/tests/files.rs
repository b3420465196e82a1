//! Input and output files: devices, pipes and links survive, no input hangs or fills the memory.

use amp::config::Config;
use remote::link::NodeServer;
use std::fs;
use std::io::Read as _;
use std::os::unix::fs::{FileTypeExt as _, PermissionsExt as _, symlink};
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};
use tests::{Program, ProgramOutput, host_sim, words};

/// Commands that write one file, with `FILE` for its name.
const WRITERS: [&str; 3] = [
    "capture --out FILE",
    "run --steps 1 --explore 5 --json --save FILE",
    "run --steps 1 --explore 5 --json --log FILE",
];

fn run(program: &Program, line: &str, file: &str) -> ProgramOutput {
    program.run(&words(&line.replace("FILE", file)))
}

fn make_fifo(path: &Path) {
    let made = Command::new("mkfifo").arg(path).status();
    assert!(made.is_ok_and(|status| status.success()));
}

#[test]
fn a_fifo_that_is_written_to_stays_a_fifo() {
    let program = host_sim!();
    let fifo = program.folder().join("fifo");
    make_fifo(&fifo);
    for line in WRITERS {
        let path = fifo.clone();
        let reader = std::thread::spawn(move || fs::read(path).expect("a reader"));
        let output = run(&program, line, "fifo");
        let kind = fs::symlink_metadata(&fifo).expect("the FIFO").file_type();
        assert!(kind.is_fifo(), "{line}: {kind:?}");
        assert_eq!(output.code, Some(0), "{line}: {}", output.stderr);
        assert!(reader.join().expect("bytes").len() > 100, "{line}");
    }
}

#[test]
fn a_device_that_is_written_to_stays_a_device() {
    let program = host_sim!();
    // A device of another name: a bug would replace only that.
    let device = program.folder().join("null");
    let made = Command::new("mknod")
        .arg(&device)
        .args(["c", "1", "3"])
        .status();
    let file = match made {
        Ok(status) if status.success() => "null",
        // Only root can create devices, and only root could replace this one.
        _ => "/dev/null",
    };
    for line in WRITERS {
        let output = run(&program, line, file);
        let path = program.folder().join(file);
        let kind = fs::symlink_metadata(path).expect("it").file_type();
        assert!(kind.is_char_device(), "{line}: {kind:?}");
        assert_eq!(output.code, Some(0), "{line}: {}", output.stderr);
    }
}

fn mode(path: &Path) -> u32 {
    let about = fs::metadata(path).expect("it is there");
    about.permissions().mode() & 0o777
}

#[test]
fn a_file_that_is_written_anew_keeps_its_mode() {
    let program = host_sim!();
    let mind = NodeServer::start(Config::recommended()).expect("a mind behind a socket");
    let host = mind.host();
    let pull = format!("link --to tcp:{host} download FILE");
    // A log is never overwritten.
    for line in [WRITERS[0], WRITERS[1], &pull] {
        for wanted in [0o640, 0o604] {
            program.put("old", "old");
            let path = program.folder().join("old");
            fs::set_permissions(&path, fs::Permissions::from_mode(wanted)).expect("a mode");
            let output = run(&program, line, "old");
            assert_eq!(output.code, Some(0), "{line}: {}", output.stderr);
            assert!(fs::read(&path).expect("it") != b"old", "{line}");
            assert_eq!(mode(&path), wanted, "{line}");
        }
    }
}

#[test]
fn a_link_is_followed_and_the_mode_of_the_file_is_kept() {
    let program = host_sim!();
    program.put("there/goal.toml", "old");
    let target = program.folder().join("there/goal.toml");
    fs::set_permissions(&target, fs::Permissions::from_mode(0o640)).expect("a mode");
    symlink("there/goal.toml", program.folder().join("link")).expect("a link");
    let _ = program.ok("capture --out link");
    let link = fs::symlink_metadata(program.folder().join("link")).expect("the link");
    assert!(link.file_type().is_symlink());
    let written = fs::read_to_string(&target).expect("the target");
    assert!(written.contains("situation"), "{written}");
    assert_eq!(mode(&target), 0o640);
    // A link to a missing file creates that file.
    for (line, name) in WRITERS.iter().zip(["a", "b", "c"]) {
        let link = program.folder().join(name);
        symlink(format!("there/new-{name}"), &link).expect("a link");
        let output = run(&program, line, name);
        assert_eq!(output.code, Some(0), "{line}: {}", output.stderr);
        let link = fs::symlink_metadata(link).expect("the link");
        assert!(link.file_type().is_symlink(), "{line}");
    }
    let left: Vec<_> = program.files("there").into_iter().collect();
    let names: Vec<_> = left.iter().map(|(name, _)| name.as_str()).collect();
    assert_eq!(names, ["goal.toml", "new-a", "new-b", "new-c"]);
}

/// Commands that read a file of this name, with `FILE` for it.
const READERS: [(&str, &str); 12] = [
    ("world.toml", "run --steps 1 --world FILE"),
    ("map.yaml", "run --steps 1 --world FILE"),
    ("goal.toml", "run --steps 1 --behavior seek:FILE"),
    ("table.csv", "som --data FILE"),
    ("log.csv", "learn --log FILE"),
    ("own.mind", "link --to tcp:127.0.0.1:1 upload FILE"),
    ("results.csv", "merge FILE"),
    ("found.csv", "plot FILE"),
    ("sweep.toml", "sweep FILE"),
    ("cells.csv", "barn --file FILE"),
    ("world_3.world", "barn --file FILE"),
    ("lengths.csv", "barn --file none.csv --lengths FILE"),
];

/// Inputs that may be too large for memory: regular files only.
const REGULAR: [&str; 2] = ["results.csv", "found.csv"];

/// The output of a command that may hang; killed after 20 s and limited to 1 GiB of memory.
fn bounded(program: &Program, line: &str) -> ProgramOutput {
    let mut child = program
        .command(&words(line))
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .expect("the program starts");
    let began = Instant::now();
    let status = loop {
        if let Some(status) = child.try_wait().expect("its state") {
            break status;
        }
        let statm = fs::read_to_string(format!("/proc/{}/statm", child.id())).unwrap_or_default();
        let resident = statm.split(' ').nth(1).and_then(|pages| pages.parse().ok());
        let resident: u64 = resident.unwrap_or(0);
        if began.elapsed() > Duration::from_secs(20) || resident > (1 << 30) / 4_096 {
            let _ = child.kill();
            let _ = child.wait();
            panic!("{line}: {resident} pages after {:?}", began.elapsed());
        }
        std::thread::sleep(Duration::from_millis(5));
    };
    let mut said = [String::new(), String::new()];
    let [stdout, stderr] = &mut said;
    let mut out = child.stdout.take().expect("its output");
    out.read_to_string(stdout).expect("text");
    let mut errors = child.stderr.take().expect("its messages");
    errors.read_to_string(stderr).expect("text");
    let [stdout, stderr] = said;
    ProgramOutput {
        code: status.code(),
        stdout,
        stderr,
    }
}

fn is_refused(program: &Program, line: &str, name: &str, why: &str) {
    let output = bounded(program, &line.replace("FILE", name));
    assert_eq!(output.code, Some(2), "{line}: {}", output.stderr);
    let sentence = output.stderr.lines().next().unwrap_or_default();
    let named = sentence.contains(name) && sentence.contains(why);
    assert!(named, "{line}: {}", output.stderr);
}

#[test]
fn a_folder_is_no_input_file() {
    let program = host_sim!();
    for (name, line) in READERS {
        let path = program.folder().join(name);
        if !path.exists() {
            fs::create_dir(path).expect("a folder");
        }
        // A folder is a valid argument for worlds, but has none.
        let why = match name {
            "world.toml" | "map.yaml" => "holds no .toml",
            "cells.csv" | "world_3.world" => "holds no world",
            _ => "is a folder",
        };
        is_refused(&program, line, name, why);
    }
}

#[test]
fn an_input_file_without_end_is_refused() {
    let program = host_sim!();
    for (name, line) in READERS {
        let path = program.folder().join(name);
        symlink("/dev/zero", path).expect("a link");
        let why = match REGULAR.contains(&name) {
            true => "is not a regular file",
            false => "is larger than",
        };
        is_refused(&program, line, name, why);
    }
}

#[test]
fn a_fifo_that_no_program_writes_to_is_refused() {
    let program = host_sim!();
    // Each waits for 5 s: all in parallel.
    std::thread::scope(|scope| {
        for (name, line) in READERS {
            make_fifo(&program.folder().join(name));
            let why = match REGULAR.contains(&name) {
                true => "is not a regular file",
                false => "no program writes to it",
            };
            let program = &program;
            scope.spawn(move || is_refused(program, line, name, why));
        }
    });
}

#[test]
fn a_stream_that_ends_is_an_input_file() {
    let program = host_sim!();
    make_fifo(&program.folder().join("table.csv"));
    let path = program.folder().join("table.csv");
    let writer = std::thread::spawn(move || fs::write(path, "1,2\n3,4\n5,7\n"));
    let output = bounded(&program, "som --data table.csv --grid 2x2");
    assert_eq!(output.code, Some(0), "{}", output.stderr);
    writer.join().expect("the writer").expect("a reader");
}
