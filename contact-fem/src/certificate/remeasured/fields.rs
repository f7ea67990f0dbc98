//! Virtual motions of a body.

use std::f64::consts::TAU;
use std::ops::Range;

use crate::model::Problem;
use crate::tensor::Vector;

/// A motion of one body: a vector for each of its nodes, of which the longest is about 1.
pub(super) struct Field<const D: usize> {
    nodes: Range<usize>,
    motion: Vec<Vector<D>>,
}

impl<const D: usize> Field<D> {
    /// Translations and, about the middle of the forces, rotations of the first body of a pair, and two waves as long as the place where forces
    /// act of each. The gaps do not tell which of the two moves rigidly. A body against itself has the waves alone, since rigid
    /// motions do no work.
    pub fn of_pair(
        problem: &Problem<D>,
        bodies: [usize; 2],
        x: &[Vector<D>],
        forces: &[Vector<D>],
    ) -> Vec<Self> {
        let sum: f64 = forces.iter().map(Vector::norm).sum();
        let weighted = x.iter().zip(forces).map(|(x, f)| x * f.norm());
        let centre = weighted.sum::<Vector<D>>() / sum;
        let loaded = x.iter().zip(forces).filter(|(_, f)| f.norm() > 0.0);
        let extent = loaded.map(|(x, _)| (x - centre).norm()).fold(0.0, f64::max);
        let mut fields = Vec::new();
        for (k, body) in bodies.into_iter().enumerate() {
            if k == 1 && bodies[0] == bodies[1] {
                continue;
            }
            let nodes = problem.nodes(body);
            let mut add = |at: &dyn Fn(&Vector<D>) -> Vector<D>| {
                let offsets = x[nodes.clone()].iter().map(|x| (x - centre) / extent);
                let motion = offsets.map(|offset| at(&offset)).collect();
                fields.push(Field {
                    nodes: nodes.clone(),
                    motion,
                });
            };
            if k == 0 && bodies[0] != bodies[1] {
                for i in 0..D {
                    add(&|_| crate::tensor::unit_vector(i));
                    (0..i).for_each(|j| {
                        add(&|r| {
                            crate::tensor::unit_vector::<D>(i) * r[j]
                                - crate::tensor::unit_vector::<D>(j) * r[i]
                        });
                    });
                }
            }
            for phase in [0.1, 0.37] {
                add(&|r| {
                    let along = |i: usize| r[i] + 0.6 * r[(i + 1) % D];
                    Vector::from_fn(|i, _| (TAU * (0.5 * along(i) + phase)).sin())
                });
            }
        }
        fields
    }

    /// The positions `x` after a share of the motion.
    pub fn moved(&self, x: &[Vector<D>], share: f64) -> Vec<Vector<D>> {
        let mut moved = x.to_vec();
        let own = moved[self.nodes.clone()].iter_mut();
        own.zip(&self.motion).for_each(|(x, v)| *x += v * share);
        moved
    }

    /// The work of forces on all nodes, and the sum of |force| |motion|.
    pub fn work(&self, forces: &[Vector<D>]) -> [f64; 2] {
        let own = forces[self.nodes.clone()].iter().zip(&self.motion);
        own.fold([0.0; 2], |[work, most], (f, v)| {
            [work + f.dot(v), most + f.norm() * v.norm()]
        })
    }
}
