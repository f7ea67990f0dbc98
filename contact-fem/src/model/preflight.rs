//! Checks of a scene before any solve.

use nalgebra::DMatrix;

use super::{Body, Integration, Scene};
use crate::error::Error;
use crate::tensor::Vector;

/// The smallest singular value that counts of the rigid-body modes restricted to the prescribed dofs,
/// as a share of the largest. Smaller ones are round-off of the coordinates, as where all supported
/// nodes are on a line.
const HOLDS: f64 = 1e-7;

/// Checks that every body has a unique name.
pub(super) fn names<const D: usize>(scene: &Scene<D>) -> Result<(), Error> {
    for (body, name) in scene.names().iter().enumerate() {
        if name.is_empty() {
            return Err(Error::UnnamedBody { body });
        }
        if let Some(first) = scene.names()[..body].iter().position(|other| other == name) {
            return Err(Error::BodyExists {
                name: name.clone(),
                bodies: [first, body],
            });
        }
    }
    Ok(())
}

/// Checks that the settings are within their ranges.
pub(super) fn settings<const D: usize>(scene: &Scene<D>) -> Result<(), Error> {
    let setting = |name, value, remedy| {
        Err(Error::Setting {
            name,
            value,
            remedy,
        })
    };
    if scene.bodies().is_empty() {
        return setting("bodies", 0.0, "a scene needs at least one body");
    }
    if let Some(Integration::Gauss(points)) = scene.integration {
        if !(1..=64).contains(&points) {
            return setting("integration", points as f64, "choose 1 to 64 Gauss points");
        }
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

/// Checks that the sum of the nodal forces is finite.
pub(super) fn loads<const D: usize>(scene: &Scene<D>) -> Result<(), Error> {
    let mut bodies = scene.bodies().iter().zip(scene.names());
    bodies.try_for_each(|(body, name)| {
        let what = format!("the sum of the nodal forces of body `{name}`");
        Error::check_finite(&what, body.forces())
    })
}

/// Checks that every part of every body is supported or may touch another body, and that at least
/// one displacement is prescribed.
pub(super) fn supports<const D: usize>(scene: &Scene<D>) -> Result<(), Error> {
    let held = |body: &Body<D>| body.prescribed().iter().any(Option::is_some);
    if !scene.bodies().iter().any(held) {
        return Err(Error::NoSupport);
    }
    let is_free = |body: &Body<D>| body.prescribed().iter().any(Option::is_none);
    if !scene.bodies().iter().any(is_free) {
        return Err(Error::NothingFree);
    }
    for (index, body) in scene.bodies().iter().enumerate() {
        let mut touches = vec![false; body.mesh().nodes().len()];
        let surfaces = scene
            .pairs()
            .iter()
            .flat_map(|pair| [&pair.first, &pair.second]);
        for side in surfaces.filter(|side| side.body.index() == index) {
            let nodes = body.mesh().boundary_nodes(&side.boundary)?;
            nodes.iter().for_each(|&node| touches[node] = true);
        }
        for part in body.mesh().parts() {
            let (free, modes) = (free_rigid_modes(body, &part), D * (D + 1) / 2);
            if free > 0 && !part.iter().any(|&node| touches[node]) {
                return Err(Error::Unsupported {
                    body: scene.names()[index].clone(),
                    node: part[0],
                    free,
                    modes,
                });
            }
        }
    }
    Ok(())
}

/// The number of independent rigid-body modes of a part of a body that its prescribed dofs leave
/// free: the rank deficiency of the modes restricted to these dofs.
///
/// Lever arms are measured from the centroid of the supported nodes in units of their extent, so
/// that the result does not depend on position and size.
fn free_rigid_modes<const D: usize>(body: &Body<D>, part: &[usize]) -> usize {
    let is_held = |&dof: &usize| body.prescribed()[dof].is_some();
    let dofs = part.iter().flat_map(|node| D * node..D * (node + 1));
    let held: Vec<usize> = dofs.filter(is_held).collect();
    let count = D * (D + 1) / 2;
    if held.is_empty() {
        return count;
    }
    let nodes = body.mesh().nodes();
    let centre = held.iter().map(|dof| nodes[dof / D]).sum::<Vector<D>>() / held.len() as f64;
    let extent = held
        .iter()
        .map(|dof| (nodes[dof / D] - centre).norm())
        .fold(0.0, f64::max);
    let planes: Vec<(usize, usize)> = (0..D).flat_map(|i| (0..i).map(move |j| (i, j))).collect();
    let mode = |dof: usize, k: usize| {
        let (node, component) = (dof / D, dof % D);
        if k < D {
            return f64::from(u8::from(component == k));
        }
        let arm = (nodes[node] - centre) / extent.max(f64::MIN_POSITIVE);
        let (i, j) = planes[k - D];
        match component {
            c if c == i => -arm[j],
            c if c == j => arm[i],
            _ => 0.0,
        }
    };
    // only R of a QR factorisation is kept: it is small for any number of dofs
    let mut R = DMatrix::zeros(0, count);
    for dofs in held.chunks(100) {
        let above = R.nrows();
        let stacked = DMatrix::from_fn(above + dofs.len(), count, |row, k| match row < above {
            true => R[(row, k)],
            false => mode(dofs[row - above], k),
        });
        R = stacked.qr().r();
    }
    let held_by = R.singular_values();
    count
        - held_by
            .iter()
            .filter(|&&s| s > HOLDS * held_by.max())
            .count()
}
