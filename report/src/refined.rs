//! A refined solution that is kept in a file, and its values anywhere in its bodies.

use std::fs;
use std::path::PathBuf;

use ipopt_contact::contact_fem::Mesh;
use ipopt_contact::contact_fem::element::{Element, Order, P1, P2};
use ipopt_contact::contact_fem::tensor::{Vector, inverse_transpose};
use ipopt_contact::prelude::*;
use rstar::RTree;
use rstar::primitives::{GeomWithData, Rectangle};
use serde::{Deserialize, Serialize};

use crate::Failure;
use crate::case::Case;
use crate::norms::{Jet, Local};

/// Where a family's refined solution is kept.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Place {
    /// The file.
    pub path: PathBuf,
    /// The revision that it must be of.
    pub revision: String,
    /// Whether the run is the refined one itself.
    pub is_refined: bool,
}

/// What is kept: the settings, from which the same mesh is built again, and u of all nodes (UL).
#[derive(Serialize, Deserialize)]
pub struct Kept {
    /// The settings.
    pub case: Case,
    revision: String,
    /// Components node by node.
    u: Vec<f64>,
}

impl Place {
    /// Writes a solution.
    pub fn save<const D: usize>(&self, case: &Case, u: &[Vector<D>]) -> Result<(), Failure> {
        let kept = Kept {
            case: case.clone(),
            revision: self.revision.clone(),
            u: u.iter().flat_map(|u| u.iter().copied()).collect(),
        };
        Ok(fs::write(&self.path, serde_json::to_vec(&kept)?)?)
    }

    /// Reads it; an error if there is none of this revision.
    pub fn load(&self) -> Result<Kept, Failure> {
        let kept: Option<Kept> = match self.path.exists() {
            true => Some(serde_json::from_slice(&fs::read(&self.path)?)?),
            false => None,
        };
        let kept = kept.filter(|kept| kept.revision == self.revision);
        kept.ok_or_else(|| {
            "the refined solution is missing; remove runs.jsonl to begin anew".into()
        })
    }
}

type Boxed<const D: usize> = GeomWithData<Rectangle<[f64; D]>, usize>;

/// A refined solution as a function of body and X.
pub struct Refined<const D: usize> {
    problem: Problem<D>,
    u: Vec<Vector<D>>,
    /// The cells of each body in boxes.
    cells: Vec<RTree<Boxed<D>>>,
}

impl<const D: usize> Refined<D>
where
    P1: Element<D>,
    P2: Element<D>,
{
    /// How far outside of a cell, in barycentric coordinates, a point still belongs to it: polygons and curved
    /// facets differ by a little.
    const OUTSIDE: f64 = 1e-4;

    /// What was kept of the scene that it was kept of.
    pub fn new(scene: Scene<D>, kept: &Kept) -> Result<Self, Failure> {
        let problem = scene.problem()?;
        let u: Vec<_> = kept
            .u
            .chunks_exact(D)
            .map(Vector::from_column_slice)
            .collect();
        if u.len() != problem.reference().len() {
            return Err("the refined solution that was kept belongs to another mesh".into());
        }
        let bodies = problem.scene().bodies().iter();
        let cells = bodies.map(|body| boxes(body.mesh())).collect();
        Ok(Refined { problem, u, cells })
    }

    /// u and ∇u at X, if that is in the body.
    pub fn at(&self, body: usize, X: &Vector<D>) -> Option<Jet<D>> {
        let mesh = self.problem.scene().bodies()[body].mesh();
        let u = &self.u[self.problem.nodes(body)];
        let point: [f64; D] = (*X).into();
        let candidates = self.cells[body].locate_all_at_point(point);
        let found = candidates.map(|cell| {
            let nodes = mesh.cell(cell.data);
            match mesh.order() {
                Order::Linear => within::<D, P1>(mesh, nodes, u, X),
                Order::Quadratic => within::<D, P2>(mesh, nodes, u, X),
            }
        });
        let best = found.max_by(|a, b| a.0.total_cmp(&b.0));
        best.filter(|(inside, _)| *inside > -Self::OUTSIDE)
            .map(|(_, jet)| jet)
    }
}

/// The smallest boxes around the cells, a tenth larger for what is curved.
fn boxes<const D: usize>(mesh: &Mesh<D>) -> RTree<Boxed<D>> {
    let boxed = |(k, cell): (usize, &[usize])| {
        let first = mesh.nodes()[cell[0]];
        let (low, high) = cell.iter().fold((first, first), |(low, high), &a| {
            (low.inf(&mesh.nodes()[a]), high.sup(&mesh.nodes()[a]))
        });
        let margin = (high - low) * 0.1;
        let corners = Rectangle::from_corners((low - margin).into(), (high + margin).into());
        GeomWithData::new(corners, k)
    };
    RTree::bulk_load(
        mesh.cells()
            .enumerate()
            .map(|(k, c)| boxed((k, c)))
            .collect(),
    )
}

/// The smallest barycentric coordinate of X in a cell, by Newton's method on X(ξ) = X, and the function there.
fn within<const D: usize, E: Element<D>>(
    mesh: &Mesh<D>,
    cell: &[usize],
    u: &[Vector<D>],
    X: &Vector<D>,
) -> (f64, Jet<D>) {
    let mut xi = Vector::<D>::repeat(1.0 / (D as f64 + 1.0));
    let mut at = Local::new::<E>(mesh, cell, u, &xi);
    for _ in 0..20 {
        let step = inverse_transpose(&at.dX).transpose() * (X - at.X);
        xi += step;
        at = Local::new::<E>(mesh, cell, u, &xi);
        if !(step.norm() > 1e-14) {
            break;
        }
    }
    let inside = (1.0 - xi.sum()).min(xi.min());
    let inside = if (at.X - X).norm().is_finite() {
        inside
    } else {
        f64::NEG_INFINITY
    };
    (inside, (at.u, at.gradient))
}

#[cfg(test)]
mod tests {
    use ipopt_contact::contact_fem::mesh::generators::onto_sphere;
    use ipopt_contact::contact_fem::tensor::Matrix;

    use super::*;
    use ipopt_contact_scenes::alone;

    /// Quadratic elements contain u = (x², x y): it comes back wherever cells are straight, and nowhere outside.
    #[test]
    fn fields_come_back() {
        let mesh = disc(1.0, 12, 3, 0.1).expect("mesh").quadratic();
        let mesh = mesh.curved("boundary", onto_sphere(1.0)).expect("curved");
        let mut body = Body::new(mesh, LinearElastic::new(1.0, 0.3).expect("law"));
        body.prescribe("boundary", [Some(0.0); 2]).expect("a side");
        let nodes: Vec<Vector<2>> = body.mesh().nodes().to_vec();
        let field = |X: &Vector<2>| Vector::<2>::new(X[0] * X[0], X[0] * X[1]);
        let kept = Kept {
            case: Case::new("any", 2, 1),
            revision: String::new(),
            u: nodes
                .iter()
                .flat_map(|X| <[f64; 2]>::from(field(X)))
                .collect(),
        };
        let refined = Refined::new(alone(body), &kept).expect("belongs");
        for X in [[0.0, 0.0], [0.3, 0.2], [-0.35, 0.41], [0.02, -0.5]].map(Vector::from) {
            let (u, gradient) = refined.at(0, &X).expect("inside");
            assert!((u - field(&X)).norm() < 1e-13, "{X:?}");
            let exact = Matrix::<2>::new(2.0 * X[0], 0.0, X[1], X[0]);
            assert!((gradient - exact).norm() < 1e-12, "{X:?}");
        }
        let bent = Vector::<2>::new(0.7, 0.7);
        let (u, _) = refined.at(0, &bent).expect("in a curved cell");
        assert!((u - field(&bent)).norm() < 1e-2);
        assert!(
            refined.at(0, &Vector::from([0.8, 0.8])).is_none(),
            "outside"
        );
        let other = Kept {
            u: vec![0.0; 4],
            ..kept
        };
        let mesh = disc(1.0, 12, 3, 0.1).expect("mesh");
        let mut body = Body::new(mesh, LinearElastic::new(1.0, 0.3).expect("law"));
        body.prescribe("boundary", [Some(0.0); 2]).expect("a side");
        assert!(Refined::new(alone(body), &other).is_err(), "another mesh");
    }

    #[test]
    fn solutions_of_other_revisions_are_not_taken() {
        let name = format!("report-refined-{}.json", std::process::id());
        let place = |revision: &str| Place {
            path: std::env::temp_dir().join(&name),
            revision: revision.into(),
            is_refined: false,
        };
        assert!(place("a").load().is_err(), "nothing there");
        let case = Case::new("any", 1, 3);
        let u = [Vector::<2>::new(0.1, 1.0 / 3.0)];
        place("a").save(&case, &u).expect("written");
        let kept = place("a").load().expect("there");
        assert_eq!((kept.case, kept.u), (case, vec![0.1, 1.0 / 3.0]));
        assert!(place("b").load().is_err(), "of another revision");
        fs::remove_file(place("a").path).expect("removed");
    }
}
