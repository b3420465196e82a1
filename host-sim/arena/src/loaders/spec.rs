//! Names of worlds: a file, a folder of files, random worlds, or a built-in world.

use std::ops::RangeInclusive;
use std::path::{Path, PathBuf};

use super::barn::{self, BarnSource};
use super::builtin;
use crate::world::World;
use files::error::{BadInput, suggestion};

/// Maximum number of random worlds in a range.
const MAX_RANGE: u64 = 1_000_000;

/// A world that is not built yet. It is small, and can be built on any thread.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum WorldSource {
    /// A world file or a map.
    File(PathBuf),
    /// The random room of this seed.
    Random(u64),
    /// The random world of another kind of this seed.
    Random2(u64),
    /// A built-in world, by name.
    Builtin(&'static str),
    /// A world of the BARN benchmark.
    Barn(BarnSource),
}

impl WorldSource {
    /// Builds the world.
    ///
    /// # Errors
    /// Those of [`World::load`]; random and built-in worlds have none.
    pub fn load(&self) -> Result<World, BadInput> {
        match self {
            Self::File(path) => World::load(path),
            Self::Random(seed) => Ok(World::random(*seed)),
            Self::Random2(seed) => Ok(World::random2(*seed)),
            Self::Builtin(name) => World::builtin(name),
            Self::Barn(source) => source.load(),
        }
    }
}

impl std::fmt::Display for WorldSource {
    /// The name that [`parse_worlds`] accepts.
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::File(path) => write!(f, "{}", path.display()),
            Self::Random(seed) => write!(f, "random:{seed}"),
            Self::Random2(seed) => write!(f, "random2:{seed}"),
            Self::Builtin(name) => f.write_str(name),
            Self::Barn(source) => source.fmt(f),
        }
    }
}

/// The worlds `text` names, in order: a built-in name, `random:SEED`, `random:A..=B`, the same
/// with `random2:`, a folder (its `.toml`, `.yaml` and `.yml` files by name) or a file. A file
/// called like a built-in world is reached as `./NAME`. `barn:FILE#N` and `barn:FILE#A..=B` are
/// worlds of the BARN benchmark (see [`barn`]).
///
/// # Errors
/// When `text` names nothing known, a range is empty or too long, or a folder holds no world.
pub fn parse_worlds(text: &str) -> Result<Vec<WorldSource>, BadInput> {
    if let Some(sources) = random_sources(text) {
        return sources;
    }
    if let Some(rest) = text.strip_prefix("barn:") {
        let named = |error| BadInput::new(format!("world \"{text}\": {error}"));
        let sources = barn::parse(rest).map_err(named)?;
        return Ok(sources.into_iter().map(WorldSource::Barn).collect());
    }
    let names = World::builtin_names();
    if let Some(name) = names.iter().find(|&&name| name == text) {
        return Ok(vec![WorldSource::Builtin(name)]);
    }
    let path = Path::new(text);
    if path.is_dir() {
        return folder_sources(path);
    }
    if path.exists() {
        return Ok(vec![WorldSource::File(path.to_owned())]);
    }
    if text.contains(['/', '\\']) || path.extension().is_some() {
        return Err(BadInput::file(path, "there is no such world file"));
    }
    let hint = suggestion(text, &names);
    Err(BadInput::new(format!(
        "unknown world \"{text}\"{hint} (a file, a folder, random:SEED, random:A..=B, random2:SEED, barn:FILE#N, or one of: {})",
        names.join(", ")
    )))
}

/// The worlds of a generator with seeds; `None` if the text names none.
fn random_sources(text: &str) -> Option<Result<Vec<WorldSource>, BadInput>> {
    type Make = fn(u64) -> WorldSource;
    let generators: [(&str, Make); 2] = [
        ("random", WorldSource::Random),
        ("random2", WorldSource::Random2),
    ];
    let (name, seeds) = text.split_once(':')?;
    let (name, make) = generators.into_iter().find(|(known, _)| *known == name)?;
    let wrong = |what: String| BadInput::new(format!("world \"{text}\": {what}"));
    let range = seed_range(name, seeds).map_err(wrong);
    Some(range.map(|range| range.map(make).collect()))
}

/// Parses `SEED` or `A..=B` after the name of a generator; errors are sentences.
fn seed_range(generator: &str, seeds: &str) -> Result<RangeInclusive<u64>, String> {
    let number = |digits: &str| {
        let plain = !digits.is_empty() && digits.bytes().all(|byte| byte.is_ascii_digit());
        let seed = if plain { digits.parse().ok() } else { None };
        seed.ok_or_else(|| {
            let forms = format!("{generator}:SEED or {generator}:A..=B, whole numbers");
            format!("\"{digits}\" is not a seed ({forms})")
        })
    };
    let (first, last) = seeds.split_once("..=").unwrap_or((seeds, seeds));
    let (first, last): (u64, u64) = (number(first)?, number(last)?);
    if first > last {
        return Err("the range is empty".to_owned());
    }
    if last - first >= MAX_RANGE {
        return Err(format!("a range may name at most {MAX_RANGE} worlds"));
    }
    Ok(first..=last)
}

fn folder_sources(folder: &Path) -> Result<Vec<WorldSource>, BadInput> {
    let unreadable = |error| BadInput::file(folder, format!("cannot be read: {error}"));
    let mut files = Vec::new();
    for entry in std::fs::read_dir(folder).map_err(unreadable)? {
        let path = entry.map_err(unreadable)?.path();
        let extension = path.extension().and_then(|e| e.to_str()).unwrap_or("");
        if matches!(extension, "toml" | "yaml" | "yml") && path.is_file() {
            files.push(path);
        }
    }
    if files.is_empty() {
        return Err(BadInput::file(folder, "holds no .toml or .yaml world file"));
    }
    files.sort_unstable();
    Ok(files.into_iter().map(WorldSource::File).collect())
}

impl World {
    /// The names of the built-in worlds; the first is the paper's arena.
    #[must_use]
    pub fn builtin_names() -> Vec<&'static str> {
        builtin::WORLDS.iter().map(|(name, _)| *name).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn all_names_of_worlds_are_parsed() {
        assert_eq!(
            parse_worlds("paper").unwrap(),
            [WorldSource::Builtin("paper")]
        );
        assert_eq!(parse_worlds("random:7").unwrap(), [WorldSource::Random(7)]);
        let range = parse_worlds("random:1..=1000").unwrap();
        assert_eq!(
            (range.len(), &range[999]),
            (1000, &WorldSource::Random(1000))
        );
        assert_eq!(
            parse_worlds(&format!("random:{0}..={0}", u64::MAX))
                .unwrap()
                .len(),
            1
        );
        assert_eq!(range[41].load().unwrap().name(), range[41].to_string());

        let folder = tempfile::tempdir().unwrap();
        let text = "[[circle]]\ncenter_m = [1, 1]\nradius_m = 0.1\n";
        for name in [
            "d.toml",
            "a.toml",
            "f.toml",
            "b.toml",
            "e.toml",
            "c.toml",
            "notes.txt",
        ] {
            std::fs::write(folder.path().join(name), text).unwrap();
        }
        let named = parse_worlds(folder.path().to_str().unwrap()).unwrap();
        let names: Vec<_> = named
            .iter()
            .map(|w| w.load().unwrap().name().to_owned())
            .collect();
        assert_eq!(names, ["a", "b", "c", "d", "e", "f"]);
        let one = folder.path().join("b.toml");
        assert_eq!(
            parse_worlds(one.to_str().unwrap()).unwrap(),
            [WorldSource::File(one)]
        );
    }

    #[test]
    fn both_generators_take_a_seed_or_a_range() {
        let one = parse_worlds("random2:7").unwrap();
        assert_eq!(one, [WorldSource::Random2(7)]);
        assert_eq!(one[0].load().unwrap().name(), one[0].to_string());
        let range = parse_worlds("random2:5..=7").unwrap();
        assert_eq!(range, [5, 6, 7].map(WorldSource::Random2));
        let range = parse_worlds("random:5..=7").unwrap();
        assert_eq!(range, [5, 6, 7].map(WorldSource::Random));
    }

    #[test]
    fn invalid_names_give_a_specific_error() {
        let folder = tempfile::tempdir().unwrap();
        for (text, words) in [
            ("paepr", "did you mean \"paper\"?"),
            ("", "unknown world"),
            ("nowhere/room.toml", "nowhere/room.toml: there is no such"),
            ("room.toml", "room.toml: there is no such"),
            ("random:", "\"\" is not a seed"),
            ("random:x", "\"x\" is not a seed"),
            ("random:-1", "\"-1\" is not a seed"),
            ("random:+1", "\"+1\" is not a seed"),
            ("random:1..5", "\"1..5\" is not a seed"),
            ("random:18446744073709551616", "is not a seed"),
            ("random:5..=4", "empty"),
            ("random:0..=1000000", "at most 1000000"),
            ("random2:", "\"\" is not a seed (random2:SEED or"),
            (
                "random2:5..=4",
                "world \"random2:5..=4\": the range is empty",
            ),
            ("random2:0..=1000000", "at most 1000000"),
            ("random3:1", "unknown world"),
            (folder.path().to_str().unwrap(), "holds no"),
        ] {
            let error = parse_worlds(text).unwrap_err().to_string();
            assert!(error.contains(words), "{error}");
        }
    }
}
