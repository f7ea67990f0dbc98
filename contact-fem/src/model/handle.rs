//! Handles of a scene's bodies, their boundaries, and its obstacles.

/// A body of a scene, as returned by [`Scene::add`](super::Scene::add). A handle contains the
/// body's number only: in another scene it denotes the body with the same number. If there is none,
/// methods of problems and records panic.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct BodyId(pub(super) usize);

impl BodyId {
    /// The body's number in the order of addition, from 0.
    pub fn index(self) -> usize {
        self.0
    }

    /// The boundary of this body with the given name in its mesh.
    pub fn on(self, boundary: impl Into<String>) -> Side {
        Side {
            body: self,
            boundary: boundary.into(),
        }
    }
}

/// An obstacle of a scene, as returned by [`Scene::obstacle`](super::Scene::obstacle): its number, likewise.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct ObstacleId(pub(super) usize);

impl ObstacleId {
    /// The obstacle's number in the order of declaration, from 0.
    pub fn index(self) -> usize {
        self.0
    }
}

/// A boundary of a body of a scene.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub struct Side {
    /// The body.
    pub body: BodyId,
    /// The name of the boundary in the body's mesh.
    pub boundary: String,
}

impl From<usize> for BodyId {
    fn from(index: usize) -> Self {
        BodyId(index)
    }
}
