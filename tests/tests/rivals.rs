//! The rivals that learn from the same random moves: same bytes with any number of threads, each
//! the same alone, clear errors for bad input.

use tests::{host_sim, words};

const SMALL: &str = "rivals --worlds 2 --steps 30 --moves 10,20";

#[test]
fn any_number_of_threads_gives_the_same_bytes() {
    let run = |threads: u32| {
        let program = host_sim!();
        let text = program.ok(&format!("{SMALL} --json --out out --threads {threads}"));
        (text, program.files("out"))
    };
    let (text, files) = run(1);
    let names: Vec<_> = files.iter().map(|(name, _)| name.as_str()).collect();
    assert_eq!(
        names,
        [
            "rivals-models.png",
            "rivals-models.svg",
            "rivals-quantizers.png",
            "rivals-quantizers.svg"
        ]
    );
    // Nine rivals, with and without symmetry, two numbers of moves; and two names of pictures.
    let rows = text.lines().filter(|line| line.starts_with('{'));
    assert_eq!(
        (rows.count(), text.lines().count()),
        (9 * 2 * 2, 9 * 2 * 2 + 2)
    );
    assert!(run(3) == (text, files));
}

#[test]
fn a_rival_is_the_same_alone_and_its_times_are_not_in_the_table() {
    let line = |flags: &str| {
        let text = host_sim!().ok(&format!("{SMALL} --symmetry on {flags}"));
        let own = text.lines().find(|line| line.starts_with("gp"));
        own.expect("its line").to_owned()
    };
    let alone = line("--rivals gp");
    let [row, other] = [alone, line("--rivals default,gp --time")].map(|line| {
        let words: Vec<_> = line.split_whitespace().map(str::to_owned).collect();
        words
    });
    assert_eq!(row, other);
}

#[test]
fn bad_input_is_named() {
    for (flags, named) in [
        ("--rivals foo", "unknown rival \"foo\""),
        ("--rivals default,forset", "did you mean \"forest\"?"),
        ("--generator randon", "did you mean \"random\"?"),
        ("--moves 20,10", "--moves"),
        ("--moves 1001", "1001"),
        ("--worlds 0", "--worlds"),
        ("--symmetry maybe", "--symmetry"),
        ("--json --markdown", "--markdown"),
    ] {
        let output = host_sim!().run(&words(&format!("rivals {flags}")));
        assert_eq!(output.code, Some(2), "{flags}");
        assert!(output.stderr.contains(named), "{flags}: {}", output.stderr);
        assert_eq!(output.stdout, "", "{flags}");
    }
}
