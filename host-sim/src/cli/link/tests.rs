//! The subcommands with a controller behind a socket.

use crate::cli::{Cli, CliError, execute};
use amp::config::Config;
use clap::Parser;
use remote::link::{Knowledge, NodeServer};

fn host_sim(served: &NodeServer, line: &str) -> Result<String, String> {
    let line = line.replace("MIND", &format!("tcp:{}", served.host()));
    let words = std::iter::once("host-sim").chain(line.split(' '));
    let cli = Cli::try_parse_from(words).unwrap();
    let mut out = Vec::new();
    match execute(cli.command, &mut out) {
        Ok(()) => Ok(String::from_utf8(out).unwrap()),
        Err(CliError::Bad(error)) => Err(error.to_string()),
        Err(CliError::Output(error)) => panic!("{error}"),
        Err(CliError::Differs(sentence)) => panic!("{sentence}"),
    }
}

#[test]
fn every_verb_says_what_came_of_it() {
    let served = NodeServer::start(Config::recommended()).unwrap();
    let verb = |verb: &str| host_sim(&served, &format!("link --to MIND {verb}"));
    assert!(verb("hello").unwrap().contains("samples the memory holds"));
    let row = |line: &str| {
        let said = verb(line).unwrap();
        said.split_whitespace().collect::<Vec<_>>().join(" ")
    };
    assert!(row("params").contains("ring-period 640"));
    assert!(row("params far 1300").contains("far 1300"));
    assert!(verb("counters").unwrap().contains("frames accepted"));
    assert!(verb("goal avoid").unwrap().contains("done"));
    assert!(verb("lead off").unwrap().contains("done"));
    assert!(verb("stop").unwrap().contains("stopped: on command"));
    assert_eq!(verb("monitor --for 0.1").unwrap(), "");
    assert!(verb("keep free").unwrap().contains("done"));
    assert!(verb("goal kept:free").unwrap().contains("done"));
    assert!(verb("goals").unwrap().contains("goal       free\ndone"));
    let explored = verb("explore 5 --for 0.2").unwrap();
    assert!(explored.contains("explores, 5 moves left"), "{explored}");
    for (line, part) in [
        ("learn", "nothing to learn from"),
        ("seek", "it has not learned yet"),
        ("explore 0", "from 1 to 100 random moves"),
        ("explore 5", "a sonar did not report in time"),
        ("goal perceived", "some sonars have not reported"),
        ("goal none.toml", "none.toml: "),
        ("params fra", "did you mean \"far\"?"),
        ("params far 9999", "between 1 and 6500 mm"),
        ("push none.mind", "none.mind: "),
        ("flash save", "it has nothing to save to"),
        ("lead home", "its firmware has no memory of places"),
        ("set-down", "its firmware has no memory of places"),
        ("lead hom", "did you mean \"home\"?"),
        ("goal saved:nest", "it has no goal of this name"),
        ("drop nest", "it has no goal of this name"),
        (
            "keep thirteen-chars",
            "\"thirteen-chars\": a name has 1 to 12",
        ),
    ] {
        let sentence = verb(line).unwrap_err();
        assert!(sentence.contains(part), "{line}: {sentence}");
    }
}

#[test]
fn what_an_episode_taught_is_pulled_and_pushed() {
    let (one, two) = (
        NodeServer::start(Config::recommended()).unwrap(),
        NodeServer::start(Config::touzet()).unwrap(),
    );
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("robot.mind");
    let file = file.display();
    let here = host_sim(&one, "run --world random:1 --steps 5 --json").unwrap();
    let there = host_sim(&one, "run --world random:1 --steps 5 --json --mind MIND");
    assert_eq!(there.unwrap(), here);
    host_sim(&one, "link --to MIND save saved").unwrap();
    let pulled = host_sim(&one, &format!("link --to MIND download {file}"));
    assert!(pulled.unwrap().contains("and 100 samples"));
    // A controller in this process has the same state.
    let own = folder.path().join("own.mind");
    let line = format!(
        "run --world random:1 --steps 5 --json --save {}",
        own.display()
    );
    assert_eq!(host_sim(&one, &line).unwrap(), here);
    let known = |path: &std::path::Path| Knowledge::load(path).unwrap().fingerprint();
    assert_eq!(known(&own), known(&folder.path().join("robot.mind")));
    let pushed = host_sim(&two, &format!("link --to MIND upload {file}"));
    assert!(pushed.unwrap().contains("100 samples uploaded"));
    let goals = host_sim(&two, "link --to MIND goals").unwrap();
    assert!(goals.contains("goal       saved"), "{goals}");
    let learned = host_sim(&two, "link --to MIND learn").unwrap();
    let last = learned.lines().last().unwrap();
    assert!(last.ends_with("mode       idle"), "{learned}");
}

#[test]
fn what_cannot_be_driven_there_is_refused_before_anything_is_written() {
    let served = NodeServer::start(Config::recommended()).unwrap();
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("out");
    let line = format!("run --explore 101 --out {} --mind MIND", out.display());
    let sentence = host_sim(&served, &line).unwrap_err();
    assert!(sentence.contains("holds 100 moves"), "{sentence}");
    assert!(!out.exists());
    for worlds in ["--world random:1..=2", "--mind MIND"] {
        let line = format!("run {worlds} --save {}", out.display());
        let sentence = host_sim(&served, &line).unwrap_err();
        assert!(sentence.contains("--save") && !out.exists(), "{sentence}");
    }
    let sentence = host_sim(&served, "run --mind host --firmware x.elf").unwrap_err();
    assert!(sentence.contains("only qemu takes an image"), "{sentence}");
}
