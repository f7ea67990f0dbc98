//! Prescribed displacements.

use std::sync::Arc;

use super::Body;
use crate::error::Error;
use crate::model::courses::{Course, Path};
use crate::program::{Amplitude, Motion, samples};
use crate::tensor::{Vector, unit_vector};

/// Nodes are in one plane up to this share of the mesh's size.
const PLANE: f64 = 1e-9;

/// What supports of a whole body are called among those of boundaries.
pub const ALL_NODES: &str = "all nodes";
/// So many nodes are named.
const NAMED: usize = 8;

/// What a support of these nodes is called among those of boundaries: `node 12`, `nodes 3, 8`, and of more than eight
/// `nodes 3, 8, …, 40 (20)`, with their number.
///
/// ```
/// use contact_fem::model::name_of_nodes;
///
/// assert_eq!(name_of_nodes(&[8, 3, 8]), "nodes 3, 8");
/// ```
pub fn name_of_nodes(nodes: &[usize]) -> String {
    let mut own = nodes.to_vec();
    own.sort_unstable();
    own.dedup();
    let list: Vec<String> = own.iter().map(ToString::to_string).collect();
    match &list[..] {
        [node] => format!("node {node}"),
        [first, second, .., last] if list.len() > NAMED => {
            format!("nodes {first}, {second}, …, {last} ({})", list.len())
        }
        _ => format!("nodes {}", list.join(", ")),
    }
}

/// # Errors
/// No node.
pub(super) fn some(name: &'static str, nodes: &[usize]) -> Result<(), Error> {
    match nodes.is_empty() {
        true => Err(Error::Setting {
            name,
            value: 0.0,
            remedy: "name one node at least: check what selects them",
        }),
        false => Ok(()),
    }
}

impl<const D: usize> Body<D> {
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
    pub(super) fn nodes_to_support(&self, boundary: &str) -> Result<Vec<usize>, Error> {
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
        self.hold_moving((ALL_NODES, &nodes), motion)
    }

    /// As [`Body::prescribe_motion`], for the given nodes.
    ///
    /// # Errors
    /// As [`Body::prescribe_path`], and if there is no node, or one that does not exist.
    pub fn prescribe_motion_of_nodes(
        &mut self,
        nodes: &[usize],
        motion: Motion<D>,
    ) -> Result<&mut Self, Error> {
        some("number of supported nodes", nodes)?;
        self.check_nodes(nodes)?;
        self.hold_moving((&name_of_nodes(nodes), nodes), motion)
    }

    pub(super) fn hold_moving(
        &mut self,
        nodes: (&str, &[usize]),
        motion: Motion<D>,
    ) -> Result<&mut Self, Error> {
        let own = motion.clone();
        let path = move |t: f64, X: &Vector<D>| own.at(t, X) - X;
        self.hold_along(nodes, Arc::new(path), Some(motion))
    }

    pub(super) fn hold_along(
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
    pub(super) fn course(&mut self, amplitude: Amplitude) -> usize {
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
        self.prescribe_all_in_time(components, Amplitude::default())
    }

    /// As [`Body::prescribe_in_time`], for every node of the body.
    ///
    /// # Errors
    /// As [`Body::prescribe_in_time`].
    pub fn prescribe_all_in_time(
        &mut self,
        components: [Option<f64>; D],
        amplitude: impl Into<Amplitude>,
    ) -> Result<&mut Self, Error> {
        let nodes: Vec<usize> = (0..self.mesh.nodes().len()).collect();
        let course = self.course(amplitude.into());
        self.hold((ALL_NODES, &nodes), components, course)
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
        self.prescribe_nodes_in_time(nodes, components, Amplitude::default())
    }

    /// As [`Body::prescribe_in_time`], for the given nodes.
    ///
    /// # Errors
    /// As [`Body::prescribe_in_time`], and if there is no node, or one that does not exist.
    pub fn prescribe_nodes_in_time(
        &mut self,
        nodes: &[usize],
        components: [Option<f64>; D],
        amplitude: impl Into<Amplitude>,
    ) -> Result<&mut Self, Error> {
        some("number of supported nodes", nodes)?;
        let course = self.course(amplitude.into());
        self.hold((&name_of_nodes(nodes), nodes), components, course)
    }

    /// Prescribes values along a course, where there are none yet, or the same.
    pub(super) fn hold(
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
                if let Some((at, values)) = self.differs(dof, (value, course)) {
                    let name = self.support_of[dof].map(|name| self.supported[name].as_str());
                    let on = [name.unwrap_or_default(), boundary];
                    let direction = unit_vector(component);
                    return Err(self.conflict((node, direction), on, values, at));
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
        if self.is_rigid() {
            return self.or_not(|body| {
                let own = body.named(boundary);
                body.declare(own, held);
                body.follow_supports()
            });
        }
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

    /// Two supports, by their boundaries, that prescribe different displacements (UL) of a node along a direction of length 1.
    pub(super) fn conflict(
        &self,
        (node, direction): (usize, Vector<D>),
        on: [&str; 2],
        [first, second]: [f64; 2],
        at: f64,
    ) -> Error {
        Error::Conflict {
            node,
            x: self.mesh.nodes()[node].iter().copied().collect(),
            component: direction.iamax(),
            direction: direction.iter().copied().collect(),
            on: Box::new(on.map(str::to_string)),
            first,
            second,
            at,
        }
    }

    /// # Errors
    /// A node that does not exist.
    pub(super) fn check_nodes(&self, nodes: &[usize]) -> Result<(), Error> {
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
    pub(super) fn named(&mut self, boundary: &str) -> usize {
        let known = self.supported.iter().position(|name| name == boundary);
        known.unwrap_or_else(|| {
            self.supported.push(boundary.to_string());
            self.supported.len() - 1
        })
    }
}
