//! The first echo of a transducer against the reference model, ray by ray, to the bit.

use super::worlds::worlds;
use super::{Met, Reference, ReferenceLobe};
use crate::caster::{ConeShape, LobeView, SonarLobe};
use crate::geometry::{Point, Pose};
use crate::noise::Noise;
use crate::nomad::FACE_RADIUS_M;
use crate::shapes::Shape;
use crate::sonar::{Hearing, SonarConfig, SonarModel};
use crate::world::World;
use core::f64::consts::{FRAC_PI_2, TAU};

struct Echoes<'a> {
    world: &'a Reference,
    lobe: ReferenceLobe,
    config: SonarConfig,
    /// Number and nearest answer of each surface.
    answers: Vec<(f64, f64)>,
    offers: Vec<f64>,
}

impl Echoes<'_> {
    fn answers_from(&self, met: &Met) -> bool {
        met.number >= 1e9 || met.cos_incidence >= libm::cos(self.config.max_incidence_rad)
    }

    fn follow(&mut self, tip: Point, direction: Point, bounces: usize) {
        let Some(met) = self.lobe.cast(direction) else {
            return;
        };
        if self.answers_from(&met) {
            match self
                .answers
                .iter_mut()
                .find(|(known, _)| *known == met.number)
            {
                Some((_, nearest)) => *nearest = nearest.min(met.way),
                None => self.answers.push((met.number, met.way)),
            }
            return;
        }
        let (mut at, mut direction, mut met) = (tip, direction, met);
        let mut way = met.way;
        for _ in 0..bounces {
            at = at + direction * met.way;
            direction = direction - met.normal * (2.0 * direction.dot(met.normal));
            let Some(next) = self.world.cast(at, direction) else {
                return;
            };
            way += next.way;
            if self.answers_from(&next) {
                return self.offers.push(way);
            }
            met = next;
        }
    }

    fn first(mut self, tip: Point, axis: Point) -> Option<f64> {
        let half = self.config.half_angle_rad;
        let step = 2.0 * half / (self.config.fan_rays - 1) as f64;
        for ray in 0..self.config.fan_rays {
            let direction = Point::unit(step * ray as f64 - half).turned(axis);
            self.follow(tip, direction, self.config.bounces);
        }
        for direction in self.lobe.promising() {
            if direction.dot(axis) >= libm::cos(half) {
                self.follow(tip, direction, 0);
            }
        }
        for &corner in &self.lobe.corners {
            let range = corner.length();
            let towards = if range > 0.0 {
                corner * (1.0 / range)
            } else {
                axis
            };
            let hidden = |met: Met| met.way < range - 1e-6;
            if !self.lobe.cast(towards).is_some_and(hidden) {
                self.offers.push(range);
            }
        }
        self.offers
            .extend(self.answers.iter().map(|(_, range)| *range));
        let limits = self.config.blanking_m..=self.config.max_range_m;
        let heard = self
            .offers
            .into_iter()
            .filter(|range| limits.contains(range));
        heard.reduce(f64::min)
    }
}

fn lobe_at(middle: Point, axis: Point, config: &SonarConfig) -> SonarLobe {
    SonarLobe {
        tip: middle + axis * FACE_RADIUS_M,
        axis,
        cone: ConeShape::new(config.half_angle_rad),
        reach_m: config.max_range_m,
    }
}

#[test]
fn echoes_have_the_bits_of_the_reference() {
    let mut counts = [0, 0];
    for seed in 0..32 {
        let (world, places) = worlds(seed);
        let world = if seed % 5 == 0 {
            world.with_post(places[0], 0.269)
        } else {
            world
        };
        let (reference, mut noise) = (Reference::of(&world), Noise::new(seed));
        for model in [SonarModel::Nomad, SonarModel::Harsh] {
            let config = model.config();
            let cone = ConeShape::new(config.half_angle_rad);
            let mut hearing = Hearing::new(&config, config.half_angle_rad);
            let mut lobes = vec![LobeView::default(); 8];
            for &place in &places {
                for sensor in 0..8 {
                    let off = if seed % 3 == 0 { noise.uniform() } else { 0.0 };
                    let axis = Point::unit(TAU * f64::from(sensor) / 8.0 + off);
                    let tip = place + axis * FACE_RADIUS_M;
                    let lobe = &mut lobes[sensor as usize];
                    world.aim(lobe, &lobe_at(place, axis, &config));
                    let heard = hearing.first_echo(&world, lobe, &config);
                    let echoes = Echoes {
                        world: &reference,
                        lobe: reference.lobe(tip, axis, cone, config.max_range_m),
                        config,
                        answers: Vec::new(),
                        offers: Vec::new(),
                    };
                    let expected = echoes.first(tip, axis);
                    assert_eq!(
                        heard,
                        expected,
                        "{seed} {place:?} {sensor} {}",
                        model.name()
                    );
                    counts[usize::from(heard.is_some())] += 1;
                }
            }
        }
    }
    assert!(counts[0] > 100 && counts[1] > 4_000, "{counts:?}");
}

/// A wall that bends too little for a corner, its bend nearest, and another wall behind it: a ray
/// towards the hidden wall finds the bend better than the fan does.
#[test]
fn hidden_walls_guide_rays_as_in_the_reference() {
    let (config, axis) = (SonarModel::Nomad.config(), Point::new(1.0, 0.0));
    let (half, reach, tip) = (
        config.half_angle_rad,
        config.max_range_m,
        axis * FACE_RADIUS_M,
    );
    let (mut noise, mut guided) = (Noise::new(1), 0);
    for _ in 0..300 {
        let bearing = noise.uniform_in(-0.2, 0.2);
        let wall = |at: Point, bearing: f64, bend: f64| Shape::Wall {
            points: vec![
                at + Point::unit(bearing + FRAC_PI_2 - bend) * 0.8,
                at,
                at + Point::unit(bearing - FRAC_PI_2 + bend) * 0.8,
            ],
        };
        let bent = wall(tip + Point::unit(bearing) * 1.5, bearing, 0.004);
        let behind = bearing + noise.uniform_in(-0.01, 0.01);
        let hidden = wall(tip + Point::unit(behind) * 3.0, behind, 0.0);
        let [alone, both] = [vec![bent.clone()], vec![bent, hidden]].map(|shapes| {
            let world = World::new("test", Pose::default(), shapes).expect("a sound world");
            let mut hearing = Hearing::new(&config, half);
            let (mut lobe, cone) = (LobeView::default(), ConeShape::new(half));
            world.aim(&mut lobe, &lobe_at(Point::default(), axis, &config));
            let heard = hearing.first_echo(&world, &mut lobe, &config);
            let reference = Reference::of(&world);
            let echoes = Echoes {
                world: &reference,
                lobe: reference.lobe(tip, axis, cone, reach),
                config,
                answers: Vec::new(),
                offers: Vec::new(),
            };
            assert_eq!(heard, echoes.first(tip, axis), "{bearing} {behind}");
            heard
        });
        guided += u32::from(alone != both);
    }
    assert!(guided > 100, "{guided}");
}

/// A robot that comes again and again to the same places, its turret held and then turned.
#[test]
fn a_robot_that_comes_again_hears_what_the_reference_hears() {
    let config = SonarModel::Nomad.config();
    let cone = ConeShape::new(config.half_angle_rad);
    let mut heard_any = 0;
    for seed in 0..4 {
        let (world, places) = worlds(seed);
        let (reference, mut noise) = (Reference::of(&world), Noise::new(seed));
        let mut hearing = Hearing::new(&config, config.half_angle_rad);
        let mut views = vec![LobeView::default(); 8];
        for turn in [0.0, 0.3] {
            for walk in 0..60 {
                let middle = places[walk % 3]
                    + Point::unit(noise.uniform() * TAU) * noise.uniform_in(0.0, 1.2);
                for sensor in [0, 3, 5] {
                    let axis = Point::unit(TAU * sensor as f64 / 8.0 + turn);
                    let lobe = lobe_at(middle, axis, &config);
                    let view = &mut views[sensor];
                    world.aim(view, &lobe);
                    let heard = hearing.first_echo(&world, view, &config);
                    let echoes = Echoes {
                        world: &reference,
                        lobe: reference.lobe(lobe.tip, axis, cone, config.max_range_m),
                        config,
                        answers: Vec::new(),
                        offers: Vec::new(),
                    };
                    let expected = echoes.first(lobe.tip, axis);
                    assert_eq!(heard, expected, "{seed} {walk} {sensor} {turn}");
                    heard_any += u32::from(heard.is_some());
                }
            }
        }
    }
    assert!(heard_any > 1_000, "{heard_any}");
}
