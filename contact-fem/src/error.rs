//! Errors of meshes, materials and scenes.

use std::fmt;

use crate::mesh::read::{Place, Problem};

/// Errors of meshes, materials and scenes. Each contains the offending index or name, the value and
/// the remedy.
#[derive(thiserror::Error)]
#[non_exhaustive]
pub enum Error {
    /// A cell whose corners are in an order that makes its volume negative.
    #[error(
        "cell {cell} is inverted (volume {volume:.3e}): reorder its nodes, in the plane \
         counter-clockwise, in space with the last one in front of the others' counter-clockwise side"
    )]
    InvertedCell {
        /// Which cell.
        cell: usize,
        /// Its signed area or volume (UL²/UL³).
        volume: f64,
    },
    /// Averaged changes of volume for quadratic cells.
    #[error(
        "`Body::with_averaged_volumes` is for linear cells, and the mesh is quadratic: take `Body::new`, which does not lock there"
    )]
    AveragedQuadratic,
    /// The law of a body of another kind or mesh.
    #[error(
        "the law of the other body cannot be taken: {why}; make both bodies of one mesh, by the constructors for bodies that deform"
    )]
    LawOfAnother {
        /// What is not the same.
        why: &'static str,
    },
    /// A node of a body of revolution on the other side of the axis.
    #[error(
        "node {node} of a body of revolution has the radius {radius:.3e}: mesh the half of its section with r = x₁ ≥ 0 alone, or move it by `Mesh::translated`"
    )]
    NegativeRadius {
        /// Which node.
        node: usize,
        /// Its first coordinate (UL).
        radius: f64,
    },
    /// Bodies of revolution together with bodies of the plane.
    #[error(
        "body `{revolved}` is one of revolution, and body `{plane}` is not: a scene has bodies of one of the two kinds; \
         make all of them bodies of revolution, or none"
    )]
    MixedRevolution {
        /// A body of revolution.
        revolved: String,
        /// A body of the plane.
        plane: String,
    },
    /// A body so far from the origin that its cells are lost in the round-off of their coordinates.
    #[error(
        "coordinates of body `{body}` are rounded to {share:.1e} of the smallest height of a cell: move all meshes towards the origin"
    )]
    FarFromOrigin {
        /// The body.
        body: String,
        /// The distance of neighbouring numbers, as a share of the smallest height of a cell.
        share: f64,
    },
    /// A cell without volume.
    #[error(
        "cell {cell} is degenerate (volume {volume:.3e} at size {size:.3e}): merge or move its nodes"
    )]
    DegenerateCell {
        /// Which cell.
        cell: usize,
        /// Its signed area or volume (UL²/UL³).
        volume: f64,
        /// The length of its longest edge (UL).
        size: f64,
    },
    /// A quadratic cell with positive corner orientation that its curved edges fold.
    #[error(
        "cell {cell} is folded by its middle nodes (tangent volume {volume:.3e}): move them towards \
         the middles of its edges or refine the mesh where it is curved"
    )]
    CurvedCell {
        /// Which cell.
        cell: usize,
        /// A lower bound of the tangent volumes within it (UL²/UL³).
        volume: f64,
    },
    /// A cell that the map of its mesh's nodes has made invalid.
    #[error(
        "the map leaves cell {cell} with a volume of {volume:.3e}: it must not reflect, flatten or \
         fold cells, nor move them so far that round-off does; refine the mesh or move it less"
    )]
    MappedCell {
        /// Which cell.
        cell: usize,
        /// Its signed area or volume (UL²/UL³); of a curved cell the smallest tangent volume.
        volume: f64,
    },
    /// A cell whose volume overflows or underflows.
    #[error(
        "the volume of cell {cell}, of size {size:.3e}, overflows or underflows: choose a unit of \
         length in which cells are neither so large nor so small"
    )]
    CellSize {
        /// Which cell.
        cell: usize,
        /// The length of its longest edge (UL).
        size: f64,
    },
    /// A cell names a node that does not exist.
    #[error("cell {cell} names node {node}, but the mesh has {nodes} nodes numbered from 0")]
    NodeOutOfRange {
        /// Which cell.
        cell: usize,
        /// The node it names.
        node: usize,
        /// How many there are.
        nodes: usize,
    },
    /// A node that belongs to no cell.
    #[error("node {node} belongs to no cell: remove it, since nothing would hold it")]
    OrphanNode {
        /// Which node.
        node: usize,
    },
    /// A facet of more than two cells.
    #[error(
        "the facet with nodes {nodes:?} belongs to {cells} cells: a body's mesh must be a manifold"
    )]
    NonManifoldFacet {
        /// Its nodes.
        nodes: Vec<usize>,
        /// How many cells share it.
        cells: usize,
    },
    /// An inconsistent node in the middle of an edge.
    #[error(
        "cell {cell} has node {node} in the middle of the edge between nodes {edge:?}: the cells at \
         an edge must share its middle node, which is no corner and on no other edge"
    )]
    EdgeNode {
        /// Which cell.
        cell: usize,
        /// The corners of the edge.
        edge: [usize; 2],
        /// The node in its middle.
        node: usize,
    },
    /// Two cells on the same side of the facet that they share.
    #[error(
        "two cells lie on the same side of the facet with nodes {nodes:?}: one of them is there \
         twice, or the mesh is folded over"
    )]
    FoldedCells {
        /// The facet's corners.
        nodes: Vec<usize>,
    },
    /// A mesh without cells.
    #[error("the mesh has no cells: a body needs at least one")]
    EmptyMesh,
    /// A boundary name that does not exist in the mesh.
    #[error("no boundary is called `{name}`; this mesh has {known:?}")]
    UnknownBoundary {
        /// The name that was given.
        name: String,
        /// The names that exist.
        known: Vec<String>,
    },
    /// A name of a region that does not exist in the mesh.
    #[error("no region is called `{name}`; this mesh has {known:?}: name one of them")]
    UnknownRegion {
        /// The name that was given.
        name: String,
        /// The names that exist.
        known: Vec<String>,
    },
    /// A cell without a law, or with several.
    #[error(
        "cell {cell} is in {} of the regions with a law: give each cell one, as by regions that do not overlap",
        if *.several { "several" } else { "none" }
    )]
    LawsOfCell {
        /// The cell's number in its mesh.
        cell: usize,
        /// Whether it has several laws, or none.
        several: bool,
    },
    /// A point with no node, or with several.
    #[error(
        "{found} nodes are within {within:.1e} of {point:?}, where there should be one: give the coordinates with all \
         digits, and of each body to its own mesh"
    )]
    NodeAt {
        /// The point (UL).
        point: Vec<f64>,
        /// The number of nodes there.
        found: usize,
        /// The distance that counts (UL).
        within: f64,
    },
    /// Two boundaries that were not declared for contact.
    #[error("{first} and {second} are no contact pair: declare it by `Scene::contact` first")]
    NoPair {
        /// One boundary, with the number of its body.
        first: String,
        /// The other one.
        second: String,
    },
    /// A pressure on a boundary whose rim is free, which has no potential.
    #[error(
        "the pressure on boundary `{boundary}` of body `{body}` is not conservative, since the rim of the boundary is free at \
         {at:?}: hold the rim, let it slide in a plane perpendicular to an axis (`Body::symmetry`), name a closed \
         boundary (join adjacent ones by `Mesh::join_boundaries`), or take a traction, whose direction stays"
    )]
    FreeRim {
        /// The body.
        body: String,
        /// The boundary under pressure.
        boundary: String,
        /// X of a node of the rim (UL).
        at: Vec<f64>,
    },
    /// A support, a foundation, a traction or a pressure on a boundary without facets.
    #[error(
        "the {what} acts on nothing, since boundary `{name}` has no facets: check the predicate that names it, \
         which must hold at all corners of a facet"
    )]
    EmptyBoundary {
        /// The name of the boundary.
        name: String,
        /// What acts on it: a support, a foundation, a traction or a pressure.
        what: &'static str,
    },
    /// A plane of symmetry that is none.
    #[error(
        "boundary `{name}` is no plane of symmetry: its nodes are not in one plane, but up to {thickness:.3e} apart across the nearest \
         one; name facets in one plane, each plane by itself"
    )]
    NotPlane {
        /// The name of the boundary.
        name: String,
        /// How far its nodes are apart across the plane that is closest to all of them (UL).
        thickness: f64,
    },
    /// A boundary name that is in use.
    #[error("a boundary is called `{name}` already: choose another name")]
    BoundaryExists {
        /// The name.
        name: String,
    },
    /// A body that does not exist in the scene.
    #[error(
        "the scene has {bodies} bodies, and the handle names body number {body}, counted from 0: use the \
         handles that this scene's `add` returned"
    )]
    UnknownBody {
        /// The number of the handle.
        body: usize,
        /// The number of bodies.
        bodies: usize,
    },
    /// A name that no body of the coarsest mesh has.
    #[error(
        "the scene on its first mesh has no body called `{name}`, it has {known:?}: ask for meshes by the names \
         that bodies are added with"
    )]
    UnknownName {
        /// The name.
        name: String,
        /// Those of the bodies.
        known: Vec<String>,
    },
    /// A body with an empty name.
    #[error("body number {} from the first has no name: give it one", body + 1)]
    UnnamedBody {
        /// Its number in the order of addition.
        body: usize,
    },
    /// Two bodies with the same name.
    #[error(
        "two bodies are called `{name}`, number {} and number {} from the first: rename one of them",
        bodies[0] + 1,
        bodies[1] + 1
    )]
    BodyExists {
        /// The name.
        name: String,
        /// Their numbers in the order of addition.
        bodies: [usize; 2],
    },
    /// An obstacle with an empty name.
    #[error("obstacle number {} from the first has no name: give it one", obstacle + 1)]
    UnnamedObstacle {
        /// Its number in the order of declaration.
        obstacle: usize,
    },
    /// An obstacle with the name of a body or of another obstacle.
    #[error("obstacle `{name}` has the name of a body or of another obstacle: rename one of them")]
    ObstacleExists {
        /// The name.
        name: String,
    },
    /// A signed distance that is none.
    #[error(
        "the {what} of obstacle `{obstacle}` is {value} at {x:?}: give `Obstacle::signed_distance` a function that is finite \
         and grows with the way from the obstacle, by as much as that (divide a level-set function by the length of its gradient)"
    )]
    ObstacleDistance {
        /// The obstacle.
        obstacle: String,
        /// What is wrong: the distance or its slope.
        what: &'static str,
        /// Its value (UL, or no unit).
        value: f64,
        /// Where (UL).
        x: Vec<f64>,
    },
    /// A surface of an obstacle that has no inside.
    #[error("the surface of the obstacle {what}, at {x:?}: {remedy}")]
    ObstacleSurface {
        /// What is wrong with it.
        what: String,
        /// Where (UL).
        x: Vec<f64>,
        /// What to do.
        remedy: &'static str,
    },
    /// A body that starts inside an obstacle.
    #[error(
        "body `{body}` starts inside obstacle `{obstacle}`: {depth:.3e} deep at {x:?} against the {tolerance:.3e} that \
         `Scene::overlap_tolerance` or `Scene::initial_gaps` grants; move one of them, check which side of the obstacle is its outside, \
         or let `Scene::initial_gaps` resolve less than 0.4 of the body's thickness"
    )]
    InsideObstacle {
        /// The body.
        body: String,
        /// The obstacle.
        obstacle: String,
        /// The deepest point (UL).
        x: Vec<f64>,
        /// Its depth (UL).
        depth: f64,
        /// The accepted depth (UL).
        tolerance: f64,
    },
    /// A NaN or an infinity in the input.
    #[error("{what} [{index}] = {value} is not finite: check where it comes from")]
    NotFinite {
        /// The name of the input.
        what: String,
        /// The index in it.
        index: usize,
        /// The value.
        value: f64,
    },
    /// Young's modulus out of range.
    #[error(
        "Young's modulus E = {E} must be positive, and between 1e-100 and 1e100: choose units in which it is not so far from 1"
    )]
    YoungsModulus {
        /// The value.
        E: f64,
    },
    /// Poisson's ratio out of range.
    #[error(
        "Poisson's ratio ν = {nu} must lie strictly between -1 and 0.5; for nearly incompressible bodies use 0.499"
    )]
    PoissonsRatio {
        /// The value.
        nu: f64,
    },
    /// Poisson's ratio so close to −1 or 0.5 that the round-off of one modulus hides the other.
    #[error(
        "Poisson's ratio ν = {nu} makes bulk and shear modulus differ by {ratio:.1e}, more than {limit:.1e}: round-off of the \
         stiffer one would hide the other; for nearly incompressible bodies use 0.499",
        limit = crate::material::Lame::MOST_APART
    )]
    ModuliApart {
        /// Poisson's ratio.
        nu: f64,
        /// The larger modulus divided by the smaller one.
        ratio: f64,
    },
    /// A law whose stress is not the derivative of its energy, or whose tangent is not that of its stress.
    #[error(
        "the law of body `{body}` has a {what} that differs from the derivative of its {of} by {error:.1e} of itself, at \
         strains of about 1 %: mend the law, `material::conformance::check` tells more"
    )]
    LawDiffers {
        /// The body.
        body: String,
        /// `stress` or `tangent`.
        what: &'static str,
        /// What it is to be the derivative of: `energy` or `stress`.
        of: &'static str,
        /// The largest difference divided by the largest value.
        error: f64,
    },
    /// A contact surface without facets.
    #[error(
        "contact surface `{boundary}` of body `{body}` has no facets: name a boundary that has some"
    )]
    EmptySurface {
        /// Which body.
        body: String,
        /// Its boundary.
        boundary: String,
    },
    /// Boundaries that cannot be tied.
    #[error("{first} and {second} cannot be tied; {why}")]
    Tie {
        /// One boundary, and its body.
        first: String,
        /// The other one.
        second: String,
        /// The cause and the remedy.
        why: crate::model::TieFault,
    },
    /// What a body that does not deform cannot have.
    #[error("a rigid body does not take {what}: {remedy}")]
    NotRigid {
        /// What was declared.
        what: &'static str,
        /// What to do.
        remedy: &'static str,
    },
    /// A rigid body that turns, where contact is looked for at the present positions.
    #[error(
        "body `{body}` is rigid and turns by small angles, but contact is looked for at the present positions: let it not turn (`Body::rigid`), \
         take `Geometry::Reference`, or give it a stiff law"
    )]
    TurnsTooFar {
        /// Which body.
        body: String,
    },
    /// A scene all of whose free bodies are rigid.
    #[error("no body deforms: give one that is free an elastic law")]
    NothingDeforms,
    /// A scene without free displacements.
    #[error("every displacement of every body is prescribed: leave something free to solve for")]
    NothingFree,
    /// A body that can move rigidly.
    #[error(
        "body `{body}` can move rigidly ({free} of {modes} rigid motions of the part with node {node} \
         are free, {motions}) and has no contact pair there: prescribe some of its displacements or declare \
         a contact pair"
    )]
    Unsupported {
        /// Which body.
        body: String,
        /// A node of the part that can move; a body may consist of several parts.
        node: usize,
        /// The number of free rigid-body modes.
        free: usize,
        /// The number of rigid-body modes in this dimension.
        modes: usize,
        /// The names of the free ones.
        motions: String,
    },
    /// A part of a body that can move rigidly, since its nodes lie on those of other parts and are not joined.
    #[error(
        "{count} nodes of body `{body}` lie on others of it and are not joined (the first are {} and {}), so that parts of it can move \
         rigidly: merge them (`merge-nodes`, `MeshFile::merged`), or, if they are apart on purpose, support each part", nodes[0], nodes[1]
    )]
    Unmerged {
        /// Which body.
        body: String,
        /// How many pairs of nodes.
        count: usize,
        /// The first pair.
        nodes: [usize; 2],
    },
    /// A scene without any prescribed displacement.
    #[error(
        "no displacement is prescribed anywhere: the scene as a whole can drift; support a body"
    )]
    NoSupport,
    /// Small-strain and other laws in contact, which suggest different geometries.
    #[error(
        "body `{small}` has a small-strain law, body `{large}` a law for large strains: \
         small strains suggest contact at the reference positions, large strains at the current ones, \
         and results differ; set `Scene::geometry` to `Geometry::Reference` or `Geometry::Current`"
    )]
    GeometryNotChosen {
        /// A body with a small-strain law.
        small: String,
        /// A body with another law.
        large: String,
    },
    /// Bodies that overlap in the reference configuration.
    #[error(
        "body `{slave}` starts inside body `{master}`: gap {gap:.3e} at node {node} ({x:?}) against the \
         {tolerance:.3e} that `Scene::overlap_tolerance` or `Scene::initial_gaps` grants; move the bodies apart, or let \
         `Scene::initial_gaps` resolve an interference fit of less than 0.4 of the thinner body's thickness"
    )]
    Overlap {
        /// The body whose node is inside.
        slave: String,
        /// The body that contains the node.
        master: String,
        /// The node, numbered within its body.
        node: usize,
        /// Its position.
        x: Vec<f64>,
        /// The gap, negative (UL).
        gap: f64,
        /// The accepted overlap (UL).
        tolerance: f64,
    },
    /// Bodies that intersect in the reference configuration.
    #[error(
        "bodies `{first}` and `{second}` cross at {x:?}, {depth:.3e} deep against the {tolerance:.3e} that \
         `Scene::overlap_tolerance` or `Scene::initial_gaps` grants; move them apart, or let `Scene::initial_gaps` \
         resolve an interference fit of less than 0.4 of the thinner body's thickness"
    )]
    Crossing {
        /// The body with the intersecting edge.
        first: String,
        /// The body with the intersected facet.
        second: String,
        /// The point of intersection.
        x: Vec<f64>,
        /// The shortest displacement that separates them there (UL).
        depth: f64,
        /// The accepted overlap (UL).
        tolerance: f64,
    },
    /// Loads and prescribed displacements that are lost in round-off.
    #[error(
        "loads and prescribed displacements move the scene by {share:.1e} of its size, which round-off hides below \
         {limit:.0e}: check their units, or scale them up"
    )]
    Negligible {
        /// The largest prescribed displacement, or a large estimate of that under the loads, divided by the diagonal
        /// of the scene.
        share: f64,
        /// The smallest share that is accepted.
        limit: f64,
    },
    /// Loads or prescribed displacements beyond what bodies could follow.
    #[error(
        "{what} of body `{body}` would move it by {} times the size of the scene, and at most {limit:.0e} is accepted: check \
         units and powers of ten",
        finite(*share)
    )]
    Excessive {
        /// The body.
        body: String,
        /// Prescribed displacements, or loads.
        what: &'static str,
        /// The displacement, of loads that of a bar as large as the scene, divided by the diagonal of the scene.
        share: f64,
        /// The largest share that is accepted.
        limit: f64,
    },
    /// Two supports that prescribe different displacements along one direction.
    #[error(
        "the displacement along {} of the node at {x:?} is prescribed twice, by {}: {first} and {second} at load factor {at}; give \
         both one value there, or take the nodes that both have out of one of them",
        along(direction),
        supports(on)
    )]
    Conflict {
        /// Which node.
        node: usize,
        /// Its position (UL).
        x: Vec<f64>,
        /// Which component, or the largest one of the direction.
        component: usize,
        /// The direction, of length 1.
        direction: Vec<f64>,
        /// The boundaries of the first and of the second support; supports of nodes are called after these.
        on: Box<[String; 2]>,
        /// The first value (UL).
        first: f64,
        /// The second value (UL).
        second: f64,
        /// The load factor at which they have these values.
        at: f64,
    },
    /// Supports along directions that are almost one, and whose values do not fit.
    #[error(
        "{} hold the node at {x:?} along directions that are only {angle:.2e}° apart, by {first} and {second} at load factor {at}, which \
         together move it by {displacement:.1e}; give both the same direction, or values that fit together",
        supports(on)
    )]
    NearlyParallel {
        /// Which node.
        node: usize,
        /// Its position (UL).
        x: Vec<f64>,
        /// The boundaries of the first and of the second support; supports of nodes are called after these.
        on: Box<[String; 2]>,
        /// The angle between the directions (degrees).
        angle: f64,
        /// The displacement along the first direction (UL).
        first: f64,
        /// The displacement along the second one (UL).
        second: f64,
        /// The component that follows from both (UL).
        displacement: f64,
        /// The load factor at which they have these values.
        at: f64,
    },
    /// What cannot hold in some phases alone.
    #[error(
        "{what} does not take `Body::during`, which switches supports along axes alone: let it act at all times; loads take an \
         amplitude, such as `Amplitude::table`"
    )]
    NotSwitched {
        /// What was declared.
        what: &'static str,
    },
    /// A support, a pair or an obstacle that is switched on or off within a phase.
    #[error(
        "{what} begins or ends at load factor {at}, within the phase from {from} to {until}: end a phase there"
    )]
    SwitchWithinPhase {
        /// Which.
        what: String,
        /// Where it begins or ends.
        at: f64,
        /// Where the phase begins.
        from: f64,
        /// Where it ends.
        until: f64,
    },
    /// A support, a pair or an obstacle that no phase of the run has.
    #[error(
        "{what} counts at no load factor of the run, which ends at {last}: change when it counts, or leave it out"
    )]
    NeverCounts {
        /// Which.
        what: String,
        /// Where the last phase ends.
        last: f64,
    },
    /// What the checks find in a later phase, with the supports that hold then.
    #[error("in the phase from load factor {from} to {until}: {error}")]
    InPhase {
        /// Where the phase begins.
        from: f64,
        /// Where it ends.
        until: f64,
        /// What they find.
        error: Box<Error>,
    },
    /// A setting outside its range.
    #[error("`{name}` = {value} is out of range: {remedy}")]
    Setting {
        /// Its name.
        name: &'static str,
        /// Its value.
        value: f64,
        /// The accepted values.
        remedy: &'static str,
    },
    /// An error of the optimisation layer.
    #[error(transparent)]
    Core(contact_core::Error),
    /// A facet on two boundaries, which a format with one label for each facet cannot represent.
    #[error(
        "the facet {nodes:?} is on the boundaries `{first}` and `{second}`: FreeFEM's formats have \
         one label a facet, so give it one name, or write bodies that touch to files of their own"
    )]
    SharedFacet {
        /// Its corners.
        nodes: Vec<usize>,
        /// One boundary.
        first: String,
        /// The other.
        second: String,
    },
    /// A file could not be read.
    #[error("cannot read {path}: {source}")]
    Read {
        /// Which file.
        path: std::path::PathBuf,
        /// Why.
        source: std::io::Error,
    },
    /// A mesh file with invalid contents.
    #[error("{}{place}: {problem}", path.as_ref().map_or("mesh file".into(), |p| p.display().to_string()))]
    MeshFile {
        /// Its path; `None` if it was read from memory.
        path: Option<std::path::PathBuf>,
        /// The position in the file.
        place: Place,
        /// The problem, what was expected and the remedy.
        problem: Problem,
    },
    /// Another recorded run writes to the folder.
    #[error("another run writes to {folder}: wait for its end, or record to another folder")]
    FolderInUse {
        /// Which folder.
        folder: std::path::PathBuf,
    },
    /// A file could not be written.
    #[error("cannot write {path}: {source}")]
    Write {
        /// Which file.
        path: std::path::PathBuf,
        /// Why.
        source: Box<dyn std::error::Error + Send + Sync>,
    },
}

/// A number that may have overflowed.
fn finite(value: f64) -> String {
    match value.is_finite() {
        true => format!("{value:.1e}"),
        false => format!("more than {:.1e}", f64::MAX),
    }
}

/// The names of two supports.
fn supports(on: &[String; 2]) -> String {
    let [first, second] = on;
    format!("the supports on `{first}` and on `{second}`")
}

/// The axis that a unit vector is along, or its components.
fn along(direction: &[f64]) -> String {
    let axes = direction.iter().zip(["x", "y", "z"]);
    let mut other = axes.filter(|(n, _)| **n != 0.0);
    match (other.next(), other.next()) {
        (Some((_, axis)), None) => axis.into(),
        _ => format!("{direction:.4?}"),
    }
}

/// The `Display` message: `main` and `unwrap` print an error by `Debug`.
impl fmt::Debug for Error {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        fmt::Display::fmt(self, f)
    }
}

impl From<contact_core::Error> for Error {
    fn from(error: contact_core::Error) -> Self {
        match error {
            contact_core::Error::Problem(inner) => match inner.downcast::<Error>() {
                Ok(own) => *own,
                Err(other) => Error::Core(contact_core::Error::Problem(other)),
            },
            other => Error::Core(other),
        }
    }
}

impl From<Error> for contact_core::Error {
    fn from(error: Error) -> Self {
        contact_core::Error::problem(error)
    }
}

impl Error {
    /// Checks that every number is finite.
    pub(crate) fn check_finite<'a>(
        what: &str,
        values: impl IntoIterator<Item = &'a f64>,
    ) -> Result<(), Error> {
        let mut bad = values
            .into_iter()
            .enumerate()
            .filter(|(_, v)| !v.is_finite());
        match bad.next() {
            None => Ok(()),
            Some((index, &value)) => Err(Error::NotFinite {
                what: what.to_string(),
                index,
                value,
            }),
        }
    }
}
