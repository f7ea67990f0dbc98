//! What is known of a scene before its run.

use std::fmt;

use contact_core::{Energy, Separable};

use super::{BodyId, Problem};

/// What a scene leaves to be found, as it is known before the run. Solvers rely on it.
///
/// | part | what relies on it | how it is checked |
/// |---|---|---|
/// | `groups` | no row acts between two of them, so that they are solved by themselves | the audit of every state looks at all bodies |
/// | `held` | within a group, such bodies are solved by themselves as long as no common row acts on them | rows between them after each solve, which is repeated for both together where one overlaps |
/// | `linear` | their stiffness is assembled and factored once | the values are compared before they are factored |
/// | `prescribed` | they have no unknowns | – |
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct ScenePlan {
    /// The bodies that contact can join, group by group; a body that no pair names is one by itself.
    pub groups: Vec<Vec<BodyId>>,
    /// The bodies that supports alone hold.
    pub held: Vec<BodyId>,
    /// The bodies with a law for small strains.
    pub linear: Vec<BodyId>,
    /// The bodies whose nodes are all prescribed.
    pub prescribed: Vec<BodyId>,
}

impl<const D: usize> Problem<D> {
    /// What is known before a run.
    pub fn plan(&self) -> ScenePlan {
        let energies = self.body_energies();
        let of = |is: &dyn Fn(usize) -> bool| -> Vec<BodyId> {
            let bodies = (0..energies.len()).filter(|&b| is(b));
            bodies.map(BodyId::from).collect()
        };
        let moves = |b: usize| energies[b].dofs() > 0;
        let mut first: Vec<usize> = (0..energies.len()).collect();
        for [a, b] in Separable::passes(self) {
            // what is prescribed joins nothing
            if moves(a) && moves(b) {
                let (kept, other) = (first[a].min(first[b]), first[a].max(first[b]));
                let joined = first.iter_mut().filter(|first| **first == other);
                joined.for_each(|first| *first = kept);
            }
        }
        let groups = (0..energies.len()).filter(|&b| first[b] == b && moves(b));
        ScenePlan {
            groups: groups.map(|g| of(&|b| first[b] == g && moves(b))).collect(),
            held: of(&|b| self.is_held(b)),
            linear: of(&|b| energies[b].is_quadratic()),
            prescribed: of(&|b| !moves(b)),
        }
    }
}

impl fmt::Display for ScenePlan {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let bodies: usize = self.groups.iter().map(Vec::len).sum();
        let largest = self.groups.iter().map(Vec::len).max().unwrap_or(0);
        write!(
            f,
            "{} bodies: {} linear, {} prescribed, {} held by supports; contact may join {bodies} to {} groups of at most {largest}",
            bodies + self.prescribed.len(),
            self.linear.len(),
            self.prescribed.len(),
            self.held.len(),
            self.groups.len(),
        )
    }
}

#[cfg(test)]
mod tests {
    use crate::mesh::generators::{Diagonals, linspace, rectangle};
    use crate::{Body, LinearElastic, NeoHookean, Scene};

    /// A held linear block, a loose neo-Hookean one on it, a tool above, and a second block under the tool.
    #[test]
    fn plans_tell_what_is_known() {
        let mesh = |x: f64, y: f64| {
            let [xs, ys] = [x, y].map(|low| linspace(low, low + 1.0, 2));
            rectangle(&xs, &ys, Diagonals::Rising).expect("a mesh")
        };
        let soft = || NeoHookean::new(1.0, 0.3).expect("a law");
        let mut base = Body::new(mesh(0.0, 0.0), LinearElastic::new(1.0, 0.3).expect("a law"));
        base.prescribe("bottom", [Some(0.0); 2]).expect("held");
        let loose = Body::new(mesh(0.0, 1.0), soft());
        let mut tool = Body::new(mesh(0.0, 2.0), soft());
        tool.prescribe_all([Some(0.0), Some(-0.1)]).expect("moved");
        let mut beside = Body::new(mesh(3.0, 1.0), soft());
        beside.prescribe("bottom", [Some(0.0); 2]).expect("held");
        let mut scene = Scene::new();
        scene.geometry = Some(crate::model::Geometry::Current);
        let base = scene.add("base", base);
        let loose = scene.add("loose", loose);
        let tool = scene.add("tool", tool);
        let beside = scene.add("beside", beside);
        scene
            .contact(base.on("top"), loose.on("bottom"))
            .expect("a pair");
        scene
            .contact(loose.on("top"), tool.on("bottom"))
            .expect("a pair");
        scene
            .contact(beside.on("top"), tool.on("right"))
            .expect("a pair");
        let plan = scene.problem().expect("a problem").plan();
        assert_eq!(plan.groups, [vec![base, loose], vec![beside]]);
        assert_eq!(plan.held, [base, tool, beside]);
        assert_eq!(plan.linear, [base]);
        assert_eq!(plan.prescribed, [tool]);
        let told = "4 bodies: 1 linear, 1 prescribed, 3 held by supports; contact may join 3 to 2 groups of at most 2";
        assert_eq!(plan.to_string(), told);
    }
}
