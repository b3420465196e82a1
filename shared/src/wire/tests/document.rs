//! PROTOCOL.md describes the messages of the grammar, all of them and nothing else.

use crate::config::Config;
use crate::controller::{NomadState, State};
use crate::fixed::{Gain, Mask, ONE_BITS};
use crate::node::MOTION_TTL_MS;
use crate::parameters::{Parameter, Unit};
use crate::scan::Echo;
use crate::shield::{Shield, ShieldConfig};
use crate::som::{Decay, Schedule};
use crate::units::{Bearing, Displacement, Millis, Range};
use crate::wire::PROTOCOL;
use crate::wire::message::{MAX_CHUNK, MAX_ECHOES};
use std::format;
use std::string::{String, ToString as _};
use std::sync::{LazyLock, Mutex, PoisonError};
use std::vec::Vec;

/// PROTOCOL.md as it is now.
pub(crate) static DOCUMENT: LazyLock<String> =
    LazyLock::new(|| std::fs::read_to_string(PATH).unwrap());
const PATH: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/PROTOCOL.md");
const GRAMMAR: &str = include_str!("../schema.txt");

/// Compares a block of the document, by its language, with what it should hold; `UPDATE_GOLDEN=1`
/// writes it anew.
pub(crate) fn check_block(language: &str, wanted: &str) {
    // Several blocks of one file may be written at once.
    static FILE: Mutex<()> = Mutex::new(());
    let _alone = FILE.lock().unwrap_or_else(PoisonError::into_inner);
    let text = std::fs::read_to_string(PATH).unwrap();
    let begin = format!("```{language}\n");
    let (before, rest) = text.split_once(&begin).expect("the block's begin");
    let (documented, after) = rest.split_once("```").expect("the block's end");
    if std::env::var_os("UPDATE_GOLDEN").is_some() {
        std::fs::write(PATH, format!("{before}{begin}{wanted}```{after}")).unwrap();
        return;
    }
    assert_eq!(documented, wanted, "UPDATE_GOLDEN=1 writes it anew");
}

/// A field with its type or a variant with its number, under its path from the symbol on.
type Entry = (String, String);

/// Splits where `is_separator` holds outside all brackets.
fn split(text: &str, is_separator: fn(char) -> bool) -> Vec<&str> {
    let mut depth = 0;
    let parts = text.split(|c| {
        match c {
            '(' | '[' | '<' => depth += 1,
            ')' | ']' | '>' => depth -= 1,
            _ => {}
        }
        depth == 0 && is_separator(c)
    });
    parts
        .map(str::trim)
        .filter(|part| !part.is_empty())
        .collect()
}

/// The entries of a structure's fields.
fn fields(path: &str, text: &str) -> Vec<Entry> {
    let mut entries = Vec::new();
    for field in split(text, char::is_whitespace) {
        let Some((name, kind)) = field.split_once(':') else {
            continue;
        };
        let path = format!("{path}.{name}");
        match kind
            .strip_prefix('(')
            .and_then(|kind| kind.strip_suffix(')'))
        {
            Some(variants) => {
                entries.push((path.clone(), "enum".into()));
                entries.extend(body(&path, variants));
            }
            None => entries.push((path, kind.into())),
        }
    }
    entries
}

/// The entries of what stands behind a symbol: variants or fields.
fn body(path: &str, text: &str) -> Vec<Entry> {
    if !text.starts_with(|c: char| c.is_ascii_digit()) {
        return fields(path, text);
    }
    let variant = |text: &str| {
        let (number, rest) = text.split_once(' ').expect("a number and a name");
        let (name, rest) = rest.split_once(' ').unwrap_or((rest, ""));
        let path = format!("{path}.{name}");
        let mut entries = std::vec![(path.clone(), number.to_string())];
        entries.extend(fields(&path, rest));
        entries
    };
    let variants = split(text, |c| c == '|').into_iter();
    variants.flat_map(variant).collect()
}

fn of_grammar(grammar: &str) -> Vec<Entry> {
    let lines = grammar.lines().filter(|line| !line.starts_with('#'));
    let text: String = lines.map(|line| format!("\n{line}")).collect();
    let joined = text.replace("\n  ", "  ");
    let symbols = joined.lines().filter_map(|line| line.split_once(" = "));
    let entries = symbols.flat_map(|(symbol, text)| body(symbol.trim(), text.trim()));
    entries.collect()
}

/// The section under a heading of the second level.
fn section(title: &str) -> &'static str {
    let (_, rest) = DOCUMENT
        .split_once(&format!("\n## {title}\n"))
        .expect(title);
    rest.split("\n## ").next().unwrap_or(rest)
}

/// The cells of a table's row, without backquotes.
fn cells(row: &str) -> Vec<String> {
    let row = row.trim().trim_matches('|').replace('`', "");
    row.split('|').map(|cell| cell.trim().to_string()).collect()
}

/// Rows of the tables of fields, each behind its symbol.
fn rows() -> Vec<(String, Vec<String>)> {
    let mut symbol = "";
    let mut rows = Vec::new();
    for line in section("Fields").lines() {
        if let Some(heading) = line.strip_prefix("### ") {
            symbol = heading;
        } else if line.starts_with("| `") {
            rows.push((symbol.to_string(), cells(line)));
        }
    }
    rows
}

#[test]
fn every_field_and_variant_is_documented_once_and_no_other() {
    let documented = rows().into_iter().map(|(symbol, cells)| {
        assert!(cells.len() >= 3, "{symbol} {cells:?}");
        (format!("{symbol}.{}", cells[0]), cells[1].clone())
    });
    let mut documented: Vec<_> = documented.collect();
    let mut wanted = of_grammar(GRAMMAR);
    assert!(wanted.len() > 290, "{} entries", wanted.len());
    documented.sort();
    wanted.sort();
    let lacking: Vec<_> = wanted
        .iter()
        .filter(|entry| !documented.contains(entry))
        .collect();
    let surplus: Vec<_> = documented
        .iter()
        .filter(|entry| !wanted.contains(entry))
        .collect();
    assert!(
        lacking.is_empty() && surplus.is_empty(),
        "lacking {lacking:?}, surplus {surplus:?}"
    );
    assert_eq!(documented, wanted, "one of them is there twice");
}

/// The unit that a field's name or type asks for.
fn unit(name: &str, kind: &str) -> Option<&'static str> {
    let by_name = [
        ("_mm_s2", "mm/s²"),
        ("_mm_s", "mm/s"),
        ("_mm", "mm"),
        ("_ms", "ms"),
        ("_q16", "2⁻¹⁶"),
        ("_q14", "2⁻¹⁴"),
        ("_q8", "2⁻⁸"),
    ];
    let found = by_name.iter().find(|(end, _)| name.ends_with(end));
    let weight = kind.contains("weight").then_some("2⁻¹³");
    found.map(|(_, unit)| *unit).or(weight)
}

#[test]
fn every_number_has_its_unit() {
    for (symbol, cells) in rows() {
        let [name, kind, documented, meaning] = &cells[..] else {
            continue;
        };
        let first = documented.split(',').next();
        if let Some(unit) = unit(name, kind) {
            assert_eq!(first, Some(unit), "{symbol}.{name}");
        }
        let integers = ["u8", "u16", "u32", "u64", "i16", "i32"];
        if integers.iter().any(|integer| kind.contains(integer)) {
            assert_ne!(first, Some("–"), "{symbol}.{name}");
        }
        assert!(!meaning.is_empty(), "{symbol}.{name}");
    }
}

/// Least and greatest value of a type of integers, or of the integers in an option or an array;
/// `None` for other types.
fn whole(kind: &str) -> Option<(i128, i128)> {
    let inner = kind.strip_prefix("option<").or(kind.strip_prefix('['));
    let inner = inner.unwrap_or(kind).split(['>', ';']).next();
    Some(match inner.unwrap_or(kind) {
        "u8" => (0, u8::MAX.into()),
        "u16" => (0, u16::MAX.into()),
        "u32" => (0, u32::MAX.into()),
        "u64" => (0, u64::MAX.into()),
        "i16" | "weight" => (i16::MIN.into(), i16::MAX.into()),
        "i32" => (i32::MIN.into(), i32::MAX.into()),
        _ => return None,
    })
}

/// A number, its digits in groups; `None` for a field's name.
fn number(text: &str) -> Option<i128> {
    text.replace('−', "-").replace(' ', "").parse().ok()
}

/// A cell's unit, empty for none, and both ends of its range.
fn unit_and_ends(cell: &str) -> (&str, &str, &str) {
    let (unit, range) = cell.rsplit_once(", ").unwrap_or(("", cell));
    let (least, greatest) = range.split_once(" … ").unwrap_or((range, range));
    (unit, least, greatest)
}

#[test]
fn every_integer_has_a_range() {
    let rows = rows();
    let path = |(symbol, cells): &(String, Vec<String>)| format!("{symbol}.{}", cells[0]);
    let paths: Vec<_> = rows.iter().map(path).collect();
    let mut count = 0;
    for ((symbol, cells), path) in rows.iter().zip(&paths) {
        let [_, kind, documented, _] = &cells[..] else {
            continue;
        };
        let row = format!("{path}: {documented}");
        let Some((first, last)) = whole(kind) else {
            assert!(kind.starts_with("vec<") || documented == "–", "{row}");
            continue;
        };
        count += 1;
        let (_, least, greatest) = unit_and_ends(documented);
        if (least, greatest) == ("any", "any") {
            continue;
        }
        // Another field is named alone, or behind the symbol that it belongs to.
        let is_field = |name: &str| {
            paths.contains(&name.into()) || paths.contains(&format!("{symbol}.{name}"))
        };
        let (from, to) = (number(least), number(greatest));
        assert!(from.is_some() || least != greatest, "{row}: no range");
        assert!(from.is_some() || is_field(least), "{row}");
        assert!(to.is_some() || is_field(greatest), "{row}");
        assert_ne!((from, to), (Some(first), Some(last)), "{row}: that is any");
        let (from, to) = (from.unwrap_or(first), to.unwrap_or(last));
        assert!(first <= from && from <= to && to <= last, "{row}");
    }
    assert!(count > 110, "{count} integers");
}

/// Unit, least and greatest value of a field whose range names no other field.
fn documented(path: &str) -> (String, i128, i128) {
    let mut rows = rows().into_iter();
    let found = rows.find(|(symbol, cells)| format!("{symbol}.{}", cells[0]) == path);
    let (_, cells) = found.expect(path);
    let (unit, least, greatest) = unit_and_ends(&cells[2]);
    let (least, greatest) = match least {
        "any" => whole(&cells[1]).expect(path),
        _ => (number(least).expect(path), number(greatest).expect(path)),
    };
    (unit.into(), least, greatest)
}

/// Greatest value of a field whose least is 0.
fn greatest(path: &str) -> i128 {
    let (_, least, greatest) = documented(path);
    assert_eq!(least, 0, "{path}");
    greatest
}

/// The field that a parameter sets; `None` for those that switch something on and off.
const fn field_of(parameter: Parameter) -> Option<&'static str> {
    Some(match parameter {
        Parameter::Near => "Encoding.near_mm",
        Parameter::Far => "Encoding.far_mm",
        Parameter::Clearance => "Config.clearance_mm",
        Parameter::Step => "RobotSpec.step_mm",
        Parameter::Speed => "RobotSpec.speed_mm_s",
        Parameter::Margin => "ShieldConfig.margin_mm",
        Parameter::Epochs => "Learning.epochs",
        Parameter::Enabled => "Config.enabled",
        Parameter::RingPeriod => "RobotSpec.ring_period_ms",
        Parameter::Shield | Parameter::Online | Parameter::FaultDetection => return None,
    })
}

#[test]
fn a_field_that_a_parameter_sets_has_its_unit_and_range() {
    for parameter in Parameter::ALL {
        let Some(field) = field_of(parameter) else {
            continue;
        };
        let spec = parameter.spec();
        let (least, greatest) = match spec.unit {
            // All 32 of them: as a number the mask is signed in one place and unsigned in the
            // other.
            Unit::Bits => (0, u32::MAX.into()),
            _ => (spec.min.into(), spec.max.into()),
        };
        let wanted = (spec.unit.to_string(), least, greatest);
        assert_eq!(documented(field), wanted, "{field}");
    }
}

#[test]
#[cfg_attr(miri, ignore = "the document is read many times: minutes")]
fn ranges_end_where_the_program_says() {
    const SAMPLES: usize = 100;
    // No other number is compiled.
    let _: Option<State<16, 16, SAMPLES>> = None::<NomadState>;
    let parts = (NomadState::SAMPLE_BYTES * SAMPLES) as i128;
    let farthest = i128::from(Range::from_mm(u16::MAX).as_mm());
    let cosine = i128::from(Bearing::ZERO.direction().x_q14);
    let one = i128::from(ONE_BITS);
    let ends = [
        ("Dimensions.protocol", PROTOCOL.into(), PROTOCOL.into()),
        ("Dimensions.sensors", 16, 16),
        ("Dimensions.neurons", 16, 16),
        ("HostMessage.Write.offset", 0, parts),
        ("TimedEcho.sensor", 0, 15),
        ("TimedEcho.range_mm", 0, farthest),
        (
            "DeviceMessage.Motion.speed_mm_s",
            0,
            Parameter::Speed.spec().max.into(),
        ),
        (
            "DeviceMessage.Motion.ttl_ms",
            MOTION_TTL_MS.into(),
            MOTION_TTL_MS.into(),
        ),
        ("DeviceMessage.Chunk.total", 0, parts),
        ("DeviceHello.samples", SAMPLES as i128, SAMPLES as i128),
        (
            "CommandRefusal.InvalidMoveCount.max",
            SAMPLES as i128,
            SAMPLES as i128,
        ),
        ("Plan.goal_neuron", 0, 15),
        ("Plan.current_neuron", 0, 15),
        ("Plan.subgoal_neuron", 0, 15),
        ("Plan.action_neuron", 0, 15),
        ("Plan.wanted", -one, one),
        ("LogEvent.SensorDisabled.sensor", 0, 15),
        ("LogEvent.SensorEnabled.sensor", 0, 15),
        // A face is kept as a displacement.
        ("RobotSpec.face_radius_mm", 0, i16::MAX.into()),
        ("Direction.x_q14", -cosine, cosine),
        ("Direction.y_q14", -cosine, cosine),
        ("DeviceMessage.Decision.situation", 0, one),
        ("Planning.tolerance", 0, one),
        ("Goal.cap", 0, one),
        ("Goal.tolerance", 0, one),
        ("Component.low", 0, one),
        // Bytes of text.
        ("DeviceHello.build", 0, 127),
        // Older than a time to live of 0, and half of the clock's range at most.
        ("Refusal.Expired.age_ms", 1, i32::MAX.into()),
        // Without deceleration there is no speed from which the robot stops; of the others 0 counts
        // as 1.
        ("RobotSpec.braking_mm_s2", 1, u16::MAX.into()),
        ("Exploration.draws", 1, u8::MAX.into()),
        ("Learning.slice", 1, 16),
    ];
    for (path, least, greatest) in ends {
        let (_, from, to) = documented(path);
        assert_eq!((from, to), (least, greatest), "{path}");
    }
    let rows = rows();
    let vectors = rows
        .iter()
        .filter(|(_, cells)| cells[1].starts_with("vec<"));
    for (symbol, cells) in vectors {
        let wanted = match cells[1].as_str() {
            "vec<u8>" => format!("at most {MAX_CHUNK} bytes"),
            _ => format!("at most {MAX_ECHOES}"),
        };
        assert_eq!(cells[2], wanted, "{symbol}.{}", cells[0]);
    }
}

/// With the greatest margin and the longest step, the shield's squares stay within 32 bits and
/// displacements within 16 up to the documented end and no farther.
#[test]
fn ranges_end_where_numbers_do() {
    let most = |parameter: Parameter| i128::from(parameter.spec().max);
    let reach_fits = |body_mm: i128| {
        let reach_mm = body_mm + most(Parameter::Margin);
        i32::try_from(reach_mm * reach_mm).is_ok()
    };
    let inertia_fits = |share_q8: i128| {
        let step_mm = most(Parameter::Step);
        i16::try_from(((share_q8 * step_mm) >> 8) + step_mm).is_ok()
    };
    let body_mm = greatest("RobotSpec.body_radius_mm");
    assert!(reach_fits(body_mm) && !reach_fits(body_mm + 1));
    let share_q8 = greatest("Planning.inertia_q8");
    assert!(inertia_fits(share_q8) && !inertia_fits(share_q8 + 1));
}

#[test]
fn what_lies_beyond_a_range_counts_as_its_end() {
    for field in ["situation_rate_q16", "action_rate_q16", "share_q16"] {
        let most = greatest(&format!("Online.{field}")) as u32;
        let gains = [most - 1, most, most + 1].map(Gain::from_q16);
        assert!(gains[0] < Gain::ONE, "{field}");
        assert_eq!(gains[1..], [Gain::ONE; 2], "{field}");
    }
    let end = |end_q16: u32| {
        let mut buffer = [0; 16];
        let bytes = postcard::to_slice(&(5_u32, end_q16, Decay::Linear), &mut buffer).unwrap();
        let schedule: Schedule = postcard::from_bytes(bytes).unwrap();
        schedule.end_q16()
    };
    assert_eq!([4, 5, 6].map(end), [4, 5, 5]);
    let lobe = greatest("ShieldConfig.half_lobe") as u16;
    let ways = [lobe / 2, lobe, lobe + 1, u16::MAX].map(way_beside_an_echo);
    assert!(ways[0] > ways[1], "{ways:?}");
    assert_eq!(ways[1..], [ways[1]; 3]);
}

/// How far to the left a robot may go that hears something ahead with lobes of this half opening.
fn way_beside_an_echo(half_lobe: u16) -> u16 {
    let mut config = Config::recommended();
    config.shield = Some(ShieldConfig {
        half_lobe: Bearing::from_turns(half_lobe),
        ..ShieldConfig::nomad200()
    });
    let at = Millis::from_ms(0);
    let mut shield = Shield::<16>::new();
    // The echo comes last: nothing contradicts it.
    for sensor in (0..16).rev() {
        let range = (sensor == 0).then(|| Range::from_mm(400));
        shield.hear(&config, sensor, Echo { range, at });
    }
    let left = Displacement {
        dx_mm: 0,
        dy_mm: 250,
    };
    shield.allow(&config, Mask::ALL, left, at).distance_mm
}

#[test]
fn the_table_of_parameters_holds_their_units_and_ranges() {
    let rows = section("Parameters").lines().map(cells);
    let rows = rows.filter(|cells| cells[0].parse::<u8>().is_ok());
    let rows: Vec<_> = rows.map(|cells| cells[..5].to_vec()).collect();
    let wanted = Parameter::ALL
        .iter()
        .enumerate()
        .map(|(number, parameter)| {
            let spec = parameter.spec();
            let unit = match spec.unit {
                Unit::Count => "count".into(),
                unit => unit.to_string(),
            };
            let (least, greatest) = (spec.min.to_string(), spec.max.to_string());
            std::vec![
                number.to_string(),
                parameter.name().into(),
                unit,
                least,
                greatest
            ]
        });
    assert_eq!(rows, wanted.collect::<Vec<_>>());
}

/// The bytes in front of two blanks, line by line.
#[test]
fn the_frame_taken_apart_is_the_example() {
    let (_, block) = DOCUMENT.split_once("```bytes\n").expect("a block of bytes");
    let (block, _) = block.split_once("```").expect("the block's end");
    let bytes = block.lines().filter_map(|line| line.split("  ").next());
    let whole = bytes.collect::<Vec<_>>().join(" ");
    let example = format!("to device, scan\n{whole}\n");
    assert!(DOCUMENT.contains(&example), "{whole}");
}
