//! No graph of traversed situations (without the feature `graph`): one step is planned at a time.

use super::State;
use crate::config::Config;
use crate::fixed::{Mask, Selection};
use crate::planner::Plan;
use crate::scan::Situation;

impl<const SENSORS: usize, const NEURONS: usize, const SAMPLES: usize>
    State<SENSORS, NEURONS, SAMPLES>
{
    #[inline(always)]
    pub(super) const fn traverse_memory(&mut self, _config: &Config<SENSORS>) {}

    #[inline(always)]
    pub(super) const fn interrupt_traversal(&mut self) {}

    #[inline(always)]
    pub(super) const fn forget_traversals(&mut self) {}

    #[inline(always)]
    pub(super) const fn traverse(
        &mut self,
        _config: &Config<SENSORS>,
        _enabled: Mask,
        _situation: &Situation<SENSORS>,
        current: Option<usize>,
    ) -> Option<usize> {
        current
    }

    #[inline(always)]
    pub(super) const fn plan_traversed<S: Selection>(
        &mut self,
        _config: &Config<SENSORS>,
        _enabled: Mask,
        _allowed: S,
        _situation: &Situation<SENSORS>,
        _current: Option<usize>,
    ) -> Option<Plan<SENSORS>> {
        None
    }
}
