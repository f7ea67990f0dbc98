//! A series of `.vtu` files with a `.pvd` index, for ParaView.

use std::path::PathBuf;

use base64::Engine;
use base64::engine::general_purpose::STANDARD;

use super::file;
use super::snapshot::{self, Snapshot};
use crate::assembly::CellState;
use crate::certificate::{Certificate, Limits};
use crate::contact::obstacle::outline::Frame;
use crate::error::Error;
use crate::model::Problem;
use crate::tensor::Vector;

/// A run in ParaView's format: one file for each step, `NAME_0000.vtu`, `NAME_0001.vtu`, …, and
/// `NAME.pvd`, which lists them with their times. A scene with obstacles has `NAME_obstacles_0000.vtu`, … beside them, as another
/// part: what of the obstacles' surfaces is around the bodies, where they are at that time, without those that do not count. Its
/// cells have the number of the `obstacle`, and the field `obstacle_NAME` of the file has the number of that name.
///
/// Points are the reference positions X; *Warp By Vector* with `displacement` shows the deformed
/// bodies. Every file is renamed to its final name when it is complete, and `NAME.pvd` lists
/// complete files only: the series of an interrupted run is readable.
///
/// | field | on | components | units |
/// |---|---|---|---|
/// | `displacement` | points | 3 | UL |
/// | `contact_pressure` | points | 1 | UF/UL², ≥ 0: the one to look at, and the file's active scalars |
/// | `contact_force` | points | 3 | UF |
/// | `contact_normal` | points | 3 | 1; outward, zero off the contact surfaces |
/// | `gap` | points | 1 | UL, positive = open; where there is none, the largest one |
/// | `status` | points | 1 | 0 open, 1 touching, 2 pressing |
/// | `nodal_von_mises`, `nodal_cauchy_stress` | points | 1, 6 | UF/UL², the mean stress of the cells around, in quadratic ones extrapolated to the node, and von Mises' of that mean |
/// | `contact_pressure_consistent` | points | 1 | UF/UL², an auxiliary field for comparisons, see [`Problem::consistent_pressures`] |
/// | `body` | points, cells | 1 | number of the body |
/// | `von_mises` | cells | 1 | UF/UL² |
/// | `error_indicator` | cells | 1 | the estimated error of the cell as a share of the energy norm, see [`ErrorEstimate`](crate::model::ErrorEstimate) |
/// | `J` | cells | 1 | volume ratio |
/// | `cauchy_stress` | cells | 6: xx, yy, zz, xy, yz, xz | UF/UL² |
/// | `body_NAME` | the file | 1 | the number of the body with this name |
/// | `certificate_…` | the file | 1 | see [`Certificate`]; converged steps only |
///
/// ```
/// use contact_fem::mesh::generators::{Diagonals, rectangle};
/// use contact_fem::output::{Snapshot, vtk::Series};
/// use contact_fem::{Body, NeoHookean, Scene};
///
/// # fn main() -> Result<(), Box<dyn std::error::Error>> {
/// let mut square = Body::new(rectangle(&[0.0, 1.0], &[0.0, 1.0], Diagonals::Rising)?, NeoHookean::new(1.0, 0.3)?);
/// square.prescribe("bottom", [Some(0.0); 2])?;
/// let mut scene = Scene::new();
/// scene.add("square", square);
/// let problem = scene.problem()?;
///
/// let folder = std::env::temp_dir().join(format!("series-{}", std::process::id()));
/// let mut series = Series::create(&folder, "run")?;
/// for time in [0.0, 0.5] {
///     series.write(time, &problem, &Snapshot::at_rest(&problem)?)?;
/// }
/// // the `.pvd` file names the two others in the folder, and nothing else is there
/// let listing = std::fs::read_to_string(series.collection())?;
/// let named: Vec<&str> = listing.split("file=\"").skip(1).filter_map(|rest| rest.split('"').next()).collect();
/// assert_eq!(named, ["run_0000.vtu", "run_0001.vtu"]);
/// assert!(named.iter().all(|file| folder.join(file).is_file()));
/// assert_eq!(std::fs::read_dir(&folder)?.count(), 3);
/// std::fs::remove_dir_all(&folder)?;
/// # Ok(())
/// # }
/// ```
#[derive(Clone, Debug)]
pub struct Series {
    folder: PathBuf,
    name: String,
    times: Vec<f64>,
    /// Whether there is a file of obstacles, for each time.
    has_obstacles: Vec<bool>,
}

impl Series {
    /// An empty series called `name` in `folder`, which is created if it does not exist. Files of
    /// an earlier series of that name are replaced one by one; the remaining ones are not listed.
    ///
    /// # Errors
    /// [`Error::Write`] if the folder cannot be created or the name has characters other than
    /// letters, digits, `_`, `-` and `.`.
    pub fn create(folder: impl Into<PathBuf>, name: &str) -> Result<Self, Error> {
        let folder = folder.into();
        file::check_name(&folder, name)?;
        file::create_folder(&folder)?;
        Ok(Series {
            folder,
            name: name.to_string(),
            times: Vec::new(),
            has_obstacles: Vec::new(),
        })
    }

    /// Adds the state `snapshot` at `time`, usually the load factor.
    ///
    /// # Errors
    /// [`Error::Write`].
    pub fn write<const D: usize>(
        &mut self,
        time: f64,
        problem: &Problem<D>,
        snapshot: &Snapshot<D>,
    ) -> Result<(), Error> {
        snapshot.check(problem)?;
        let index = self.times.len();
        let scene = problem.scene();
        let has_obstacles = !scene.obstacles().is_empty();
        if has_obstacles {
            let names = numbers("obstacle", scene.obstacle_names());
            let text = Grid::of_obstacles(problem, snapshot).text(&in_file(&names));
            let path = self.folder.join(self.obstacles_name(index));
            file::replace(&path, text.as_bytes())?;
        }
        let certificate = snapshot.certificate.as_ref();
        let text = Grid::new(problem, snapshot).text(&metadata(scene.names(), certificate));
        let path = self.folder.join(self.file_name(index));
        file::replace(&path, text.as_bytes())?;
        self.times.push(time);
        self.has_obstacles.push(has_obstacles);
        file::replace(&self.collection(), self.listing().as_bytes())
    }

    /// The path of the `.pvd` file, which is created by the first step.
    pub fn collection(&self) -> PathBuf {
        self.folder.join(format!("{}.pvd", self.name))
    }

    /// The number of states.
    pub fn len(&self) -> usize {
        self.times.len()
    }

    /// Whether the series has no states.
    pub fn is_empty(&self) -> bool {
        self.times.is_empty()
    }

    /// The names of the files that the next state is written to, the one that lists the others first.
    #[cfg(feature = "record")]
    pub(super) fn next_files<const D: usize>(&self, problem: &Problem<D>) -> Vec<String> {
        let index = self.times.len();
        let mut files = vec![format!("{}.pvd", self.name), self.file_name(index)];
        if !problem.scene().obstacles().is_empty() {
            files.push(self.obstacles_name(index));
        }
        files
    }

    fn file_name(&self, index: usize) -> String {
        format!("{}_{index:04}.vtu", self.name)
    }

    fn obstacles_name(&self, index: usize) -> String {
        format!("{}_obstacles_{index:04}.vtu", self.name)
    }

    /// The text of the `.pvd` file.
    fn listing(&self) -> String {
        let mut text = String::from(
            "<?xml version=\"1.0\"?>\n\
             <VTKFile type=\"Collection\" version=\"0.1\" byte_order=\"LittleEndian\">\n  \
             <Collection>\n",
        );
        let states = self.times.iter().zip(&self.has_obstacles).enumerate();
        for (index, (time, has_obstacles)) in states {
            let mut add = |part: usize, file: String| {
                text += &format!(
                    "    <DataSet timestep=\"{time}\" part=\"{part}\" file=\"{file}\"/>\n"
                );
            };
            // the bodies last: whoever looks for the last state takes the last line
            if *has_obstacles {
                add(1, self.obstacles_name(index));
            }
            add(0, self.file_name(index));
        }
        text + "  </Collection>\n</VTKFile>\n"
    }
}

/// Field data of the file.
fn in_file(data: &str) -> String {
    format!("\n<FieldData>{data}\n</FieldData>")
}

/// The number of each name as field data.
fn numbers(what: &str, names: &[String]) -> String {
    let number = |(number, name): (usize, &String)| {
        format!(
            "\n<DataArray type=\"Int32\" Name=\"{what}_{}\" NumberOfTuples=\"1\" \
             format=\"ascii\">{number}</DataArray>",
            escaped(name)
        )
    };
    names.iter().enumerate().map(number).collect()
}

/// The numbers of bodies and the certificate, if there is one, as field data of the file.
fn metadata(names: &[String], certificate: Option<&Certificate>) -> String {
    let limits = Limits::default();
    let mut text = numbers("body", names);
    let Some(certificate) = certificate else {
        return in_file(&text);
    };
    let mut array = |name: &str, value: f64| {
        text += &format!(
            "\n<DataArray type=\"Float64\" Name=\"certificate_{name}\" NumberOfTuples=\"1\" \
             format=\"ascii\">{value:e}</DataArray>"
        );
    };
    for entry in certificate.entries(&limits) {
        if let Some(value) = entry.value {
            array(entry.name, value);
        }
    }
    array("roundoff", certificate.roundoff());
    array("holds", f64::from(u8::from(certificate.holds(&limits))));
    in_file(&text)
}

/// A name as the value of an XML attribute.
fn escaped(name: &str) -> String {
    let special = [
        ("&", "&amp;"),
        ("<", "&lt;"),
        (">", "&gt;"),
        ("\"", "&quot;"),
    ];
    let replace = |text: String, (from, to): (&str, &str)| text.replace(from, to);
    special.into_iter().fold(file::in_xml(name), replace)
}

/// Numbers of one of VTK's types.
#[derive(Clone, Debug, PartialEq)]
enum Numbers {
    Float64(Vec<f64>),
    Int32(Vec<i32>),
    Int64(Vec<i64>),
    UInt8(Vec<u8>),
}

impl Numbers {
    fn kind(&self) -> &'static str {
        match self {
            Numbers::Float64(_) => "Float64",
            Numbers::Int32(_) => "Int32",
            Numbers::Int64(_) => "Int64",
            Numbers::UInt8(_) => "UInt8",
        }
    }

    fn bytes(&self) -> Vec<u8> {
        match self {
            Numbers::Float64(all) => all.iter().flat_map(|x| x.to_le_bytes()).collect(),
            Numbers::Int32(all) => all.iter().flat_map(|x| x.to_le_bytes()).collect(),
            Numbers::Int64(all) => all.iter().flat_map(|x| x.to_le_bytes()).collect(),
            Numbers::UInt8(all) => all.clone(),
        }
    }
}

/// Numbers with a name; those of one point or cell follow each other.
struct Array {
    name: &'static str,
    components: usize,
    numbers: Numbers,
}

impl Array {
    /// Its element, with the length in bytes and the data in base64.
    fn text(&self) -> String {
        let data = self.numbers.bytes();
        let mut bytes = (data.len() as u64).to_le_bytes().to_vec();
        bytes.extend(data);
        format!(
            "<DataArray type=\"{}\" Name=\"{}\" NumberOfComponents=\"{}\" format=\"binary\">\n{}\n</DataArray>\n",
            self.numbers.kind(),
            self.name,
            self.components,
            STANDARD.encode(bytes)
        )
    }
}

/// Mesh and fields.
struct Grid {
    /// What the file says of its fields, and which of them are shown first.
    about: [&'static str; 2],
    points: Array,
    cells: [Array; 3],
    of_points: Vec<Array>,
    of_cells: Vec<Array>,
}

impl Grid {
    fn new<const D: usize>(problem: &Problem<D>, snapshot: &Snapshot<D>) -> Self {
        let (mut connectivity, mut body_of_cell) = (Vec::new(), Vec::new());
        let (mut offsets, mut types) = (Vec::new(), Vec::new());
        for (body, nodes) in snapshot::cells(problem) {
            let before = connectivity.len();
            connectivity.extend(nodes.map(|a| a as i64));
            types.push(cell_type(D, connectivity.len() - before));
            offsets.push(connectivity.len() as i64);
            body_of_cell.push(body as i32);
        }
        Grid {
            about: [ABOUT, SHOWN],
            points: floats("Points", 3, in_space(problem.reference())),
            cells: [
                array("connectivity", 1, Numbers::Int64(connectivity)),
                array("offsets", 1, Numbers::Int64(offsets)),
                array("types", 1, Numbers::UInt8(types)),
            ],
            of_points: point_fields(problem, snapshot),
            of_cells: cell_fields(snapshot, body_of_cell),
        }
    }

    /// The obstacles around the bodies, where they are at the snapshot's load factor.
    fn of_obstacles<const D: usize>(problem: &Problem<D>, snapshot: &Snapshot<D>) -> Self {
        let rest = problem.reference();
        let moved = rest.iter().zip(&snapshot.displacements);
        let around = rest.iter().copied().chain(moved.map(|(X, u)| X + u));
        let frame = Frame::around(around);
        let (mut points, mut offsets, mut obstacles) = (Vec::new(), Vec::new(), Vec::new());
        for (index, obstacle, pose) in problem.obstacles_at(snapshot.load_factor) {
            for piece in frame
                .iter()
                .flat_map(|frame| obstacle.outline(&pose, frame))
            {
                points.extend(piece);
                offsets.push(points.len() as i64);
                obstacles.push(index as i32);
            }
        }
        let types = vec![outline_type(D); offsets.len()];
        let connectivity = (0..points.len() as i64).collect();
        Grid {
            about: ["", ""],
            points: floats("Points", 3, in_space(&points)),
            cells: [
                array("connectivity", 1, Numbers::Int64(connectivity)),
                array("offsets", 1, Numbers::Int64(offsets)),
                array("types", 1, Numbers::UInt8(types)),
            ],
            of_points: Vec::new(),
            of_cells: vec![array("obstacle", 1, Numbers::Int32(obstacles))],
        }
    }

    /// The file, with data of the whole grid.
    fn text(&self, metadata: &str) -> String {
        let all = |arrays: &[Array]| arrays.iter().map(Array::text).collect::<String>();
        let count = |of: &Array| match &of.numbers {
            Numbers::Float64(all) => all.len() / of.components,
            Numbers::UInt8(all) => all.len(),
            Numbers::Int32(all) => all.len(),
            Numbers::Int64(all) => all.len(),
        };
        let [about, shown] = self.about;
        format!(
            "<?xml version=\"1.0\"?>\n\
             <VTKFile type=\"UnstructuredGrid\" version=\"1.0\" byte_order=\"LittleEndian\" header_type=\"UInt64\">\n\
             <UnstructuredGrid>{metadata}\n\
             <Piece NumberOfPoints=\"{}\" NumberOfCells=\"{}\">\n\
             {about}<PointData{shown}>\n{}</PointData>\n<CellData>\n{}</CellData>\n\
             <Points>\n{}</Points>\n<Cells>\n{}</Cells>\n\
             </Piece>\n</UnstructuredGrid>\n</VTKFile>\n",
            count(&self.points),
            count(&self.cells[2]),
            all(&self.of_points),
            all(&self.of_cells),
            self.points.text(),
            all(&self.cells),
        )
    }
}

/// What a reader of the file should know of its fields.
const ABOUT: &str = "<!-- contact_pressure is the contact pressure. contact_pressure_consistent is an auxiliary \
    field for comparisons with other programs: it oscillates and may be negative. -->\n";
/// The fields that programs show first.
const SHOWN: &str = " Scalars=\"contact_pressure\" Vectors=\"displacement\"";

/// VTK's type of a piece of an obstacle: a line or a polygon.
fn outline_type(dimension: usize) -> u8 {
    match dimension {
        2 => 3,
        _ => 7,
    }
}

/// VTK's type of a simplex with this number of nodes; its node order is that of the elements.
fn cell_type(dimension: usize, nodes: usize) -> u8 {
    match (dimension, nodes) {
        (2, 3) => 5,
        (2, _) => 22,
        (_, 4) => 10,
        _ => 24,
    }
}

fn point_fields<const D: usize>(problem: &Problem<D>, snapshot: &Snapshot<D>) -> Vec<Array> {
    let bodies = 0..problem.scene().bodies().len();
    let body_of_node = bodies.flat_map(|k| problem.nodes(k).map(move |_| k as i32));
    let gaps = snapshot.gaps.iter();
    // not ∞, which spoils the scale of colours
    let finite = gaps.clone().filter(|gap| gap.is_finite());
    let widest = match finite.copied().fold(0.0, f64::max) {
        widest if widest > 0.0 => widest,
        _ => problem.scale().length,
    };
    let gaps = gaps.map(|gap| gap.min(widest));
    let statuses = snapshot.statuses.iter().map(|status| *status as i32);
    let von_mises = snapshot.averages.iter().map(CellState::von_mises);
    let stress = snapshot.averages.iter().flat_map(symmetric_components);
    vec![
        floats("displacement", 3, in_space(&snapshot.displacements)),
        floats("contact_pressure", 1, snapshot.pressures.clone()),
        floats("contact_force", 3, in_space(&snapshot.contact_forces)),
        floats("contact_normal", 3, in_space(&snapshot.contact_normals)),
        floats("gap", 1, gaps.collect()),
        array("status", 1, Numbers::Int32(statuses.collect())),
        floats("nodal_von_mises", 1, von_mises.collect()),
        floats("nodal_cauchy_stress", 6, stress.collect()),
        floats(
            "contact_pressure_consistent",
            1,
            snapshot.consistent_pressures.clone(),
        ),
        array("body", 1, Numbers::Int32(body_of_node.collect())),
    ]
}

fn cell_fields<const D: usize>(snapshot: &Snapshot<D>, bodies: Vec<i32>) -> Vec<Array> {
    let cells = &snapshot.cells;
    let values = |of: fn(&CellState<D>) -> f64| cells.iter().map(of).collect::<Vec<f64>>();
    let stress = cells.iter().flat_map(symmetric_components);
    vec![
        floats("von_mises", 1, values(CellState::von_mises)),
        floats("J", 1, values(|cell| cell.J)),
        floats("cauchy_stress", 6, stress.collect()),
        floats("error_indicator", 1, snapshot.errors.clone()),
        array("body", 1, Numbers::Int32(bodies)),
    ]
}

fn array(name: &'static str, components: usize, numbers: Numbers) -> Array {
    Array {
        name,
        components,
        numbers,
    }
}

fn floats(name: &'static str, components: usize, values: Vec<f64>) -> Array {
    array(name, components, Numbers::Float64(values))
}

/// Three coordinates for each vector; the third is 0 in the plane.
fn in_space<const D: usize>(vectors: &[Vector<D>]) -> Vec<f64> {
    let three = |v: &Vector<D>| [0, 1, 2].map(|i| if i < D { v[i] } else { 0.0 });
    vectors.iter().flat_map(three).collect()
}

/// σ as VTK orders symmetric tensors: xx, yy, zz, xy, yz, xz.
fn symmetric_components<const D: usize>(cell: &CellState<D>) -> [f64; 6] {
    [(0, 0), (1, 1), (2, 2), (0, 1), (1, 2), (0, 2)].map(|(i, j)| match (i < D, j < D) {
        (true, true) => cell.sigma[(i, j)],
        (false, false) => cell.sigma_zz,
        _ => 0.0,
    })
}

#[cfg(test)]
mod tests {
    use vtkio::model::{Attribute, DataSet, Piece, Vtk};

    use super::super::snapshot::tests::{displaced, squares, tetrahedron};
    use super::*;
    use crate::certificate::Condition;
    use crate::mesh::generators::{Diagonals, rectangle};
    use crate::{Body, Motion, NeoHookean, Obstacle, Scene};

    fn folder(name: &str) -> PathBuf {
        std::env::temp_dir().join(format!("contact-fem-{name}-{}", std::process::id()))
    }

    fn values(array: &Array) -> Vec<f64> {
        match &array.numbers {
            Numbers::Float64(all) => all.clone(),
            Numbers::Int32(all) => all.iter().map(|&k| k.into()).collect(),
            Numbers::Int64(all) => all.iter().map(|&k| k as f64).collect(),
            Numbers::UInt8(all) => all.iter().map(|&k| k.into()).collect(),
        }
    }

    /// Writes two states, reads the second one back by another library and compares it.
    fn round_trip<const D: usize>(name: &str, problem: &Problem<D>, snapshot: &Snapshot<D>) {
        let folder = folder(name);
        let mut series = Series::create(&folder, "run").expect("a series");
        let rest = Snapshot::at_rest(problem).expect("a snapshot");
        series.write(0.0, problem, &rest).expect("written");
        series.write(0.5, problem, snapshot).expect("written");
        let text = std::fs::read(folder.join("run_0001.vtu")).expect("a file");
        let text = String::from_utf8_lossy(&text);
        assert!(text.contains("certificate_drift\" NumberOfTuples=\"1\" format=\"ascii\">2.5e-1<"));
        assert!(text.contains("certificate_holds\" NumberOfTuples=\"1\" format=\"ascii\">0e0<"));

        let listing = std::fs::read_to_string(series.collection()).expect("a listing");
        assert_eq!(listing.matches("<DataSet").count(), 2);
        assert!(listing.contains("timestep=\"0.5\" part=\"0\" file=\"run_0001.vtu\""));
        let grid = Vtk::import(folder.join("run_0001.vtu")).expect("a grid");
        let DataSet::UnstructuredGrid { pieces, .. } = grid.data else {
            panic!("not an unstructured grid");
        };
        let Some(Piece::Inline(read)) = pieces.into_iter().next() else {
            panic!("no data in the file");
        };
        let own = Grid::new(problem, snapshot);
        assert_eq!(read.points.cast_into(), Some(values(&own.points)));
        for (read, own) in [
            (&read.data.point, &own.of_points),
            (&read.data.cell, &own.of_cells),
        ] {
            assert_eq!(read.len(), own.len());
            for (read, own) in read.iter().zip(own) {
                let Attribute::DataArray(array) = read else {
                    panic!("{} is no array", own.name);
                };
                assert_eq!(array.name, own.name);
                assert_eq!(array.elem.num_comp() as usize, own.components);
                assert_eq!(array.data.cast_into(), Some(values(own)), "{}", own.name);
            }
        }
        let types = read.cells.types.iter().map(|kind| f64::from(*kind as u8));
        assert_eq!(types.collect::<Vec<f64>>(), values(&own.cells[2]));
        let (connectivity, offsets) = read.cells.cell_verts.into_xml();
        let numbers = |all: Vec<u64>| all.into_iter().map(|k| k as f64).collect::<Vec<f64>>();
        assert_eq!(numbers(connectivity), values(&own.cells[0]));
        assert_eq!(numbers(offsets), values(&own.cells[1]));
        std::fs::remove_dir_all(&folder).expect("removed");
    }

    #[test]
    fn what_is_written_reads_back() {
        let plane = squares();
        let certificate = Certificate::uniform(0.0, 0.0).with(Condition::Drift, Some(0.25));
        let mut snapshot = displaced(&plane);
        snapshot.certificate = Some(certificate);
        round_trip("plane", &plane, &snapshot);
        let space = tetrahedron();
        let mut snapshot = displaced(&space);
        snapshot.certificate = Some(certificate);
        round_trip("space", &space, &snapshot);
    }

    #[test]
    fn fields_have_their_components() {
        let problem = squares();
        let snapshot = displaced(&problem);
        let grid = Grid::new(&problem, &snapshot);
        assert_eq!(values(&grid.points).len(), 3 * 8);
        assert_eq!(grid.cells[2].numbers, Numbers::UInt8(vec![5; 4]));
        let names =
            |fields: &[Array]| -> Vec<&str> { fields.iter().map(|field| field.name).collect() };
        let points = names(&grid.of_points);
        let known = [
            "displacement",
            "contact_pressure",
            "contact_force",
            "contact_normal",
            "gap",
            "status",
            "nodal_von_mises",
            "nodal_cauchy_stress",
            "contact_pressure_consistent",
            "body",
        ];
        assert_eq!(points, known);
        let cells = names(&grid.of_cells);
        assert_eq!(
            cells,
            ["von_mises", "J", "cauchy_stress", "error_indicator", "body"]
        );
        let stress = symmetric_components(&snapshot.cells[1]);
        let cell = &snapshot.cells[1];
        assert_eq!(
            stress[..3],
            [cell.sigma[(0, 0)], cell.sigma[(1, 1)], cell.sigma_zz]
        );
        assert_eq!(stress[3..], [cell.sigma[(0, 1)], 0.0, 0.0]);
    }

    /// A square on a floor, with a disc that comes down by 2 and turns up for the second half alone: the disc's points are a radius away
    /// from where it is by hand, those of the floor at y = 0, and no point is far from the square.
    #[test]
    fn obstacles_are_a_part_of_their_own() {
        let mesh = rectangle(&[0.0, 1.0], &[0.0, 1.0], Diagonals::Rising).expect("a square");
        let mut body = Body::new(mesh, NeoHookean::new(10.0, 0.3).expect("a law"));
        body.prescribe("bottom", [Some(0.0); 2]).expect("held");
        let mut scene = Scene::new();
        let square = scene.add("square", body);
        let floor = Obstacle::half_space([0.0; 2], [0.0, 1.0]).expect("a floor");
        scene
            .obstacle("floor", square.on("bottom"), floor)
            .expect("an obstacle");
        let down = Motion::translation([0.0, -2.0]).expect("a motion");
        let disc = Obstacle::ball([0.5, 3.2], 0.2)
            .expect("a disc")
            .moving(down);
        let disc = scene
            .obstacle("a <disc>", square.on("top"), disc)
            .expect("an obstacle");
        scene.obstacle_during(disc, &[[0.5, 2.0]]).expect("times");
        let problem = scene.problem().expect("a problem");
        let folder = folder("obstacles");
        let mut series = Series::create(&folder, "run").expect("a series");
        let mut snapshot = Snapshot::at_rest(&problem).expect("a snapshot");
        for (time, numbers) in [(0.0, vec![0.0]), (1.0, vec![0.0, 1.0])] {
            snapshot.load_factor = time;
            let name = format!("run_obstacles_{:04}.vtu", series.len());
            series.write(time, &problem, &snapshot).expect("written");
            let text = std::fs::read_to_string(folder.join(&name)).expect("a file");
            assert!(text.contains("Name=\"obstacle_a &lt;disc&gt;\""), "{text}");
            let grid = Vtk::import(folder.join(&name)).expect("a grid");
            let DataSet::UnstructuredGrid { mut pieces, .. } = grid.data else {
                panic!("not an unstructured grid");
            };
            let Some(Piece::Inline(read)) = pieces.pop() else {
                panic!("no data in the file");
            };
            let points: Vec<f64> = read.points.cast_into().expect("numbers");
            let Attribute::DataArray(array) = &read.data.cell[0] else {
                panic!("no array");
            };
            let obstacles: Vec<f64> = array.data.cast_into().expect("numbers");
            let mut found = obstacles.clone();
            found.dedup();
            assert_eq!((array.name.as_str(), found), ("obstacle", numbers));
            assert!(read.cells.types.iter().all(|kind| *kind as u8 == 3));
            // lines do not share points
            for (x, obstacle) in points.chunks(3).zip(obstacles.iter().flat_map(|k| [k, k])) {
                let off = match *obstacle {
                    0.0 => x[1],
                    _ => (x[0] - 0.5).hypot(x[1] - 1.2) - 0.2,
                };
                // the frame cuts chords
                assert!(off.abs() < 1e-3 && x[2] == 0.0, "{x:?} of {obstacle}");
                assert!(x[..2].iter().all(|c| (-0.1..1.1).contains(c)), "{x:?}");
            }
        }
        let listing = std::fs::read_to_string(series.collection()).expect("a listing");
        let parts: Vec<&str> = listing.split("part=\"").skip(1).collect();
        let expected = ["1\" file=\"run_obstacles_0000", "0\" file=\"run_0000"];
        assert_eq!(parts.len(), 4);
        assert!(
            parts
                .iter()
                .zip(expected)
                .all(|(part, begin)| part.starts_with(begin))
        );
        std::fs::remove_dir_all(&folder).expect("removed");
    }

    /// The recovered pressure is what a program shows first, and the file says what the other one is.
    #[test]
    fn the_file_tells_which_pressure_to_read() {
        let problem = squares();
        let text = Grid::new(&problem, &displaced(&problem)).text("");
        let has = |part| text.matches(part).count() == 1;
        assert!(has(
            "<PointData Scalars=\"contact_pressure\" Vectors=\"displacement\">"
        ));
        assert!(has("<!-- contact_pressure is the contact pressure."));
    }

    #[test]
    fn names_of_bodies_are_valid_in_xml() {
        let text = metadata(&["a\u{0}\u{1b}<\"b".into()], None);
        assert!(
            text.contains("Name=\"body_a\u{fffd}\u{fffd}&lt;&quot;b\""),
            "{text}"
        );
    }

    #[test]
    fn odd_names_are_refused() {
        for name in ["", ".", "..", "../a", "a/b", "a\"b", "a<b", "a\u{1}"] {
            let refused = Series::create(folder("names"), name);
            assert!(matches!(refused, Err(Error::Write { .. })), "{name}");
        }
    }
}
