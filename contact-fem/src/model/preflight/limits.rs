//! The thresholds of the preflight. Each has its unit, its source and what depends on it.

/// The smallest singular value that counts of the rigid-body modes restricted to the prescribed dofs,
/// as a share of the largest. Smaller ones are round-off of the coordinates, as where all supported
/// nodes are on a line. The number of free motions depends on it.
pub(super) const HOLDS: f64 = 1e-7;

/// The largest number of pieces of a part, joined at nodes or edges only, whose motions are counted. The count costs the
/// third power of it.
pub(super) const MOST_PIECES: usize = 64;

/// The depth of bodies inside each other below which they only touch, as a share of the facet size: far above the
/// round-off of coordinates. The note on interference depends on it.
pub(super) const TOUCHES: f64 = 1e-6;

/// The depth to which bodies without contact are moved into each other, as a share of their motion, that is worth a warning: above what
/// the estimate of the motion and chords of curved surfaces leave.
pub(super) const MEETS: f64 = 0.05;

/// The smallest −n·n̄ (no unit) of surfaces that face each other. The contact search takes any positive value; this
/// is above round-off.
pub(super) const FACES: f64 = 0.01;

/// The smallest cosine (no unit) between the averaged normal at a node and the normals of its facets. At the tip of a wedge
/// and of a crack it is 0 up to round-off; below, a push along the averaged normal pulls a facet into its body.
pub(super) const OUTWARD: f64 = -0.05;

/// The distance of nodes of a body that lie on each other, as a share of the facets there: above the digits that
/// mesh files keep.
pub(super) const COINCIDES: f64 = 1e-6;

/// The smallest thickness between two contact facets of a body, as a share of their length. The contact search does not
/// see material that is thinner (its share for overlaps of two bodies), and may take a body's far side for its near one.
pub(super) const THIN: f64 = 0.2;

/// The largest angle (degrees) between facets of a plane: above the digits that mesh files keep. A circle of 3600 facets
/// turns by as much from one to the next.
pub(super) const STRAIGHT: f64 = 0.1;

/// The smallest angle (degrees) between facets that may be a true corner: below the 45° of a chamfer, and above the 30°
/// of a circle of 12 facets.
pub(super) const CORNER: f64 = 40.0;

/// The largest number of straight facets with bends on all sides that are no curve: a bevel has one, and a corner with two
/// bevels two.
pub(super) const MOST_STRAIGHT: usize = 2;

/// The largest ratio of a cell's longest edge to its smallest height (no unit). The condition number of the stiffness
/// grows with its square: 6 digits are lost here. Meshes graded towards a contact have 700, and are solved to the
/// usual accuracy.
pub(super) const SLIVER: f64 = 1000.0;

/// The largest ratio of the facet lengths of two surfaces (no unit): within a coarse facet that many fine ones
/// share one linear pressure, and Gauss points (4 a facet by default) skip fine facets.
pub(super) const MESH_RATIO: f64 = 10.0;

/// The largest Poisson's ratio (no unit) of linear elements. Bulk and shear modulus differ tenfold there, and
/// linear simplices have about as many volumes to keep as unknowns.
pub(super) const LOCKING: f64 = 0.45;

/// The largest prescribed motion of surfaces along each other, with contact at the reference positions, as a share of the facet
/// length: beyond it a point is opposite another facet than the one that holds it.
pub(super) const BEYOND_FACET: f64 = 1.0;

/// The largest difference of a law's stress from the derivative of its energy, and of its tangent from that of its
/// stress, as a share of the largest value: above what is lost by differences, and below what is no derivative at all.
pub(super) const SLOPE: f64 = 0.1;

/// The largest rotation (degrees) of a law for small strains: it stretches a body by 1 − cos 5° = 0.4 %.
pub(super) const ROTATION: f64 = 5.0;

/// The smallest share of the scene's size that displacements may have with laws for small strains (no unit). Gaps, as
/// differences of positions, keep 3 to 4 digits there.
pub(super) const SMALLEST_LINEAR: f64 = 1e-12;

/// As [`SMALLEST_LINEAR`], with a law of F: strains are differences of F and I, and keep 7 digits here, their
/// squares in the energy none.
pub(super) const SMALLEST_OF_F: f64 = 1e-9;

/// The largest ratio of bodies' sizes or stiffnesses (no unit). A thousand is the step of prefixes, as from mm to m and
/// from MPa to GPa; a million is that from Pa to MPa, and beyond it no pair of solids goes.
pub(super) const UNITS: f64 = 1e6;

/// The relative round-off (no unit) that is granted to values at a threshold which scenes meet exactly.
pub(super) const AT_LIMIT: f64 = 1e-6;

/// The largest difference of the slope of a distance from 1 (no unit): far above what differences leave, and below that of
/// a function which is no distance, such as x² + y² − r².
pub(super) const SLOPE_OF_DISTANCE: f64 = 1e-3;

/// Tied boundaries of bodies for large strains that are further apart, as a share of the facet size, are worth a warning: a rotation by a
/// right angle stretches the facets there by about as much.
pub(super) const TIED_APART: f64 = 1e-3;

/// Round-off of coordinates, as a share of a cell's smallest height: beyond the first worth a warning, beyond the second refused, as
/// strains of a hundredth are off by more than a thousandth then.
pub(super) const ROUNDED: [f64; 2] = [1e-9, 1e-5];

/// The largest displacement as a share of the scene's size, and the largest force divided by the stiffness and the area of the scene
/// (no unit). Nothing that is meant comes near; what is a thousand times as large overflows in squares and cubes.
pub(super) const LARGEST: f64 = 1e9;
