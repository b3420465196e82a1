//! Patrols: a robot is led from station to station once, and then goes on by itself. At each
//! station it names the next one by what it perceives.
//!
//! Its situations are coded as thermometers of 128 bits. The sequence is held by a pair of
//! associative memories; beside it stand a table of the same codes, the nearest station by the
//! robot's position, and a list with a pointer.

mod stations;
mod summary;

pub use summary::{NamerSummary, summarize};

use crate::errands::places;
use amp::config::Config;
use amp::fixed::Weight;
use amp::scan::Situation;
use amp::sequence::Pattern;
use arena::loaders::WorldSource;
use arena::noise::Noise;
use arena::robot::TurretMode;
use arena::sonar::SonarModel;
use arena::world::{Point, World};
use files::error::BadInput;
use rayon::prelude::*;
use serde::Serialize;
use sim::behavior::Behavior;
use sim::episode::{self, Arrival, Destination, NEST_RADIUS_M, Setup};
use sim::error::EpisodeError;
use sim::robot::AnyRobot;
use sim::turret_pilot::TurretController;
use stations::{Record, Stations};

/// Bits of a coded situation.
const BITS: usize = 128;
/// So many of the 16 values of a situation are missing when a station is to be recognized.
pub const MISSING: [usize; 4] = [0, 4, 8, 12];

/// What names the next station.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Namer {
    /// The pair of associative memories, corrected.
    Pair,
    /// The same by Hebb's rule alone.
    PairHebb,
    /// The nearest code in a table, and what follows it.
    Table,
    /// The station that is nearest to where the robot thinks that it is.
    Position,
    /// A list and a pointer, which is right at the beginning.
    List,
}

impl Namer {
    /// All, in the order of the table.
    pub const ALL: [Self; 5] = [
        Self::Pair,
        Self::PairHebb,
        Self::Table,
        Self::Position,
        Self::List,
    ];

    /// Those that lead the robot; the others are only asked.
    pub const LEADERS: [Self; 3] = [Self::Pair, Self::Table, Self::List];

    /// The name in tables.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Pair => "pair, corrected",
            Self::PairHebb => "pair, Hebb",
            Self::Table => "table, nearest code",
            Self::Position => "nearest position",
            Self::List => "list with a pointer",
        }
    }

    /// Whether it goes by what is perceived.
    const fn perceives(self) -> bool {
        matches!(self, Self::Pair | Self::PairHebb | Self::Table)
    }
}

/// What all worlds share.
#[derive(Debug, Clone)]
pub struct PatrolTrial {
    /// First seed of all randomness in each world.
    pub seed: u64,
    /// Seeds of each world.
    pub seeds: u32,
    /// Stations in each world, if they are drawn.
    pub stations: u32,
    /// The stations, m, if they are given.
    pub given: Vec<Point>,
    /// Random moves before the first drive.
    pub explore_moves: u16,
    /// Decisions of one drive, at most.
    pub steps: u32,
    /// The robot.
    pub robot: AnyRobot,
    /// Its sonars.
    pub sonar: SonarModel,
    /// The controller's configuration.
    pub config: Config<16>,
}

/// A round of one patrol.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Round {
    /// The world.
    pub world: String,
    /// The seed.
    pub seed: u64,
    /// What led the robot.
    pub namer: Namer,
    /// The station where it began.
    pub from: usize,
    /// Stations that were reached in their order, before the first that was not.
    pub reached: usize,
    /// Stations of a whole round.
    pub stations: usize,
    /// How far the robot was from the stations that it reached, m: mean.
    pub error_m: f64,
    /// Steps with a contact.
    pub contacts: u32,
}

/// The next station as it was named at one station.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Naming {
    /// The world.
    pub world: String,
    /// The seed.
    pub seed: u64,
    /// What named it.
    pub namer: Namer,
    /// Values of the situation that were missing.
    pub missing: usize,
    /// It was the right one.
    pub is_right: bool,
}

/// What was measured with one seed in one world.
#[derive(Debug, Clone, Default)]
pub struct Patrols {
    /// Rounds of the namers that lead.
    pub rounds: Vec<Round>,
    /// The next station as all namers named it, wherever the robot stood at a station.
    pub namings: Vec<Naming>,
    /// Why it ended early.
    pub stopped: Option<EpisodeError>,
}

/// Measures all worlds and seeds, on all cores. `done` is called after each.
///
/// # Errors
/// When a world cannot be loaded, or a controller refuses a command or is silent before its first
/// drive.
pub fn measure(
    trial: &PatrolTrial,
    worlds: &[WorldSource],
    done: &(impl Fn() + Sync),
) -> Result<Vec<Patrols>, BadInput> {
    let pairs = worlds.iter().flat_map(|world| {
        let seeds = 0..u64::from(trial.seeds);
        seeds.map(move |number| (world, trial.seed.wrapping_add(number)))
    });
    let pairs: Vec<_> = pairs.collect();
    let one = |(source, seed): &(&WorldSource, u64)| {
        let world = source.load()?;
        let failed = |why| BadInput::new(format!("world {}: {why}", world.name()));
        let patrols = in_world(trial, &world, *seed).map_err(failed);
        done();
        patrols
    };
    pairs.par_iter().map(one).collect()
}

fn in_world(trial: &PatrolTrial, world: &World, seed: u64) -> Result<Patrols, EpisodeError> {
    let setup = Setup {
        config: trial.robot.config(trial.config.clone()),
        preset: "default".to_owned(),
        behavior: Behavior::Avoid,
        explore_moves: trial.explore_moves,
        steps: 1,
        seed,
        sonar: trial.sonar,
        faults: Vec::new(),
        goal: None,
        second_robot: false,
        turret: TurretMode::Held,
        robot: Some(trial.robot.clone()),
        set_down: None,
        record: false,
    };
    let stations = match trial.given.is_empty() {
        true => places(world, trial.robot.model().radius_m, trial.stations, seed),
        false => trial.given.clone(),
    };
    let mut watch = Watch::new(world.name(), seed, stations);
    let mut controller = TurretController::new(setup.config.clone(), &trial.robot);
    let next = |arrival: Option<&Arrival>| watch.next(arrival);
    let stopped = episode::patrol(world, &setup, &mut controller, trial.steps, next)?;
    Ok(Patrols {
        stopped,
        ..watch.patrols
    })
}

/// What the robot does now.
#[derive(Debug, Clone, Copy)]
enum Doing {
    /// It is led to this station for the first time.
    Led(usize),
    /// It is brought to where this leader begins.
    Brought(usize),
    /// It is led by this leader, to this station.
    Goes { leader: usize, to: usize },
}

/// Leads the robot and writes down what it did.
struct Watch {
    /// Where the stations are, m.
    places: Vec<Point>,
    world: String,
    seed: u64,
    noise: Noise,
    doing: Doing,
    records: Vec<Record>,
    stations: Option<Stations>,
    /// The station where each round begins.
    from: usize,
    round: Option<Round>,
    patrols: Patrols,
}

impl Watch {
    fn new(world: &str, seed: u64, places: Vec<Point>) -> Self {
        let mut noise = Noise::new(seed ^ 0x7061_7472);
        let from = noise.index(places.len());
        Self {
            places,
            world: world.to_owned(),
            seed,
            noise,
            doing: Doing::Led(0),
            records: Vec::new(),
            stations: None,
            from,
            round: None,
            patrols: Patrols::default(),
        }
    }

    /// Where the robot goes next.
    fn next(&mut self, arrival: Option<&Arrival>) -> Option<Destination> {
        let Some(arrival) = arrival else {
            return self.lead_to(0);
        };
        match self.doing {
            Doing::Led(station) => {
                self.records.push(Record {
                    code: Pattern::of_situation(&arrival.situation),
                    position: arrival.believed,
                });
                if station + 1 < self.places.len() {
                    return self.lead_to(station + 1);
                }
                self.stations = Some(Stations::of(std::mem::take(&mut self.records)));
                self.bring(0)
            }
            Doing::Brought(leader) => {
                self.round = Some(Round {
                    world: self.world.clone(),
                    seed: self.seed,
                    namer: Namer::LEADERS[leader],
                    from: self.from,
                    reached: 0,
                    stations: self.places.len(),
                    error_m: 0.0,
                    contacts: 0,
                });
                self.go_on(leader, self.from, arrival)
            }
            Doing::Goes { leader, to } => self.arrived(leader, to, arrival),
        }
    }

    fn lead_to(&mut self, station: usize) -> Option<Destination> {
        self.doing = Doing::Led(station);
        let place = self.places.get(station)?;
        Some(Destination::InWorld(*place))
    }

    /// Brings the robot to where this leader begins; `None` after the last leader.
    fn bring(&mut self, leader: usize) -> Option<Destination> {
        Namer::LEADERS.get(leader)?;
        self.doing = Doing::Brought(leader);
        let place = self.places.get(self.from)?;
        Some(Destination::InWorld(*place))
    }

    /// At a station: all name the next one, and the robot goes where its leader says.
    fn go_on(&mut self, leader: usize, station: usize, arrival: &Arrival) -> Option<Destination> {
        if self.places[station].distance(arrival.at) > NEST_RADIUS_M {
            // It was not brought there: no round began.
            self.round = None;
            return self.end_round(leader);
        }
        self.ask_all(station, arrival);
        let stations = self.stations.as_ref()?;
        let code = Pattern::of_situation(&arrival.situation);
        let pointer = stations.after(station);
        let namer = Namer::LEADERS[leader];
        let named = stations.name(namer, &code, arrival.believed, pointer);
        if named != pointer {
            return self.end_round(leader);
        }
        let position = stations.records.get(named)?.position;
        self.doing = Doing::Goes { leader, to: named };
        Some(Destination::InFrame(position))
    }

    /// The robot was to go to this station.
    fn arrived(&mut self, leader: usize, to: usize, arrival: &Arrival) -> Option<Destination> {
        let error_m = self.places[to].distance(arrival.at);
        let round = self.round.as_mut()?;
        round.contacts += arrival.contacts;
        if error_m <= NEST_RADIUS_M {
            let before = round.reached as f64;
            round.error_m = (round.error_m * before + error_m) / (before + 1.0);
            round.reached += 1;
            if round.reached < round.stations {
                return self.go_on(leader, to, arrival);
            }
        }
        self.end_round(leader)
    }

    fn end_round(&mut self, leader: usize) -> Option<Destination> {
        self.patrols.rounds.extend(self.round.take());
        self.bring(leader + 1)
    }

    fn ask_all(&mut self, station: usize, arrival: &Arrival) {
        let Some(stations) = &self.stations else {
            return;
        };
        let right = stations.after(station);
        for missing in MISSING {
            let situation = without(&arrival.situation, missing, &mut self.noise);
            let code = Pattern::of_situation(&situation);
            for namer in Namer::ALL {
                if missing > 0 && !namer.perceives() {
                    continue;
                }
                let named = stations.name(namer, &code, arrival.believed, right);
                self.patrols.namings.push(Naming {
                    world: self.world.clone(),
                    seed: self.seed,
                    namer,
                    missing,
                    is_right: named == right,
                });
            }
        }
    }
}

/// The situation as if so many random sensors were silent.
fn without(situation: &Situation<16>, missing: usize, noise: &mut Noise) -> Situation<16> {
    let mut rest = *situation;
    let mut sensors: Vec<usize> = (0..rest.len()).collect();
    for place in 0..missing {
        let other = place + noise.index(sensors.len() - place);
        sensors.swap(place, other);
        rest[sensors[place]] = Weight::ZERO;
    }
    rest
}

#[cfg(test)]
mod tests;
