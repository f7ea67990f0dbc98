//! Bodies: mesh, material law, supports and loads.

mod boundary;
mod held;
mod revolution;
mod rollers;

use std::sync::Arc;

use super::courses::{Course, Load, Origin, Path, Supports};
use crate::assembly::{
    AveragedVolume, BodyEnergy, Laws, QuadraticEnergy, StrainEnergy, Tied, add_body_force,
    add_traction,
};
use crate::element::{Element, Order, P1, P2};
use crate::error::Error;
use crate::material::{Deformation, Material, Volumetric, conformance};
use crate::mesh::Mesh;
use crate::program::{Amplitude, Motion, samples};
use crate::tensor::{Matrix, Vector, unit_vector};

pub(super) use boundary::{Foundation, Pressure};
pub(super) use held::Holding;

/// Of a law that varies from point to point, about so many are checked.
const SAMPLED: usize = 1000;

/// Nodes are in one plane up to this share of the mesh's size.
const PLANE: f64 = 1e-9;

/// # Errors
/// No node.
fn some(name: &'static str, nodes: &[usize]) -> Result<(), Error> {
    match nodes.is_empty() {
        true => Err(Error::Setting {
            name,
            value: 0.0,
            remedy: "name one node at least: check what selects them",
        }),
        false => Ok(()),
    }
}

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
pub struct Body<const D: usize> {
    mesh: Mesh<D>,
    law: Arc<dyn Law<D>>,
    supports: Supports<D>,
    /// The displacement prescribed for each dof at load factor 1 (UL), if any.
    prescribed: Vec<Option<f64>>,
    /// The boundaries that supports name, in the order in which they were, and for each prescribed dof the first that did; the
    /// empty name is that of supports of nodes.
    supported: Vec<String>,
    support_of: Vec<Option<usize>>,
    /// All of them, and when they hold.
    declared: held::Declarations,
    /// Nodes that slide along planes of any direction.
    rollers: rollers::Rollers<D>,
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
    /// around the nodes, see [`AveragedVolume`].
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

    /// Prescribes the displacement components (UL, at full load) of all nodes of a boundary;
    /// components that are `None` stay free.
    ///
    /// # Errors
    /// If the boundary is unknown or has no facets, a value is not finite, or a dof is prescribed twice with
    /// different values.
    pub fn prescribe(
        &mut self,
        boundary: &str,
        components: [Option<f64>; D],
    ) -> Result<&mut Self, Error> {
        let nodes = self.nodes_to_support(boundary)?;
        self.hold((boundary, &nodes), components, 0)
    }

    /// The nodes of a boundary that is to be supported.
    fn nodes_to_support(&self, boundary: &str) -> Result<Vec<usize>, Error> {
        let nodes = self.mesh.boundary_nodes(boundary)?;
        match nodes.is_empty() {
            true => Err(Error::EmptyBoundary {
                name: boundary.to_string(),
                what: "support",
            }),
            false => Ok(nodes),
        }
    }

    /// Makes a plane boundary a plane of symmetry: displacements along its normal are zero on it, and the
    /// others are free. Model a half or a quarter of the bodies; forces and energies are those of the part.
    ///
    /// A quarter of a plate, drawn upwards:
    /// ```
    /// use contact_fem::mesh::generators::{Diagonals, rectangle};
    /// use contact_fem::{Body, LinearElastic};
    ///
    /// # fn main() -> Result<(), contact_fem::Error> {
    /// let grid = [0.0, 0.5, 1.0];
    /// let plate = rectangle(&grid, &grid, Diagonals::Rising)?;
    /// let mut plate = Body::new(plate, LinearElastic::new(100.0, 0.3)?);
    /// plate.symmetry("left")?.symmetry("bottom")?.traction("top", [0.0, 1.0])?;
    /// # Ok(())
    /// # }
    /// ```
    ///
    /// # Errors
    /// As [`Body::prescribe`], if the boundary is not in one plane and, where no axis is perpendicular to it, as
    /// [`Body::prescribe_along`].
    pub fn symmetry(&mut self, boundary: &str) -> Result<&mut Self, Error> {
        let nodes = self.nodes_to_support(boundary)?;
        let extent = |nodes: &mut dyn Iterator<Item = usize>, i: usize| {
            let range = nodes.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], a| {
                let x = self.mesh.nodes()[a][i];
                [low.min(x), high.max(x)]
            });
            range[1] - range[0]
        };
        let size = (0..D).map(|i| extent(&mut (0..self.mesh.nodes().len()), i));
        let size = size.fold(0.0, f64::max);
        let own = (0..D).map(|i| (i, extent(&mut nodes.iter().copied(), i)));
        let flattest = own.min_by(|a, b| a.1.total_cmp(&b.1));
        match flattest {
            Some((axis, thickness)) if thickness <= PLANE * size => {
                let mut components = [None; D];
                components[axis] = Some(0.0);
                self.hold((boundary, &nodes), components, 0)
            }
            _ => match self.normal_of_plane(&nodes) {
                (n, thickness) if thickness <= PLANE * size => {
                    self.hold_plane((boundary, &nodes), n.into(), (0.0, Amplitude::default()))
                }
                (_, thickness) => Err(Error::NotPlane {
                    name: boundary.to_string(),
                    thickness,
                }),
            },
        }
    }

    /// As [`Body::prescribe`], with the components times an amplitude in place of the load factor. What is not zero at
    /// load factor 0 is applied within the first step.
    ///
    /// A bar is drawn by 0.1 and let go again, and its weight is there all the time:
    /// ```
    /// use contact_fem::mesh::generators::{Diagonals, linspace, rectangle};
    /// use contact_fem::{Amplitude, Body, LinearElastic, Phase, Scene, Simulation};
    ///
    /// # fn main() -> Result<(), contact_fem::Error> {
    /// let mesh = rectangle(&linspace(0.0, 4.0, 8), &linspace(0.0, 1.0, 2), Diagonals::Alternating)?;
    /// let mut bar = Body::new(mesh, LinearElastic::new(200.0, 0.0)?);
    /// bar.prescribe("left", [Some(0.0), Some(0.0)])?;
    /// let there_and_back = Amplitude::table(&[(0.0, 0.0), (1.0, 1.0), (2.0, 0.0)])?;
    /// bar.prescribe_in_time("right", [Some(0.1), Some(0.0)], there_and_back)?;
    /// bar.body_force_in_time([0.0, -0.5], Amplitude::constant(1.0))?;
    /// let mut scene = Scene::new();
    /// let bar = scene.add("bar", bar);
    /// let mut problem = scene.problem()?;
    ///
    /// let phases = [Phase::new("draw", 1.0, 2), Phase::new("let go", 2.0, 2)];
    /// let history = Simulation::in_phases(phases).run(&mut problem)?;
    /// assert!(history.is_complete());
    /// let [drawn, back] = [1, 3].map(|step| &history.steps[step]);
    /// assert_eq!((drawn.phase(), back.phase()), ("draw", "let go"));
    /// assert!(drawn.stored_energy > 10.0 * back.stored_energy);
    /// assert!((back.reaction(bar)[1] - 2.0).abs() < 1e-9, "the weight");
    /// # Ok(())
    /// # }
    /// ```
    ///
    /// # Errors
    /// As [`Body::prescribe`]. Values of an amplitude are checked at the times that a run comes to.
    pub fn prescribe_in_time(
        &mut self,
        boundary: &str,
        components: [Option<f64>; D],
        amplitude: impl Into<Amplitude>,
    ) -> Result<&mut Self, Error> {
        let nodes = self.nodes_to_support(boundary)?;
        let course = self.course(amplitude.into());
        self.hold((boundary, &nodes), components, course)
    }

    /// Prescribes all components of the displacement (UL) of all nodes of a boundary, as a function of the load factor and
    /// the reference position X (UL).
    ///
    /// # Errors
    /// As [`Body::prescribe`]. Values are checked at the load factors 1/16, 2/16, … 1, and at those that a run comes to.
    pub fn prescribe_path(
        &mut self,
        boundary: &str,
        path: impl Fn(f64, &Vector<D>) -> Vector<D> + Send + Sync + 'static,
    ) -> Result<&mut Self, Error> {
        let nodes = self.nodes_to_support(boundary)?;
        self.hold_along((boundary, &nodes), Arc::new(path), None)
    }

    /// Moves a boundary rigidly: its nodes go along circles and lines, exactly.
    ///
    /// # Errors
    /// As [`Body::prescribe_path`].
    pub fn prescribe_motion(
        &mut self,
        boundary: &str,
        motion: Motion<D>,
    ) -> Result<&mut Self, Error> {
        let nodes = self.nodes_to_support(boundary)?;
        self.hold_moving((boundary, &nodes), motion)
    }

    /// Moves the whole body rigidly, as a tool.
    ///
    /// # Errors
    /// As [`Body::prescribe_path`].
    pub fn prescribe_motion_of_all(&mut self, motion: Motion<D>) -> Result<&mut Self, Error> {
        let nodes: Vec<usize> = (0..self.mesh.nodes().len()).collect();
        self.hold_moving(("", &nodes), motion)
    }

    fn hold_moving(
        &mut self,
        nodes: (&str, &[usize]),
        motion: Motion<D>,
    ) -> Result<&mut Self, Error> {
        let own = motion.clone();
        let path = move |t: f64, X: &Vector<D>| own.at(t, X) - X;
        self.hold_along(nodes, Arc::new(path), Some(motion))
    }

    fn hold_along(
        &mut self,
        (boundary, nodes): (&str, &[usize]),
        path: Path<D>,
        motion: Option<Motion<D>>,
    ) -> Result<&mut Self, Error> {
        for t in samples() {
            let values = nodes.iter().map(|&a| path(t, &self.mesh.nodes()[a]));
            let values: Vec<f64> = values.flat_map(|u| u.data.0[0]).collect();
            Error::check_finite("prescribed displacement", &values)?;
        }
        self.supports.courses.push(Course::Along(path, motion));
        let course = self.supports.courses.len() - 1;
        self.hold((boundary, nodes), [Some(0.0); D], course)
    }

    /// The number of a course with this amplitude.
    fn course(&mut self, amplitude: Amplitude) -> usize {
        if amplitude.is_proportional() {
            return 0;
        }
        self.supports.courses.push(Course::Scaled(amplitude));
        self.supports.courses.len() - 1
    }

    /// As [`Body::prescribe`], for every node of the body. The body then moves rigidly, and none of
    /// its cells is assembled.
    ///
    /// # Errors
    /// As [`Body::prescribe`].
    pub fn prescribe_all(&mut self, components: [Option<f64>; D]) -> Result<&mut Self, Error> {
        let nodes: Vec<usize> = (0..self.mesh.nodes().len()).collect();
        self.prescribe_nodes(&nodes, components)
    }

    /// As [`Body::prescribe`], for the given nodes.
    ///
    /// # Errors
    /// As [`Body::prescribe`], and if there is no node, or one that does not exist.
    pub fn prescribe_nodes(
        &mut self,
        nodes: &[usize],
        components: [Option<f64>; D],
    ) -> Result<&mut Self, Error> {
        some("number of supported nodes", nodes)?;
        self.hold(("", nodes), components, 0)
    }

    /// Prescribes values along a course, where there are none yet, or the same. Nodes of no boundary have the empty name.
    fn hold(
        &mut self,
        (boundary, nodes): (&str, &[usize]),
        components: [Option<f64>; D],
        course: usize,
    ) -> Result<&mut Self, Error> {
        let given = components.iter().flatten();
        Error::check_finite("prescribed displacement", given)?;
        self.check_nodes(nodes)?;
        for &node in nodes {
            let given = components.iter().enumerate();
            for (component, value) in given.filter_map(|(i, value)| Some((i, (*value)?))) {
                let dof = D * node + component;
                for first in self.held_beside(dof) {
                    let values = [first, (value, course)];
                    let at = |t: f64| (t, values.map(|value| self.supports.value(dof, value, t)));
                    let all = samples().map(at);
                    let mut differ = all.filter(|(_, [first, second])| first != second);
                    if let Some((at, [first, second])) = differ.next_back() {
                        let name = self.support_of[dof].map(|name| self.supported[name].clone());
                        return Err(Error::Conflict {
                            node,
                            x: self.mesh.nodes()[node].iter().copied().collect(),
                            component,
                            direction: unit_vector::<D>(component).iter().copied().collect(),
                            on: Box::new([name.unwrap_or_default(), boundary.to_string()]),
                            first,
                            second,
                            at,
                        });
                    }
                }
            }
        }
        let all = nodes
            .iter()
            .flat_map(|node| components.iter().enumerate().map(move |c| (node, c)));
        let held = all.filter_map(|(&node, (component, value))| {
            Some((D * node + component, ((*value)?, course)))
        });
        let held = held.collect();
        if !nodes.iter().any(|node| self.slides(*node)) {
            let own = self.named(boundary);
            self.declare(own, held);
            return Ok(self);
        }
        self.always("a support of nodes that slide along a direction")?;
        self.or_not(|body| {
            let own = body.named(boundary);
            body.declare(own, held);
            body.resolve_all(nodes)
        })
    }

    /// # Errors
    /// A node that does not exist.
    fn check_nodes(&self, nodes: &[usize]) -> Result<(), Error> {
        let count = self.mesh.nodes().len();
        match nodes.iter().find(|node| **node >= count) {
            None => Ok(()),
            Some(node) => Err(Error::Setting {
                name: "node",
                value: *node as f64,
                remedy: "name a node of this body's mesh",
            }),
        }
    }

    /// The number of a boundary among those that supports name.
    fn named(&mut self, boundary: &str) -> usize {
        let known = self.supported.iter().position(|name| name == boundary);
        known.unwrap_or_else(|| {
            self.supported.push(boundary.to_string());
            self.supported.len() - 1
        })
    }

    /// Adds a dead traction (force per reference area, UF/UL in the plane, UF/UL² in space) on a
    /// boundary.
    ///
    /// # Errors
    /// If the boundary is unknown or has no facets, or a value is not finite.
    pub fn traction(&mut self, boundary: &str, traction: [f64; D]) -> Result<&mut Self, Error> {
        self.traction_field(boundary, |_| traction.into())
    }

    /// As [`Body::traction`], for a traction that depends on the reference position X.
    ///
    /// # Errors
    /// As [`Body::traction`].
    pub fn traction_field(
        &mut self,
        boundary: &str,
        traction: impl Fn(&Vector<D>) -> Vector<D>,
    ) -> Result<&mut Self, Error> {
        let forces = self.traction_forces(boundary, traction)?;
        self.add_forces(
            Origin::Traction(boundary.to_string()),
            forces,
            Amplitude::default(),
        )
    }

    /// As [`Body::traction`], times an amplitude in place of the load factor. What is not zero at load factor 0 is applied
    /// within the first step.
    ///
    /// # Errors
    /// As [`Body::traction`]. Values of an amplitude are checked at the times that a run comes to.
    pub fn traction_in_time(
        &mut self,
        boundary: &str,
        traction: [f64; D],
        amplitude: impl Into<Amplitude>,
    ) -> Result<&mut Self, Error> {
        let forces = self.traction_forces(boundary, |_| traction.into())?;
        self.add_forces(
            Origin::Traction(boundary.to_string()),
            forces,
            amplitude.into(),
        )
    }

    /// Adds a dead traction that depends on the load factor and on the reference position X (UL).
    ///
    /// # Errors
    /// As [`Body::traction`]. Values are checked at the load factors 1/16, 2/16, … 1, and at those that a run comes to.
    pub fn traction_path(
        &mut self,
        boundary: &str,
        traction: impl Fn(f64, &Vector<D>) -> Vector<D> + Send + Sync + 'static,
    ) -> Result<&mut Self, Error> {
        self.traction_forces(boundary, |_| Vector::zeros())?;
        let (mesh, boundary) = (self.mesh.clone(), boundary.to_string());
        let origin = Origin::Traction(boundary.clone());
        self.add_path(origin, move |t, forces| {
            // checked above
            let facets = mesh.boundary(&boundary).unwrap_or_default();
            add_traction(&mesh, &facets, |X| traction(t, X), forces);
        })
    }

    fn traction_forces(
        &self,
        boundary: &str,
        traction: impl Fn(&Vector<D>) -> Vector<D>,
    ) -> Result<Vec<f64>, Error> {
        let facets = self.facets(boundary, "traction")?;
        let mut forces = vec![0.0; self.forces.len()];
        add_traction(&self.mesh, &facets, traction, &mut forces);
        Ok(forces)
    }

    /// The facets of a boundary on which something acts.
    fn facets(&self, boundary: &str, what: &'static str) -> Result<Vec<&[usize]>, Error> {
        let facets = self.mesh.boundary(boundary)?;
        match facets.is_empty() {
            true => Err(Error::EmptyBoundary {
                name: boundary.to_string(),
                what,
            }),
            false => Ok(facets),
        }
    }

    /// Adds a dead body force (force per reference volume, UF/UL² in the plane, UF/UL³ in space).
    ///
    /// # Errors
    /// If a value is not finite.
    pub fn body_force(&mut self, force: [f64; D]) -> Result<&mut Self, Error> {
        self.body_force_field(|_| force.into())
    }

    /// As [`Body::body_force`], for a force that depends on the reference position X.
    ///
    /// # Errors
    /// As [`Body::body_force`].
    pub fn body_force_field(
        &mut self,
        force: impl Fn(&Vector<D>) -> Vector<D>,
    ) -> Result<&mut Self, Error> {
        let mut forces = vec![0.0; self.forces.len()];
        self.law.add_body_force(&self.mesh, &force, &mut forces);
        self.add_forces(Origin::BodyForce, forces, Amplitude::default())
    }

    /// As [`Body::body_force`], times an amplitude in place of the load factor. What is not zero at load factor 0 is applied
    /// within the first step.
    ///
    /// # Errors
    /// If a value is not finite. Values of an amplitude are checked at the times that a run comes to.
    pub fn body_force_in_time(
        &mut self,
        force: [f64; D],
        amplitude: impl Into<Amplitude>,
    ) -> Result<&mut Self, Error> {
        let mut forces = vec![0.0; self.forces.len()];
        let field = |_: &Vector<D>| force.into();
        self.law.add_body_force(&self.mesh, &field, &mut forces);
        self.add_forces(Origin::BodyForce, forces, amplitude.into())
    }

    /// Adds a dead body force that depends on the load factor and on the reference position X (UL).
    ///
    /// # Errors
    /// If a value is not finite, which is checked at the load factors 1/16, 2/16, … 1, and at those that a run comes to.
    pub fn body_force_path(
        &mut self,
        force: impl Fn(f64, &Vector<D>) -> Vector<D> + Send + Sync + 'static,
    ) -> Result<&mut Self, Error> {
        let (mesh, law) = (self.mesh.clone(), Arc::clone(&self.law));
        self.add_path(Origin::BodyForce, move |t, forces| {
            law.add_body_force(&mesh, &|X| force(t, X), forces);
        })
    }

    /// Adds a dead force (UF) on each of the given nodes.
    ///
    /// # Errors
    /// If a value is not finite, or a node does not exist.
    pub fn nodal_force(&mut self, nodes: &[usize], force: [f64; D]) -> Result<&mut Self, Error> {
        self.nodal_force_in_time(nodes, force, Amplitude::default())
    }

    /// As [`Body::nodal_force`], times an amplitude in place of the load factor.
    ///
    /// # Errors
    /// As [`Body::nodal_force`]. Values of an amplitude are checked at the times that a run comes to.
    pub fn nodal_force_in_time(
        &mut self,
        nodes: &[usize],
        force: [f64; D],
        amplitude: impl Into<Amplitude>,
    ) -> Result<&mut Self, Error> {
        some("number of loaded nodes", nodes)?;
        let mut forces = vec![0.0; self.forces.len()];
        for &node in nodes {
            let Some(own) = forces.get_mut(D * node..D * (node + 1)) else {
                return Err(Error::Setting {
                    name: "node",
                    value: node as f64,
                    remedy: "name a node of this body's mesh",
                });
            };
            own.iter_mut().zip(force).for_each(|(sum, f)| *sum += f);
        }
        self.add_forces(Origin::NodalForce, forces, amplitude.into())
    }

    /// Adds the nodal forces of a load if all of them are finite.
    fn add_forces(
        &mut self,
        origin: Origin,
        forces: Vec<f64>,
        amplitude: Amplitude,
    ) -> Result<&mut Self, Error> {
        self.always(origin.kind())?;
        Error::check_finite(origin.kind(), &forces)?;
        if amplitude.is_proportional() {
            let sums = self.proportional.iter_mut().zip(&forces);
            sums.for_each(|(sum, force)| *sum += force);
        }
        self.loads.push((origin, Load::Scaled(forces, amplitude)));
        self.forces = self.forces_at(1.0);
        Ok(self)
    }

    /// Adds forces that are computed anew at each load factor.
    fn add_path(
        &mut self,
        origin: Origin,
        add: impl Fn(f64, &mut [f64]) + Send + Sync + 'static,
    ) -> Result<&mut Self, Error> {
        self.always(origin.kind())?;
        for t in samples() {
            let mut forces = vec![0.0; self.forces.len()];
            add(t, &mut forces);
            Error::check_finite(origin.kind(), &forces)?;
        }
        self.loads.push((origin, Load::Given(Arc::new(add))));
        self.forces = self.forces_at(1.0);
        Ok(self)
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

    /// The boundaries that supports name, and for each prescribed dof the first that did; the empty name stands for supports of
    /// nodes.
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

    /// The largest prescribed displacement (UL), and the largest sum of all magnitudes of forces (UF), at load factors up
    /// to 1; values that are not finite are left out.
    pub(super) fn largest(&self) -> (f64, f64) {
        let of = |t: f64| {
            let largest = self.largest_prescribed(t);
            let forces = self.loaded_at(t);
            let dead: f64 = forces.iter().map(|f| f.abs()).sum();
            (largest, dead + self.sum_of_pressures(t))
        };
        match self.has_program() {
            true => samples().map(of).fold((0.0, 0.0), |(u, f), (v, g)| {
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

/// Erases the types of element and material.
trait Law<const D: usize>: Send + Sync {
    fn is_small_strain(&self) -> bool;
    fn locks(&self) -> bool;
    fn rest_moduli(&self) -> (f64, f64);
    fn slopes(&self) -> [f64; 2];
    fn energy(&self, body: &Body<D>) -> Box<dyn BodyEnergy<D>>;
    fn add_body_force(
        &self,
        mesh: &Mesh<D>,
        force: &dyn Fn(&Vector<D>) -> Vector<D>,
        forces: &mut [f64],
    );
}

struct ElasticLaw<E, M>(E, Laws<M>);

/// The same with averaged changes of volume.
struct AveragedLaw<M>(M);

/// See [`Body::rest_moduli`].
fn rest_moduli<const D: usize>(law: &impl Material<D>) -> (f64, f64) {
    let rest = Deformation::new(Matrix::identity());
    let contraction = law.contraction(&rest);
    let along = |axis: usize| {
        let e = unit_vector(axis);
        contraction(&e, &e)[(0, 0)]
    };
    (along(1), along(0))
}

/// The same of several laws.
fn rest_moduli_of<const D: usize>(laws: &[impl Material<D>]) -> (f64, f64) {
    let mut all = laws.iter().map(rest_moduli);
    let first = all.next().unwrap_or((f64::NAN, f64::NAN));
    all.fold(first, |(shear, longitudinal), own| {
        let ratio = (longitudinal / shear).max(own.1 / own.0);
        let softer = shear.min(own.0);
        (softer, softer * ratio)
    })
}

/// See [`Body::law_slopes`].
fn slopes_of<const D: usize>(laws: &[impl Material<D>]) -> [f64; 2] {
    let sampled = laws.iter().step_by(laws.len().div_ceil(SAMPLED));
    let nan_max = |a: f64, b: f64| if a.is_nan() || a > b { a } else { b };
    sampled
        .map(conformance::slopes)
        .fold([0.0; 2], |worst, own| {
            std::array::from_fn(|k| nan_max(own[k], worst[k]))
        })
}

impl<const D: usize, E: Element<D>, M: Material<D>> Law<D> for ElasticLaw<E, M> {
    fn is_small_strain(&self) -> bool {
        M::QUADRATIC
    }

    fn locks(&self) -> bool {
        E::ORDER == Order::Linear
    }

    fn rest_moduli(&self) -> (f64, f64) {
        rest_moduli_of(self.1.all())
    }

    fn slopes(&self) -> [f64; 2] {
        slopes_of(self.1.all())
    }

    fn energy(&self, body: &Body<D>) -> Box<dyn BodyEnergy<D>> {
        let (dofs, prescribed) = body.eliminated();
        let (mesh, forces) = (&body.mesh, body.forces.clone());
        let energy = StrainEnergy::<D, E, M>::with_laws(mesh, &self.1, dofs, prescribed, forces);
        match M::QUADRATIC {
            true => Box::new(QuadraticEnergy::new(energy)),
            false => Box::new(energy),
        }
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

impl<const D: usize, M: Volumetric<D>> Law<D> for AveragedLaw<M>
where
    P1: Element<D>,
{
    fn is_small_strain(&self) -> bool {
        M::QUADRATIC
    }

    fn locks(&self) -> bool {
        false
    }

    fn rest_moduli(&self) -> (f64, f64) {
        rest_moduli(&self.0)
    }

    fn slopes(&self) -> [f64; 2] {
        conformance::slopes(&self.0)
    }

    fn energy(&self, body: &Body<D>) -> Box<dyn BodyEnergy<D>> {
        let (dofs, prescribed) = body.eliminated();
        let forces = body.forces.clone();
        Box::new(AveragedVolume::new(
            &body.mesh, &self.0, dofs, prescribed, forces,
        ))
    }

    fn add_body_force(
        &self,
        mesh: &Mesh<D>,
        force: &dyn Fn(&Vector<D>) -> Vector<D>,
        forces: &mut [f64],
    ) {
        add_body_force::<D, P1>(mesh, force, forces);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::NeoHookean;
    use crate::mesh::generators::{Diagonals, rectangle};

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
