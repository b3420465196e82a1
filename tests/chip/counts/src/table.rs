//! The program on the chip: counts everything and prints the table with the allowed numbers.
//!
//! Allowed is the count at the time of writing plus a tenth, so that another compiler passes and a
//! costly change does not. Decisions and learning as a whole have their own limits.

use crate::episode::CountedEpisode;
use crate::stopwatch::{InstructionStats, Stopwatch};
use crate::{body, link, maps, modality, places, points, reference};
use amp::body::HeldRing;
use amp::config::Config;
use amp::controller::NomadState;
use amp::node::NomadNode;
use core::panic::PanicInfo;
use cortex_m_rt::entry;
use cortex_m_semihosting::{debug, hprintln};
// The chip's interrupt vectors.
use stm32f4xx_hal as _;

#[entry]
fn main() -> ! {
    static mut SENSORS: body::Sensors<0> = body::Sensors::new();
    static mut LED: body::Sensors<256> = body::Sensors::new();
    static mut MAP: places::Map = places::Map::new();
    let sensors: &'static mut body::Sensors<0> = SENSORS;
    let led: &'static mut body::Sensors<256> = LED;
    let map: &'static mut places::Map = MAP;
    let chip = cortex_m::Peripherals::take().expect("not taken yet");
    let watch = Stopwatch::new(chip.SYST);
    reference::compare();
    let mut ring = HeldRing;
    let episode = CountedEpisode::new(&watch, Config::recommended(), &mut ring);
    hprintln!("| call | calls | instructions, mean | most | allowed |");
    hprintln!("| --- | ---: | ---: | ---: | ---: |");
    print_maps(&watch, &episode);
    print_episode(&episode);
    print_link(&watch, &episode);
    print_body(&watch, &body::episode(&watch, sensors));
    print_places(&places::count(&watch, map), &body::episode(&watch, led));
    print_modality(&modality::records(&watch));
    hprintln!();
    hprintln!("| what | bytes |");
    hprintln!("| --- | ---: |");
    hprintln!("| `NomadState` | {} |", size_of::<NomadState>());
    hprintln!("| `NomadNode` | {} |", size_of::<NomadNode>());
    let (body, led) = (
        size_of::<body::Sensors<0>>(),
        size_of::<body::Sensors<256>>(),
    );
    hprintln!("| `MountedSensors` | {body} |");
    hprintln!("| `MountedSensors` with 256 places | {led} |");
    debug::exit(debug::EXIT_SUCCESS);
    loop {
        cortex_m::asm::wfi();
    }
}

/// Allowed instructions of a decision, for any goal.
const DECISION: u32 = 30_000;

fn print_maps(watch: &Stopwatch, episode: &CountedEpisode<'_>) {
    let [by_kernels, portable] = maps::searches(watch, episode);
    row("best-matching unit, 16 × 16, by kernels", by_kernels, 500);
    row("best-matching unit, 16 × 16, portable", portable, 2_810);
    row("recall of an action", maps::recalls(watch, episode), 11_420);
    let [[situation, action], [near_situation, near_action]] = maps::updates(watch, episode);
    row("situation map learns, winner alone", situation, 170);
    row(
        "situation map learns, winner and 4 neighbors",
        near_situation,
        450,
    );
    row("action map learns, winner alone", action, 640);
    row(
        "action map learns, winner and 4 neighbors",
        near_action,
        780,
    );
}

fn print_episode(episode: &CountedEpisode<'_>) {
    let (counts, events) = (&episode.counts, &episode.robot.counts);
    row("echo at rest", events.echo, 11_280);
    row("echo on the way: the guard", events.on_the_way, 20_700);
    row("report of the base", events.odometry, 1_680);
    row(
        "random move (last echo of the ring)",
        counts.random_move,
        34_200,
    );
    row(
        "**decision** (last echo of the ring): avoid",
        counts.decision,
        DECISION,
    );
    row("decision: along a wall", counts.along_wall, DECISION);
    row("decision: to a place", counts.to_place, DECISION);
    row("decision: obstacles on the right", counts.passing, DECISION);
    row("decision: after a leader", counts.following, DECISION);
    row(
        "decision: avoid by the paper's four steps (`probe`)",
        counts.four_steps,
        DECISION,
    );
    row("tick of learning", counts.tick, 15_660);
    let mut learning = InstructionStats::default();
    learning.add(counts.tick.sum());
    row(
        "**learning**, 100 samples × 100 epochs, all ticks",
        learning,
        30_000_000,
    );
}

fn print_link(watch: &Stopwatch, episode: &CountedEpisode<'_>) {
    let counts = link::decisions(watch, episode);
    row("unpacking a scan of 16 echoes", counts.unpack, 6_600);
    row("packing a decision", link::packing(watch, episode), 5_070);
    row(
        "decision by a frame: scan in, three frames out",
        counts.decision,
        99_600,
    );
}

fn print_body(watch: &Stopwatch, counts: &body::BodyCounts) {
    row(
        "body: echo at rest, with 256 points",
        counts.events.echo,
        36_000,
    );
    row(
        "body: of an echo, keeping 200 to 256 points",
        points::echoes(watch),
        21_800,
    );
    row("body: echo on the way", counts.events.on_the_way, 108_000);
    row(
        "body: **decision** (last echo of the ring): avoid",
        counts.decision,
        140_400,
    );
    row("body: report of the base", counts.events.odometry, 11_800);
    row(
        "body: echo while it finds its sensors",
        counts.babble.on_the_way,
        21_050,
    );
    row("body: step to where they are", counts.step, 389_290);
    let mut whole = InstructionStats::default();
    whole.add(counts.step.sum());
    row("body: all steps", whole, 122_100_000);
}

fn print_places(counts: &places::PlaceCounts, body: &body::BodyCounts) {
    row("places: where the robot is", counts.locate, 15_200);
    row(
        "places: a slice, with 256 places and points",
        counts.slice,
        119_400,
    );
    row("places: all slices, not led", counts.perceive, 408_200);
    row("places: all slices, led", counts.lead, 10_000_000);
    row("places: all slices, lost", counts.lost, 10_000_000);
    row("places: last echo of the ring", body.decision, 115_800);
    row(
        "places: a slice that decides, or one before it",
        body.events.slice,
        87_000,
    );
}

fn print_modality(counts: &modality::ModalityCounts) {
    row("modality: something is perceived", counts.perceive, 11_400);
    row(
        "modality: the same, and another is forgotten",
        counts.full,
        27_800,
    );
    row("modality: where to look for it", counts.aim, 13_400);
}

fn row(call: &str, stats: InstructionStats, allowed: u32) {
    let (calls, mean, most) = (stats.calls(), stats.mean(), stats.most());
    hprintln!("| {call} | {calls} | {mean} | {most} | {allowed} |");
}

#[panic_handler]
fn panic(info: &PanicInfo<'_>) -> ! {
    hprintln!("{info}");
    debug::exit(debug::EXIT_FAILURE);
    loop {
        cortex_m::asm::wfi();
    }
}
