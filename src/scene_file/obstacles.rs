//! Obstacles of a scene file.

use std::path::Path;

use contact_fem::model::Side;
use contact_fem::{Obstacle, Scene};

use super::contact::Bodies;
use super::keys::{Ball, Cuboid, Cylinder, HalfSpace, ObstacleKeys};
use super::meshes::{Found, MeshKeys};
use super::place::Place;
use super::program::motion;
use super::{Error, SceneFile};

impl SceneFile {
    pub(super) fn add_obstacles<const D: usize>(
        &self,
        scene: &mut Scene<D>,
        bodies: &Bodies<'_>,
    ) -> Result<(), Error> {
        for (k, keys) in self.keys.obstacle.iter().enumerate() {
            let place = self.obstacle_place(k);
            let shape = keys.shape(&place, &self.folder)?;
            let shape = match motion(&place, &keys.motion)? {
                Some(motion) => shape.moving(motion),
                None => shape,
            };
            let sides = keys.on.iter().enumerate();
            let sides = sides.map(|(k, side)| bodies.side(scene, &place.entry("on", k), side));
            let sides: Vec<Side> = sides.collect::<Result<_, Error>>()?;
            let mut sides = sides.into_iter();
            let Some(first) = sides.next() else {
                let what = "`on` is empty: name the boundaries that may touch it";
                return Err(place.key("on").wrong(what));
            };
            let at = place.key("on");
            let obstacle = at.of(scene.obstacle(&keys.name, first, shape))?;
            for other in sides {
                at.of(scene.contact_obstacle(other, obstacle))?;
            }
            if let Some(friction) = keys.friction {
                let given = scene.obstacle_friction(obstacle, friction);
                place.key("friction").of(given)?;
            }
            if let Some(during) = &keys.during {
                let switched = scene.obstacle_during(obstacle, &during.0);
                place.key("during").of(switched)?;
            }
        }
        Ok(())
    }

    pub(super) fn obstacle_place(&self, k: usize) -> Place<'_> {
        let name = match self.keys.obstacle[k].name.as_str() {
            "" => format!("obstacle {}", k + 1),
            name => format!("obstacle {name}"),
        };
        self.place().part("obstacle", k, name)
    }
}

impl ObstacleKeys {
    /// The one shape that is given.
    fn shape<const D: usize>(
        &self,
        place: &Place<'_>,
        folder: &Path,
    ) -> Result<Obstacle<D>, Error> {
        let shapes = [
            self.half_space
                .as_ref()
                .map(|keys| keys.shape(&place.key("half-space"))),
            self.ball.as_ref().map(|keys| keys.ball(&place.key("ball"))),
            self.cavity
                .as_ref()
                .map(|keys| keys.cavity(&place.key("cavity"))),
            self.cylinder
                .as_ref()
                .map(|keys| keys.cylinder(&place.key("cylinder"))),
            self.bore.as_ref().map(|keys| keys.bore(&place.key("bore"))),
            self.cuboid
                .as_ref()
                .map(|keys| keys.shape(&place.key("cuboid"))),
            self.polygon
                .as_ref()
                .map(|keys| polygon(&place.key("polygon"), keys)),
            self.surface
                .as_ref()
                .map(|keys| surface(&place.key("surface"), keys, folder)),
        ];
        let mut shapes: Vec<Result<Obstacle<D>, Error>> = shapes.into_iter().flatten().collect();
        match (shapes.pop(), shapes.is_empty()) {
            (Some(shape), true) => shape,
            _ => Err(place.wrong(
                "give it one shape: `half-space`, `ball`, `cavity`, `cylinder`, `bore`, `cuboid`, `polygon` or `surface`",
            )),
        }
    }
}

impl HalfSpace {
    fn shape<const D: usize>(&self, place: &Place<'_>) -> Result<Obstacle<D>, Error> {
        let point = place.key("point").vector(&self.point)?;
        let normal = place.key("normal").vector(&self.normal)?;
        place.of(Obstacle::half_space(point, normal))
    }
}

impl Ball {
    fn ball<const D: usize>(&self, place: &Place<'_>) -> Result<Obstacle<D>, Error> {
        let centre = place.key("centre").vector(&self.centre)?;
        place.of(Obstacle::ball(centre, self.radius))
    }

    fn cavity<const D: usize>(&self, place: &Place<'_>) -> Result<Obstacle<D>, Error> {
        let centre = place.key("centre").vector(&self.centre)?;
        place.of(Obstacle::cavity(centre, self.radius))
    }
}

impl Cylinder {
    fn cylinder<const D: usize>(&self, place: &Place<'_>) -> Result<Obstacle<D>, Error> {
        let point = place.key("point").vector(&self.point)?;
        place.of(Obstacle::cylinder_along(&self.axis, point, self.radius))
    }

    fn bore<const D: usize>(&self, place: &Place<'_>) -> Result<Obstacle<D>, Error> {
        let point = place.key("point").vector(&self.point)?;
        place.of(Obstacle::bore_along(&self.axis, point, self.radius))
    }
}

impl Cuboid {
    fn shape<const D: usize>(&self, place: &Place<'_>) -> Result<Obstacle<D>, Error> {
        let low = place.key("low").vector(&self.low)?;
        let high = place.key("high").vector(&self.high)?;
        place.of(Obstacle::cuboid(low, high))
    }
}

/// The inside of a closed polygon, whose corners go around it counter-clockwise.
fn polygon<const D: usize>(place: &Place<'_>, corners: &[Vec<f64>]) -> Result<Obstacle<D>, Error> {
    if D != 2 {
        return Err(place.wrong("a polygon is in the plane: in space, take `surface`"));
    }
    if corners.len() < 3 {
        let count = corners.len();
        return Err(place.wrong(format!("has {count} corners: a polygon has 3 at least")));
    }
    let points: Result<Vec<[f64; D]>, Error> = corners.iter().map(|x| place.vector(x)).collect();
    let count = corners.len();
    let side = |k: usize| std::array::from_fn(|end| (k + end) % count);
    let sides: Vec<[usize; D]> = (0..count).map(side).collect();
    place.of(Obstacle::surface(&points?, &sides))
}

/// The inside of the surface in a file, or of a mesh that is made.
fn surface<const D: usize>(
    place: &Place<'_>,
    keys: &MeshKeys,
    folder: &Path,
) -> Result<Obstacle<D>, Error> {
    match keys {
        MeshKeys::File(path) => place.of(Obstacle::read(folder.join(path))),
        MeshKeys::Made(_) => match keys.mesh::<D>(place, folder, (None, None))? {
            Found::Mesh(mesh) => place.of(Obstacle::of_mesh(&mesh)),
            _ => Err(place.wrong(format!("it is not in {D} dimensions, as the first body is"))),
        },
    }
}
