//! What one Polaroid transducer can hear from where it is.
//!
//! Rays over the lobe and towards likely places find what the transducer can see. A flat face
//! answers near its normal and is a mirror otherwise; circles and corners answer at any angle. Each
//! answers once, at its nearest point (regions of constant depth, Leonard and Durrant-Whyte).

use core::f64::consts::PI;

use super::config::SonarConfig;
use crate::caster::{Fan, Hit, LobeHit, LobeView, Surface};
use crate::world::{Point, World};

/// Scratch memory and precomputed directions.
#[derive(Debug, Clone)]
pub(crate) struct Hearing {
    fan: Fan,
    cos_half_angle: f64,
    cos_max_incidence: f64,
    /// Cosine of the angle between axis and normal beyond which a face answers no ray of the lobe.
    least_facing: f64,
    promising: Vec<Point>,
    /// Rays of the fan and what they met first.
    fan_hits: Vec<(Point, LobeHit)>,
    answers: Answers,
}

impl Hearing {
    pub(crate) fn new(config: &SonarConfig, half_angle: f64) -> Self {
        let max_incidence = config.max_incidence_rad.clamp(0.0, PI / 2.0);
        Self {
            fan: Fan::new(config.fan_rays.max(2), half_angle),
            cos_half_angle: libm::cos(half_angle),
            cos_max_incidence: libm::cos(max_incidence),
            // Less by far more than any rounding.
            least_facing: libm::cos((half_angle + max_incidence).min(PI)) - 1e-6,
            promising: Vec::new(),
            fan_hits: Vec::new(),
            answers: Answers::default(),
        }
    }

    /// Range of the first echo after the blanking, m, of what the lobe was aimed at.
    pub(crate) fn first_echo(
        &mut self,
        world: &World,
        lobe: &mut LobeView,
        config: &SonarConfig,
    ) -> Option<f64> {
        self.aim_at_promising(lobe);
        if config.blanking_m > 0.0 || config.bounces > 0 || !self.fan.is_narrow() {
            return self.first_by_rays(world, lobe, config);
        }
        let (least_cos, facing) = (self.cos_max_incidence, self.least_facing);
        let answer = lobe.nearest_answer(&self.fan, &self.promising, least_cos, facing);
        let most = answer.min(config.max_range_m);
        let corner = lobe.nearest_corner(0.0, most).unwrap_or(f64::INFINITY);
        let first = answer.min(corner);
        (first <= config.max_range_m).then_some(first)
    }

    /// The same by all rays.
    #[inline(never)]
    fn first_by_rays(
        &mut self,
        world: &World,
        lobe: &mut LobeView,
        config: &SonarConfig,
    ) -> Option<f64> {
        let mut first = FirstInRange {
            least: config.blanking_m,
            most: config.max_range_m,
            range: None,
        };
        self.hear_rays(lobe, &mut first);
        self.follow(world, lobe, config.bounces, &mut first);
        if let Some(corner) = lobe.nearest_corner(first.least, first.range.unwrap_or(first.most)) {
            first.offer(corner);
        }
        first.range
    }

    fn aim_at_promising(&mut self, lobe: &LobeView) {
        let axis = lobe.lobe().axis;
        self.promising.clear();
        for direction in lobe.promising() {
            if direction.dot(axis) >= self.cos_half_angle {
                self.promising.push(direction);
            }
        }
    }

    /// Casts every ray and offers the nearest answer of each surface: one that answers too early
    /// does not answer again.
    fn hear_rays(&mut self, lobe: &LobeView, first: &mut FirstInRange) {
        let axis = lobe.lobe().axis;
        self.fan_hits.clear();
        self.answers.clear();
        for direction in self.fan.directions() {
            let ray = direction.turned(axis);
            if let Some(hit) = lobe.cast(ray) {
                self.fan_hits.push((ray, hit));
                self.answers.add(&hit, self.cos_max_incidence);
            }
        }
        for &ray in &self.promising {
            if let Some(hit) = lobe.cast(ray) {
                self.answers.add(&hit, self.cos_max_incidence);
            }
        }
        for &(_, range) in &self.answers.nearest {
            first.offer(range);
        }
    }

    /// Follows the rays of the fan that faces mirror, up to `bounces` times.
    fn follow(&self, world: &World, lobe: &LobeView, bounces: usize, first: &mut FirstInRange) {
        let tip = lobe.lobe().tip;
        for (ray, hit) in &self.fan_hits {
            let Some(mut normal) = hit.normal else {
                continue;
            };
            if hit.cos_incidence >= self.cos_max_incidence {
                continue;
            }
            let (mut at, mut direction) = (tip, *ray);
            let (mut last_way, mut way) = (hit.distance_m, hit.distance_m);
            for _ in 0..bounces {
                at = at + direction * last_way;
                direction = direction - normal * (2.0 * direction.dot(normal));
                let Some(next) = world.cast(at, direction) else {
                    break;
                };
                way += next.distance_m;
                if self.answers_from(&next) {
                    first.offer(way);
                    break;
                }
                (last_way, normal) = (next.distance_m, next.normal);
            }
        }
    }

    fn answers_from(&self, hit: &Hit) -> bool {
        matches!(hit.surface, Surface::Circle(_)) || hit.cos_incidence >= self.cos_max_incidence
    }
}

/// The nearest answer of each surface.
#[derive(Debug, Clone, Default)]
struct Answers {
    /// Number of the surface, and how far, m.
    nearest: Vec<(f64, f64)>,
}

impl Answers {
    fn clear(&mut self) {
        self.nearest.clear();
    }

    /// Adds a hit if it answers: if its cosine is at least `least_cos`.
    fn add(&mut self, hit: &LobeHit, least_cos: f64) {
        if hit.cos_incidence < least_cos {
            return;
        }
        let mut known = self.nearest.iter_mut();
        match known.find(|(number, _)| *number == hit.number) {
            Some((_, nearest)) => *nearest = nearest.min(hit.distance_m),
            None => self.nearest.push((hit.number, hit.distance_m)),
        }
    }
}

/// The least range offered that lies within limits.
struct FirstInRange {
    least: f64,
    most: f64,
    range: Option<f64>,
}

impl FirstInRange {
    fn offer(&mut self, range: f64) {
        if self.wants(range) {
            self.range = Some(range);
        }
    }

    fn wants(&self, range: f64) -> bool {
        let better = self.range.is_none_or(|known| range < known);
        better && range >= self.least && range <= self.most
    }
}
