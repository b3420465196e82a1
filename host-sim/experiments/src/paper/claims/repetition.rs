//! Claims of section 2.4 (and the abstract): a behavior improves by repetition.

use super::{Claim, ClaimVerdict};
use crate::paper::measure::Measured;
use crate::repetition::Curve;
use crate::scenes::BehaviorScene;
use sim::statistics::Mean;

/// The claims about repetition.
pub(super) fn claims(measured: &Measured) -> [Claim; 2] {
    let curves = &measured.repetitions;
    let sample = format!(
        "{} scenes of default, {} episodes each, {} repetitions after 100 random moves",
        curves.len(),
        measured.size.worlds * measured.size.seeds,
        measured.size.times
    );
    let [gains, against_frozen] = [|curve: &Curve| curve.gain, |curve: &Curve| curve.difference]
        .map(|of: fn(&Curve) -> Mean| {
            let changes = curves
                .iter()
                .map(|(scene, curve)| Change::of(scene, of(curve)));
            changes.collect::<Vec<_>>()
        });
    let helped = |changes: &[Change]| -> Vec<bool> {
        changes.iter().map(|change| change.sign > 0).collect()
    };
    [
        Claim::new("2.4", "the behavior performance will improve with repetition")
            .holds_if("later repetitions (last half) better than the first, paired (95 % interval), in every scene")
            .measured(counted(&gains), sample.clone())
            .verdict(ClaimVerdict::of(&helped(&gains))),
        Claim::new("2.4", "learning occurs by the mere realization of the behavior")
            .holds_if("maps that keep learning do better than frozen ones (last half, paired, 95 % interval), in every scene")
            .measured(counted(&against_frozen), sample)
            .verdict(ClaimVerdict::of(&helped(&against_frozen))),
    ]
}

/// A change of a scene's measure between repetitions.
struct Change {
    /// Better (1), worse (−1), or not significant (0).
    sign: i8,
    text: String,
}

impl Change {
    fn of(scene: &BehaviorScene, change: Mean) -> Self {
        let [low, high] = change.interval;
        let up = i8::from(low > 0.0) - i8::from(high < 0.0);
        // An error is better when it is smaller.
        let is_error = scene.measure.starts_with("error");
        Self {
            sign: if is_error { -up } else { up },
            text: format!("{} {:+.3} {}", scene.title(), change.mean, scene.measure),
        }
    }
}

fn counted(changes: &[Change]) -> String {
    let of = |sign: i8| {
        let texts = changes.iter().filter(|change| change.sign == sign);
        texts.map(|change| change.text.as_str()).collect::<Vec<_>>()
    };
    let listed = |texts: Vec<&str>| match texts.len() {
        0 => "0".to_owned(),
        count => format!("{count} ({})", texts.join("; ")),
    };
    format!(
        "of {} scenes {} better, {} worse",
        changes.len(),
        listed(of(1)),
        listed(of(-1))
    )
}
