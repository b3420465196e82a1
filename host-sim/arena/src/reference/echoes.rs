//! The first echo of a transducer compared with the reference model, bit by bit.

use super::worlds::{test_world, test_world_with_post};
use super::{Reference, ReferenceHit, ReferenceLobe};
use crate::caster::{ConeShape, LobeView, SonarLobe};
use crate::geometry::{Point, Pose};
use crate::noise::Noise;
use crate::nomad::FACE_RADIUS_M;
use crate::shapes::Shape;
use crate::sonar::{Hearing, SonarConfig, SonarModel};
use crate::world::World;
use core::f64::consts::{FRAC_PI_2, TAU};

/// The first echo of a transducer by casting every ray.
struct EchoSearch<'a> {
    world: &'a Reference,
    aimed: SonarLobe,
    lobe: ReferenceLobe,
    config: SonarConfig,
    /// Number and nearest echo of each surface, m.
    surface_echoes: Vec<(f64, f64)>,
    ranges: Vec<f64>,
}

impl<'a> EchoSearch<'a> {
    fn new(world: &'a Reference, aimed: &SonarLobe, config: SonarConfig) -> Self {
        Self {
            world,
            aimed: *aimed,
            lobe: world.lobe(aimed.tip, aimed.axis, aimed.cone, config.max_range_m),
            config,
            surface_echoes: Vec::new(),
            ranges: Vec::new(),
        }
    }

    fn returns_echo(&self, hit: &ReferenceHit) -> bool {
        hit.number >= 1e9 || hit.cos_incidence >= libm::cos(self.config.max_incidence_rad)
    }

    fn follow_ray(&mut self, direction: Point, bounces: usize) {
        let Some(hit) = self.lobe.cast(direction) else {
            return;
        };
        if self.returns_echo(&hit) {
            match self
                .surface_echoes
                .iter_mut()
                .find(|(known, _)| *known == hit.number)
            {
                Some((_, nearest)) => *nearest = nearest.min(hit.distance_m),
                None => self.surface_echoes.push((hit.number, hit.distance_m)),
            }
            return;
        }
        let (mut at, mut direction, mut hit) = (self.aimed.tip, direction, hit);
        let mut total_m = hit.distance_m;
        for _ in 0..bounces {
            at = at + direction * hit.distance_m;
            direction = direction - hit.normal * (2.0 * direction.dot(hit.normal));
            let Some(next) = self.world.cast(at, direction) else {
                return;
            };
            total_m += next.distance_m;
            if self.returns_echo(&next) {
                return self.ranges.push(total_m);
            }
            hit = next;
        }
    }

    fn first_echo(mut self) -> Option<f64> {
        let axis = self.aimed.axis;
        let half = self.config.half_angle_rad;
        let step = 2.0 * half / (self.config.fan_rays - 1) as f64;
        for ray in 0..self.config.fan_rays {
            let direction = Point::unit(step * ray as f64 - half).turned(axis);
            self.follow_ray(direction, self.config.bounces);
        }
        for direction in self.lobe.promising() {
            if direction.dot(axis) >= libm::cos(half) {
                self.follow_ray(direction, 0);
            }
        }
        for &corner in &self.lobe.corners {
            let range = corner.length();
            let towards = if range > 0.0 {
                corner * (1.0 / range)
            } else {
                axis
            };
            let hides = |hit: ReferenceHit| hit.distance_m < range - 1e-6;
            if !self.lobe.cast(towards).is_some_and(hides) {
                self.ranges.push(range);
            }
        }
        self.ranges
            .extend(self.surface_echoes.iter().map(|(_, range)| *range));
        let limits = self.config.blanking_m..=self.config.max_range_m;
        let in_limits = self
            .ranges
            .into_iter()
            .filter(|range| limits.contains(range));
        in_limits.reduce(f64::min)
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
fn echoes_equal_the_reference() {
    let mut counts = [0, 0];
    for seed in 0..32 {
        let (world, places) = test_world_with_post(seed);
        let (reference, mut noise) = (Reference::new(&world), Noise::new(seed));
        for model in [SonarModel::Nomad, SonarModel::Harsh] {
            let config = model.config();
            let mut hearing = Hearing::new(&config, config.half_angle_rad);
            let mut lobes = vec![LobeView::default(); 8];
            for &place in &places {
                for sensor in 0..8 {
                    let off = if seed % 3 == 0 { noise.uniform() } else { 0.0 };
                    let axis = Point::unit(TAU * f64::from(sensor) / 8.0 + off);
                    let lobe = &mut lobes[sensor as usize];
                    world.aim(lobe, &lobe_at(place, axis, &config));
                    let echo = hearing.first_echo(&world, lobe, &config);
                    let expected =
                        EchoSearch::new(&reference, &lobe_at(place, axis, &config), config)
                            .first_echo();
                    assert_eq!(echo, expected, "{seed} {place:?} {sensor} {}", model.name());
                    counts[usize::from(echo.is_some())] += 1;
                }
            }
        }
    }
    assert!(counts[0] > 100 && counts[1] > 4_000, "{counts:?}");
}

/// A wall with a bend too small for a corner hides another wall. The ray towards the hidden wall
/// hits nearer to the bend than the rays of the fan.
#[test]
fn rays_towards_hidden_walls_equal_the_reference() {
    let (config, axis) = (SonarModel::Nomad.config(), Point::new(1.0, 0.0));
    let (half, tip) = (config.half_angle_rad, axis * FACE_RADIUS_M);
    let (mut noise, mut differing) = (Noise::new(1), 0);
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
            let mut lobe = LobeView::default();
            world.aim(&mut lobe, &lobe_at(Point::default(), axis, &config));
            let echo = hearing.first_echo(&world, &mut lobe, &config);
            let reference = Reference::new(&world);
            let aimed = lobe_at(Point::default(), axis, &config);
            let expected = EchoSearch::new(&reference, &aimed, config).first_echo();
            assert_eq!(echo, expected, "{bearing} {behind}");
            echo
        });
        differing += u32::from(alone != both);
    }
    assert!(differing > 100, "{differing}");
}

/// A robot returns to the same positions, first with a held turret, then with a turned one.
#[test]
fn echoes_of_returning_robots_equal_the_reference() {
    let config = SonarModel::Nomad.config();
    let mut echo_count = 0;
    for seed in 0..4 {
        let (world, places) = test_world(seed);
        let (reference, mut noise) = (Reference::new(&world), Noise::new(seed));
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
                    let echo = hearing.first_echo(&world, view, &config);
                    let expected = EchoSearch::new(&reference, &lobe, config).first_echo();
                    assert_eq!(echo, expected, "{seed} {walk} {sensor} {turn}");
                    echo_count += u32::from(echo.is_some());
                }
            }
        }
    }
    assert!(echo_count > 1_000, "{echo_count}");
}
