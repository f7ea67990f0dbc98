//! What the run of a scene file records.

use std::path::PathBuf;

use contact_core::Equilibrium;
use contact_fem::model::Problem;
use contact_fem::output::record::Recording;
use contact_fem::tensor::Vector;
use contact_fem::{BodyId, Simulation, StepRecord};

use super::keys::{BodyKeys, ReactionKeys};
use super::place::Place;
use super::{Error, SceneFile};

impl SceneFile {
    /// Records a run of this file to `folder`, with the file's `output`.
    ///
    /// # Errors
    /// A reaction of bodies or boundaries that there are not, or along no direction.
    pub fn record<'a, const D: usize, S: Equilibrium>(
        &self,
        simulation: &'a mut Simulation<S>,
        problem: &Problem<D>,
        folder: impl Into<PathBuf>,
    ) -> Result<Recording<'a, D, S>, Error> {
        let output = &self.keys.output;
        let mut recording = simulation.record(folder);
        let plan = &mut recording.plan;
        let place = self.place().key("output");
        if let Some(name) = &output.name {
            plan.name.clone_from(name);
            checked(&place.key("name"), plan.check())?;
        }
        if let Some(picture) = &output.picture {
            plan.picture.clone_from(picture);
            checked(&place.key("picture"), plan.check())?;
        }
        plan.vtu_every = output.vtu_every.unwrap_or(plan.vtu_every);
        plan.half_way = output.half_way.unwrap_or(plan.half_way);
        match &output.reaction {
            None => Ok(recording),
            Some(keys) => Ok(recording.force(self.reaction(keys, problem)?)),
        }
    }

    /// The force of the supports of some bodies, or of their supports on one boundary, and of what holds or moves some obstacles, along a
    /// direction.
    fn reaction<const D: usize>(
        &self,
        keys: &ReactionKeys,
        problem: &Problem<D>,
    ) -> Result<impl Fn(&StepRecord<D>) -> f64 + use<D>, Error> {
        let place = self.place().key("output").key("reaction");
        if keys.of.is_empty() {
            let what = "is empty: name the bodies whose supports count, or obstacles";
            return Err(place.key("of").wrong(what));
        }
        let scene = problem.scene();
        let (names, obstacles) = (scene.names(), scene.obstacle_names());
        let (mut of, mut tools) = (Vec::new(), Vec::new());
        for (k, asked) in keys.of.iter().enumerate() {
            if keys.of[..k].contains(asked) {
                let what = format!("names `{asked}` twice: leave one of them out");
                return Err(place.key("of").wrong(what));
            }
            let number = |names: &[String]| names.iter().position(|name| name == asked);
            match (number(names), number(obstacles)) {
                (Some(body), _) => of.push(BodyId::from(body)),
                (None, Some(obstacle)) => tools.push(obstacle),
                (None, None) => {
                    let others = match obstacles {
                        [] => String::new(),
                        _ => format!(" and the obstacles {obstacles:?}"),
                    };
                    let what = format!(
                        "there is no body or obstacle `{asked}`: there are the bodies {names:?}{others}"
                    );
                    return Err(place.key("of").wrong(what));
                }
            }
        }
        let at = place.key("along");
        let along = Vector::<D>::from(at.vector(&keys.along)?);
        // of any length: its square may overflow, or vanish
        let largest = along.amax();
        let unit = (largest > 0.0).then(|| (along / largest).normalize());
        let unit = unit.ok_or_else(|| {
            at.wrong("has no length: give the direction along which the force is measured")
        })?;
        let on = keys.on.as_ref().map(ToString::to_string);
        if let Some(on) = &on {
            if let Some(&tool) = tools.first() {
                return Err(place.key("on").wrong(format!(
                    "obstacle `{}` has no supports on `{on}`: leave `on` or the obstacle out",
                    obstacles[tool]
                )));
            }
            let bodies = self
                .keys
                .body
                .iter()
                .filter(|own| keys.of.contains(&own.name));
            let is_held = |own: &BodyKeys| {
                let supports = own
                    .supports
                    .iter()
                    .filter_map(|support| support.on.as_ref());
                supports
                    .chain(&own.symmetry)
                    .chain(own.foundations.iter().map(|own| &own.on))
                    .any(|name| name.to_string() == *on)
            };
            if !bodies.into_iter().any(is_held) {
                return Err(place.key("on").wrong(format!(
                    "no support of these bodies is on `{on}`: name a boundary that `supports`, `symmetry` or `foundations` name, or leave `on` out"
                )));
            }
        }
        Ok(move |record: &StepRecord<D>| match &on {
            None => {
                let supports = of.iter().map(|&body| record.reaction(body));
                // what the bodies do to an obstacle, its drive does the other way round
                let drives = tools.iter().map(|&tool| -record.obstacle_forces[tool]);
                supports.chain(drives).map(|force| force.dot(&unit)).sum()
            }
            Some(on) => {
                let all = record.support_reactions.iter();
                let own = all.filter(|(side, _)| side.boundary == *on && of.contains(&side.body));
                own.map(|(_, force)| force.dot(&unit)).sum()
            }
        })
    }
}

/// What is wrong with the name of a file, whose folder is not known yet.
fn checked(place: &Place<'_>, names: Result<(), contact_fem::Error>) -> Result<(), Error> {
    match names {
        Err(contact_fem::Error::Write { source, .. }) => Err(place.wrong(source.to_string())),
        names => place.of(names),
    }
}
