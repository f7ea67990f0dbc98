//! Bodies of a scene file: meshes, laws, supports and loads.

use contact_fem::element::{Element, P1, P2};
use contact_fem::model::{ALL_NODES, name_of_nodes};
use contact_fem::tensor::Vector;
use contact_fem::{Body, Mesh, Scene};

use super::contact::Bodies;
use super::keys::{
    AmplitudeKeys, Ball, BodyKeys, BoundaryKeys, CurvedKeys, Cylinder, ForceKeys, FoundationKeys,
    HalfSpace, Name, NormalKeys, PressureKeys, Region, SmoothKeys, SupportKeys, TorqueKeys,
    TorqueValue, TractionKeys,
};
use super::laws;
use super::meshes::{Found, MeshKeys};
use super::place::Place;
use super::program::{amplitude, motion};
use super::rounds::onto;
use super::{Error, SceneFile};

impl SceneFile {
    /// Whether a quadratic body has a side that is curved by more than round-off of a file.
    ///
    /// # Errors
    /// As [`SceneFile::scene`].
    pub fn is_curved<const D: usize>(&self) -> Result<bool, Error>
    where
        P1: Element<D>,
        P2: Element<D>,
    {
        for (k, keys) in self.keys.body.iter().enumerate() {
            let mesh = self.mesh::<D>(&self.body_place(k), keys)?;
            if mesh.is_curved(1e-9) {
                return Ok(true);
            }
        }
        Ok(false)
    }

    pub(super) fn body_place(&self, index: usize) -> Place<'_> {
        let name = match self.keys.body[index].name.as_str() {
            "" => format!("body {}", index + 1),
            name => format!("body {name}"),
        };
        self.place().part("body", index, name)
    }

    /// Adds all bodies to the scene.
    pub(super) fn add_bodies<const D: usize>(
        &self,
        scene: &mut Scene<D>,
    ) -> Result<Bodies<'_>, Error>
    where
        P1: Element<D>,
        P2: Element<D>,
    {
        let (mut names, mut ids) = (Vec::new(), Vec::new());
        for (k, keys) in self.keys.body.iter().enumerate() {
            if let Some(other) = names.iter().position(|name| *name == keys.name) {
                let line = self.body_place(other).line();
                return Err(self.body_place(k).key("name").wrong(format!(
                    "two bodies are called `{}`, this one and that of line {line}: rename one of them",
                    keys.name
                )));
            }
            ids.push(scene.add(&keys.name, self.body(&self.body_place(k), keys)?));
            names.push(keys.name.as_str());
        }
        Ok(Bodies { names, ids })
    }

    /// The mesh of a body, as the scene asks for it.
    fn mesh<const D: usize>(&self, place: &Place<'_>, keys: &BodyKeys) -> Result<Mesh<D>, Error>
    where
        P1: Element<D>,
        P2: Element<D>,
    {
        let region = keys.region.as_ref().map(ToString::to_string);
        if let (MeshKeys::Made(_), Some(region)) = (&keys.mesh, &region) {
            let what = format!("a mesh that is made has no region {region}: leave it out");
            return Err(place.key("region").wrong(what));
        }
        if let (None, Some(distance)) = (keys.mesh.file(), keys.merge_nodes) {
            let what = format!(
                "a mesh that is made has no nodes to merge within {distance}: leave it out"
            );
            return Err(place.key("merge-nodes").wrong(what));
        }
        if region.is_some() && !keys.laws.is_empty() {
            let what = "its `laws` name regions of the whole mesh: leave `region` out";
            return Err(place.key("region").wrong(what));
        }
        let at = place.key("mesh");
        let found = match keys.laws.is_empty() {
            true => keys
                .mesh
                .mesh(&at, &self.folder, (region.as_deref(), keys.merge_nodes)),
            false => keys.mesh.with_regions(&at, &self.folder, keys.merge_nodes),
        };
        let mut mesh = match found? {
            Found::Mesh(mesh) => *mesh,
            Found::Regions(names) => {
                let names = names.join(", ");
                return Err(at.wrong(format!(
                    "its mesh has the regions {names}: choose one by `region`, or name all in `laws`"
                )));
            }
            Found::OtherDimension => {
                let what = format!("its mesh is not in {D} dimensions, as the first body's is");
                return Err(at.wrong(what));
            }
        };
        if keys.quadratic {
            mesh = mesh.quadratic();
        }
        let bent = |mut mesh: Mesh<D>, offset: Vector<D>| -> Result<Mesh<D>, Error> {
            for (k, curve) in keys.curved.iter().enumerate() {
                mesh = curve.bend(&place.entry("curved", k), mesh, offset)?;
            }
            Ok(mesh)
        };
        mesh = bent(mesh, Vector::zeros())?;
        if self.is_straight {
            mesh = mesh.straight();
        }
        let mut moved = [0.0; D];
        if let Some(offset) = &keys.translated {
            let at = place.key("translated");
            moved = at.vector(offset)?;
            mesh = at.of(mesh.translated(moved))?;
        }
        let own: Vec<String> = mesh.boundary_names().map(String::from).collect();
        for (name, boundary) in &keys.boundaries {
            let at = place.key("boundaries");
            if own.contains(name) {
                return Err(at.wrong(format!(
                    "its mesh has a boundary `{name}` already: choose another name"
                )));
            }
            boundary.add(&at, name, &mut mesh)?;
        }
        // names come first: a facet that was not on a boundary has no part on it
        let refined = self
            .refinement
            .drawn(&keys.name, mesh, |mesh| match self.is_straight {
                true => Ok(mesh),
                false => {
                    let mesh = keys
                        .mesh
                        .drawn(&at, mesh, moved.into())
                        .map_err(Uncut::Drawn)?;
                    bent(mesh, moved.into()).map_err(Uncut::Drawn)
                }
            });
        refined.map_err(|why| match why {
            Uncut::Drawn(why) => why,
            Uncut::Mesh(why) => place.key("mesh").refused(why),
        })
    }

    fn body<const D: usize>(&self, place: &Place<'_>, keys: &BodyKeys) -> Result<Body<D>, Error>
    where
        P1: Element<D>,
        P2: Element<D>,
    {
        // files of fields are called after the body
        if keys.name.contains(['/', '\\']) {
            let what = "a name has no `/` or `\\`, since files are called after it";
            return Err(place.key("name").wrong(what));
        }
        let mut body = laws::body(place, keys, self.mesh(place, keys)?)?;
        for (k, name) in keys.symmetry.iter().enumerate() {
            let at = place.entry("symmetry", k);
            at.of(body.symmetry(&name.to_string()))?;
        }
        for (k, support) in keys.supports.iter().enumerate() {
            let held = support.hold(&place.entry("supports", k), &mut body);
            held.map_err(|why| keys.against(place, k, (&body, why)))?;
        }
        for (k, traction) in keys.tractions.iter().enumerate() {
            traction.load(&place.entry("tractions", k), &mut body)?;
        }
        for (k, torque) in keys.torques.iter().enumerate() {
            torque.load(&place.entry("torques", k), &mut body)?;
        }
        for (k, force) in keys.forces.iter().enumerate() {
            force.load(&place.entry("forces", k), &mut body)?;
        }
        for (k, pressure) in keys.pressures.iter().enumerate() {
            pressure.load(&place.entry("pressures", k), &mut body)?;
        }
        for (k, foundation) in keys.foundations.iter().enumerate() {
            foundation.found(&place.entry("foundations", k), &mut body)?;
        }
        keys.weigh(place, &mut body)?;
        Ok(body)
    }
}

/// Why a mesh cannot be refined.
enum Uncut {
    Drawn(Error),
    Mesh(contact_fem::Error),
}

impl From<contact_fem::Error> for Uncut {
    fn from(why: contact_fem::Error) -> Self {
        Uncut::Mesh(why)
    }
}

impl CurvedKeys {
    /// Moves the middle nodes of the boundary onto a sphere, a circle or a cylinder, of a mesh that has been moved by `offset`.
    fn bend<const D: usize>(
        &self,
        place: &Place<'_>,
        mesh: Mesh<D>,
        offset: Vector<D>,
    ) -> Result<Mesh<D>, Error> {
        let CurvedKeys {
            on, centre, radius, ..
        } = self;
        let radius = *radius;
        positive(&place.key("radius"), radius)?;
        let centre = Vector::<D>::from(match centre {
            Some(centre) => place.key("centre").vector(centre)?,
            None => [0.0; D],
        });
        let centre = centre + offset;
        let axis = match &self.axis[..] {
            [] => Vector::zeros(),
            axis => {
                let at = place.key("axis");
                let axis = Vector::<D>::from(at.vector(axis)?);
                let unit = axis.try_normalize(0.0).filter(|_| D == 3);
                unit.ok_or_else(|| {
                    at.wrong("is a direction in space: give it a length, or leave it out")
                })?
            }
        };
        place.of(mesh.curved(&on.to_string(), onto(centre, axis, radius)))
    }
}

impl BoundaryKeys {
    /// How far a corner may be off a plane or a box, as a share of the mesh's diagonal.
    const OFF: f64 = 1e-9;
    /// How far off a ball or a cylinder, whose radius files seldom have to all digits.
    const OFF_ROUND: f64 = 1e-6;

    /// Names the boundary.
    fn add<const D: usize>(
        &self,
        place: &Place<'_>,
        name: &str,
        mesh: &mut Mesh<D>,
    ) -> Result<(), Error> {
        let region = match self {
            BoundaryKeys::Of(names) => {
                let names: Vec<String> = names.iter().map(ToString::to_string).collect();
                return place.of(mesh.join_boundaries(name, &names));
            }
            BoundaryKeys::In(region) => region,
        };
        let (low, high) = mesh.bounding_box();
        let diagonal = (high - low).norm();
        let off = Self::OFF * diagonal;
        let direction = |of: &[f64], what: &str| -> Result<Vector<D>, Error> {
            let direction = Vector::<D>::from(place.vector(of)?).try_normalize(0.0);
            direction.ok_or_else(|| place.wrong(format!("the {what} of `{name}` has no length")))
        };
        match region {
            Region::Plane(HalfSpace { point, normal }) => {
                let point = Vector::<D>::from(place.vector(point)?);
                let n = direction(normal, "normal")?;
                mesh.name_boundary(name, |x| n.dot(&(x - point)).abs() <= off);
            }
            Region::Box(corners) => {
                let low = place.vector::<D>(&corners.low)?;
                let high = place.vector::<D>(&corners.high)?;
                let is_in =
                    |x: &Vector<D>| (0..D).all(|i| x[i] >= low[i] - off && x[i] <= high[i] + off);
                mesh.name_boundary(name, is_in);
            }
            Region::Ball(Ball { centre, radius }) => {
                let centre = Vector::<D>::from(place.vector(centre)?);
                positive(&place.key("radius"), *radius)?;
                let off = Self::OFF_ROUND * diagonal;
                mesh.name_boundary(name, |x| ((x - centre).norm() - radius).abs() <= off);
            }
            Region::Cylinder(Cylinder {
                point,
                axis,
                radius,
            }) => {
                let point = Vector::<D>::from(place.vector(point)?);
                let axis = match (D, &axis[..]) {
                    (2, []) => Vector::zeros(),
                    (2, _) => {
                        let what = "is a direction in space: leave it out in the plane";
                        return Err(place.key("axis").wrong(what));
                    }
                    _ => direction(axis, "axis")?,
                };
                positive(&place.key("radius"), *radius)?;
                let off = Self::OFF_ROUND * diagonal;
                let across = |x: &Vector<D>| {
                    let arm = x - point;
                    (arm - axis * arm.dot(&axis)).norm()
                };
                mesh.name_boundary(name, |x| (across(x) - radius).abs() <= off);
            }
            Region::Normal(NormalKeys {
                direction: looks,
                within,
            }) => {
                let looks = direction(looks, "direction")?;
                let least = angle(&place.key("within"), *within)?.cos();
                mesh.name_facets(name, |_, n| n.dot(&looks) >= least);
            }
            Region::Smooth(SmoothKeys { from, angle: most }) => {
                let from = Vector::<D>::from(place.vector(from)?);
                angle(&place.key("angle"), *most)?;
                mesh.name_smooth(name, &from, *most);
            }
        }
        match place.of(mesh.boundary(name))?.is_empty() {
            true => Err(place.wrong(format!(
                "no facet of the mesh is on `{name}`: it takes facets that have all corners there, or normals that look there"
            ))),
            false => Ok(()),
        }
    }
}

fn positive(place: &Place<'_>, radius: f64) -> Result<(), Error> {
    match radius > 0.0 && radius.is_finite() {
        true => Ok(()),
        false => Err(place.wrong(format!("the radius {radius} must be positive and finite"))),
    }
}

/// An angle in degrees, in radians.
fn angle(place: &Place<'_>, degrees: f64) -> Result<f64, Error> {
    match (0.0..=180.0).contains(&degrees) {
        true => Ok(degrees.to_radians()),
        false => Err(place.wrong(format!(
            "{degrees} is no angle from 0 to 180 degrees: choose one"
        ))),
    }
}

impl BodyKeys {
    /// The error of a support that another one contradicts, with the line of that one, too.
    fn against<const D: usize>(
        &self,
        place: &Place<'_>,
        k: usize,
        (body, error): (&Body<D>, Error),
    ) -> Error {
        use contact_fem::Error as Refused;
        let Error::Refused { part, source } = error else {
            return error;
        };
        let on = match &*source {
            Refused::Conflict { on, .. } | Refused::NearlyParallel { on, .. } => on,
            _ => return Error::Refused { part, source },
        };
        // this one may be either
        let first = match self.supports[k].is_called(&on[0], body) {
            true => &on[1],
            false => &on[0],
        };
        let is_first = |on: &Name| on.to_string() == *first;
        let mut supports = self.supports[..k].iter();
        let support = supports.position(|own| own.is_called(first, body));
        let symmetry = self.symmetry.iter().position(is_first);
        let other = match (support, symmetry) {
            (Some(j), _) => place.entry("supports", j),
            (None, Some(j)) => place.entry("symmetry", j),
            (None, None) => return Error::Refused { part, source },
        };
        let part = match other.line() {
            line if line == place.entry("supports", k).line() => part,
            line => format!("{part}, against line {line}"),
        };
        Error::Refused { part, source }
    }

    /// The body force.
    fn weigh<const D: usize>(&self, place: &Place<'_>, body: &mut Body<D>) -> Result<(), Error> {
        let (at, in_time) = (place.key("body-force"), place.key("body-force-amplitude"));
        let course = amplitude(&in_time, self.body_force_amplitude.as_ref())?;
        match &self.body_force {
            Some(force) => {
                at.of(body.body_force_in_time(at.vector(force)?, course))?;
            }
            None if self.body_force_amplitude.is_some() => {
                let what = "`body-force-amplitude` has no effect without `body-force`";
                return Err(in_time.wrong(what));
            }
            None => {}
        }
        Ok(())
    }
}

impl TractionKeys {
    fn load<const D: usize>(&self, place: &Place<'_>, body: &mut Body<D>) -> Result<(), Error> {
        let force = place.key("force").vector(&self.force)?;
        let course = amplitude(&place.key("amplitude"), self.amplitude.as_ref())?;
        let on = self.on.to_string();
        let loaded = body.traction_in_time(&on, force, course);
        place.key("on").of(loaded)?;
        Ok(())
    }
}

impl TorqueKeys {
    fn load<const D: usize>(&self, place: &Place<'_>, body: &mut Body<D>) -> Result<(), Error> {
        let torque = match &self.torque {
            TorqueValue::InPlane(torque) => std::slice::from_ref(torque),
            TorqueValue::InSpace(torque) => torque,
        };
        let course = amplitude(&place.key("amplitude"), self.amplitude.as_ref())?;
        let on = self.on.to_string();
        match body.torque_in_time(&on, torque, course) {
            Err(why @ contact_fem::Error::Setting { .. }) => place.key("torque").of(Err(why)),
            other => place.key("on").of(other.map(|_| ())),
        }
    }
}

impl ForceKeys {
    fn load<const D: usize>(&self, place: &Place<'_>, body: &mut Body<D>) -> Result<(), Error> {
        let force = place.key("force").vector(&self.force)?;
        let course = amplitude(&place.key("amplitude"), self.amplitude.as_ref())?;
        let at = place.key("at");
        let nodes = nodes_at(&at, body, &self.at)?;
        at.of(body.nodal_force_in_time(&nodes, force, course))?;
        Ok(())
    }
}

/// The nodes of a body at these points.
fn nodes_at<const D: usize>(
    at: &Place<'_>,
    body: &Body<D>,
    points: &[Vec<f64>],
) -> Result<Vec<usize>, Error> {
    let points: Result<Vec<[f64; D]>, Error> = points.iter().map(|x| at.vector(x)).collect();
    at.of(body.mesh().nodes_at(&points?))
}

impl PressureKeys {
    fn load<const D: usize>(&self, place: &Place<'_>, body: &mut Body<D>) -> Result<(), Error> {
        let course = amplitude(&place.key("amplitude"), self.amplitude.as_ref())?;
        let on = self.on.to_string();
        place.of(body.pressure_in_time(&on, self.pressure, course))?;
        Ok(())
    }
}

impl FoundationKeys {
    fn found<const D: usize>(&self, place: &Place<'_>, body: &mut Body<D>) -> Result<(), Error> {
        let on = self.on.to_string();
        place.of(match self.normal_only {
            true => body.normal_foundation(&on, self.stiffness),
            false => body.foundation(&on, self.stiffness),
        })?;
        Ok(())
    }
}

impl SupportKeys {
    /// Whether the library may call it so; the numbers of the nodes that it holds `at` points are not in the file.
    pub(super) fn may_be_called(&self, name: &str) -> bool {
        match (&self.on, &self.at) {
            (Some(on), _) => on.to_string() == name,
            (None, Some(_)) => name.starts_with("node"),
            (None, None) => name == ALL_NODES,
        }
    }

    /// Whether a support of this body has this name in the library.
    fn is_called<const D: usize>(&self, name: &str, body: &Body<D>) -> bool {
        match &self.at {
            Some(points) => {
                let points: Option<Vec<[f64; D]>> = points
                    .iter()
                    .map(|x| x.as_slice().try_into().ok())
                    .collect();
                let nodes = points.and_then(|points| body.mesh().nodes_at(&points).ok());
                nodes.is_some_and(|nodes| name_of_nodes(&nodes) == name)
            }
            None => self.may_be_called(name),
        }
    }

    fn hold<const D: usize>(&self, place: &Place<'_>, body: &mut Body<D>) -> Result<(), Error> {
        let Some(during) = &self.during else {
            return self.hold_now(place, body);
        };
        self.check_growth(place, &during.0)?;
        let mut held = Ok(());
        let switched = body.during(&during.0, |body| {
            held = self.hold_now(place, body);
            Ok(body)
        });
        place.key("during").of(switched)?;
        held
    }

    /// Refuses values that move nothing, since their amplitude does not change while the support holds.
    fn check_growth(&self, place: &Place<'_>, during: &[[f64; 2]]) -> Result<(), Error> {
        let values = [("x", self.x), ("y", self.y), ("z", self.z), ("by", self.by)];
        let mut values = values.into_iter();
        let given = values.find(|(_, value)| value.is_some_and(|value| value != 0.0));
        // what holds from the beginning moves from rest to its first value
        let stays = |amplitude: &Option<AmplitudeKeys>| match amplitude {
            Some(amplitude) => during
                .iter()
                .all(|own| own[0] > 0.0 && amplitude.is_constant(*own)),
            None => false,
        };
        let motions = &self.motion.0;
        if !motions.is_empty() && motions.iter().all(|own| stays(&own.amplitude)) {
            let what = "has no effect: the support begins later, moves nodes by what its motion grows from then on, and the amplitude \
                        stays the same: write x = 0 and so on to hold them where they are, or change the amplitude while it holds";
            return Err(place.key("motion").wrong(what));
        }
        let Some((key, Some(value))) = given else {
            return Ok(());
        };
        match stays(&self.amplitude) {
            true => Err(place.key(key).wrong(format!(
                "`{key} = {value}` has no effect: the support begins later, moves nodes by what its value grows from then on, and its \
                 amplitude stays the same: write 0 to hold them where they are, or change the amplitude while it holds"
            ))),
            false => Ok(()),
        }
    }

    fn hold_now<const D: usize>(&self, place: &Place<'_>, body: &mut Body<D>) -> Result<(), Error> {
        let all = [self.x, self.y, self.z];
        if D == 2 && self.z.is_some() {
            return Err(place.key("z").wrong("a support in the plane has no `z`"));
        }
        let name = self.on.as_ref().map(ToString::to_string);
        let components = std::array::from_fn(|i| all[i]);
        let moves = motion(place, &self.motion)?;
        let has_components = all.iter().any(Option::is_some);
        let direction = match &self.along {
            Some(along) => Some(place.key("along").vector(along)?),
            None => None,
        };
        let by = self.by.unwrap_or(0.0);
        let has_values = has_components || direction.is_some();
        let is_on = name.is_some();
        let what = match (has_values, &moves, &self.amplitude, &self.at) {
            _ if has_components && direction.is_some() => {
                "has components and `along`: give it one of them"
            }
            _ if self.by.is_some() && direction.is_none() => "has `by` without `along`",
            _ if direction.is_some() && !is_on && self.at.is_none() => {
                "has `along`: name its nodes by `on` or `at`"
            }
            (.., Some(_)) if is_on => "has `on` and `at`: give it one of them",
            (false, None, ..) => "holds nothing: give it x, y, z, `along` or `motion`",
            (true, Some(_), ..) => "has components and a motion: give it one of them",
            (_, Some(_), Some(_), _) => {
                "has a motion, which has amplitudes of its own: leave `amplitude` out"
            }
            _ => "",
        };
        if !what.is_empty() {
            let on = match (&name, &self.at) {
                (Some(name), _) => format!("on {name}"),
                (None, Some(_)) => "at nodes".into(),
                (None, None) => "without `on`".into(),
            };
            return Err(place.wrong(format!("its support {on} {what}")));
        }
        let course = amplitude(&place.key("amplitude"), self.amplitude.as_ref())?;
        if let Some(points) = &self.at {
            let at = place.key("at");
            let nodes = nodes_at(&at, body, points)?;
            at.of(match (moves, direction) {
                (Some(moves), _) => body.prescribe_motion_of_nodes(&nodes, moves),
                (None, Some(n)) => body.prescribe_nodes_along_in_time(&nodes, n, by, course),
                (None, None) => body.prescribe_nodes_in_time(&nodes, components, course),
            })?;
            return Ok(());
        }
        let is_boundary = name
            .as_ref()
            .is_none_or(|name| body.mesh().boundary(name).is_ok());
        let held_on = match (is_boundary, direction.is_some()) {
            (false, _) => place.key("on"),
            (true, true) => place.key("along"),
            (true, false) => place.clone(),
        };
        let held = match (name, moves, direction) {
            (Some(name), Some(moves), _) => body.prescribe_motion(&name, moves),
            (None, Some(moves), _) => body.prescribe_motion_of_all(moves),
            (Some(name), None, Some(n)) => body.prescribe_along_in_time(&name, n, by, course),
            (Some(name), None, None) => body.prescribe_in_time(&name, components, course),
            (None, None, _) => body.prescribe_all_in_time(components, course),
        };
        held_on.of(held)?;
        Ok(())
    }
}
