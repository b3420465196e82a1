//! A controller at a serial device: a pseudo terminal with the chip's code at its other end.

use amp::config::Config;
use remote::link::NodeServer;
use tests::host_sim;
use tests::pty::{FaultyPty, LineFault};

const EPISODE: &str = "run --world random:3 --steps 40 --explore 30 --json";

fn with_mind(program: &tests::Program, mind: &str) -> tests::ProgramOutput {
    let words: Vec<_> = EPISODE.split_whitespace().chain(["--mind", mind]).collect();
    program.run(&words)
}

fn serial(pty: &FaultyPty) -> String {
    format!("serial:{}@115200", pty.path.display())
}

#[test]
fn a_mind_at_a_serial_device_prints_the_same_line() {
    let program = host_sim!();
    let here = with_mind(&program, "host");
    for line in [LineFault::Good, LineFault::StartsInTheMiddle] {
        let mind = NodeServer::start(Config::touzet()).unwrap();
        let pty = FaultyPty::to(&mind.host(), line);
        let there = with_mind(&program, &serial(&pty));
        assert_eq!(there.code, Some(0), "{line:?}: {}", there.stderr);
        assert_eq!(there.stdout, here.stdout, "{line:?}");
        assert!(
            there.stderr.contains("configuration"),
            "it says that it differed: {}",
            there.stderr
        );
    }
}

#[test]
fn a_line_at_another_speed_is_said_in_a_sentence() {
    let program = host_sim!();
    let mind = NodeServer::start(Config::recommended()).unwrap();
    let pty = FaultyPty::to(&mind.host(), LineFault::WrongSpeed);
    let output = with_mind(&program, &serial(&pty));
    assert_eq!((output.code, output.stdout.as_str()), (Some(2), ""));
    assert!(output.stderr.contains("speed"), "{}", output.stderr);
    assert_eq!(
        output.stderr.trim_end().lines().count(),
        1,
        "{}",
        output.stderr
    );
}

#[test]
fn a_device_that_disappears_is_said_in_a_sentence() {
    let program = host_sim!();
    let mind = NodeServer::start(Config::recommended()).unwrap();
    let pty = FaultyPty::to(&mind.host(), LineFault::PulledAfter(2_000));
    let output = with_mind(&program, &serial(&pty));
    assert_eq!(
        (output.code, output.stdout.as_str()),
        (Some(2), ""),
        "{}",
        output.stderr
    );
    let last = output.stderr.trim_end().lines().last().unwrap_or("");
    assert!(
        last.contains("link broke") || last.contains("no answer"),
        "{}",
        output.stderr
    );
}

#[test]
fn a_device_that_is_not_there_is_named() {
    let output = with_mind(&host_sim!(), "serial:/dev/ttyNowhere7");
    assert_eq!(output.code, Some(2));
    assert!(
        output.stderr.contains("/dev/ttyNowhere7"),
        "{}",
        output.stderr
    );
}
