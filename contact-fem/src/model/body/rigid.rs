//! Bodies that do not deform: tools under forces and on springs.

use std::sync::Arc;

use nalgebra::{DMatrix, DVector};

use super::Body;
use super::law::Law;
use super::rollers::Share;
use crate::assembly::{BodyEnergy, RigidEnergy, add_body_force};
use crate::element::{Element, Order, P1, P2, RingP2};
use crate::error::Error;
use crate::mesh::Mesh;
use crate::model::courses::Part;
use crate::model::preflight::{modes, motion};
use crate::model::{BodyId, Problem};
use crate::program::samples;
use crate::tensor::{Vector, unit_vector};

/// A dof whose unit motion has less than this share beside the motions of the leaders adds no independent motion.
const HOLDS: f64 = 1e-7;
/// A coefficient of a dof in the motion of another one is round-off below this.
const ROUND_OFF: f64 = 1e-13;
/// Two supports that hold a motion may differ by this share of their values.
const SAME: f64 = 1e-9;

/// How a rigid body may move.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::model) struct Rigid {
    /// Whether it turns, by small angles.
    pub turns: bool,
}

/// How far a rigid body has moved.
#[derive(Clone, Debug, PartialEq)]
pub struct RigidMotion<const D: usize> {
    /// The body.
    pub body: BodyId,
    /// The displacement of the middle of its bounding box (UL).
    pub displacement: Vector<D>,
    /// The angles by which it has turned about the axes (radians): one in the plane, three in space; empty if it does not turn.
    pub rotation: Vec<f64>,
}

/// No law: nothing is strained.
struct RigidLaw<E>(E);

impl<const D: usize, E: Element<D>> Law<D> for RigidLaw<E> {
    fn is_small_strain(&self) -> bool {
        true
    }

    fn locks(&self) -> bool {
        false
    }

    fn rest_moduli(&self) -> (f64, f64) {
        (f64::INFINITY, f64::INFINITY)
    }

    fn slopes(&self) -> [f64; 2] {
        [0.0; 2]
    }

    fn energy(&self, body: &Body<D>) -> Box<dyn BodyEnergy<D>> {
        let (dofs, prescribed) = body.eliminated();
        let facets = body.mesh.exterior();
        let coupled = facets.filter(|_| body.acts_on_boundary());
        let forces = body.forces.clone();
        Box::new(RigidEnergy::new::<D>(dofs, prescribed, forces, coupled))
    }

    fn add_body_force(
        &self,
        mesh: &Mesh<D>,
        force: &dyn Fn(&Vector<D>) -> Vector<D>,
        forces: &mut [f64],
    ) {
        add_body_force::<D, E>(mesh, force, forces);
    }
}

impl Body<2> {
    /// A [rigid body](Body::rigid) of revolution, as [`Body::of_revolution`]: it moves along the axis.
    ///
    /// # Errors
    /// [`Error::NegativeRadius`]: a node with r < 0 by more than round-off.
    pub fn rigid_of_revolution(mesh: Mesh<2>) -> Result<Self, Error> {
        let (mesh, _) = mesh.revolved()?;
        let law: Arc<dyn Law<2>> = match mesh.order() {
            Order::Linear => Arc::new(RigidLaw(P1)),
            Order::Quadratic => Arc::new(RigidLaw(RingP2)),
        };
        let mut body = Body::of(mesh, law);
        body.rigid = Some(Rigid { turns: false });
        let all: Vec<usize> = (0..body.mesh.nodes().len()).collect();
        body.hold(("all radii", &all), [Some(0.0), None], 0)?;
        Ok(body)
    }
}

/// The dofs that a dof of a rigid body follows, with coefficients.
type Led = Vec<(usize, f64)>;

impl<const D: usize> Body<D> {
    /// A body that does not deform and does not turn: a tool under a force, a weight or a pressure, or on springs, in place of a given
    /// motion. Its unknowns are the components of one displacement; how far it moves is [`StepRecord::rigid_motions`](crate::StepRecord::rigid_motions).
    ///
    /// A support of any of its nodes holds a component of the whole body: that is how it is guided. What would turn it is taken by its
    /// guides. A displacement that is prescribed drives it.
    ///
    /// A rigid plate is pressed by 3 onto a block whose sides are guided, so that it gives way by σ/E' of its height 1:
    /// ```
    /// use contact_fem::mesh::generators::{Diagonals, linspace, rectangle};
    /// use contact_fem::{Body, LinearElastic, Scene, Simulation};
    ///
    /// # fn main() -> Result<(), contact_fem::Error> {
    /// let mesh = |y, ny| rectangle(&linspace(0.0, 1.0, ny), &linspace(y, y + 1.0, ny), Diagonals::Rising);
    /// let mut block = Body::new(mesh(0.0, 4)?, LinearElastic::new(200.0, 0.0)?);
    /// block.symmetry("bottom")?.symmetry("left")?;
    /// let mut plate = Body::rigid(mesh(1.0, 3)?);
    /// plate.prescribe("left", [Some(0.0), None])?.traction("top", [0.0, -3.0])?;
    ///
    /// let mut scene = Scene::new();
    /// let (block, plate) = (scene.add("block", block), scene.add("plate", plate));
    /// scene.contact(block.on("top"), plate.on("bottom"))?;
    /// let history = Simulation::with_increments(1).run(&mut scene.problem()?)?;
    /// let moved = &history.steps[0].rigid_motions[0];
    /// assert_eq!(moved.body, plate);
    /// assert!((moved.displacement[1] + 3.0 / 200.0).abs() < 1e-9);
    /// # Ok(())
    /// # }
    /// ```
    pub fn rigid(mesh: Mesh<D>) -> Self
    where
        P1: Element<D>,
        P2: Element<D>,
    {
        Body::of_rigid(mesh, Rigid { turns: false })
    }

    /// As [`Body::rigid`], and it turns by small angles: a plate that tilts, a roller under a torque. Nodes move by q + θ × (X − X₀), which is a
    /// rotation to first order alone, so that contact must be looked for at the reference positions
    /// ([`Geometry::Reference`](crate::model::Geometry::Reference)).
    pub fn rigid_turning(mesh: Mesh<D>) -> Self
    where
        P1: Element<D>,
        P2: Element<D>,
    {
        Body::of_rigid(mesh, Rigid { turns: true })
    }

    fn of_rigid(mesh: Mesh<D>, rigid: Rigid) -> Self
    where
        P1: Element<D>,
        P2: Element<D>,
    {
        let law: Arc<dyn Law<D>> = match mesh.order() {
            Order::Linear => Arc::new(RigidLaw(P1)),
            Order::Quadratic => Arc::new(RigidLaw(P2)),
        };
        let mut body = Body::of(mesh, law);
        body.rigid = Some(rigid);
        body.follow();
        body
    }

    /// Whether it does not deform.
    pub fn is_rigid(&self) -> bool {
        self.rigid.is_some()
    }

    /// Whether it does not deform, and turns by small angles.
    pub(in crate::model) fn turns(&self) -> bool {
        self.rigid.is_some_and(|rigid| rigid.turns)
    }

    /// Finds anew which dofs of a rigid body follow which.
    ///
    /// # Errors
    /// If supports prescribe displacements that no rigid motion has.
    pub(super) fn follow_supports(&mut self) -> Result<(), Error> {
        if self.is_rigid() {
            let led = self.follow();
            self.agree_with(&led)?;
        }
        Ok(())
    }

    /// Lets all dofs follow some of them, the leaders, which are held dofs as far as there are any. The result has the leaders of each dof.
    fn follow(&mut self) -> Vec<Led> {
        let dofs = self.prescribed.len();
        let held: Vec<_> = (0..dofs)
            .map(|dof| self.declared_at_all_times(dof))
            .collect();
        let motions = self.motions();
        let leads = leaders(
            &motions,
            &held.iter().map(Option::is_some).collect::<Vec<_>>(),
        );
        let led = followed(&motions, &leads);
        self.rollers.ties.clear();
        self.rollers.shares.clear();
        for dof in 0..dofs {
            let own = led[dof].iter();
            let by_support: Vec<(usize, f64)> = own
                .clone()
                .filter(|(p, _)| held[*p].is_some())
                .copied()
                .collect();
            let free: Vec<(usize, f64)> =
                own.filter(|(p, _)| held[*p].is_none()).copied().collect();
            let value = match held[dof] {
                Some((value, _)) => Some(value),
                None if leads.contains(&dof) => None,
                None => {
                    let part = |&(p, factor): &(usize, f64)| {
                        let (value, _) = held[p]?;
                        Some(Part {
                            factor,
                            dof: p,
                            value,
                        })
                    };
                    let parts: Vec<Part> = by_support.iter().filter_map(part).collect();
                    Some(self.supports.combined(&parts))
                }
            };
            self.supports.values[dof] = value;
            self.prescribed[dof] = value.map(|value| self.supports.value(dof, value, 1.0));
            self.support_of[dof] = held[dof].map(|(_, name)| name);
            let shares = self.rollers.shares.entry(dof / D).or_default();
            if value.is_some() {
                let share = |&(p, share): &(usize, f64)| {
                    let (_, name) = held[p]?;
                    Some(Share {
                        name,
                        dof: p,
                        prescribed: dof,
                        share,
                    })
                };
                shares.extend(by_support.iter().filter_map(share));
                if held[dof].is_none() && !free.is_empty() {
                    self.rollers.ties.insert(dof, free);
                }
            }
        }
        led
    }

    /// # Errors
    /// If supports prescribe displacements that no rigid motion has.
    fn agree_with(&self, led: &[Led]) -> Result<(), Error> {
        for (dof, own) in led.iter().enumerate() {
            let Some((value, name)) = self.declared_at_all_times(dof) else {
                continue;
            };
            for t in samples().rev() {
                let at = |dof, value| self.supports.course_at(dof, value, t);
                let (mut sum, mut size, mut other) = (0.0, 0.0, name);
                for (p, c) in own {
                    if let Some((value, name)) = self.declared_at_all_times(*p) {
                        sum += c * at(*p, value);
                        size += (c * at(*p, value)).abs();
                        other = name;
                    }
                }
                let second = at(dof, value);
                if (sum - second).abs() > SAME * size.max(second.abs()) {
                    if other == name {
                        return Err(Error::NotRigid {
                            what: "a support that turns or deforms it",
                            remedy: "move all of its nodes alike; what is turned is an obstacle with a motion, or an elastic body all of whose nodes have it",
                        });
                    }
                    let on = [other, name].map(|name| self.supported[name].as_str());
                    let along = (dof / D, unit_vector(dof % D));
                    return Err(self.conflict(along, on, [sum, second], t));
                }
            }
        }
        Ok(())
    }

    /// The motion of its nodes, displaced by `U` (UL).
    fn moved(&self, id: BodyId, U: &[Vector<D>]) -> RigidMotion<D> {
        let motions = self.motions();
        let all = DVector::from_iterator(self.prescribed.len(), U.iter().flatten().copied());
        let normal = motions.transpose() * &motions;
        let amounts = normal.lu().solve(&(motions.transpose() * all));
        let amounts = amounts.unwrap_or_else(|| DVector::from_element(motions.ncols(), f64::NAN));
        let (low, high) = self.mesh.bounding_box();
        // the motions after the translations turn x to y, x to z and y to z the other way round, in units of the extent
        let turn = |(k, sign): (usize, f64)| sign * amounts[D + k] / (high - low).norm();
        let about: &[(usize, f64)] = match (self.turns(), D) {
            (false, _) => &[],
            (true, 2) => &[(0, -1.0)],
            (true, _) => &[(2, -1.0), (1, 1.0), (0, -1.0)],
        };
        RigidMotion {
            body: id,
            displacement: Vector::from_fn(|i, _| amounts[i]),
            rotation: about.iter().copied().map(turn).collect(),
        }
    }

    /// What each dof is in the motions that the body may have: translations, and rotations about its middle in units of its extent.
    fn motions(&self) -> DMatrix<f64> {
        let (low, high) = self.mesh.bounding_box();
        let centre = (low + high) * 0.5;
        let extent = (high - low).norm();
        let count = match self.turns() {
            true => modes::<D>(false),
            false => D,
        };
        let X = self.mesh.nodes();
        DMatrix::from_fn(self.prescribed.len(), count, |dof, k| {
            motion::<D>(k, &((X[dof / D] - centre) / extent), dof % D)
        })
    }
}

impl<const D: usize> Problem<D> {
    /// How far each rigid body has moved at `u`.
    pub fn rigid_motions(&self, u: &[f64]) -> Vec<RigidMotion<D>> {
        let bodies = self.scene().ids().zip(self.scene().bodies());
        let mut rigid = bodies.filter(|(_, body)| body.is_rigid()).peekable();
        if rigid.peek().is_none() {
            return Vec::new();
        }
        let U = self.displacements(u);
        let moved = |(id, body): (BodyId, &Body<D>)| body.moved(id, &U[self.nodes(id)]);
        rigid.map(moved).collect()
    }
}

/// The leaders, which all dofs follow, one for each independent motion: held dofs come first, and of equal rank the dof that has most of what is left
/// of the motions.
fn leaders(motions: &DMatrix<f64>, held: &[bool]) -> Vec<usize> {
    let mut left = motions.clone();
    let mut leads = Vec::new();
    for is_held in [true, false] {
        while leads.len() < motions.ncols() {
            let own = (0..held.len()).filter(|dof| held[*dof] == is_held);
            let norms = own.map(|dof| (dof, left.row(dof).norm()));
            // the first of equal ones
            let largest = norms.fold(
                (0, HOLDS),
                |most, own| if own.1 > most.1 { own } else { most },
            );
            let (dof, norm) = largest;
            if norm <= HOLDS {
                break;
            }
            let unit = left.row(dof).transpose() / norm;
            let along = &left * &unit;
            left -= along * unit.transpose();
            leads.push(dof);
        }
    }
    leads
}

/// For each dof the coefficients of the leaders in its motion.
fn followed(motions: &DMatrix<f64>, leads: &[usize]) -> Vec<Led> {
    // rows of the leaders span those of all
    let P = motions.select_rows(leads);
    let gram = (&P * P.transpose()).lu();
    let of_dof = |dof: usize| -> Led {
        if leads.contains(&dof) {
            return vec![(dof, 1.0)];
        }
        let row: DVector<f64> = &P * motions.row(dof).transpose();
        let shares = gram
            .solve(&row)
            .unwrap_or_else(|| DVector::zeros(leads.len()));
        let all = leads.iter().copied().zip(shares.iter().copied());
        all.filter(|(_, c)| c.abs() > ROUND_OFF).collect()
    };
    (0..motions.nrows()).map(of_dof).collect()
}
