//! Claims of sections 4 and 5.3: the arms of other authors, and pointing.

use super::{Claim, ClaimVerdict, percents};
use crate::paper::arms::{TARGETS, region_seeds};
use crate::paper::measure::Measured;
use sim::statistics::Mean;

/// The claims of section 4, in order.
pub(super) fn related_works(measured: &Measured) -> Vec<Claim> {
    vec![reaching(measured), second_behavior(measured)]
}

/// "Actually able to control the displacements of the robot arm."
fn reaching(measured: &Measured) -> Claim {
    let reaching = &measured.arms.reaching;
    let reached = reaching.reached.percent();
    Claim::new(
        "4",
        "able to control the displacements of the robot arm (Coiton et al.)",
    )
    .holds_if(
        "after 100 random moves the hand is within 2 % of the reach from ≥ 95 % of random targets \
         in at most 40 moves",
    )
    .measured(
        format!(
            "{} of the targets, in {:.1} moves",
            percents(reached.mean),
            reaching.moves.mean
        ),
        sample(measured.size.draws),
    )
    .verdict(ClaimVerdict::of(&[reached.mean >= 95.0]))
}

/// "Only one behavior is possible … in our approach any behavior can be generated."
fn second_behavior(measured: &Measured) -> Claim {
    let arms = &measured.arms;
    let [without, with] = [&arms.untold, &arms.around];
    let inside = |share: Mean| percents(share.percent().mean);
    let ratio = 100.0 * with.hand_inside.mean / without.hand_inside.mean.max(f64::MIN_POSITIVE);
    let is_avoided = with.hand_inside.mean <= 0.1 * without.hand_inside.mean;
    let is_reached = with.reached.mean >= 0.95 * without.reached.mean;
    Claim::new(
        "4",
        "only one behavior is possible; in our approach any behavior can be generated",
    )
    .holds_if(
        "the same memory serves a second goal, a region that the hand is to avoid: it enters in at \
         most a tenth as many reaches, and 95 % as many targets are reached",
    )
    .measured(
        format!(
            "the hand enters in {} of the reaches without this goal and in {} with it ({ratio:.1} % \
             as many), the arm in {} and {}; targets reached {} and {}",
            inside(without.hand_inside),
            inside(with.hand_inside),
            inside(without.link_inside),
            inside(with.link_inside),
            inside(without.reached),
            inside(with.reached)
        ),
        sample(region_seeds(measured.size)),
    )
    .verdict(ClaimVerdict::of(&[is_avoided, is_reached]))
}

/// "Small movements involved in pointing behaviors."
pub(super) fn pointing(measured: &Measured) -> Claim {
    let pointing = &measured.arms.pointing;
    let pointed = pointing.pointed.percent().mean;
    Claim::new(
        "5.3",
        "could be … the case of small movements involved in pointing behaviors",
    )
    .holds_if(
        "two couples of maps, of an eye and an arm, point at ≥ 95 % of random targets within 1° \
         after 100 random moves of each",
    )
    .measured(
        format!(
            "{} within 1°, median error {:.2}°, in {:.1} moves; nothing is said of cortices",
            percents(pointed),
            pointing.median_error_deg,
            pointing.moves.mean
        ),
        sample(measured.size.draws),
    )
    .verdict(ClaimVerdict::of(&[pointed >= 95.0]))
}

fn sample(seeds: u32) -> String {
    format!("{seeds} seeds × {TARGETS} targets")
}
