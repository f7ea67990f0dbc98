//! Bodies: mesh, material law, supports and loads.

mod boundary;
mod held;
mod law;
mod loads;
mod revolution;
mod rigid;
mod rollers;
mod supports;

use std::sync::Arc;

use super::courses::{Load, Origin, Supports};
use crate::assembly::{BodyEnergy, Laws, Tied};
use crate::element::{Element, Order, P1, P2};
use crate::error::Error;
use crate::material::{Material, Volumetric};
use crate::mesh::Mesh;
use crate::program::samples_with;
use crate::tensor::Vector;
use law::{AveragedLaw, ElasticLaw, Law};

pub(super) use boundary::{Foundation, Pressure};
pub(super) use held::Holding;
pub use rigid::RigidMotion;
pub use supports::{ALL_NODES, name_of_nodes};

/// An elastic body: a mesh, a material law, prescribed displacements and loads.
///
/// ```
/// use contact_fem::mesh::generators::cuboid;
/// use contact_fem::{Body, NeoHookean};
///
/// # fn main() -> Result<(), contact_fem::Error> {
/// let beam = cuboid([0.0; 3], [4.0, 1.0, 1.0], [8, 2, 2])?;
/// let mut beam = Body::new(beam.quadratic(), NeoHookean::new(1000.0, 0.3)?);
/// beam.prescribe("left", [Some(0.0); 3])?;
/// beam.traction("right", [0.0, 0.0, -2.5])?;
///
/// // nodal forces have the resultant of the traction, on an area of 1, and its moment about X = (0, ½, ½)
/// let (mut force, mut moment) = ([0.0; 3], 0.0);
/// for (X, f) in beam.mesh().nodes().iter().zip(beam.forces().chunks(3)) {
///     force = [0, 1, 2].map(|i| force[i] + f[i]);
///     moment += X[0] * f[2] - (X[2] - 0.5) * f[0];
/// }
/// assert!(force[0].abs() + force[1].abs() + (force[2] + 2.5).abs() < 1e-12);
/// assert!((moment + 4.0 * 2.5).abs() < 1e-12);
/// # Ok(())
/// # }
/// ```
#[derive(Clone)]
pub struct Body<const D: usize> {
    mesh: Mesh<D>,
    law: Arc<dyn Law<D>>,
    supports: Supports<D>,
    /// The displacement prescribed for each dof at load factor 1 (UL), if any.
    prescribed: Vec<Option<f64>>,
    /// The boundaries that supports name, in the order in which they were, and for each prescribed dof the first that did;
    /// supports of nodes have names of their own.
    supported: Vec<String>,
    support_of: Vec<Option<usize>>,
    /// All of them, and when they hold.
    declared: held::Declarations,
    /// Nodes that slide along planes of any direction.
    rollers: rollers::Rollers<D>,
    /// How it moves if it does not deform.
    rigid: Option<rigid::Rigid>,
    /// All loads with their origin, and the sum of the proportional ones at load factor 1 (UF).
    loads: Vec<(Origin, Load<D>)>,
    proportional: Vec<f64>,
    /// The sum of all of them there.
    forces: Vec<f64>,
    /// Springs on boundaries, and pressures that follow them.
    foundations: Vec<Foundation>,
    pressures: Vec<Pressure<D>>,
}

impl<const D: usize> Body<D> {
    /// A body without supports and loads; its elements have the order of its mesh.
    pub fn new(mesh: Mesh<D>, material: impl Material<D>) -> Self
    where
        P1: Element<D>,
        P2: Element<D>,
    {
        let law: Arc<dyn Law<D>> = match mesh.order() {
            Order::Linear => Arc::new(ElasticLaw(P1, material.into())),
            Order::Quadratic => Arc::new(ElasticLaw(P2, material.into())),
        };
        Body::of(mesh, law)
    }

    /// A body whose regions have laws of their own. They are of one type; an enum of yours, which implements [`Material`], may be
    /// several. Layers stick together, since they share the nodes between them.
    ///
    /// Two layers in series:
    /// ```
    /// use contact_fem::mesh::generators::{Diagonals, linspace, rectangle};
    /// use contact_fem::{Body, LinearElastic, Scene, Simulation};
    ///
    /// # fn main() -> Result<(), contact_fem::Error> {
    /// let mut mesh = rectangle(&linspace(0.0, 2.0, 4), &[0.0, 1.0], Diagonals::Rising)?;
    /// mesh.name_region("soft", |X| X[0] < 1.0);
    /// mesh.name_region("stiff", |X| X[0] > 1.0);
    /// let laws = [("soft", LinearElastic::new(100.0, 0.0)?), ("stiff", LinearElastic::new(300.0, 0.0)?)];
    /// let mut bar = Body::with_laws(mesh, laws)?;
    /// bar.symmetry("left")?.symmetry("bottom")?.prescribe("right", [Some(0.01), None])?;
    /// let mut scene = Scene::new();
    /// scene.add("bar", bar);
    /// let history = Simulation::with_increments(1).run(&mut scene.problem()?)?;
    /// let last = history.last().expect("one step");
    /// assert!((last.energy - 0.5 * 0.01 * 0.01 / (1.0 / 100.0 + 1.0 / 300.0)).abs() < 1e-12);
    /// # Ok(())
    /// # }
    /// ```
    ///
    /// # Errors
    /// A region that does not exist, and a cell in none of them or in several.
    pub fn with_laws<M: Material<D>>(
        mesh: Mesh<D>,
        laws: impl IntoIterator<Item = (impl AsRef<str>, M)>,
    ) -> Result<Self, Error>
    where
        P1: Element<D>,
        P2: Element<D>,
    {
        let law: Arc<dyn Law<D>> = match mesh.order() {
            Order::Linear => Arc::new(ElasticLaw(P1, Laws::of_regions::<D, P1>(&mesh, laws)?)),
            Order::Quadratic => Arc::new(ElasticLaw(P2, Laws::of_regions::<D, P2>(&mesh, laws)?)),
        };
        Ok(Body::of(mesh, law))
    }

    /// A body whose law varies with the reference position X (UL). The law of each quadrature point is made once, here.
    ///
    /// # Errors
    /// Those of `law`.
    pub fn graded<M: Material<D>>(
        mesh: Mesh<D>,
        law: impl Fn(&Vector<D>) -> Result<M, Error>,
    ) -> Result<Self, Error>
    where
        P1: Element<D>,
        P2: Element<D>,
    {
        let law: Arc<dyn Law<D>> = match mesh.order() {
            Order::Linear => Arc::new(ElasticLaw(P1, Laws::graded::<D, P1>(&mesh, law)?)),
            Order::Quadratic => Arc::new(ElasticLaw(P2, Laws::graded::<D, P2>(&mesh, law)?)),
        };
        Ok(Body::of(mesh, law))
    }

    /// A body of linear elements that do not lock where the law is nearly incompressible: changes of volume are averaged
    /// around the nodes, see [`AveragedVolume`](crate::assembly::AveragedVolume).
    ///
    /// At ν = 0.4999 triangles come to within 1 % of quadratic ones of half the number along a side (`contact-fem/tests/bodies/locking.rs`), where plain
    /// ones are off by factors; tetrahedra to 7 %, where plain ones are off by 12 %.
    ///
    /// Each node is coupled with the neighbours of its neighbours; factors are larger for it, in space several times.
    ///
    /// # Errors
    /// If the mesh is quadratic: its elements do not lock.
    pub fn with_averaged_volumes(mesh: Mesh<D>, material: impl Volumetric<D>) -> Result<Self, Error>
    where
        P1: Element<D>,
    {
        match mesh.order() {
            Order::Linear => Ok(Body::of(mesh, Arc::new(AveragedLaw(material)))),
            Order::Quadratic => Err(Error::AveragedQuadratic),
        }
    }

    /// Takes the law of `other`, a body of the same cells: of one material, of regions, graded, or with averaged volumes. Supports and loads
    /// stay, and those of `other` do not count. See [`Scene::body_mut`](crate::Scene::body_mut).
    ///
    /// # Errors
    /// [`Error::LawOfAnother`]: other cells, a body that does not deform, or one of revolution and one that is not.
    pub fn take_law(&mut self, other: Self) -> Result<&mut Self, Error> {
        let wrong = match (&self.mesh, &other.mesh) {
            _ if self.is_rigid() || other.is_rigid() => {
                Some("a body that does not deform has none")
            }
            (own, of) if own.is_of_revolution() != of.is_of_revolution() => {
                Some("one of the two is a body of revolution, and the other is not")
            }
            (own, of) if !own.has_cells_of(of) => Some("their cells or nodes are not the same"),
            _ => None,
        };
        if let Some(why) = wrong {
            return Err(Error::LawOfAnother { why });
        }
        self.law = other.law;
        Ok(self)
    }

    fn of(mesh: Mesh<D>, law: Arc<dyn Law<D>>) -> Self {
        let dofs = D * mesh.nodes().len();
        Body {
            law,
            supports: Supports::new(mesh.nodes().to_vec()),
            mesh,
            prescribed: vec![None; dofs],
            supported: Vec::new(),
            support_of: vec![None; dofs],
            declared: held::Declarations::default(),
            rollers: rollers::Rollers::default(),
            rigid: None,
            loads: Vec::new(),
            proportional: vec![0.0; dofs],
            forces: vec![0.0; dofs],
            foundations: Vec::new(),
            pressures: Vec::new(),
        }
    }

    /// The mesh.
    pub fn mesh(&self) -> &Mesh<D> {
        &self.mesh
    }

    /// The displacement prescribed for each dof at load factor 1 (UL), if any. Where nodes slide along planes that are not
    /// perpendicular to an axis, one component is, without what the others add to it.
    pub fn prescribed(&self) -> &[Option<f64>] {
        &self.prescribed
    }

    /// The displacements prescribed at a load factor (UL), as [`Body::prescribed`] in ascending order of the dofs; 0 at the load factor 0, before
    /// the first step.
    pub fn prescribed_at(&self, factor: f64) -> Vec<f64> {
        self.supports.at(factor)
    }

    /// The nodal forces of dead loads at load factor 1 (all dofs, UF).
    pub fn forces(&self) -> &[f64] {
        &self.forces
    }

    /// The nodal forces of dead loads at a load factor (all dofs, UF); 0 at the load factor 0, before the first step. Forces that
    /// supports have left which let go belong to them.
    pub fn forces_at(&self, factor: f64) -> Vec<f64> {
        let mut forces = self.loaded_at(factor);
        self.add_fading_forces(factor, &mut forces);
        forces
    }

    /// The same without supports.
    fn loaded_at(&self, factor: f64) -> Vec<f64> {
        let mut forces: Vec<f64> = self.proportional.iter().map(|f| factor * f).collect();
        if factor != 0.0 {
            let loads = self.loads.iter().map(|(_, load)| load);
            let others = loads.filter(|load| !load.is_proportional());
            others.for_each(|load| load.add(factor, &mut forces));
        }
        forces
    }

    /// The nodal forces of each load at a load factor, as [`Body::forces_at`], with their origin.
    pub(super) fn loads_at(&self, factor: f64) -> impl Iterator<Item = (&Origin, Vec<f64>)> {
        self.loads.iter().map(move |(origin, load)| {
            let mut forces = vec![0.0; self.forces.len()];
            if factor != 0.0 {
                load.add(factor, &mut forces);
            }
            (origin, forces)
        })
    }

    /// The boundaries that supports name, and for each prescribed dof the first that did; supports of nodes have names of
    /// their own.
    pub(super) fn support_names(&self) -> (&[String], &[Option<usize>]) {
        (&self.supported, &self.support_of)
    }

    /// Whether not all loads and prescribed displacements are proportional to the load factor.
    pub(crate) fn has_program(&self) -> bool {
        let mut loads = self.loads.iter().map(|(_, load)| load);
        let mut pressures = self.pressures.iter();
        !(self.supports.is_proportional()
            && !self.is_switched()
            && !self.has_rollers()
            && loads.all(Load::is_proportional)
            && pressures.all(Pressure::is_proportional))
    }

    /// The prescribed displacements, with their courses.
    pub(super) fn supports(&self) -> &Supports<D> {
        &self.supports
    }

    /// The load factors at which the sizes of its prescribed displacements and loads are estimated before a run: to the end of
    /// its amplitudes' tables, and to 1 at least.
    pub(super) fn times(&self) -> Vec<f64> {
        if !self.has_program() {
            return vec![1.0];
        }
        samples_with(self.knots())
    }

    /// The times of the tables of all amplitudes.
    pub(super) fn knots(&self) -> impl Iterator<Item = f64> + '_ {
        let loads = self.loads.iter().flat_map(|(_, load)| load.knots());
        let pressures = self.pressures.iter().flat_map(Pressure::knots);
        self.supports.knots().chain(loads).chain(pressures)
    }

    /// The displacements prescribed at a load factor (UL), as [`Body::prescribed`].
    pub(crate) fn prescribed_values(&self, factor: f64) -> Vec<Option<f64>> {
        let mut values = self.prescribed_at(factor).into_iter();
        let all = self.prescribed.iter();
        all.map(|held| held.and_then(|_| values.next())).collect()
    }

    /// The largest prescribed displacement (UL), and the largest sum of all magnitudes of forces (UF), at the load factors of
    /// [`Body::times`]; values that are not finite are left out.
    pub(super) fn largest(&self) -> (f64, f64) {
        let of = |t: f64| {
            let largest = self.largest_prescribed(t);
            let forces = self.loaded_at(t);
            let dead: f64 = forces.iter().map(|f| f.abs()).sum();
            (largest, dead + self.sum_of_pressures(t))
        };
        match self.has_program() {
            true => self
                .times()
                .into_iter()
                .map(of)
                .fold((0.0, 0.0), |(u, f), (v, g)| {
                    (u.max(v), f64::max(f, if g.is_finite() { g } else { 0.0 }))
                }),
            false => of(1.0),
        }
    }

    /// Whether the law is a small-strain law, that is linear in the displacement gradient.
    pub fn is_small_strain(&self) -> bool {
        self.law.is_small_strain()
    }

    /// Whether the elements are too stiff where the law is nearly incompressible.
    pub(super) fn locks(&self) -> bool {
        self.law.locks()
    }

    /// How much the law's stress differs from the derivative of its energy, and its tangent from that of its stress, see
    /// [`conformance::slopes`].
    pub(super) fn law_slopes(&self) -> [f64; 2] {
        self.law.slopes()
    }

    /// The shear modulus and the modulus of stretching without lateral strain (UF/UL²) at rest, along the
    /// first two axes. Of several laws the least shear modulus, and it times the largest ratio of both.
    pub(crate) fn rest_moduli(&self) -> (f64, f64) {
        self.law.rest_moduli()
    }

    /// For each dof, whether it is prescribed at all times, as far as one support is.
    pub(super) fn is_always_prescribed(&self) -> Vec<bool> {
        match self.is_switched() {
            true => (0..self.prescribed.len())
                .map(|dof| self.declared_at_all_times(dof).is_some())
                .collect(),
            false => self.is_prescribed(),
        }
    }

    /// For each dof, whether it is prescribed.
    pub(super) fn is_prescribed(&self) -> Vec<bool> {
        self.prescribed.iter().map(Option::is_some).collect()
    }

    /// The energy over the free dofs, at load factor 0.
    pub(super) fn energy(&self) -> Box<dyn BodyEnergy<D>> {
        let energy = self.with_boundary(self.law.energy(self));
        match self.ties().is_empty() {
            true => energy,
            false => {
                let full = self.prescribed.iter().flatten().copied().collect();
                Box::new(Tied::new(energy, self.dofs(), full))
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::generators::{Diagonals, rectangle};
    use crate::{Amplitude, LinearElastic, NeoHookean};

    fn square() -> Body<2> {
        let mesh = rectangle(&[0.0, 1.0], &[0.0, 1.0], Diagonals::Rising).expect("mesh");
        Body::new(mesh, NeoHookean::new(1.0, 0.3).expect("law"))
    }

    #[test]
    fn supports_and_forces_need_nodes() {
        let mut body = square();
        let refused = body.prescribe_nodes(&[], [Some(0.5); 2]).err();
        assert!(matches!(refused, Some(Error::Setting { value: 0.0, .. })));
        let refused = body.nodal_force(&[], [0.0, -5.0]).err();
        assert!(matches!(refused, Some(Error::Setting { value: 0.0, .. })));
    }

    /// A body that takes the law of another has the energy of one that was made with it, whatever law that is.
    #[test]
    fn laws_of_others() {
        let law = |young: f64| LinearElastic::new(young, 0.3).expect("a law");
        let mesh = square().mesh;
        let averaged = || {
            let law = crate::NeoHookean::new(3.0, 0.4).expect("a law");
            Body::with_averaged_volumes(mesh.clone(), law).expect("linear cells")
        };
        let graded = || Body::graded(mesh.clone(), |X| LinearElastic::new(1.0 + X[0], 0.2));
        let graded = || graded().expect("a law everywhere");
        let makers: [&dyn Fn() -> Body<2>; 3] =
            [&|| Body::new(mesh.clone(), law(7.0)), &averaged, &graded];
        let u: Vec<f64> = (0..8).map(|i| 0.02 * ((3 * i % 5) as f64 - 2.0)).collect();
        for make in makers {
            let mut body = square();
            body.take_law(make()).expect("the same cells");
            let [own, of] = [body, make()].map(|body| body.energy().value(&u));
            assert!(own == of && own > 0.0, "{own} {of}");
        }
        let ring = |young: f64| {
            let law = LinearElastic::new(young, 0.3).expect("a law");
            Body::of_revolution(mesh.clone(), law).expect("radii above zero")
        };
        let mut body = ring(1.0);
        body.take_law(ring(7.0)).expect("the same cells");
        // the nodes on the axis are held, and the energy of the first law is a seventh
        let free = body.prescribed().iter().filter(|p| p.is_none()).count();
        let [own, of] = [&body, &ring(1.0)].map(|body| body.energy().value(&u[..free]));
        assert!((own / of - 7.0).abs() < 1e-12, "{own} {of}");
    }

    #[test]
    fn laws_of_bodies_that_differ_are_refused() {
        let grid = [0.0, 1.0];
        let mesh = |diagonals| rectangle(&grid, &grid, diagonals).expect("a mesh");
        let law = NeoHookean::new(1.0, 0.3).expect("a law");
        let others = [
            (Body::new(mesh(Diagonals::Falling), law), "cells"),
            (Body::new(mesh(Diagonals::Rising).quadratic(), law), "cells"),
            (Body::rigid(mesh(Diagonals::Rising)), "does not deform"),
            (
                Body::of_revolution(mesh(Diagonals::Rising), law).expect("a body"),
                "of revolution",
            ),
        ];
        for (other, word) in others {
            let refused = square()
                .take_law(other)
                .err()
                .map(|error| error.to_string());
            let text = refused.expect("a refusal");
            assert!(text.contains(word), "{text}");
        }
    }

    /// Loads of all kinds add up at every load factor, and none is there before the first step.
    #[test]
    fn forces_in_time() {
        let mut body = square();
        body.nodal_force(&[1, 1, 2], [3.0, 0.0]).expect("a force");
        body.nodal_force_in_time(&[2], [0.0, 5.0], 1.0)
            .expect("a force");
        body.traction_path("top", |t, X| Vector::<2>::new(t * t * X[1], 0.0))
            .expect("a traction");
        assert!(body.has_program());
        let twice = [0.0, 0.0, 12.0, 0.0, 6.0 + 2.0, 5.0, 2.0, 0.0];
        let at = |t: f64| body.forces_at(t);
        assert!(
            at(2.0)
                .iter()
                .zip(twice)
                .all(|(f, g)| (f - g).abs() < 1e-14)
        );
        assert_eq!(at(0.0), [0.0; 8]);
        assert_eq!(body.forces(), at(1.0));
        for wrong in [
            square().nodal_force(&[4], [1.0, 0.0]).err(),
            square().nodal_force(&[0], [f64::NAN, 0.0]).err(),
        ] {
            assert!(wrong.is_some());
        }
    }

    /// A quarter of a plate is drawn as the whole would be: u = σ/E (−ν(1 + ν) X, (1 − ν²) Y) in plane strain.
    #[test]
    fn planes_of_symmetry() {
        let mut quarter = square();
        let slanted = |X: &Vector<2>| (X[0] - X[1]).abs() < 1e-9;
        quarter.mesh.name_boundary("corner", |X| X[0] * X[1] < 1e-9);
        assert!(quarter.symmetry("corner").is_err(), "two sides");
        assert!(quarter.symmetry("nowhere").is_err());
        quarter.mesh.name_boundary("slanted", slanted);
        assert!(quarter.symmetry("slanted").is_err());

        let mesh = rectangle(&[0.0, 0.4, 1.0], &[0.0, 1.0], Diagonals::Rising).expect("mesh");
        let law = crate::LinearElastic::new(100.0, 0.25).expect("law");
        let mut quarter = Body::new(mesh, law);
        let planes = quarter
            .symmetry("left")
            .and_then(|body| body.symmetry("bottom"));
        let drawn = planes.and_then(|body| body.traction("top", [0.0, 2.0]));
        drawn.expect("named by the generator");
        let mut scene = crate::Scene::new();
        scene.add("quarter", quarter);
        let mut problem = scene.problem().expect("a problem");
        let history = crate::Simulation::with_increments(1).run(&mut problem);
        let solution = history.expect("a run").run.solution.expect("a solution");
        let now = problem.positions(&solution.state.u);
        for (x, X) in now.iter().zip(problem.reference()) {
            let exact = Vector::<2>::new(-0.25 * 1.25 * X[0], (1.0 - 0.0625) * X[1]) * 0.02;
            assert!((x - X - exact).norm() < 1e-12, "{x} from {X}");
        }
    }

    /// Of two values for a dof, one may repeat the other.
    #[test]
    fn supports_that_agree() {
        let mut body = square();
        let held = |amplitude: f64| Amplitude::constant(amplitude);
        body.prescribe("left", [Some(0.0), None]).expect("support");
        body.prescribe_in_time("top", [Some(0.0), Some(2.0)], held(3.0))
            .expect("0 is 0 in any course");
        let conflict = body.prescribe("right", [None, Some(2.0)]).err();
        let told = conflict.expect("a conflict").to_string();
        let expected = "the displacement along y of the node at [1.0, 1.0] is prescribed twice, by the supports on `top` and on \
                        `right`: 6 and 2 at load factor 1;";
        assert!(told.starts_with(expected), "{told}");
        // nodes row by row: the left ones are 0 and 2
        assert_eq!(body.prescribed_at(5.0), [0.0, 0.0, 6.0, 0.0, 6.0]);
        assert_eq!(body.prescribed_at(0.0), [0.0; 5]);
    }
}
