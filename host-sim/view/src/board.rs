//! A board as a source: a mind whose ring and base are its own, at the end of a link.
//!
//! Over the link it says its mode, its decisions and, asked, what it knows; it says neither where it is nor what each sonar
//! has heard, so there is no arena. The session's clock is the board's: a link that falls silent stops the robot.

use super::choices::mind_file;
use super::goal::Pursued;
use super::order::{Done, Order};
use super::seen::{Knowing, meters, millimeters, plan_seen, ring};
use super::snapshot::{Counts, Now, Part, Scene, Short, Showable, Snapshot, Xy};
use super::source::{Abilities, Refused, Source, Stepped};
use super::trail::{Trail, mark};
use amp::config::{Choice, Config};
use amp::controller::Decision;
use amp::fixed::Weight;
use amp::planner::difference;
use amp::scan::Situation;
use amp::units::Displacement;
use amp::wire::FromMind;
use amp::wire::message::{self, GoalBy, ModeReport};
use arena::world::Point;
use files::hex::unhex;
use remote::link::{Knowledge, LinkError, Session};
use sim::behavior::Behavior;
use sim::episode::{Seeds, StepFlags};
use sim::pilot::SimState;
use std::sync::Arc;
use std::time::{Duration, Instant};

/// Time between two signs of life: a mind bears three times as long a silence.
const ALIVE: Duration = Duration::from_millis(100);

/// Signs of life, which are not answered, between two questions whether the mind is still there.
const CHECK: u32 = 10;

/// So many questions in a row may remain without an answer before the board counts as lost.
const MAX_SILENT: u32 = 3;

/// A board that is watched and steered.
pub struct Board {
    session: Session,
    name: String,
    config: Config<16>,
    known: Box<SimState>,
    explore_moves: u16,
    seed: u64,
    mode: ModeReport,
    goal: Pursued,
    nest: Option<Situation<16>>,
    decision: Option<Decision<16>>,
    before: Option<Situation<16>>,
    counts: Counts,
    trail: Trail,
    note: Option<String>,
    failure: Option<String>,
    checked: u32,
    /// Questions in a row that were not answered in time.
    silent: u32,
    time_s: f64,
    revision: u64,
    scene: Option<Arc<Part<Scene>>>,
    knowing: Knowing,
}

impl Board {
    /// The mind at the end of an open session by its own clock, called so; it explores with so many moves, and pursues this. It
    /// listens to sonars of its own; one that has none says so on the page.
    ///
    /// # Errors
    /// [`LinkError`].
    pub fn new(
        mut session: Session,
        name: String,
        explore_moves: u16,
        seed: u64,
        behavior: &Behavior,
    ) -> Result<Self, LinkError> {
        let note = match session.use_own_ring()? {
            true => None,
            false => Some("It has no sonars of its own: it will not move".to_owned()),
        };
        let mode = session.mode()?;
        let knowledge = Knowledge::read(&mut session)?;
        Ok(Self {
            session,
            name,
            config: knowledge.config().clone(),
            known: Box::new(knowledge.state().clone()),
            explore_moves,
            seed,
            mode,
            goal: Pursued::behavior(behavior),
            nest: None,
            decision: None,
            before: None,
            counts: Counts::default(),
            trail: Trail::latest(),
            note,
            failure: None,
            checked: 0,
            silent: 0,
            time_s: 0.0,
            revision: 0,
            scene: None,
            knowing: Knowing::default(),
        })
    }

    /// Listens for as long as a sign of life lasts. Returns whether something was decided.
    fn listen(&mut self) -> Result<bool, LinkError> {
        let until = Instant::now() + ALIVE;
        let at_ms = self.session.elapsed_ms();
        self.session.send_heartbeat(at_ms)?;
        let mut whole = false;
        while let Some(report) = self.session.next_report(until)? {
            whole |= self.take(&report.said);
        }
        self.checked += 1;
        if self.checked.is_multiple_of(CHECK) {
            let mode = self.session.mode()?;
            whole |= self.change(mode);
        }
        if whole {
            self.go_on()?;
        }
        if whole && !self.moves() {
            self.fetch()?;
        }
        Ok(whole)
    }

    fn take(&mut self, said: &FromMind<16>) -> bool {
        match said {
            FromMind::Decision(decision) => self.decide(decision),
            FromMind::Mode(mode) => return self.change(*mode),
            _ => return false,
        }
        true
    }

    fn change(&mut self, mode: ModeReport) -> bool {
        let before = std::mem::replace(&mut self.mode, mode);
        // A mode that is only said again keeps its note.
        if before != mode {
            self.note = match mode {
                ModeReport::Stopped(reason) => {
                    Some(format!("It stands: {}", sim::error::stop_reason(reason)))
                }
                _ => None,
            };
        }
        std::mem::discriminant(&before) != std::mem::discriminant(&mode)
    }

    fn decide(&mut self, decision: &Decision<16>) {
        self.nest.get_or_insert(decision.situation);
        self.before = self.decision.map(|before| before.situation);
        self.decision = Some(*decision);
        let stride = StepFlags {
            at_goal: decision.at_goal,
            shielded: decision.allowed != decision.wanted,
            touched: false,
            touched_by: false,
        };
        let neuron = decision.plan.map(|plan| usize::from(plan.current_neuron));
        let seeks = neuron.is_some();
        match seeks {
            true => self.counts.steps += 1,
            false => self.counts.explored[0] += 1,
        }
        self.counts.at_goal += u32::from(seeks && stride.at_goal);
        self.counts.shielded += u32::from(seeks && stride.shielded);
        let place = Point::default();
        self.trail
            .push(mark(self.time_s, place, seeks, stride, neuron, None));
    }

    /// Goes on to the next part of a chain when the present one is reached; after the last it stands.
    fn go_on(&mut self) -> Result<(), LinkError> {
        if self.mode != ModeReport::Seek {
            return Ok(());
        }
        match self.goal.go_on(self.counts.steps, self.counts.at_goal) {
            None => Ok(()),
            Some(true) => self.pursue(),
            Some(false) => self.order(message::Order::Stop),
        }
    }

    /// Fetches what it knows.
    fn fetch(&mut self) -> Result<(), LinkError> {
        let knowledge = Knowledge::read(&mut self.session)?;
        *self.known = knowledge.state().clone();
        self.config = knowledge.config().clone();
        self.knowing.forget();
        Ok(())
    }

    fn moves(&self) -> bool {
        !matches!(self.mode, ModeReport::Idle | ModeReport::Stopped(_))
    }

    fn order(&mut self, order: message::Order<16>) -> Result<(), LinkError> {
        let at_ms = self.session.elapsed_ms();
        let reports = self.session.command(at_ms, order)?;
        let mut changed = false;
        for report in &reports {
            changed |= self.take(&report.said);
        }
        if changed && !self.moves() {
            self.fetch()?;
        }
        Ok(())
    }

    fn pursue(&mut self) -> Result<(), LinkError> {
        let goal = self.goal.goal(&self.config, &self.nest());
        self.order(message::Order::Goal(GoalBy::Components(goal)))?;
        self.order(message::Order::Seek)
    }

    fn nest(&self) -> Situation<16> {
        self.nest.unwrap_or([Weight::ZERO; 16])
    }

    fn obey(&mut self, order: &Order) -> Result<Done, Refused> {
        if self.mode == ModeReport::Learn && *order != Order::Stop {
            return Err("it still learns".into());
        }
        match order {
            Order::Stop => self.order(message::Order::Stop)?,
            Order::Explore => self.order(message::Order::Explore {
                moves: self.explore_moves,
                seed: Seeds::of(self.seed).exploration,
            })?,
            Order::Learn => self.order(message::Order::Learn)?,
            Order::Seek => {
                self.goal.begin(self.counts.steps, self.counts.at_goal);
                self.pursue()?;
            }
            Order::Resume => self.order(message::Order::Resume)?,
            Order::Behavior { .. } | Order::GoalNeuron { .. } | Order::GoalFile { .. } => {
                let known = Some(&*self.known).filter(|known| known.has_learned());
                self.goal = Pursued::asked(order, (self.nest(), Point::default()), known)?;
                if self.mode == ModeReport::Seek {
                    self.obey(&Order::Seek)?;
                }
            }
            Order::SaveMind => return Ok(mind_file(&self.config, &self.known)),
            Order::LoadMind { hex } => {
                let bytes = unhex(hex).ok_or("the file did not arrive whole")?;
                Knowledge::from_bytes(&bytes)?.upload(&mut self.session)?;
                self.fetch()?;
                self.scene = None;
            }
            _ => return Err("that cannot be asked of a board".into()),
        }
        Ok(Done::Well)
    }

    fn scene(&mut self) -> Arc<Part<Scene>> {
        if let Some(scene) = &self.scene {
            return Arc::clone(scene);
        }
        let config = &self.config;
        let names = Behavior::NAMES.iter().filter(|name| **name != "follow");
        let about = |name: &&str| [(*name).to_owned(), Behavior::about(name).to_owned()];
        let scene = Scene {
            world: format!("board at {}", self.name),
            near_far_m: [config.encoding.near_mm, config.encoding.far_mm].map(millimeters),
            step_m: millimeters(config.robot.step_mm),
            seed: self.seed.to_string(),
            preset: "the board's own".to_owned(),
            sonar: "the board's own".to_owned(),
            turret: "as it is".to_owned(),
            moves: self.explore_moves,
            mind: self.name.clone(),
            recalls: config.planning.choice == Choice::Recall,
            abilities: self.abilities(),
            behaviors: names.map(about).collect(),
            ..Scene::default()
        };
        let scene = Arc::new(Part::new("scene", 0, self.revision, scene));
        self.scene = Some(Arc::clone(&scene));
        scene
    }

    fn now(&self) -> Now {
        let decision = self.decision;
        let plan = decision.and_then(|decision| decision.plan);
        let moved = |way: fn(&Decision<16>) -> Displacement| {
            decision
                .as_ref()
                .map_or(Xy::default(), |it| meters(way(it)))
        };
        let changed = decision.zip(self.before);
        let moves = f64::from(self.explore_moves.max(1));
        let (mode, done) = match self.mode {
            _ if self.failure.is_some() => ("failed", 0.0),
            ModeReport::Idle => ("idle", 0.0),
            ModeReport::Explore { left } => ("explore", 1.0 - f64::from(left) / moves),
            ModeReport::Learn => ("learn", 0.5),
            ModeReport::Seek => ("seek", 0.0),
            ModeReport::Stopped(_) => ("stopped", 0.0),
        };
        Now {
            time_s: Short(self.time_s),
            mode,
            why: self.failure.clone(),
            note: self.note.clone(),
            resumes: mode == "stopped",
            done: Short(done),
            on: std::array::from_fn(|sensor| self.config.believed.contains(sensor)),
            situation: decision.map_or_else(Default::default, |it| ring(&it.situation)),
            changed: changed.map(|(now, before)| ring(&difference(&now.situation, &before))),
            plan: plan.map(|plan| plan_seen(&plan, &self.known)),
            wanted_m: moved(|decision| decision.wanted),
            allowed_m: moved(|decision| decision.allowed),
            goal: self.goal.seen(&self.config, &self.nest(), Point::default()),
            counts: self.counts.clone(),
            shield: self.config.shield.is_some(),
            online: self.config.online.is_some(),
            link: Some(self.name.clone()),
            trail: self.trail.ends(),
            ..Now::default()
        }
    }
}

impl Source for Board {
    fn abilities(&self) -> Abilities {
        Abilities {
            drive: true,
            save: true,
            load: true,
            unplaced: true,
            ..Abilities::default()
        }
    }

    fn step(&mut self) -> Stepped {
        if self.failure.is_some() {
            return Stepped::Standing;
        }
        let whole = match self.listen() {
            Ok(whole) => {
                self.silent = 0;
                whole
            }
            // It may only be slow.
            Err(LinkError::Silent { .. }) if self.silent < MAX_SILENT => {
                self.silent += 1;
                false
            }
            Err(error) => {
                self.failure = Some(format!("{}: {error}", self.name));
                return Stepped::Standing;
            }
        };
        let now_s = f64::from(self.session.elapsed_ms()) / 1e3;
        let took_s = now_s - std::mem::replace(&mut self.time_s, now_s);
        Stepped::Took { took_s, whole }
    }

    fn carry_out(&mut self, order: &Order) -> Result<Done, Refused> {
        if let Some(why) = &self.failure {
            return Err(why.clone().into());
        }
        self.obey(order)
    }

    fn snapshot(&mut self) -> Snapshot {
        self.revision += 1;
        let learned = self.known.has_learned();
        let mut parts: Vec<Arc<dyn Showable>> = vec![self.scene()];
        let (revision, known) = (self.revision, &self.known);
        parts.extend(self.knowing.parts(revision, known, &self.config, learned));
        Snapshot {
            parts,
            now: Box::new(self.now()),
            trail: self.trail.parts().collect(),
            revision,
        }
    }

    fn steering_lost(&mut self, silence: Duration) {
        let drives = matches!(self.mode, ModeReport::Explore { .. } | ModeReport::Seek);
        if self.failure.is_some() || !drives {
            return;
        }
        match self.order(message::Order::Stop) {
            Ok(()) => {
                let seconds = silence.as_secs_f64();
                self.note = Some(format!(
                    "It stopped: no page has steered it for {seconds} s"
                ));
            }
            Err(error) => self.failure = Some(format!("{}: {error}", self.name)),
        }
    }

    /// The robot stands.
    fn end(&mut self) -> Result<(), String> {
        if self.failure.is_some() || !self.moves() {
            return Ok(());
        }
        let stopped = self.order(message::Order::Stop);
        stopped.map_err(|error| format!("{}: {error}", self.name))
    }
}
