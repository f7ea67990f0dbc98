//! What can be known to be wrong with a scene before any solve.

use nalgebra::DMatrix;

use super::{Body, Problem, Scene};
use crate::contact::gaps::deepest_node;
use crate::contact::{Master, Surface};
use crate::error::Error;
use crate::tensor::Vector;

/// Settings within their ranges.
pub(super) fn settings<const D: usize>(scene: &Scene<D>) -> Result<(), Error> {
    let setting = |name, value, remedy| {
        Err(Error::Setting {
            name,
            value,
            remedy,
        })
    };
    if scene.bodies.is_empty() {
        return setting("bodies", 0.0, "a scene needs at least one body");
    }
    if scene.gauss_points == 0 || scene.gauss_points > 64 {
        return setting(
            "gauss_points",
            scene.gauss_points as f64,
            "choose 1 to 64, 4 by default",
        );
    }
    match scene.reach {
        Some(reach) if reach.is_nan() || reach <= 0.0 => {
            setting("reach", reach, "a positive length, or None for the default")
        }
        _ if scene.overlap_tolerance.is_nan() || scene.overlap_tolerance < 0.0 => setting(
            "overlap_tolerance",
            scene.overlap_tolerance,
            "a share of the facet size, 0 or more",
        ),
        _ => Ok(()),
    }
}

/// Every body is held by supports or may touch another body, and something is held at all.
pub(super) fn supports<const D: usize>(scene: &Scene<D>) -> Result<(), Error> {
    let held = |body: &Body<D>| body.prescribed().iter().any(Option::is_some);
    if !scene.bodies.iter().any(held) {
        return Err(Error::NoSupport);
    }
    let is_free = |body: &Body<D>| body.prescribed().iter().any(Option::is_none);
    if !scene.bodies.iter().any(is_free) {
        return Err(Error::NothingFree);
    }
    let modes = D * (D + 1) / 2;
    for (index, body) in scene.bodies.iter().enumerate() {
        let names = |pair: &super::Pair| pair.first.body == index || pair.second.body == index;
        if scene.pairs.iter().any(names) {
            continue;
        }
        let free = modes - held_rigid_modes(body);
        if free > 0 {
            return Err(Error::Unsupported {
                body: index,
                free,
                modes,
            });
        }
    }
    Ok(())
}

/// How many independent rigid motions the prescribed dofs of a body hold: the rank of the rigid
/// modes restricted to those dofs.
fn held_rigid_modes<const D: usize>(body: &Body<D>) -> usize {
    let (low, high) = body.mesh().bounding_box();
    let (centre, size) = ((low + high) * 0.5, (high - low).norm());
    let planes: Vec<(usize, usize)> = (0..D).flat_map(|i| (0..i).map(move |j| (i, j))).collect();
    let prescribed = body.prescribed().iter().enumerate();
    let held: Vec<usize> = prescribed
        .filter_map(|(dof, value)| value.map(|_| dof))
        .collect();
    let mode = |dof: usize, k: usize| {
        let (node, component) = (dof / D, dof % D);
        let arm = (body.mesh().nodes()[node] - centre) / size;
        if k < D {
            return f64::from(u8::from(component == k));
        }
        let (i, j) = planes[k - D];
        match component {
            c if c == i => -arm[j],
            c if c == j => arm[i],
            _ => 0.0,
        }
    };
    let count = D + planes.len();
    // the Gram matrix is small whatever the number of dofs
    let gram = DMatrix::from_fn(count, count, |p, q| {
        held.iter()
            .map(|&dof| mode(dof, p) * mode(dof, q))
            .sum::<f64>()
    });
    let largest = gram.trace();
    let eigenvalues = gram.symmetric_eigenvalues();
    eigenvalues.iter().filter(|&&e| e > 1e-10 * largest).count()
}

/// No body starts inside another one.
pub(super) fn overlap<const D: usize>(problem: &Problem<D>) -> Result<(), Error> {
    let x = problem.reference();
    let masters = problem.masters(x);
    for pass in problem.passes() {
        let (slave, master) = (&problem.surfaces()[pass.slave], &masters[pass.master]);
        let normals = masters[pass.slave].normals();
        let facing = deepest_node(slave, normals, master, x);
        let swallowed = || swallowed_node(problem, slave, master);
        let Some((node, gap)) = facing.or_else(swallowed) else {
            continue;
        };
        let size = slave.facet_size().max(master.surface().facet_size());
        let tolerance = problem.scene().overlap_tolerance * size;
        if -gap > tolerance {
            return Err(Error::Overlap {
                slave: slave.body(),
                master: master.surface().body(),
                node: node - problem.first_node(slave.body()),
                x: x[node].iter().copied().collect(),
                gap,
                tolerance,
            });
        }
    }
    Ok(())
}

/// A node of `slave` inside a cell of the master's body although the surface there does not face
/// it, as when one body starts wholly within another: the deepest as (scene node, minus its
/// distance from the surface).
fn swallowed_node<const D: usize>(
    problem: &Problem<D>,
    slave: &Surface<D>,
    master: &Master<'_, D>,
) -> Option<(usize, f64)> {
    let mesh = problem.scene().bodies()[master.surface().body()].mesh();
    let (low, high) = mesh.bounding_box();
    let x = problem.reference();
    let in_box = |x: &Vector<D>| (0..D).all(|i| low[i] <= x[i] && x[i] <= high[i]);
    let inside = slave
        .nodes()
        .iter()
        .filter(|&&a| in_box(&x[a]) && mesh.contains(&x[a]));
    let depths = inside.filter_map(|&a| Some((a, -master.project(&x[a])?.distance)));
    depths.min_by(|a, b| a.1.total_cmp(&b.1))
}
