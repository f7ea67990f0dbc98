//! Obstacles of a scene file.

use contact_fem::{Obstacle, Scene};

use super::contact::Bodies;
use super::keys::{Ball, Cuboid, HalfSpace, ObstacleKeys};
use super::program::motion;
use super::{Error, SceneFile, of, vector};

impl ObstacleKeys {
    /// The one shape that is given.
    fn shape<const D: usize>(&self, part: &str) -> Result<Obstacle<D>, Error> {
        let mut shapes = Vec::new();
        if let Some(HalfSpace { point, normal }) = &self.half_space {
            let (point, normal) = (
                vector(part, "point", point)?,
                vector(part, "normal", normal)?,
            );
            shapes.push(Obstacle::half_space(point, normal));
        }
        if let Some(Ball { centre, radius }) = &self.ball {
            shapes.push(Obstacle::ball(vector(part, "centre", centre)?, *radius));
        }
        if let Some(Ball { centre, radius }) = &self.cavity {
            shapes.push(Obstacle::cavity(vector(part, "centre", centre)?, *radius));
        }
        if let Some(round) = &self.cylinder {
            let point = vector(part, "point", &round.point)?;
            shapes.push(Obstacle::cylinder_along(&round.axis, point, round.radius));
        }
        if let Some(round) = &self.bore {
            let point = vector(part, "point", &round.point)?;
            shapes.push(Obstacle::bore_along(&round.axis, point, round.radius));
        }
        if let Some(Cuboid { low, high }) = &self.cuboid {
            let (low, high) = (vector(part, "low", low)?, vector(part, "high", high)?);
            shapes.push(Obstacle::cuboid(low, high));
        }
        match (shapes.pop(), shapes.is_empty()) {
            (Some(shape), true) => of(part, shape),
            _ => Err(Error::Part {
                part: part.into(),
                what: "give it one shape: `half-space`, `ball`, `cavity`, `cylinder`, `bore` or `cuboid`".into(),
            }),
        }
    }
}

impl SceneFile {
    pub(super) fn add_obstacles<const D: usize>(
        &self,
        scene: &mut Scene<D>,
        bodies: &Bodies<'_>,
    ) -> Result<(), Error> {
        for keys in &self.keys.obstacle {
            let part = format!("obstacle {}", keys.name);
            let shape = keys.shape(&part)?;
            let shape = match motion(&part, &keys.motion)? {
                Some(motion) => shape.moving(motion),
                None => shape,
            };
            let Some((first, others)) = keys.on.split_first() else {
                let what = "`on` is empty: name the boundaries that may touch it".into();
                return Err(Error::Part { part, what });
            };
            let first = bodies.side(&part, first)?;
            let obstacle = of(&part, scene.obstacle(&keys.name, first, shape))?;
            for other in others {
                let other = bodies.side(&part, other)?;
                of(&part, scene.contact_obstacle(other, obstacle))?;
            }
            if let Some(during) = &keys.during {
                let switched = scene.obstacle_during(obstacle, during);
                of(&format!("{part}, `during`"), switched)?;
            }
        }
        Ok(())
    }
}
