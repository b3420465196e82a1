//! The flag for maps of other sizes.

use super::remote::MindChoice;
use super::run::RunArgs;
use clap::Args;
use files::error::BadInput;
use sim::episode::{NEURON_COUNTS, Setup};

/// Size of the maps.
#[derive(Debug, Clone, Copy, Args)]
pub struct NeuronArgs {
    /// Neurons of each map: 4, 9, 16, 25, 36, 49 or 64; other than 16 only on the Nomad's ring in
    /// this process, without pictures and files
    #[arg(long, value_name = "N", default_value_t = 16, value_parser = parsed)]
    pub(super) neurons: u8,
}

/// A number of neurons that maps may have.
///
/// # Errors
/// Any other text.
pub(super) fn parsed(text: &str) -> Result<u8, BadInput> {
    let number = text.parse().ok();
    let number = number.filter(|number| NEURON_COUNTS.contains(number));
    number.ok_or_else(|| {
        let numbers = NEURON_COUNTS.map(|number| number.to_string());
        BadInput::new(format!("a map has one of {} neurons", numbers.join(", ")))
    })
}

impl NeuronArgs {
    /// The number of neurons, if it is not the firmware's 16.
    pub(super) fn other(self) -> Option<u8> {
        Some(self.neurons).filter(|neurons| *neurons != 16)
    }

    /// Refuses what needs maps of 16 neurons.
    ///
    /// # Errors
    /// Another robot or another controller, pictures or files, with maps of another size.
    pub(super) fn check(self, run: &RunArgs, setup: &Setup) -> Result<(), BadInput> {
        let Some(neurons) = self.other() else {
            return Ok(());
        };
        let mind = run.mind.choice != MindChoice::Host;
        let needs = [
            (mind, "--mind"),
            (setup.robot.is_some(), "--robot and --places"),
            (run.out.is_some(), "--out"),
            (run.save.is_some(), "--save"),
            (run.log.is_some(), "--log"),
        ];
        match needs.into_iter().find(|(is_given, _)| *is_given) {
            Some((_, flag)) => Err(BadInput::new(format!(
                "--neurons {neurons}: not with {flag}, only with maps of 16 neurons"
            ))),
            None => Ok(()),
        }
    }
}
