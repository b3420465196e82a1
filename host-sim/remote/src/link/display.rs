//! Messages as text, for people.

use amp::controller::{self, Decision};
use amp::goal::Name;
use amp::units::Displacement;
use amp::wire::message::{
    DeviceHello, DeviceMessage, LogEvent, ModeReport, MotionCommand, Oscillator, Refusal, Report,
    ResetCause,
};
use sim::error::stop_reason;

/// The cause of a reset, as a clause.
#[must_use]
pub fn reset(cause: ResetCause) -> &'static str {
    match cause {
        ResetCause::Unknown => "the cause is unknown",
        ResetCause::PowerOn => "the power came on",
        ResetCause::Pin => "its reset pin was pulled",
        ResetCause::Requested => "a reset was requested",
        ResetCause::Watchdog => "its watchdog was not fed",
        ResetCause::Panic => "its program panicked",
        ResetCause::HardFault => "its processor faulted",
        ResetCause::StackOverflow => "its stack overflowed",
    }
}

/// The processor's clock source.
#[must_use]
pub fn oscillator(oscillator: Oscillator) -> &'static str {
    match oscillator {
        Oscillator::Unknown => "unknown",
        Oscillator::Crystal => "its crystal",
        Oscillator::Internal => {
            "its internal oscillator: the crystal failed or has another frequency"
        }
    }
}

/// Why a request was refused.
#[must_use]
pub fn refusal(why: Refusal) -> String {
    match why {
        Refusal::Incompatible(theirs) => format!("it speaks protocol {}", theirs.protocol),
        Refusal::NoSession => "it has no session".into(),
        Refusal::Expired { age_ms } => format!("the command came {age_ms} ms too late"),
        Refusal::Command(why) => command(why),
        Refusal::Parameter(why) => why.to_string(),
        Refusal::Transfer(why) => why.to_string(),
        Refusal::Config => "the bytes are not a valid configuration".into(),
        Refusal::Moving => {
            "not while the robot explores, learns or seeks (`host-sim link … stop`)".into()
        }
        Refusal::NoRing => "it has no sonars of its own, or uses the host's clock".into(),
        Refusal::NoSituation => "some sonars have not reported yet".into(),
        Refusal::Flash(why) => why.to_string(),
        Refusal::NoSuchGoal => "it has no goal of this name (`host-sim link … goals`)".into(),
        Refusal::InvalidGoalName => "it has 8 goals already: drop one first".into(),
        Refusal::Body => {
            "its firmware is for a ring on a turret: build it with --features any-body".into()
        }
        Refusal::NoPlaces => {
            "its firmware has no memory of places: build it with --features places".into()
        }
    }
}

fn command(why: controller::CommandRefusal) -> String {
    match why {
        controller::CommandRefusal::InvalidMoveCount { max } => {
            format!("it takes from 1 to {max} random moves")
        }
        controller::CommandRefusal::NoSamples => {
            "there is nothing to learn from: explore first, or push a memory".into()
        }
        controller::CommandRefusal::NotLearned => {
            "it has not learned yet: learn first, or push maps".into()
        }
        controller::CommandRefusal::NothingToResume => "there is nothing to resume".into(),
        controller::CommandRefusal::FixedRing => {
            "it has been told of no body: nothing is to be found".into()
        }
    }
}

/// A report as one line: the controller's time, kind and content.
#[must_use]
pub fn describe(report: &Report<16>) -> String {
    let (kind, text) = match &report.message {
        DeviceMessage::Hello(controller) => ("hello", hello(controller)),
        DeviceMessage::Motion(command) => ("motion", motion(command)),
        DeviceMessage::Decision(taken) => ("decision", decision(taken)),
        DeviceMessage::Mode(state) => ("mode", mode(*state)),
        DeviceMessage::Counters(counted) => (
            "counters",
            format!(
                "{} frames accepted, {} sent",
                counted.accepted, counted.sent
            ),
        ),
        DeviceMessage::Refusal { seq, reason } => {
            ("refusal", format!("of frame {seq}: {}", refusal(*reason)))
        }
        DeviceMessage::Chunk {
            part,
            offset,
            total,
            bytes,
        } => (
            "piece",
            format!("{part:?}, {} bytes from {offset} of {total}", bytes.len()),
        ),
        DeviceMessage::Parameter {
            parameter,
            value,
            spec,
        } => (
            "parameter",
            format!("{} = {value} {}", parameter.name(), spec.unit),
        ),
        DeviceMessage::Log(LogEvent::LinkLost) => ("log", "no message came from the host".into()),
        DeviceMessage::Log(LogEvent::FramesDropped { count }) => {
            ("log", format!("{count} frames dropped so far"))
        }
        DeviceMessage::Log(LogEvent::SensorDisabled { sensor, fault }) => (
            "log",
            format!("sonar {sensor} is disabled: {fault:?}").to_lowercase(),
        ),
        DeviceMessage::Log(LogEvent::SensorEnabled { sensor }) => {
            ("log", format!("sonar {sensor} is enabled again"))
        }
        DeviceMessage::Log(LogEvent::StaleEcho { age_ms }) => (
            "log",
            format!("an echo was {age_ms} ms old and was ignored"),
        ),
        DeviceMessage::Done { seq } => ("done", format!("frame {seq}")),
        DeviceMessage::Busy { ms } => ("busy", format!("for at most {ms} ms")),
        DeviceMessage::Goal { name, .. } if *name == Name::NONE => {
            ("goal", "the current one".into())
        }
        DeviceMessage::Goal { name, .. } => ("goal", name.as_str().to_owned()),
    };
    let time_s = f64::from(report.device_ms) / 1e3;
    format!("{time_s:10.3} s  {kind:<9}  {}", text.trim_end())
}

fn hello(controller: &DeviceHello) -> String {
    format!(
        "build {}, started because {}; config {:08x}, maps {:08x}, memory {:08x}",
        build(&controller.build),
        reset(controller.reset),
        controller.config_crc,
        controller.maps_crc,
        controller.memory_crc
    )
}

/// Name of the build, or "unknown".
#[must_use]
pub fn build(name: &[u8; 8]) -> String {
    let text = String::from_utf8_lossy(name);
    match text.trim_matches(['\0', ' ']) {
        "" => "unknown".into(),
        name => name.escape_default().to_string(),
    }
}

fn vector(way: Displacement) -> String {
    format!("({:+}, {:+}) mm", way.dx_mm, way.dy_mm)
}

fn motion(command: &MotionCommand) -> String {
    let (id, revision) = (command.id, command.revision);
    let way = command.motion().displacement;
    if way == Displacement::ZERO {
        return format!("{id}.{revision}  stop");
    }
    format!(
        "{id}.{revision}  {} at {} mm/s for at most {} ms",
        vector(way),
        command.speed_mm_s,
        command.ttl_ms
    )
}

fn decision(taken: &Decision<16>) -> String {
    let how = match &taken.plan {
        None => "random move".into(),
        Some(plan) => format!(
            "situation {} → {} → goal {}, action {} ({})",
            plan.current_neuron,
            plan.subgoal_neuron,
            plan.goal_neuron,
            plan.action_neuron,
            plan.why
        ),
    };
    let cut = if taken.allowed == taken.wanted {
        String::new()
    } else {
        format!(", shortened to {}", vector(taken.allowed))
    };
    let goal = if taken.at_goal { ", at the goal" } else { "" };
    format!("{how}: {}{cut}{goal}", vector(taken.wanted))
}

fn mode(state: ModeReport) -> String {
    match state {
        ModeReport::Idle => "idle".into(),
        ModeReport::Explore { left } => format!("explores, {left} moves left"),
        ModeReport::Learn => "learns".into(),
        ModeReport::Seek => "seeks its goal".into(),
        ModeReport::Stopped(reason) => format!("stopped: {}", stop_reason(reason)),
        ModeReport::Babble { left } => {
            format!("moves to find where its sensors look, {left} moves left")
        }
        ModeReport::Calibrate => "finds where its sensors look".into(),
    }
}
