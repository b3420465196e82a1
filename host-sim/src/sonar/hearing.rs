//! What one Polaroid transducer can hear from where it is.
//!
//! A fan of rays over the lobe, and one ray at each place most likely to answer, find what the transducer
//! can see; what is hidden is met by no ray. A flat face answers where the sound meets it near its normal,
//! and is a mirror otherwise. A circle answers wherever it is met. A corner or edge answers from its tip, at
//! any angle. Each thing answers once, with its nearest answering point (Leonard and Durrant-Whyte's
//! regions of constant depth come out of that).

use core::f64::consts::PI;

use super::SonarConfig;
use crate::world::{Hit, LobeView, Point, Surface, World};

/// How much nearer than a corner a ray may end and still be said to reach it, m.
const CORNER_SLACK_M: f64 = 1e-6;

/// Scratch memory and precomputed directions.
#[derive(Debug, Clone)]
pub(super) struct Hearing {
    /// The fan, relative to the axis.
    fan: Vec<Point>,
    cos_half_angle: f64,
    cos_max_incidence: f64,
    /// The nearest answer of each surface met.
    answers: Vec<(Surface, f64)>,
}

impl Hearing {
    pub(super) fn new(config: &SonarConfig, half_angle: f64) -> Self {
        let rays = config.fan_rays.max(2);
        let step = 2.0 * half_angle / (rays - 1) as f64;
        let fan = (0..rays).map(|i| Point::unit(step * i as f64 - half_angle));
        Self {
            fan: fan.collect(),
            cos_half_angle: libm::cos(half_angle),
            cos_max_incidence: libm::cos(config.max_incidence_rad.clamp(0.0, PI / 2.0)),
            answers: Vec::new(),
        }
    }

    /// Range of the first echo after the blanking, m.
    pub(super) fn first_echo(
        &mut self,
        world: &World,
        lobe: &LobeView,
        tip: Point,
        axis: Point,
        config: &SonarConfig,
    ) -> Option<f64> {
        self.answers.clear();
        let mut first = Nearest {
            least: config.blanking_m,
            most: config.max_range_m,
            range: None,
        };
        for i in 0..self.fan.len() {
            let direction = self.fan[i].turned(axis);
            self.follow(world, lobe, tip, direction, config.bounces, &mut first);
        }
        for direction in lobe.promising() {
            if direction.dot(axis) >= self.cos_half_angle {
                self.follow(world, lobe, tip, direction, 0, &mut first);
            }
        }
        for corner in lobe.corners() {
            let range = corner.length();
            let direction = if range > 0.0 {
                corner * (1.0 / range)
            } else {
                axis
            };
            let hidden = |hit: Hit| hit.distance_m < range - CORNER_SLACK_M;
            if !lobe.cast(direction).is_some_and(hidden) {
                first.offer(range);
            }
        }
        for &(_, range) in &self.answers {
            first.offer(range);
        }
        first.range
    }

    /// Sends one ray out; a face it meets too obliquely mirrors it on, up to `bounces` times.
    fn follow(
        &mut self,
        world: &World,
        lobe: &LobeView,
        tip: Point,
        direction: Point,
        bounces: usize,
        first: &mut Nearest,
    ) {
        let Some(hit) = lobe.cast(direction) else {
            return;
        };
        if self.answers_from(&hit) {
            return self.note(hit.surface, hit.distance_m);
        }
        let (mut at, mut direction, mut hit) = (tip, direction, hit);
        let mut way = hit.distance_m;
        for _ in 0..bounces {
            at = at + direction * hit.distance_m;
            direction = direction - hit.normal * (2.0 * direction.dot(hit.normal));
            let Some(next) = world.cast(at, direction) else {
                return;
            };
            way += next.distance_m;
            if self.answers_from(&next) {
                return first.offer(way);
            }
            hit = next;
        }
    }

    fn answers_from(&self, hit: &Hit) -> bool {
        matches!(hit.surface, Surface::Circle(_)) || hit.cos_incidence >= self.cos_max_incidence
    }

    /// Keeps the nearest answer of each surface.
    fn note(&mut self, surface: Surface, range: f64) {
        match self.answers.iter_mut().find(|(known, _)| *known == surface) {
            Some((_, nearest)) => *nearest = nearest.min(range),
            None => self.answers.push((surface, range)),
        }
    }
}

/// The least range offered that lies within limits.
struct Nearest {
    least: f64,
    most: f64,
    range: Option<f64>,
}

impl Nearest {
    fn offer(&mut self, range: f64) {
        let better = self.range.is_none_or(|known| range < known);
        if better && range >= self.least && range <= self.most {
            self.range = Some(range);
        }
    }
}
