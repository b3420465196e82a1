//! The controller: configuration, goals, plans, shield, events, transfer of its state.

use crate::arithmetic::{bearing, displacement, echo, mask, now, weight};
use crate::maps::grid;
use crate::{any, bytes, format_text, sink};
use amp::action_map::ActionMap;
use amp::body::{Body as _, MountedSensors};
use amp::config::{Config, MAX_CONFIG};
use amp::controller::{self, Command, Event, NomadState, Progress, StatePart, StopReason};
use amp::goal::{Component, Goal};
use amp::memory::{Memory, Sample};
use amp::modality::{Modality, Search, Sought};
use amp::parameters::Parameter;
use amp::places::Places;
use amp::planner::{Planner, Why, difference};
use amp::robot::RobotSpec;
use amp::scan::Encoding;
use amp::shield::Shield;
use amp::som::Som;
use amp::units::Range;

pub fn all() {
    goals();
    plans();
    shields();
    configs();
    memories();
    events();
    bodies();
    modalities();
    parts();
}

pub fn config() -> Config<16> {
    any(Config::recommended())
}

pub fn goal() -> Goal<16> {
    any(Goal::free_of_obstacles())
}

fn goals() {
    let situation = any([weight(); 16]);
    sink(Goal::<16>::nothing_within(
        Range::from_mm(any(1)),
        any(Encoding {
            near_mm: 1,
            far_mm: 2,
        }),
    ));
    sink((Goal::avoiding(&config()), Goal::perceived(&situation)));
    sink((
        goal().distance(&situation, mask()),
        goal().holds(&situation, mask(), weight()),
    ));
    sink(goal().nearest(&situation));
    sink((Component::at_least(weight()), Component::at_most(weight())));
}

fn plans() {
    let situations = any(Som::<16, 16>::zeroed(grid()));
    let actions = any(ActionMap::<16, 16>::zeroed(grid()));
    let config = config();
    let planner = Planner {
        config: &config,
        situations: &situations,
        actions: &actions,
        enabled: mask(),
        allowed: mask(),
        current: any(Some(1)),
        course: displacement(),
        cut: any(true),
    };
    sink(planner.plan(&any([weight(); 16]), &goal()));
    sink(difference(&any([weight(); 16]), &any([weight(); 16])));
    format_text(any(Why::Neighbor));
}

fn shields() {
    let mut shield = any(Shield::<16>::new());
    shield.hear(&config(), any(1), echo());
    shield.moved(displacement(), bearing());
    sink(shield.allow(&config(), mask(), displacement(), now()));
    sink(shield.shorten(&config(), displacement()));
    shield.forget();
    sink(shield);
}

fn configs() {
    sink(Config::touzet());
    sink(config().for_robot(any(RobotSpec::miniature())));
    let mut config = config();
    let parameter = any(Parameter::Near);
    if let Err(why) = parameter.set(&mut config, any(1)) {
        format_text(why);
    }
    sink((parameter.get(&config), parameter.spec(), parameter.name()));
    format_text(parameter.spec().unit);
    sink(config);
}

fn memories() {
    let mut memory = any(Memory::<16, 100>::new());
    let kept = memory.keep(any(Sample {
        before: [1; 16],
        after: [2; 16],
        commanded: displacement(),
        executed: displacement(),
    }));
    if let Err(why) = kept {
        format_text(why);
    }
    sink(memory.samples());
    memory.clear();
    sink(memory);
}

fn event() -> Event<16> {
    match any(0) {
        0 => Event::Echo {
            sensor: any(1),
            range: echo().range,
        },
        1 => Event::Odometry {
            motion: any(1),
            moved: displacement(),
            turned: bearing(),
            progress: any(Progress::Ended),
        },
        2 => Event::Command(any(Command::Seek(goal()))),
        5 => Event::Command(any(Command::Calibrate {
            moves: 20,
            seed: 1,
            actuators: true,
        })),
        3 => Event::Alarm(any(StopReason::LinkLost)),
        4 => Event::Touched,
        _ => Event::Tick,
    }
}

fn events() {
    let mut state = any(NomadState::new(grid()));
    sink(controller::handle(&config(), &mut state, now(), event()));
    sink((state.is_moving(), *state.mode()));
    sink(state);
}

fn bodies() {
    let mut state = any(NomadState::new(grid()));
    let mut body = any(MountedSensors::<16, 16, 256, 256>::new());
    sink(body.handle(&config(), &mut state, now(), event()));
    sink(body.think(&config(), &mut state, now()));
    sink(body.replace(bytes()));
    let mut room = any([0; MAX_CONFIG]);
    sink(body.to_bytes(&mut room));
    sink((body, state));
}

fn modalities() {
    let mut modality = any(Modality::<3, 256>::new());
    let values = any([1; 3]);
    modality.perceive(&values, displacement(), now());
    let sought = any(Sought::Alike([1; 3]));
    sink(modality.recall(&sought, displacement()).copied());
    sink(modality.recall_before(&values, now()).copied());
    let places = any(Places::<16, 256>::new());
    let mut search = any(Search::default());
    sink(search.aim(&modality, &sought, &places, now()));
    modality.forget();
    sink((modality, search));
}

fn parts() {
    let mut state = any(NomadState::new(grid()));
    let part = any(StatePart::Situations);
    let mut room = any([0; 160]);
    sink(state.part_len(part));
    sink(state.read_part(part, any(1), any(&mut room[..])));
    if let Err(why) = state.write_part(part, any(1), bytes()) {
        format_text(why);
    }
    state.forget();
    sink((state, room));
}
