//! Cases as files that other programs read, with what their supports must carry.

use contact_fem::element::{Element, Order, P1, P2};
use contact_fem::material::Material;
use contact_fem::model::{InitialGaps, Problem};
use contact_fem::tensor::Vector;
use contact_fem::{Body, LinearElastic, Mesh, NeoHookean};
use serde::Serialize;
use serde_json::{Value, json};

use super::{Case, Check, Dimension, Setting, Truth};
use crate::Failure;

/// An elastic law by its name and constants.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub(super) struct Elastic {
    pub law: Law,
    /// Young's modulus (UF/UL²).
    pub young: f64,
    /// Poisson's ratio.
    pub poisson: f64,
}

impl Elastic {
    /// A body under this law.
    pub fn body<const D: usize>(self, mesh: Mesh<D>) -> Result<Body<D>, Failure>
    where
        LinearElastic: Material<D>,
        NeoHookean: Material<D>,
        P1: Element<D>,
        P2: Element<D>,
    {
        Ok(match self.law {
            Law::Linear => Body::new(mesh, LinearElastic::new(self.young, self.poisson)?),
            Law::NeoHookean => Body::new(mesh, NeoHookean::new(self.young, self.poisson)?),
        })
    }
}

/// The laws of the catalogue.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub(super) enum Law {
    /// Small strains.
    Linear,
    /// ψ = μ/2 (tr C − 3 − 2 ln J) + λ/2 (ln J)².
    NeoHookean,
}

/// What the supports of a body must exert on it at full load.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Reaction {
    /// The name of the value.
    pub what: &'static str,
    /// The body, by its place in the scene.
    pub body: usize,
    /// The component.
    pub axis: usize,
    /// The truth.
    #[serde(flatten)]
    pub must: Must,
    /// The largest difference that counts as right, as a share of the expected value.
    pub tolerance: f64,
    /// The value under Ciarlet's law ψ = μ/2 (tr C − 3 − 2 ln J) + λ/4 (J² − 1 − 2 ln J), where it is another one (UF).
    #[serde(skip_serializing_if = "Option::is_none")]
    pub be_ciarlet: Option<f64>,
}

/// A truth about a force of the supports.
#[derive(Clone, Copy, Debug, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Must {
    /// It has this value (UF).
    Be(f64),
    /// It is the opposite of the force on this body.
    Oppose(usize),
    /// It is larger (UF).
    Exceed(f64),
}

impl Reaction {
    pub(super) fn new(
        what: &'static str,
        [body, axis]: [usize; 2],
        must: Must,
        tolerance: f64,
    ) -> Self {
        Reaction {
            what,
            body,
            axis,
            must,
            tolerance,
            be_ciarlet: None,
        }
    }

    /// The truth for a run under a law that stands in for the scene's.
    pub(super) fn under(self, law: Option<&str>) -> Self {
        match (law, self.be_ciarlet) {
            (Some("ciarlet"), Some(value)) => Reaction {
                must: Must::Be(value),
                ..self
            },
            _ => self,
        }
    }

    /// The comparison with forces of all bodies, of which a run may have none.
    pub fn check(&self, reactions: &[Vec<f64>]) -> Check {
        let of = |body: usize| {
            let force = reactions.get(body).and_then(|force| force.get(self.axis));
            force.copied().unwrap_or(f64::NAN)
        };
        let found = of(self.body);
        match self.must {
            Must::Be(value) => Check::relative(self.what, found, value, self.tolerance),
            Must::Oppose(other) => Check::relative(self.what, found, -of(other), self.tolerance),
            Must::Exceed(least) => Check::that(self.what, found > least),
        }
    }
}

impl Case {
    /// Declares the laws of all bodies, in their order: other programs can read the case then.
    pub(super) fn with_laws(self, laws: Vec<Elastic>) -> Self {
        Case { laws, ..self }
    }

    /// What its supports must carry, if that is the whole truth about it.
    pub fn reactions(&self) -> Option<Vec<Reaction>> {
        match &self.dimension {
            Dimension::Plane(setting) => setting.reactions(),
            Dimension::Space(setting) => setting.reactions(),
        }
    }

    /// The case for other programs, if they can be told it: meshes, laws, supports, loads, pairs, and what must come of them.
    ///
    /// # Errors
    /// If the scene is refused.
    pub fn exchanged(&self) -> Result<Option<Value>, Failure> {
        if self.laws.is_empty() {
            return Ok(None);
        }
        let Some(checks) = self.reactions() else {
            return Ok(None);
        };
        let (dimension, parts) = match &self.dimension {
            Dimension::Plane(setting) => (2, setting.exchanged(&self.laws)?),
            Dimension::Space(setting) => (3, setting.exchanged(&self.laws)?),
        };
        let mut file = json!({
            "name": self.name,
            "class": self.class,
            "dimension": dimension,
            "increments": self.increments,
            "checks": checks,
        });
        if let (Value::Object(file), Value::Object(parts)) = (&mut file, parts) {
            file.extend(parts);
        }
        Ok(Some(file))
    }
}

impl<const D: usize> Setting<D> {
    fn reactions(&self) -> Option<Vec<Reaction>> {
        match &self.truth {
            Truth::Reactions(all) => Some(all()),
            Truth::Values(_) | Truth::Refused(_) => None,
        }
    }

    fn exchanged(&self, laws: &[Elastic]) -> Result<Value, Failure> {
        let scene = (self.scene)()?;
        let names = scene.names().to_vec();
        let initial_gaps = match scene.initial_gaps {
            InitialGaps::Refuse => "refuse",
            InitialGaps::Resolve => "resolve",
            InitialGaps::Adjust => "adjust",
        };
        let problem = scene.problem()?;
        let bodies = problem.scene().bodies().iter().zip(&names).zip(laws);
        let bodies: Vec<Value> = bodies
            .map(|((body, name), elastic)| {
                let dofs = |values: &mut dyn Iterator<Item = Option<f64>>| -> Vec<Value> {
                    let values = values.enumerate();
                    let given = values.filter_map(|(dof, value)| Some((dof, value?)));
                    given
                        .map(|(dof, value)| json!([dof / D, dof % D, value]))
                        .collect()
                };
                let mesh = body.mesh();
                json!({
                    "name": name,
                    "degree": if mesh.order() == Order::Linear { 1 } else { 2 },
                    "nodes": mesh.nodes().iter().map(Vector::as_slice).collect::<Vec<_>>(),
                    "cells": mesh.cells().collect::<Vec<_>>(),
                    "law": elastic.law,
                    "young": elastic.young,
                    "poisson": elastic.poisson,
                    "prescribed": dofs(&mut body.prescribed().iter().copied()),
                    "forces": dofs(&mut body.forces().iter().map(|f| (*f != 0.0).then_some(*f))),
                })
            })
            .collect();
        Ok(json!({ "initial_gaps": initial_gaps, "bodies": bodies, "pairs": pairs(&problem) }))
    }
}

/// The pairs of surfaces, each once, with the nodes of their facets as the bodies number them.
fn pairs<const D: usize>(problem: &Problem<D>) -> Vec<Value> {
    let mut pairs: Vec<[usize; 2]> = Vec::new();
    for pass in problem.passes() {
        let pair = [pass.slave.min(pass.master), pass.slave.max(pass.master)];
        if !pairs.contains(&pair) {
            pairs.push(pair);
        }
    }
    let side = |k: usize| {
        let surface = &problem.surfaces()[k];
        let first = problem.first_node(surface.body());
        let facets = surface.facets().map(|facet| {
            let nodes = facet.iter().map(|a| surface.nodes()[*a] - first);
            nodes.collect::<Vec<usize>>()
        });
        json!({ "body": surface.body(), "facets": facets.collect::<Vec<_>>() })
    };
    let each = pairs.into_iter();
    each.map(|[a, b]| json!({ "first": side(a), "second": side(b) }))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Weights, ways and surfaces are in the file as the scene has them.
    #[test]
    fn files_have_the_whole_scene() {
        let all = crate::extremes::all();
        let first = all.iter().find(|case| case.name == "stack");
        let first = first.expect("there is one");
        let file = first.exchanged().expect("a scene").expect("forces");
        let body = |k: usize| &file["bodies"][k];
        let facets = |side: &str| file["pairs"][0][side]["facets"].as_array().map(Vec::len);
        let mut sides = [facets("first"), facets("second")];
        sides.sort_unstable();
        assert_eq!(sides, [Some(3), Some(4)]);
        assert_eq!(body(1)["nodes"].as_array().map(Vec::len), Some(25));
        assert_eq!(body(1)["cells"].as_array().map(Vec::len), Some(32));
        let ways = body(1)["prescribed"].as_array().expect("supports").iter();
        let down = ways.filter(|way| way[1] == 1).map(|way| way[2].as_f64());
        assert_eq!(down.collect::<Vec<_>>(), [Some(-0.1); 5]);
        assert_eq!(
            (&body(0)["law"], &body(0)["poisson"]),
            (&json!("neo-hookean"), &json!(0.3))
        );

        let resting = all
            .iter()
            .find(|case| case.name == "3 linear blocks at rest, weight 1e0");
        let file = resting
            .expect("there is one")
            .exchanged()
            .expect("a scene")
            .expect("forces");
        let bodies = file["bodies"].as_array().expect("bodies").iter();
        let forces = bodies.flat_map(|body| body["forces"].as_array().expect("loads"));
        let weight: f64 = forces
            .filter(|force| force[1] == 1)
            .filter_map(|f| f[2].as_f64())
            .sum();
        assert!((weight + 3.0).abs() < 1e-12, "{weight}");
        assert_eq!(file["checks"][0]["be"], json!(3.0));
    }
}
