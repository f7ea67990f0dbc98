//! The scenes of the gallery: each is complete and certified, and its number is that of a formula, which is computed here from the
//! measures of the scene. Its table and its page tell both.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::Path;

use serde_json::{Map, Value};

use super::{fresh, program, read, results, root};

const FOLDER: &str = "examples/gallery";

/// The summary of a run that is complete and certified, and what it printed.
fn summary(scene: &Path, out: &Path) -> (BTreeMap<String, Value>, String) {
    let (code, told) = program(&["run", "--out"], &[out, scene]);
    assert_eq!(code, Some(0), "{told}");
    let summary = results(out);
    assert_eq!(summary["status"], "complete", "{told}");
    assert_eq!(summary["certificate"]["holds"], true, "{told}");
    (summary, told)
}

/// Whether the lines from the ending on have a number that is `value` to four digits, with either sign.
fn is_printed(value: f64, told: &str) -> bool {
    let ending = told.split(": complete").nth(1).unwrap_or_default();
    let words = ending.split(|c: char| !(c.is_ascii_digit() || ".e-".contains(c)));
    let mut numbers = words.filter_map(|word| word.parse::<f64>().ok());
    numbers.any(|number| (number.abs() / value - 1.0).abs() < 5e-4)
}

/// The table of the gallery, an entry for each scene.
fn entries() -> Vec<Map<String, Value>> {
    let text = read(Path::new(FOLDER).join("gallery.json"));
    serde_json::from_str(&text).expect("a list of entries")
}

fn text<'a>(entry: &'a Map<String, Value>, key: &str) -> &'a str {
    let value = entry.get(key).and_then(Value::as_str);
    value.unwrap_or_else(|| panic!("no text `{key}` in {entry:?}"))
}

fn number(entry: &Map<String, Value>, key: &str) -> f64 {
    let value = entry.get(key).and_then(Value::as_f64);
    value.unwrap_or_else(|| panic!("no number `{key}` in {entry:?}"))
}

/// The first key of a JSON pointer, and the pointer from there.
fn split(pointer: &str) -> (&str, &str) {
    let pointer = pointer.strip_prefix('/').unwrap_or(pointer);
    pointer.split_at(pointer.find('/').unwrap_or(pointer.len()))
}

/// A scene's number is that of the formula, within the table's bound; the table has the formula's value and the scene's.
fn compare(name: &str, truth: f64) {
    let entries = entries();
    let mut named = entries.iter().filter(|entry| text(entry, "scene") == name);
    let entry = named.next().expect("an entry of the table");
    let scene = root().join(FOLDER).join(name).with_extension("toml");
    let (summary, printed) = summary(&scene, &fresh(&format!("gallery_{name}")));
    // the pointer's first word is a key of the summary
    let (key, rest) = split(text(entry, "key"));
    let value = summary.get(key).and_then(|of| of.pointer(rest));
    let value = value.and_then(Value::as_f64);
    // of a pair it is the force on the first surface, which may be pressed down
    let value = value.expect("a number of the summary").abs();
    assert!(is_printed(value, &printed), "{name}: {value} {printed}");
    let off = value / truth - 1.0;
    let bound = number(entry, "bound");
    assert!(off.abs() <= bound, "{name}: {value} {truth}, {off:.1e}");
    // to the digits that are told
    let told = number(entry, "truth") / truth - 1.0;
    assert!(told.abs() < 1e-4, "{name}: {truth} {told:.1e}");
    let told = number(entry, "measured") / value - 1.0;
    assert!(told.abs() < 1e-3, "{name}: {value} {told:.1e}");
}

/// A test of each scene against its truth, and their names.
macro_rules! scenes {
    ($($name:ident)*) => {
        const NAMES: &[&str] = &[$(stringify!($name)),*];
        $(#[test]
        fn $name() {
            compare(stringify!($name), truths::$name());
        })*
    };
}

scenes! { o_ring snap_fit press_fit bearing bolt buffer roller indentation hip stack chain seal_lip }

/// The numbers by their formulas, in mm, N and MPa.
mod truths {
    use std::f64::consts::PI;

    /// Modulus and Poisson's ratio of steel as the scenes have it.
    const STEEL: (f64, f64) = (208_000.0, 0.3);

    fn plane_strain((young, poisson): (f64, f64)) -> f64 {
        young / (1.0 - poisson * poisson)
    }

    /// Lindley's force on a ring that is free to widen.
    pub fn o_ring() -> f64 {
        let (mean, cord, young, squeeze) = (20.0, 4.0, 6.0, 0.2_f64);
        PI * mean * cord * young * (1.25 * squeeze.powf(1.5) + 50.0 * squeeze.powi(6))
    }

    /// A beam of width 1 with shear, clamped at its root: what unit forces move.
    struct Beam {
        bending: f64,
        shear: f64,
    }

    impl Beam {
        fn new(young: f64, poisson: f64, height: f64) -> Beam {
            let inertia = height.powi(3) / 12.0;
            let shear_modulus = young / (2.0 * (1.0 + poisson));
            Beam {
                bending: young * inertia,
                shear: 5.0 / 6.0 * shear_modulus * height,
            }
        }

        /// The deflection at `far` under a unit force at `near`, or the other way round.
        fn compliance(&self, near: f64, far: f64) -> f64 {
            near * near * (3.0 * far - near) / (6.0 * self.bending) + near / self.shear
        }
    }

    /// The force that bends the arm by the height of the nose.
    pub fn snap_fit() -> f64 {
        let (length, height) = (18.4, 1.0);
        height / Beam::new(2000.0, 0.35, 2.0).compliance(length, length)
    }

    /// The rollers move the legs by `way`; the ends move by half the gap, held by a force on each other.
    pub fn buffer() -> f64 {
        let (at, end, way, half_gap) = (20.0, 39.0, 0.6, 1.0);
        let leg = Beam::new(2000.0, 0.3, 2.0);
        let [aa, ab, bb] = [(at, at), (at, end), (end, end)].map(|(a, b)| leg.compliance(a, b));
        (way * bb - half_gap * ab) / (aa * bb - ab * ab)
    }

    /// Lamé's pressure between a hub and a solid shaft of the same law, in plane stress.
    pub fn press_fit() -> f64 {
        let (young, interference, radius, outer) = (210_000.0, 0.015, 15.0, 30.0);
        let share: f64 = radius / outer;
        young * interference / (2.0 * radius) * (1.0 - share * share)
    }

    /// Hertz's largest pressure on a line, for the force per length of the half on the flat face.
    pub fn bearing() -> f64 {
        let (ball, groove, load) = (5.0, 5.2, 2.0 * 34.5 * 5.0);
        let radius = 1.0 / (1.0 / ball - 1.0 / groove);
        (load * plane_strain(STEEL) / (PI * radius)).sqrt()
    }

    /// Hertz's approach of two plates, solved for the force by bisection; half of it is on a quarter.
    pub fn roller() -> f64 {
        let (radius, approach, modulus) = (10.0, 0.1, plane_strain(STEEL));
        let by = |load: f64| {
            let half_width = (4.0 * load * radius / (PI * modulus)).sqrt();
            2.0 * load / (PI * modulus) * (2.0 * (4.0 * radius / half_width).ln() - 1.0)
        };
        let (mut low, mut high) = (1.0, 1e5);
        for _ in 0..100 {
            let middle = 0.5 * (low + high);
            match by(middle) < approach {
                true => low = middle,
                false => high = middle,
            }
        }
        0.5 * low
    }

    /// Boussinesq's force on a rigid flat punch.
    pub fn indentation() -> f64 {
        let (radius, depth) = (1.0, 0.01);
        2.0 * radius * plane_strain(STEEL) * depth
    }

    /// The force in the shank, by the stiffness of bolt and joint.
    pub fn bolt() -> f64 {
        let (steel, gasket, tightened, pull) = (210_000.0, 10_000.0, 0.1, 8000.0);
        let (shank, length) = (PI * 25.0, 60.0 + 0.5 * 10.0);
        let ring = PI * (81.0 - 36.0);
        let of_bolt = steel * shank / length;
        let of_joint = ring / (56.0 / steel + 4.0 / gasket);
        (tightened * of_joint + pull) * of_bolt / (of_bolt + of_joint)
    }

    /// Hertz's largest pressure in a point, of two bodies of one metal.
    pub fn hip() -> f64 {
        let (head, cup, load) = (25.0, 25.1, 2500.0);
        let modulus = 0.5 * plane_strain((230_000.0, 0.3));
        let radius: f64 = 1.0 / (1.0 / head - 1.0 / cup);
        let contact = (0.75 * load * radius / modulus).cbrt();
        1.5 * load / (PI * contact * contact)
    }

    /// Four blocks of 4 mm by 1 mm.
    pub fn stack() -> f64 {
        4.0 * (0.25 * 4.0)
    }

    /// Two forces on the half of the chain.
    pub fn chain() -> f64 {
        2.0 * 100.0
    }

    /// The radial force that widens the rim of a long thin tube.
    pub fn seal_lip() -> f64 {
        let (radius, wall, widened): (f64, f64, f64) = (20.2, 0.4, 0.1);
        let (young, poisson): (f64, f64) = (10.0, 0.45);
        let modulus = plane_strain((young, poisson));
        let decay = (3.0 * (1.0 - poisson * poisson)).powf(0.25) / (radius * wall).sqrt();
        let bending = modulus * wall.powi(3) / 12.0;
        2.0 * PI * radius * 2.0 * decay.powi(3) * bending * widened
    }
}

/// The table, the tests and the folder have the same scenes; the page and README show each of them.
#[test]
fn all_scenes_are_told() {
    let files = fs::read_dir(root().join(FOLDER)).expect("a folder");
    let files = files.map(|entry| entry.expect("an entry").path());
    let scenes: BTreeSet<String> = files
        .filter(|path| path.extension().is_some_and(|end| end == "toml"))
        .filter_map(|path| Some(path.file_stem()?.to_str()?.to_string()))
        .collect();
    assert!(scenes.iter().eq(NAMES.iter().collect::<BTreeSet<_>>()));
    let entries = entries();
    assert_eq!(entries.len(), scenes.len());
    let words = |text: &str| text.split_whitespace().collect::<Vec<_>>().join(" ");
    let (page, readme) = (words(&read("docs/gallery.md")), words(&read("README.md")));
    for entry in &entries {
        let [name, title] = ["scene", "title"].map(|key| text(entry, key));
        assert!(scenes.contains(name), "{name}");
        let unit = text(entry, "unit");
        let told = |key: &str| format!("{} {unit}", entry[key]);
        let row = format!("| {} | {} |", told("measured"), told("truth"));
        let picture = format!("](gallery/{name}.png)");
        let heading = format!("## {title} ![");
        let caption = words(text(entry, "caption"));
        for part in [
            row,
            picture,
            heading,
            caption,
            text(entry, "formula").into(),
        ] {
            assert!(page.contains(&part), "{name}: {part}");
        }
        let thumbnail = format!("](docs/gallery/{name}.png)](docs/gallery.md#");
        assert!(readme.contains(&thumbnail), "{name}");
    }
}

/// The first scene of README runs as it is printed, and the floor carries what the page says.
#[test]
fn the_scene_of_the_readme_runs() {
    let readme = read("README.md");
    let (_, rest) = readme.split_once("```toml\n").expect("a scene");
    let (scene, rest) = rest.split_once("```").expect("its end");
    let folder = fresh("gallery_readme");
    fs::write(folder.join("block.toml"), scene).expect("written");
    let (summary, _) = summary(&folder.join("block.toml"), &folder.join("out"));
    let force = summary["obstacle_forces"][0][1].as_f64().expect("a force");
    // plane strain, on a width of 2
    let expected = -100.0 / (1.0 - 0.09) * 0.1 * 2.0;
    assert!((force - expected).abs() < 1e-8, "{force} {expected}");
    let (told, _) = rest.split_once("## ").expect("a section");
    assert!(told.contains(&format!("{:.2} UF", -expected)), "{told}");
}
