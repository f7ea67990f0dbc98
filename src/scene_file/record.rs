//! What the run of a scene file records.

use std::path::PathBuf;

use contact_core::Equilibrium;
use contact_fem::model::Problem;
use contact_fem::output::record::Recording;
use contact_fem::tensor::Vector;
use contact_fem::{BodyId, Simulation, StepRecord};

use super::keys::ReactionKeys;
use super::{Error, SceneFile};

impl SceneFile {
    /// Records a run of this file to `folder`, with the file's `output`.
    ///
    /// # Errors
    /// A reaction of bodies that there are not, or along no direction.
    pub fn record<'a, const D: usize, S: Equilibrium>(
        &self,
        simulation: &'a mut Simulation<S>,
        problem: &Problem<D>,
        folder: impl Into<PathBuf>,
    ) -> Result<Recording<'a, D, S>, Error> {
        let output = &self.keys.output;
        let mut recording = simulation.record(folder);
        let plan = &mut recording.plan;
        if let Some(name) = &output.name {
            plan.name.clone_from(name);
        }
        if let Some(picture) = &output.picture {
            plan.picture.clone_from(picture);
        }
        plan.vtu_every = output.vtu_every.unwrap_or(plan.vtu_every);
        plan.half_way = output.half_way.unwrap_or(plan.half_way);
        match &output.reaction {
            None => Ok(recording),
            Some(keys) => Ok(recording.force(self.reaction(keys, problem)?)),
        }
    }

    /// The force of the supports of some bodies along a direction.
    fn reaction<const D: usize>(
        &self,
        keys: &ReactionKeys,
        problem: &Problem<D>,
    ) -> Result<impl Fn(&StepRecord<D>) -> f64 + use<D>, Error> {
        let place = self.place().key("output").key("reaction");
        let names = problem.scene().names();
        let of: Result<Vec<BodyId>, Error> = keys
            .of
            .iter()
            .map(|body| {
                let index = names.iter().position(|name| name == body);
                let unknown = || {
                    place
                        .key("of")
                        .wrong(format!("there is no body `{body}`: there are {names:?}"))
                };
                index.map(BodyId::from).ok_or_else(unknown)
            })
            .collect();
        let of = of?;
        let along = Vector::<D>::from(place.key("along").vector(&keys.along)?);
        Ok(move |record: &StepRecord<D>| {
            of.iter()
                .map(|&body| record.reaction(body).dot(&along))
                .sum()
        })
    }
}
