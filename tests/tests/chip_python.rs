//! A Python host, written from PROTOCOL.md alone, drives the firmware in an emulated chip.

use amp::wire::SCHEMA;
use std::io::ErrorKind;
use std::process::{Child, Command, Output, Stdio};
use std::time::{Duration, Instant};
use tests::board::EmulatedBoard;
use tests::root;

/// Timeout of the whole episode. It takes seconds on an idle machine.
const LIMIT: Duration = Duration::from_secs(300);
const CLIENT: &str = "tests/python/client.py";

/// Starts the client with its output in pipes.
fn python(args: &[&str]) -> Child {
    let started = Command::new("python3")
        .arg(root().join(CLIENT))
        .args(args)
        .stdin(Stdio::null())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn();
    match started {
        Ok(child) => child,
        Err(error) if error.kind() == ErrorKind::NotFound => {
            panic!("there is no python3: apt-get install -y --no-install-recommends python3")
        }
        Err(error) => panic!("python3 cannot be started: {error}"),
    }
}

/// Waits for the end of a program with little output; kills it after [`LIMIT`].
fn output(mut child: Child) -> Output {
    let began = Instant::now();
    while child.try_wait().expect("its state").is_none() {
        if began.elapsed() > LIMIT {
            child.kill().expect("it still runs");
            let output = child.wait_with_output().expect("its output");
            panic!("{CLIENT} has not ended after {LIMIT:?}: {output:?}");
        }
        std::thread::sleep(Duration::from_millis(50));
    }
    child.wait_with_output().expect("its output")
}

fn text(bytes: &[u8]) -> &str {
    std::str::from_utf8(bytes).expect("UTF-8")
}

#[test]
fn a_client_written_from_the_document_drives_the_chip() {
    let source = std::fs::read_to_string(root().join(CLIENT)).expect("the client");
    let schema = format!("SCHEMA = {SCHEMA:#010x}\n");
    assert!(source.contains(&schema), "{CLIENT} lacks {schema}");
    let board = EmulatedBoard::start();
    let output = output(python(&[board.host()]));
    let (stdout, stderr) = (text(&output.stdout), text(&output.stderr));
    assert_eq!(output.status.code(), Some(0), "{stdout}{stderr}");
    let last = stdout.lines().last();
    let wanted = "explored 20 moves, learned, took 20 decisions, stopped";
    assert_eq!(last, Some(wanted), "{stdout}{stderr}");
    assert_eq!(stderr, "");
}

#[test]
fn the_client_says_what_is_wrong_with_its_arguments() {
    let said = |args: &[&str]| {
        let output = output(python(args));
        (output.status.code(), text(&output.stderr).to_owned())
    };
    let (code, stderr) = said(&["nowhere"]);
    assert!(
        code == Some(2) && stderr.contains("nowhere is no HOST:PORT"),
        "{stderr}"
    );
    let (code, stderr) = said(&["127.0.0.1:1"]);
    assert!(
        code == Some(2) && stderr.contains("127.0.0.1:1: "),
        "{stderr}"
    );
}
