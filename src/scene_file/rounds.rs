//! Boundaries that the generators put on circles, cylinders and spheres: refined meshes are drawn onto them.

use contact_fem::Mesh;
use contact_fem::tensor::Vector;

use super::Error;
use super::meshes::{DiscKeys, EquilateralDiscKeys, Grid, Made, MeshKeys};
use super::place::Place;

/// The map of points onto a circle, a sphere, or a cylinder around an `axis` of length 1, which is zero where there is none. The centre, and points on the
/// axis, stay where they are.
pub(super) fn onto<const D: usize>(
    centre: Vector<D>,
    axis: Vector<D>,
    radius: f64,
) -> impl Fn(&Vector<D>) -> Vector<D> {
    move |x| {
        let arm = x - centre;
        let along = axis * axis.dot(&arm);
        let out = arm - along;
        match out.norm() {
            0.0 => *x,
            length => centre + along + out * (radius / length),
        }
    }
}

/// A boundary at a distance from the origin, or from the third axis.
struct Round {
    boundary: &'static str,
    radius: f64,
    is_around_axis: bool,
}

impl MeshKeys {
    /// The refined `mesh` with its round boundaries drawn onto their circles and spheres; it has been moved by `offset`.
    pub(super) fn drawn<const D: usize>(
        &self,
        place: &Place<'_>,
        mesh: Mesh<D>,
        offset: Vector<D>,
    ) -> Result<Mesh<D>, Error> {
        let mut mesh = mesh;
        for round in self.rounds(place)? {
            let is_there = mesh.boundary_names().any(|name| name == round.boundary);
            if !is_there {
                continue;
            }
            let axis = match D == 3 && round.is_around_axis {
                true => Vector::from_fn(|i, _| if i + 1 == D { 1.0 } else { 0.0 }),
                false => Vector::zeros(),
            };
            mesh = place.of(mesh.drawn(round.boundary, onto(offset, axis, round.radius)))?;
        }
        Ok(mesh)
    }

    /// The boundaries that a generator puts on circles, cylinders and spheres, with their radii; the axis of a cylinder is the third one.
    fn rounds(&self, place: &Place<'_>) -> Result<Vec<Round>, Error> {
        match self {
            MeshKeys::File(_) => Ok(Vec::new()),
            MeshKeys::Made(made) => made.rounds(&place.key(made.name())),
        }
    }
}

impl Made {
    fn rounds(&self, place: &Place<'_>) -> Result<Vec<Round>, Error> {
        let round = |boundary, radius| Round {
            boundary,
            radius,
            is_around_axis: false,
        };
        let ends = |radii: &Grid, names: [&'static str; 2]| -> Result<Vec<Round>, Error> {
            let radii = radii.values(&place.key("radii"))?;
            let ends = [radii[0], radii[radii.len() - 1]];
            let both = names.into_iter().zip(ends);
            let both = both.filter(|(_, radius)| *radius > 0.0);
            Ok(both.map(|(name, radius)| round(name, radius)).collect())
        };
        Ok(match self {
            Made::Disc(DiscKeys { radius, .. })
            | Made::EquilateralDisc(EquilateralDiscKeys { radius, .. }) => {
                vec![round("boundary", *radius)]
            }
            Made::Annulus(keys) => ends(&keys.radii, ["inner", "outer"])?,
            Made::HalfDisc(keys) | Made::QuarterDisc(keys) => ends(&keys.radii, ["inner", "arc"])?,
            Made::Sphere(keys) | Made::Hemisphere(keys) | Made::EighthSphere(keys) => {
                vec![round("surface", keys.radius)]
            }
            Made::Cylinder(keys) => vec![Round {
                is_around_axis: true,
                ..round("side", keys.radius)
            }],
            Made::Extrude(keys) => {
                let mut all = keys.plane.rounds(&place.key("plane"))?;
                all.iter_mut().for_each(|round| round.is_around_axis = true);
                all
            }
            Made::Rectangle(_) | Made::Cuboid(_) | Made::CuboidGraded(_) => Vec::new(),
        })
    }
}
