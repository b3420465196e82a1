//! What a robot has of its own, and what its controller is told of it.

use super::MAX_BEAMS;
use amp::places::Aim;
use amp::turret::BodySpec;
use arena::noise::Noise;
use files::error::BadInput;
use serde::{Deserialize, Serialize};
use std::f64::consts::TAU;
use std::str::FromStr;

/// What the controller of a robot is told of it.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub struct ToldRobot {
    /// Its body.
    pub body: BodySpec<MAX_BEAMS>,
    /// Its memory of places leads it to goals.
    pub is_led: bool,
}

impl ToldRobot {
    /// Where its places lead it when it is to be led there. One that they do not lead to goals
    /// still drives around by them.
    #[must_use]
    pub fn led(&self, aim: Option<Aim>) -> Option<Aim> {
        let drives_around = matches!(aim, Some(Aim::Frontier | Aim::Everywhere));
        aim.filter(|_| self.is_led || drives_around)
    }
}

/// What a robot is taken from its model.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Ranges {
    /// Everything: body, speeds, and the range and cone of its sensors.
    #[default]
    Own,
    /// Only where its sensors look and how it drives; body, speeds, and what the sensors tell are
    /// the Nomad's.
    Nomad,
}

impl FromStr for Ranges {
    type Err = BadInput;

    fn from_str(text: &str) -> Result<Self, BadInput> {
        match text {
            "own" => Ok(Self::Own),
            "nomad" => Ok(Self::Nomad),
            _ => Err(BadInput::unknown("ranges", text, &["own", "nomad"])),
        }
    }
}

/// Where the controller's knowledge of its body comes from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Origin {
    /// It is told.
    #[default]
    Known,
    /// It learns that from its random moves.
    Learned,
}

impl FromStr for Origin {
    type Err = BadInput;

    fn from_str(text: &str) -> Result<Self, BadInput> {
        match text {
            "known" => Ok(Self::Known),
            "learned" => Ok(Self::Learned),
            _ => Err(BadInput::unknown("value", text, &["known", "learned"])),
        }
    }
}

/// A base whose commands and odometry do not mean what they say.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Miswiring {
    /// Where the base goes ahead, in the frame of its commands, rad.
    pub front_rad: f64,
    /// Left and right are exchanged.
    pub is_mirrored: bool,
    /// True length of what the base takes for 1.
    pub length: f64,
    /// True turn of what the base takes for 1.
    pub turn: f64,
}

impl Miswiring {
    /// Drawn from a seed: any front and side, lengths from 0.7 to 1.4, turns from 0.8 to 1.25.
    #[must_use]
    pub fn of_seed(seed: u64) -> Self {
        let mut noise = Noise::new(seed);
        Self {
            front_rad: noise.uniform_in(0.0, TAU),
            is_mirrored: noise.chance(0.5),
            length: noise.uniform_in(0.7, 1.4),
            turn: noise.uniform_in(0.8, 1.25),
        }
    }

    /// 1, or −1 where left and right are exchanged.
    #[must_use]
    pub fn side(&self) -> f64 {
        if self.is_mirrored { -1.0 } else { 1.0 }
    }
}
