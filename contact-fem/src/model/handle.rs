//! How a scene's bodies and their boundaries are named.

/// A body of a scene, as [`Scene::add`](super::Scene::add) returns it. For another scene it means the
/// body that was added there at the same place; where there is none, methods of problems and records
/// panic.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct BodyId(pub(super) usize);

impl BodyId {
    /// Its place in the order in which the bodies were added, from 0.
    pub fn index(self) -> usize {
        self.0
    }

    /// One of its boundaries, by the name that its mesh gives it.
    pub fn on(self, boundary: impl Into<String>) -> Side {
        Side {
            body: self,
            boundary: boundary.into(),
        }
    }
}

/// A boundary of a body of a scene.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub struct Side {
    /// The body.
    pub body: BodyId,
    /// The name of a boundary of its mesh.
    pub boundary: String,
}

impl From<usize> for BodyId {
    fn from(index: usize) -> Self {
        BodyId(index)
    }
}
