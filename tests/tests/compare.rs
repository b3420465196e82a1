//! The comparison with other methods: same bytes with any number of threads, clear errors for bad
//! input.

use tests::{host_sim, words};

const SMALL: &str = "compare --world random:1..=2 --seeds 2 --steps 40 --moves 20,40";

#[test]
fn any_number_of_threads_gives_the_same_bytes() {
    let run = |threads: u32| {
        let program = host_sim!();
        let text = program.ok(&format!("{SMALL} --out out --threads {threads}"));
        (text, program.files("out"))
    };
    let (text, files) = run(1);
    let names: Vec<_> = files.iter().map(|(name, _)| name.as_str()).collect();
    assert_eq!(
        names,
        ["compare.csv", "compare.md", "compare.png", "compare.svg"]
    );
    // 8 methods with one number of moves, random and three rules, lazy Q with two, three learners
    // with two; with and without shield.
    let csv = String::from_utf8(files[0].1.clone()).expect("UTF-8");
    assert_eq!(csv.lines().count(), 1 + 2 * (8 + 4 + 2 + 3 * 2));
    assert!(run(2) == (text.clone(), files));
    // Times appear on standard error only.
    assert_eq!(
        host_sim!().ok(&format!("{SMALL} --time")).lines().count() + 2,
        text.lines().count()
    );
}

#[test]
fn a_method_is_the_same_alone_or_among_others() {
    let line = |methods: &str| {
        let text = host_sim!().ok(&format!("{SMALL} --shield off --methods {methods}"));
        let own = text.lines().find(|line| line.starts_with("q-table"));
        let words: Vec<_> = own
            .expect("its line")
            .split_whitespace()
            .map(str::to_owned)
            .collect();
        words
    };
    assert_eq!(line("q-table"), line("vfh-plus,q-table,default"));
}

#[test]
fn another_robot_is_compared_on_the_nomads_body() {
    let flags = "--methods vfh-plus,default --shield off";
    let text = |robot: &str| host_sim!().ok(&format!("{SMALL} {flags} {robot}"));
    let of_robot = text("--robot p3dx --ranges nomad");
    assert!(of_robot.contains("p3dx"), "{of_robot}");
    let lines = |text: &str| text.lines().take(6).map(str::to_owned).collect::<Vec<_>>();
    assert_ne!(lines(&of_robot), lines(&text("")));
}

#[test]
fn bad_input_is_named() {
    for (flags, named) in [
        ("--methods foo", "unknown method \"foo\""),
        ("--methods default,q-tabel", "did you mean \"q-table\"?"),
        ("--moves 200,100", "--moves"),
        ("--seeds 0", "--seeds"),
        ("--world random:x", "random:x"),
        ("--tune default", "--tune default"),
        ("--robot p3dx", "needs --ranges nomad"),
        (
            "--robot p3dx --ranges nomad --methods cosine",
            "--methods cosine",
        ),
        ("--robot p3dy --ranges nomad", "did you mean \"p3dx\"?"),
    ] {
        let output = host_sim!().run(&words(&format!("compare {flags}")));
        assert_eq!(output.code, Some(2), "{flags}");
        assert!(output.stderr.contains(named), "{flags}: {}", output.stderr);
        assert_eq!(output.stdout, "", "{flags}");
    }
}
