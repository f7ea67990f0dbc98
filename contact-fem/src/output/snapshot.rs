//! The fields of one state, for writing and drawing.

use contact_core::LinearGaps;
use contact_core::equilibrium::Solution;

use crate::assembly::CellState;
use crate::certificate::Certificate;
use crate::error::Error;
use crate::mesh::Mesh;
use crate::model::{CellErrors, Opposite, PairRecord, PairSide, PairState, Problem, Side, Status};
use crate::simulation::StepView;
use crate::tensor::Vector;

/// Displacement, contact pressure and stress of all bodies at one load.
///
/// Nodes and cells are numbered body by body, in the order of the bodies.
///
/// A block under pressure has σ_yy = −3, and σ_zz = ν σ_yy in plane strain, in every cell:
/// ```
/// # #[cfg(feature = "ipopt")]
/// # fn main() -> Result<(), Box<dyn std::error::Error>> {
/// use contact_fem::mesh::generators::{Diagonals, linspace, rectangle};
/// use contact_fem::output::Snapshot;
/// use contact_fem::{Body, LinearElastic, Scene, Simulation};
///
/// let sides = linspace(0.0, 1.0, 3);
/// let mut block = Body::new(rectangle(&sides, &sides, Diagonals::Rising)?, LinearElastic::new(100.0, 0.3)?);
/// block.prescribe("bottom", [None, Some(0.0)])?;
/// block.prescribe("left", [Some(0.0), None])?;
/// block.traction("top", [0.0, -3.0])?;
/// let mut scene = Scene::new();
/// scene.add("block", block);
/// let mut problem = scene.problem()?;
///
/// let history = Simulation::with_increments(1).run(&mut problem)?;
/// let solution = history.run.solution.as_ref().ok_or("not converged")?;
/// for cell in Snapshot::new(&problem, solution)?.cells {
///     assert!((cell.sigma[(1, 1)] + 3.0).abs() < 1e-9 && cell.sigma[(0, 0)].abs() < 1e-9);
///     assert!((cell.sigma_zz + 0.3 * 3.0).abs() < 1e-9);
/// }
/// # Ok(())
/// # }
/// # #[cfg(not(feature = "ipopt"))]
/// # fn main() {}
/// ```
#[derive(Clone, Debug)]
pub struct Snapshot<const D: usize> {
    /// The load factor, at which obstacles are where they are.
    pub load_factor: f64,
    /// u at every node (UL).
    pub displacements: Vec<Vector<D>>,
    /// The recovered contact pressure at every node (UF/UL², ≥ 0), see [`Problem::pressures`]:
    /// 0 outside the contact surfaces, the largest where several meet in a corner.
    pub pressures: Vec<f64>,
    /// The consistent contact pressure, see [`Problem::consistent_pressures`], likewise.
    pub consistent_pressures: Vec<f64>,
    /// The pressures at each place of contact by itself.
    pub places: Vec<Place>,
    /// The smallest gap of every node to the surfaces that it may touch (UL), positive = open; `+∞` where none is in reach, and
    /// outside the contact surfaces.
    pub gaps: Vec<f64>,
    /// Whether every node is open, touches or presses.
    pub statuses: Vec<Status>,
    /// The outward unit normal of the contact surface at every node where contact is searched; of the one with the larger pressure where
    /// two meet, and zero outside of the surfaces.
    pub contact_normals: Vec<Vector<D>>,
    /// The contact force Cᵀλ on every node, with friction where there is some (UF).
    pub contact_forces: Vec<Vector<D>>,
    /// Stress and volume ratio of every cell.
    pub cells: Vec<CellState<D>>,
    /// Stress and volume ratio at every node: means over its cells, weighted by their volumes. Each cell has there the linear function
    /// that is closest to the values at its quadrature points, a linear cell its constant.
    pub averages: Vec<CellState<D>>,
    /// The estimated error of every cell, see [`ErrorEstimate::cells`](crate::model::ErrorEstimate::cells).
    pub errors: Vec<f64>,
    /// The certificate, if the state is a converged step.
    pub certificate: Option<Certificate>,
}

/// A surface of a pair, or one on an obstacle, with the pressures there.
#[derive(Clone, Debug, PartialEq)]
pub struct Place {
    /// Its boundary and what that meets, by their names: `block bottom on floor`.
    pub name: String,
    /// The surface, as its position in [`Problem::surfaces`].
    pub surface: usize,
    /// The recovered pressures of the pair at the surface's nodes (UF/UL², ≥ 0), see [`PairSide::pressures`](crate::model::PairSide::pressures).
    pub pressures: Vec<f64>,
}

impl Place {
    /// Both sides of each pair.
    fn all<const D: usize>(problem: &Problem<D>, states: Vec<PairState<D>>) -> Vec<Self> {
        let scene = problem.scene();
        let body = |side: &Side| scene.names()[side.body.index()].clone();
        let boundary = |side: &Side| format!("{} {}", body(side), side.boundary);
        let names = |record: &PairRecord<D>| match &record.second {
            Opposite::Obstacle(id) => {
                let obstacle = &scene.obstacle_names()[id.index()];
                [
                    format!("{} on {obstacle}", boundary(&record.first)),
                    String::new(),
                ]
            }
            Opposite::Side(second) if *second == record.first => {
                [format!("{} on itself", boundary(second)), String::new()]
            }
            Opposite::Side(second) => [(&record.first, second), (second, &record.first)]
                .map(|(own, other)| format!("{} on {}", boundary(own), body(other))),
        };
        let sides = states
            .into_iter()
            .flat_map(|state| names(&state.record).into_iter().zip(state.sides));
        let place = |(name, side): (String, PairSide<D>)| Place {
            name,
            surface: side.surface,
            pressures: side.pressures,
        };
        sides.map(place).collect()
    }
}

impl<const D: usize> Snapshot<D> {
    /// The state `solution`; `problem` must be at the load of the solution.
    ///
    /// # Errors
    /// If the solution is not of this problem, or has values that are not finite; as [`Problem::pressures`].
    pub fn new(problem: &Problem<D>, solution: &Solution) -> Result<Self, Error> {
        let (gaps, lambda) = (&solution.gaps, &solution.lambda);
        let state = Self::with_contact(problem, problem.load(), &solution.state.u, (gaps, lambda))?;
        Ok(match solution.friction {
            None => state,
            Some(_) => Snapshot {
                contact_forces: problem.surface_forces(solution),
                ..state
            },
        })
    }

    /// A converged step, with its certificate.
    ///
    /// # Errors
    /// As [`Problem::pressures`].
    pub fn of_step(step: &StepView<'_, D>) -> Result<Self, Error> {
        Ok(Snapshot {
            certificate: Some(step.record.certificate),
            ..Self::new(step.problem, step.solution)?
        })
    }

    /// The state without displacement and contact, before the first load step.
    ///
    /// # Errors
    /// As [`Problem::pressures`].
    pub fn at_rest(problem: &Problem<D>) -> Result<Self, Error> {
        let u = vec![0.0; problem.dofs().free()];
        Self::with_contact(problem, 0.0, &u, (&LinearGaps::new(true), &[]))
    }

    /// Checks that there is a value for each node and each cell of `problem`.
    #[cfg(any(feature = "plot", feature = "vtk"))]
    pub(super) fn check(&self, problem: &Problem<D>) -> Result<(), Error> {
        let (nodes, bodies) = (problem.reference().len(), problem.scene().bodies().iter());
        let cells = bodies.map(|body| body.mesh().len()).sum();
        for (what, found, expected) in [
            ("Snapshot::displacements", self.displacements.len(), nodes),
            ("Snapshot::pressures", self.pressures.len(), nodes),
            (
                "Snapshot::consistent_pressures",
                self.consistent_pressures.len(),
                nodes,
            ),
            ("Snapshot::gaps", self.gaps.len(), nodes),
            ("Snapshot::statuses", self.statuses.len(), nodes),
            (
                "Snapshot::contact_normals",
                self.contact_normals.len(),
                nodes,
            ),
            ("Snapshot::averages", self.averages.len(), nodes),
            ("Snapshot::contact_forces", self.contact_forces.len(), nodes),
            ("Snapshot::cells", self.cells.len(), cells),
            ("Snapshot::errors", self.errors.len(), cells),
        ] {
            contact_core::Error::check_length_of(what, found, expected)?;
        }
        self.places.iter().try_for_each(|place| {
            let surface = problem.surfaces().get(place.surface);
            let nodes = surface.map_or(0, |surface| surface.nodes().len());
            let what = "Snapshot::places, the pressures of one";
            Ok(contact_core::Error::check_length_of(
                what,
                place.pressures.len(),
                nodes,
            )?)
        })
    }

    fn with_contact(
        problem: &Problem<D>,
        load_factor: f64,
        u: &[f64],
        (gaps, lambda): (&LinearGaps, &[f64]),
    ) -> Result<Self, Error> {
        contact_core::Error::check_vector("u", u, problem.dofs().free())?;
        let displacements = problem.displacements(u);
        let states = problem.pair_states(u, gaps, lambda)?;
        let [mut pressures, mut consistent_pressures] =
            [0, 1].map(|_| vec![0.0; displacements.len()]);
        let of_surfaces = [
            problem.surface_pressures(&states),
            problem.consistent_pressures(u, gaps, lambda)?,
        ];
        // a node in a corner has its largest pressure and the normal there
        let mut contact_normals = vec![Vector::<D>::zeros(); displacements.len()];
        let [of_surfaces, consistent] = of_surfaces;
        let surfaces = problem.surfaces().iter().zip(problem.contact_normals(u));
        for ((surface, normals), (own, consistent)) in
            surfaces.zip(of_surfaces.iter().zip(&consistent))
        {
            for (k, &node) in surface.nodes().iter().enumerate() {
                let is_first = contact_normals[node].norm() == 0.0;
                if is_first || own[k] > pressures[node] || own[k].is_nan() {
                    pressures[node] = own[k];
                    consistent_pressures[node] = consistent[k];
                    contact_normals[node] = normals[k];
                }
            }
        }
        let mut nodal_gaps = vec![f64::INFINITY; displacements.len()];
        let mut statuses = vec![Status::Open; displacements.len()];
        for side in states.iter().flat_map(|state| &state.sides) {
            let surface = &problem.surfaces()[side.surface];
            let nodes = surface.nodes().iter().zip(surface.node_sizes());
            for ((&node, size), gap) in nodes.zip(&side.gaps) {
                let gap = gap.unwrap_or(f64::INFINITY);
                nodal_gaps[node] = nodal_gaps[node].min(gap);
                if gap < Status::TOUCHES * size {
                    statuses[node] = Status::Touching;
                }
            }
        }
        let pressing = pressures.iter().enumerate().filter(|(_, p)| **p > 0.0);
        pressing.for_each(|(node, _)| statuses[node] = Status::Pressing);
        let bodies = problem.scene().bodies().iter().zip(problem.body_energies());
        let (mut cells, mut averages) = (Vec::new(), Vec::new());
        for (k, (body, energy)) in bodies.enumerate() {
            let own = &displacements[problem.nodes(k)];
            averages.extend(averaged(
                body.mesh(),
                &energy.nodal_states(body.mesh(), own),
            ));
            cells.extend(energy.cell_states(body.mesh(), own));
        }
        Ok(Snapshot {
            load_factor,
            displacements,
            pressures,
            consistent_pressures,
            places: Place::all(problem, states),
            gaps: nodal_gaps,
            statuses,
            contact_normals,
            averages,
            contact_forces: problem.contact_forces(gaps, lambda),
            cells,
            errors: CellErrors::new(problem, u).shares(),
            certificate: None,
        })
    }
}

/// The means over the cells around each node of a mesh, weighted by the cells' volumes, of what the cells have at their nodes.
fn averaged<const D: usize>(mesh: &Mesh<D>, nodal: &[CellState<D>]) -> Vec<CellState<D>> {
    let mut around = vec![Vec::new(); mesh.nodes().len()];
    let mut nodal = nodal.iter();
    for (k, nodes) in mesh.cells().enumerate() {
        let volume = mesh.volume(k);
        for (&a, state) in nodes.iter().zip(nodal.by_ref()) {
            around[a].push((volume, state));
        }
    }
    // every node belongs to a cell
    let mean = |own: Vec<(f64, &CellState<D>)>| {
        let total: f64 = own.iter().map(|(volume, _)| volume).sum();
        CellState::sum(
            own.into_iter()
                .map(|(volume, state)| (volume / total, state)),
        )
    };
    around.into_iter().map(mean).collect()
}

/// All cells of all bodies as (body, scene node numbers), in the order of [`Snapshot::cells`].
#[cfg(any(feature = "plot", feature = "vtk"))]
pub(super) fn cells<const D: usize>(
    problem: &Problem<D>,
) -> impl Iterator<Item = (usize, impl Iterator<Item = usize>)> {
    let bodies = problem.scene().bodies().iter().enumerate();
    bodies.flat_map(move |(k, body)| {
        let first = problem.first_node(k);
        let cells = body.mesh().cells();
        cells.map(move |cell| (k, cell.iter().map(move |a| first + a)))
    })
}

#[cfg(test)]
pub(super) mod tests {
    use contact_core::gaps::Sampling;

    use super::*;
    use crate::element::{Element, P1, P2};
    use crate::mesh::generators::{Diagonals, cuboid, rectangle};
    use crate::{Body, LinearElastic, NeoHookean, Scene};

    fn held<const D: usize>(mesh: Mesh<D>) -> Body<D>
    where
        P1: Element<D>,
        P2: Element<D>,
    {
        let mut body = Body::new(mesh, NeoHookean::new(10.0, 0.3).expect("a law"));
        let nodes: Vec<usize> = (0..D).collect();
        body.prescribe_nodes(&nodes, [Some(0.0); D]).expect("held");
        body
    }

    /// Two squares of two triangles each, one on top of the other.
    pub fn squares() -> Problem<2> {
        let square =
            |y: f64| rectangle(&[0.0, 1.0], &[y, y + 1.0], Diagonals::Rising).expect("a square");
        let mut scene = Scene::new();
        let lower = scene.add("lower", held(square(0.0)));
        let upper = scene.add("upper", held(square(1.1)));
        scene
            .contact(lower.on("top"), upper.on("bottom"))
            .expect("a pair");
        scene.problem().expect("a problem")
    }

    /// One tetrahedron.
    #[cfg(any(feature = "vtk", feature = "plot"))]
    pub fn tetrahedron() -> Problem<3> {
        let corners = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
        let mesh = Mesh::new(corners.to_vec(), vec![0, 1, 2, 3]).expect("a mesh");
        let mut scene = Scene::new();
        scene.add("tetrahedron", held(mesh));
        scene.problem().expect("a problem")
    }

    /// Every free component is displaced by 0.1, and every row has a multiplier of 3.
    pub fn displaced<const D: usize>(problem: &Problem<D>) -> Snapshot<D> {
        let u = vec![0.1; problem.dofs().free()];
        let gaps = problem.rows(&u, Sampling::Nodes).expect("a state");
        let lambda = vec![3.0; gaps.len()];
        Snapshot::with_contact(problem, problem.load(), &u, (&gaps, &lambda)).expect("a snapshot")
    }

    #[test]
    fn pressure_is_on_the_surfaces_only() {
        let problem = squares();
        let rest = Snapshot::at_rest(&problem).expect("a snapshot");
        assert!(rest.pressures.iter().all(|&p| p == 0.0));
        assert!(rest.cells.iter().all(|cell| cell.von_mises() == 0.0));
        let displaced = displaced(&problem);
        for (k, p) in displaced.pressures.iter().enumerate() {
            // the top of the lower square and the bottom of the upper one
            assert_eq!(*p != 0.0, (2..6).contains(&k), "node {k}: {p}");
        }
        assert_eq!(displaced.cells.len(), 4);
        for (k, status) in displaced.statuses.iter().enumerate() {
            assert_eq!(*status == Status::Pressing, (2..6).contains(&k), "node {k}");
        }
        assert!(rest.statuses.iter().all(|status| *status == Status::Open));
        for (k, gap) in rest.gaps.iter().enumerate() {
            let is_contact_node = (2..6).contains(&k);
            let expected = if is_contact_node { 0.1 } else { f64::INFINITY };
            assert!(*gap == expected || (gap - expected).abs() < 1e-12, "{gap}");
        }
        // the lower top moves up by 0.1, and the upper bottom is held: these two nodes still face each other's square
        assert!(displaced.gaps[2].abs() < 1e-12 && displaced.gaps[5].abs() < 1e-12);
        // the outward normals of a top and a bottom
        assert!((displaced.contact_normals[2][1] - 1.0).abs() < 1e-12);
        assert!((displaced.contact_normals[4][1] + 1.0).abs() < 1e-12);
        assert_eq!(displaced.contact_normals[0], Vector::<2>::zeros());
        assert_eq!(displaced.displacements[2], Vector::<2>::repeat(0.1));
    }

    /// Quadratic cells have linear stresses: those of pure bending, u = κ (x y, −x²/2), are exact at all nodes, on the boundary, too.
    #[test]
    fn stresses_of_quadratic_cells_are_exact_in_bending() {
        fn check<const D: usize>(mesh: Mesh<D>)
        where
            P1: Element<D>,
            P2: Element<D>,
        {
            let (E, nu, curvature) = (100.0, 0.3, 1e-3);
            let mesh = mesh.quadratic();
            let law = LinearElastic::new(E, nu).expect("a law");
            let mut body = Body::new(mesh.clone(), law);
            body.prescribe("bottom", [Some(0.0); D]).expect("held");
            let mut scene = Scene::new();
            scene.add("beam", body);
            let problem = scene.problem().expect("a problem");
            let bent = |X: &Vector<D>| {
                let mut u = Vector::<D>::zeros();
                u[0] = curvature * X[0] * X[1];
                u[1] = -0.5 * curvature * X[0] * X[0];
                u
            };
            let U: Vec<Vector<D>> = mesh.nodes().iter().map(bent).collect();
            let nodal = problem.body_energies()[0].nodal_states(&mesh, &U);
            // ε_xx = κ y alone
            let stiffness = E * (1.0 - nu) / ((1.0 + nu) * (1.0 - 2.0 * nu));
            for (X, state) in mesh.nodes().iter().zip(averaged(&mesh, &nodal)) {
                let expected = stiffness * curvature * X[1];
                assert!(
                    (state.sigma[(0, 0)] - expected).abs() < 1e-12,
                    "{X}: {state:?}"
                );
                assert!(state.sigma[(0, 1)].abs() < 1e-12, "{X}: {state:?}");
            }
        }
        let sides = [0.0, 0.3, 1.0, 1.2];
        check(rectangle(&sides, &[0.0, 0.5, 2.0], Diagonals::Alternating).expect("a mesh"));
        check(cuboid([0.0; 3], [1.0, 2.0, 1.5], [2, 3, 1]).expect("a mesh"));
    }
}
