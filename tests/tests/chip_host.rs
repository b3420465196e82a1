//! The host program with the firmware in an emulated chip as its controller.

use tests::chip::image;
use tests::host_sim;

#[test]
fn an_episode_with_the_chip_prints_the_same_line() {
    let program = host_sim!();
    let image = image().to_str().expect("a path of letters");
    let episode = "run --world random:2 --world paper --steps 60 --json";
    let words: Vec<_> = episode.split_whitespace().collect();
    let here = program.run(&words);
    let chip = program.run(&[&words[..], &["--mind", "qemu", "--firmware", image]].concat());
    assert_eq!(
        (here.code, chip.code),
        (Some(0), Some(0)),
        "{}",
        chip.stderr
    );
    assert_eq!(chip.stdout, here.stdout);
    assert_eq!(here.stdout.lines().count(), 2);
}

#[test]
fn what_the_chip_decided_is_decided_again_here() {
    let program = host_sim!();
    let image = image().to_str().expect("a path of letters");
    let run =
        "run --world random:2 --steps 60 --sonar nomad --log chip.mcap --mind qemu --firmware";
    let words: Vec<_> = run.split_whitespace().collect();
    let chip = program.run(&[&words[..], &[image]].concat());
    assert_eq!(chip.code, Some(0), "{}", chip.stderr);
    let said = program.ok("replay chip.mcap");
    assert!(said.contains("every one identical"), "{said}");
}

#[test]
fn the_chip_answers_questions() {
    let program = host_sim!();
    let image = image().to_str().expect("a path of letters");
    let ask = |verb: &[&str]| {
        program.run(&[&["link", "--to", "qemu", "--firmware", image], verb].concat())
    };
    let hello = ask(&["hello"]);
    assert_eq!(hello.code, Some(0), "{}", hello.stderr);
    assert!(
        hello.stdout.contains("samples the memory holds"),
        "{}",
        hello.stdout
    );
    // QEMU has no crystal, and its image does not try to use one.
    let clocked = |line: &str| line.starts_with("clocked by") && line.contains("unknown");
    assert!(hello.stdout.lines().any(clocked), "{}", hello.stdout);
    let counters = ask(&["counters"]);
    let drift = |line: &str| line.starts_with("ms that this clock fell behind");
    assert!(counters.stdout.lines().any(drift), "{}", counters.stdout);
    let speed = ask(&["params", "speed"]);
    assert!(speed.stdout.contains("508"), "{}", speed.stdout);
    let refused = ask(&["params", "speed", "5000"]);
    assert_eq!(refused.code, Some(2));
    assert!(refused.stderr.contains("508 mm/s"), "{}", refused.stderr);
    let unlearned = ask(&["seek"]);
    assert_eq!(
        unlearned.code,
        Some(2),
        "{} {}",
        unlearned.stdout,
        unlearned.stderr
    );
}
