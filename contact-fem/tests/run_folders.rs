//! Folders of recorded runs, read back after every way to end: what is there is whole, and says what happened.
#![cfg(unix)]

use std::collections::BTreeMap;
use std::io::Write;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, ExitStatus, Stdio};
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use contact_fem::mesh::generators::{Diagonals, linspace, rectangle};
use contact_fem::model::Problem;
use contact_fem::output::record::{Recorded, Recording};
use contact_fem::{Body, Error, NeoHookean, Scene, Simulation};
use serde_json::Value;
use vtkio::model::Vtk;

/// Tells a child process where to record, and how many increments.
const FOLDER: &str = "RUN_FOLDERS_FOLDER";
const INCREMENTS: &str = "RUN_FOLDERS_INCREMENTS";
/// How many children are killed; more on request.
const KILLS: &str = "RUN_FOLDERS_KILLS";

type Files = BTreeMap<String, Vec<u8>>;

/// A block whose top is pushed sideways and `down`.
fn block(down: f64) -> Problem<2> {
    let sides = linspace(0.0, 1.0, 4);
    let mesh = rectangle(&sides, &sides, Diagonals::Rising).expect("a mesh");
    let mut block = Body::new(mesh, NeoHookean::new(100.0, 0.3).expect("a law"));
    block.prescribe("bottom", [Some(0.0); 2]).expect("support");
    let top = [Some(0.1), Some(-down)];
    block.prescribe("top", top).expect("support");
    let mut scene = Scene::new();
    scene.add("block", block);
    scene.problem().expect("a problem")
}

/// A run of the block, without output.
fn run(folder: &Path, increments: usize) -> Result<Recorded<2>, Error> {
    let mut simulation = Simulation::with_increments(increments);
    quiet(simulation.record(folder)).run(&mut block(0.1))
}

fn quiet<S>(mut recording: Recording<'_, 2, S>) -> Recording<'_, 2, S> {
    recording.plan.name = "run".into();
    recording.plan.quiet = true;
    recording
}

/// An empty folder of a test.
fn fresh(name: &str) -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join(name);
    if folder.exists() {
        std::fs::remove_dir_all(&folder).expect("removed");
    }
    std::fs::create_dir_all(&folder).expect("a folder");
    folder
}

/// All files of a folder.
fn files(folder: &Path) -> Files {
    let entries = std::fs::read_dir(folder).expect("a folder");
    let file = |entry: std::io::Result<std::fs::DirEntry>| {
        let entry = entry.expect("a file");
        let name = entry.file_name().into_string().expect("a name");
        (name, std::fs::read(entry.path()).expect("bytes"))
    };
    entries.map(file).collect()
}

fn ending(files: &Files, end: &str) -> Vec<String> {
    let names = files.keys().filter(|name| name.ends_with(end));
    names.cloned().collect()
}

fn summary(folder: &Path) -> Value {
    let text = std::fs::read(folder.join("summary.json")).expect("a summary");
    serde_json::from_slice(&text).expect("JSON")
}

/// Checks that every file is whole, and that the series lists what is there.
fn check_whole(folder: &Path) {
    let files = files(folder);
    for (name, bytes) in &files {
        let text = String::from_utf8_lossy(bytes);
        match name.rsplit_once('.').map(|(_, end)| end) {
            Some("json") => drop(serde_json::from_slice::<Value>(bytes).expect(name)),
            Some("csv") => {
                assert!(text.ends_with('\n') && text.lines().count() >= 1, "{name}");
                // the reader checks that all lines have the same number of fields
                let lines = csv::Reader::from_reader(&bytes[..]).into_records();
                lines.for_each(|line| drop(line.expect(name)));
            }
            Some("vtu") => drop(Vtk::import(folder.join(name)).expect(name)),
            Some("pvd") => {
                assert!(text.ends_with("</VTKFile>\n"), "{name}");
                let listed = listed(&text);
                assert!(
                    listed.iter().all(|file| files.contains_key(*file)),
                    "{text}"
                );
            }
            Some("svg") => assert!(text.ends_with("</svg>\n"), "{name}"),
            Some("lock" | "part" | "txt") => {}
            _ => panic!("{name} is none of a run's files"),
        }
    }
}

/// The files that a series lists.
fn listed(pvd: &str) -> Vec<&str> {
    let parts = pvd.split("file=\"").skip(1);
    parts.filter_map(|part| part.split('"').next()).collect()
}

/// Checks a folder whose run has ended, and that its series has this number of states and nothing of an earlier run.
fn check_ended(folder: &Path, status: &str, states: usize) -> Value {
    check_whole(folder);
    let found = files(folder);
    assert_eq!(ending(&found, ".part"), [""; 0]);
    let expected: Vec<String> = (0..states).map(|k| format!("run_{k:04}.vtu")).collect();
    assert_eq!(ending(&found, ".vtu"), expected);
    let pvd = String::from_utf8_lossy(&found["run.pvd"]);
    assert_eq!(listed(&pvd), expected);
    let summary = summary(folder);
    assert_eq!(summary["status"], status, "{}", summary["reason"]);
    assert_eq!(summary["process"], std::process::id());
    summary
}

fn path_of(error: &Error) -> &Path {
    match error {
        Error::Write { path, .. } => path,
        other => panic!("not of a file: {other}"),
    }
}

/// A block on another one, pushed down by 0.1 if they are to meet, up if not.
fn stacked(meet: bool) -> Problem<2> {
    let block = |low: f64, side: &str, value: [Option<f64>; 2]| {
        let (x, y) = (linspace(0.0, 1.0, 4), linspace(low, low + 1.0, 4));
        let mesh = rectangle(&x, &y, Diagonals::Rising).expect("a mesh");
        let mut block = Body::new(mesh, NeoHookean::new(100.0, 0.3).expect("a law"));
        block.prescribe(side, value).expect("support");
        block
    };
    let push = if meet { -0.1 } else { 0.1 };
    let mut scene = Scene::new();
    let lower = scene.add("lower", block(0.0, "bottom", [Some(0.0); 2]));
    let upper = scene.add("upper", block(1.0, "top", [Some(0.0), Some(push)]));
    let pair = scene.contact(lower.on("top"), upper.on("bottom"));
    pair.expect("a pair");
    scene.problem().expect("a problem")
}

/// Every run in which something presses has a picture of the pressure; the next run without contact takes it away.
#[test]
fn the_pressure_is_drawn_where_bodies_meet() {
    let folder = fresh("pressure");
    for meet in [true, false] {
        let mut simulation = Simulation::with_increments(2);
        let recorded = quiet(simulation.record(&folder)).run(&mut stacked(meet));
        assert!(recorded.expect("a run").history.is_complete());
        check_whole(&folder);
        let files = files(&folder);
        assert_eq!(files.contains_key("pressure.svg"), meet);
        let largest = summary(&folder)["pressure_max"].as_f64();
        assert_eq!(largest.is_some_and(|p| p > 1.0), meet, "{largest:?}");
        let lock = String::from_utf8_lossy(&files["run.lock"]);
        assert_eq!(lock.contains("pressure.svg"), meet, "{lock}");
        if meet {
            let picture = String::from_utf8_lossy(&files["pressure.svg"]);
            let has = |text| picture.contains(text);
            assert!(has("Contact pressure") && has("lower") && has("upper"));
        }
    }
}

/// Three steps and a force make a picture of it, under the name that the plan gives.
#[test]
fn the_force_is_drawn_where_there_is_one() {
    let folder = fresh("force");
    for (increments, name, is_drawn) in [
        (2, "force.svg", false),
        (3, "force.svg", true),
        (3, "reaction.svg", true),
        (3, "", false),
    ] {
        let mut simulation = Simulation::with_increments(increments);
        let mut recording = quiet(simulation.record(&folder));
        recording.plan.force_picture = name.into();
        recording.run(&mut block(0.1)).expect("a run");
        check_ended(&folder, "complete", increments + 1);
        let files = files(&folder);
        let pictures = ["meshes.svg"].into_iter().chain(is_drawn.then_some(name));
        let mut pictures: Vec<&str> = pictures.collect();
        pictures.sort_unstable();
        assert_eq!(ending(&files, ".svg"), pictures, "{increments} {name}");
        if is_drawn {
            let text = String::from_utf8_lossy(&files[name]);
            assert!(text.contains("reaction (UF)") && text.contains("time (load factor)"));
        }
    }
}

#[test]
fn a_second_run_is_refused_and_disturbs_nothing() {
    let folder = fresh("in_use");
    run(&folder, 5).expect("an earlier run");
    let mut steps = 0;
    let tried = std::cell::RefCell::new(&mut steps);
    let mut simulation = Simulation::with_increments(2);
    let recording = quiet(simulation.record(&folder)).message(|_| {
        let before = files(&folder);
        // of the run before, nothing is left
        assert_eq!(summary(&folder)["status"], "running");
        assert!(!before.contains_key("meshes.svg") && ending(&before, ".vtu").len() <= 2);
        let refused = run(&folder, 2).expect_err("in use");
        let is_named = matches!(&refused, Error::FolderInUse { folder: named } if *named == folder);
        assert!(
            is_named && refused.to_string().contains("another folder"),
            "{refused}"
        );
        assert!(before == files(&folder));
        **tried.borrow_mut() += 1;
        String::new()
    });
    recording.run(&mut block(0.1)).expect("not disturbed");
    assert_eq!(steps, 2);
    let summary = check_ended(&folder, "complete", 3);
    assert_eq!(summary["reason"], Value::Null);
    run(&folder, 1).expect("the folder is free again");
    check_ended(&folder, "complete", 2);
}

#[test]
fn no_ending_leaves_what_an_earlier_run_said() {
    let folder = fresh("endings");
    let complete = || {
        run(&folder, 6).expect("a run");
        let summary = check_ended(&folder, "complete", 7);
        assert_eq!(summary["converged"], true);
    };
    std::fs::write(folder.join("notes.txt"), "mine").expect("a file of the user");

    complete();
    let mut simulation = Simulation::with_increments(6);
    simulation.load_steps.stop.request();
    let recording = quiet(simulation.record(&folder));
    recording.run(&mut block(0.1)).expect("no misuse");
    let stopped = check_ended(&folder, "stopped", 1);
    assert_eq!(stopped["converged"], false);
    assert!(
        stopped["reason"]
            .as_str()
            .expect("a reason")
            .starts_with("interrupted")
    );

    complete();
    let mut simulation = Simulation::with_increments(6);
    simulation.load_steps.budget.factorizations = Some(1);
    let recording = quiet(simulation.record(&folder));
    let recorded = recording.run(&mut block(0.1)).expect("no misuse");
    let kept = recorded.history.steps.len();
    let stopped = check_ended(&folder, "stopped", 1 + kept);
    let reason = stopped["reason"].as_str().expect("a reason");
    assert!(reason.contains("factorisations (1)"), "{reason}");
    assert_eq!(stopped["factorisations"], 1);

    complete();
    // half way down, the block would be flat
    let mut simulation = Simulation::with_increments(2);
    let recording = quiet(simulation.record(&folder));
    let recorded = recording.run(&mut block(2.0)).expect("no misuse");
    let states = recorded.history.steps.iter();
    let states = 1 + states.filter(|step| step.attempt.to > 0.0).count();
    let failed = check_ended(&folder, "failed", states);
    assert!(
        failed["reason"]
            .as_str()
            .expect("a reason")
            .starts_with("not converged")
    );
    assert_eq!(failed["converged"], false);

    complete();
    let mut simulation = Simulation::with_increments(6);
    let recording = quiet(simulation.record(&folder)).message(|_| panic!("in a callback"));
    let panicked = catch_unwind(AssertUnwindSafe(|| drop(recording.run(&mut block(0.1)))));
    assert!(panicked.is_err());
    let failed = check_ended(&folder, "failed", 1);
    assert_eq!(failed["reason"], "panicked");

    complete();
    assert_eq!(files(&folder)["notes.txt"], b"mine");
}

#[test]
fn only_files_of_an_earlier_run_are_removed() {
    let folder = fresh("files_of_others");
    let mine = ["notes.txt", "run_0099.vtu", "other.svg", "run_0001.vtu.txt"];
    let write = |name: &str| std::fs::write(folder.join(name), "mine").expect("written");
    mine.iter().for_each(|name| write(name));
    let mut simulation = Simulation::with_increments(2);
    let mut recording = quiet(simulation.record(&folder));
    recording.plan.own_files = vec!["curves.txt".into()];
    recording.run(&mut block(0.1)).expect("a run");
    write("curves.txt");

    let mut simulation = Simulation::with_increments(1);
    let mut recording = quiet(simulation.record(&folder));
    (recording.plan.name, recording.plan.picture) = ("second".into(), String::new());
    recording.run(&mut block(0.1)).expect("a run");
    let found = files(&folder);
    let mut expected: Vec<&str> = mine.to_vec();
    expected.extend(["run.lock", "second.csv", "second.pvd", "second_0000.vtu"]);
    expected.extend(["second_0001.vtu", "second_iterations.csv", "summary.json"]);
    expected.extend(["second_pairs.csv", "second_supports.csv", "second_work.csv"]);
    expected.sort_unstable();
    assert_eq!(found.keys().collect::<Vec<_>>(), expected);
    assert!(mine.iter().all(|name| found[*name] == b"mine"));
}

#[test]
fn a_list_of_others_is_not_obeyed() {
    let folder = fresh("list_of_others");
    std::fs::write(folder.join("victim.txt"), "mine").expect("written");
    let list = folder.join("run.lock");
    std::fs::write(&list, "a lock of another program\nvictim.txt\n").expect("written");
    let before = files(&folder);
    let refused = run(&folder, 1).expect_err("not its list");
    assert_eq!(path_of(&refused), list);
    assert!(before == files(&folder));

    // names that lead out of the folder, and a line without an end
    std::fs::remove_file(&list).expect("removed");
    run(&folder, 1).expect("a run");
    let outside = folder.with_file_name("outside.txt");
    std::fs::write(&outside, "mine").expect("written");
    let mut text = std::fs::read_to_string(&list).expect("a list");
    text += &format!("../outside.txt\n{}\nvictim.txt", outside.display());
    std::fs::write(&list, text).expect("written");
    run(&folder, 1).expect("a run");
    assert!(outside.exists() && folder.join("victim.txt").exists());
}

#[test]
fn names_that_leave_the_folder_are_refused_before_anything_is_touched() {
    let folder = fresh("names");
    run(&folder, 2).expect("an earlier run");
    let before = files(&folder);
    let set = |change: &dyn Fn(&mut contact_fem::output::record::Plan<'_, 2>)| {
        let mut simulation = Simulation::with_increments(1);
        let mut recording = quiet(simulation.record(&folder));
        change(&mut recording.plan);
        let refused = recording.run(&mut block(0.1)).expect_err("refused");
        assert!(matches!(refused, Error::Write { .. }), "{refused}");
    };
    for name in ["", "..", "../evil", "/evil", "a\u{7}"] {
        set(&|plan| plan.name = name.into());
    }
    for name in [
        ".",
        "..",
        "../evil.svg",
        "/evil.svg",
        "a\n.svg",
        "summary.json",
        "run.lock",
    ] {
        set(&|plan| plan.picture = name.into());
        set(&|plan| plan.own_files = vec![name.into()]);
    }
    set(&|plan| plan.picture = "pressure.svg".into());
    set(&|plan| plan.force_picture = "pressure.svg".into());
    set(&|plan| plan.own_files = vec!["force.svg".into()]);
    set(&|plan| plan.own_files = vec!["meshes.svg".into()]);
    assert!(before == files(&folder));
}

/// Lets the file `name` be written to a device that is always full.
#[cfg(target_os = "linux")]
fn fill(folder: &Path, name: &str) {
    let beside = folder.join(format!("{name}.part"));
    std::os::unix::fs::symlink("/dev/full", beside).expect("a link");
}

#[test]
#[cfg(target_os = "linux")]
fn the_first_file_that_finds_the_disk_full_is_named() {
    let folder = fresh("full_series");
    fill(&folder, "run_0002.vtu");
    fill(&folder, "meshes.svg");
    let error = run(&folder, 4).expect_err("full");
    assert_eq!(path_of(&error), folder.join("run_0002.vtu"));
    let failed = check_ended(&folder, "failed", 2);
    let reason = failed["reason"].as_str().expect("a reason");
    assert!(
        reason.contains("run_0002.vtu") && reason.contains("No space"),
        "{reason}"
    );
    assert_eq!(failed["converged"], false);
}

#[test]
#[cfg(target_os = "linux")]
fn a_picture_that_fails_loses_no_data() {
    let folder = fresh("full_picture");
    fill(&folder, "meshes.svg");
    let error = run(&folder, 4).expect_err("full");
    assert_eq!(path_of(&error), folder.join("meshes.svg"));
    let failed = check_ended(&folder, "failed", 5);
    assert_eq!(failed["converged"], true);
    assert_eq!(failed["steps"], 4);
    let steps = &files(&folder)["run.csv"];
    assert_eq!(String::from_utf8_lossy(steps).lines().count(), 5);
}

#[test]
#[cfg(target_os = "linux")]
fn a_folder_that_takes_no_summary_gets_no_data() {
    let folder = fresh("full_summary");
    fill(&folder, "summary.json");
    let error = run(&folder, 4).expect_err("full");
    assert_eq!(path_of(&error), folder.join("summary.json"));
    // it is tried once more, after the link is gone
    assert_eq!(summary(&folder)["status"], "failed");
    let found = files(&folder);
    assert_eq!(
        found.keys().collect::<Vec<_>>(),
        ["run.lock", "summary.json"]
    );
}

/// What the other tests run in processes of their own.
#[test]
#[ignore = "a part of other tests"]
fn child() {
    let Ok(folder) = std::env::var(FOLDER) else {
        return;
    };
    let increments = std::env::var(INCREMENTS).expect("increments");
    let increments = increments.parse().expect("a number");
    if let Err(error) = run(Path::new(&folder), increments) {
        println!("{error}");
        std::process::exit(2);
    }
}

/// Starts [`child`], through a shell command that ends with it.
fn start(before: &str, folder: &Path, increments: usize) -> Child {
    let test = std::env::current_exe().expect("this program");
    let mut command = Command::new("sh");
    command.args(["-c", &format!("{before} exec \"$0\" \"$@\"")]);
    command.arg(test).args(["--ignored", "--exact", "child"]);
    command.env(FOLDER, folder);
    command.env(INCREMENTS, increments.to_string());
    command.stdout(Stdio::null()).stderr(Stdio::null());
    command.spawn().expect("a process")
}

/// Kills a process after a time, unless it has ended.
fn kill_after(mut child: Child, delay: Duration) -> ExitStatus {
    std::thread::sleep(delay);
    let _ = child.kill();
    child.wait().expect("a status")
}

/// Numbers between 0 and 1 that differ from run to run.
fn random() -> f64 {
    use std::hash::{BuildHasher, RandomState};
    RandomState::new().hash_one(0) as f64 / u64::MAX as f64
}

/// What is left after a kill is the earlier run's, untouched; or of the run that was killed, which is not complete.
#[test]
fn killed_at_any_moment() {
    let kills = std::env::var(KILLS).map_or(20, |count| count.parse().expect("a number"));
    let (folder, increments) = (fresh("killed"), 150);
    run(&folder, 20).expect("an earlier run");
    let clock = Instant::now();
    let status = start("", &folder, increments).wait().expect("a status");
    assert!(status.success());
    let whole_time = clock.elapsed().as_secs_f64();
    let mut seen: BTreeMap<String, usize> = BTreeMap::new();
    for _ in 0..kills {
        run(&folder, 20).expect("an earlier run");
        let before = files(&folder);
        let child = start("", &folder, increments);
        let process = child.id();
        let delay = Duration::from_secs_f64(1.1 * whole_time * random());
        let status = kill_after(child, delay);
        check_whole(&folder);
        let found = files(&folder);
        let told = found.contains_key("summary.json").then(|| summary(&folder));
        let kind = match &told {
            _ if found == before => "not begun",
            None => "no summary",
            Some(told) => {
                assert_eq!(told["process"], process, "{told}");
                let states = 1 + increments;
                match told["status"].as_str() {
                    Some("running") => {
                        assert!(!status.success() && ending(&found, ".vtu").len() <= states);
                        "running"
                    }
                    Some("complete") => {
                        assert_eq!(ending(&found, ".vtu").len(), states);
                        "complete"
                    }
                    other => panic!("{other:?}"),
                }
            }
        };
        *seen.entry(kind.into()).or_default() += 1;
    }
    println!("{kills} kills within {whole_time:.2} s: {seen:?}");
}

/// Disks of ten sizes that all are too small: tmpfs in a name space of its own, where the system permits that.
#[test]
#[cfg(target_os = "linux")]
fn full_disks() {
    let disk = fresh("disk");
    let mut told = Vec::new();
    for kilobytes in [8, 24, 32, 48, 64, 96, 160, 256, 512, 1024] {
        let mount = format!(
            "mount -t tmpfs -o size={kilobytes}k tmpfs \"$1\" && exec \"$0\" --ignored --exact on_a_full_disk --nocapture"
        );
        let output = Command::new("unshare")
            .args(["--map-root-user", "--mount", "sh", "-c", &mount])
            .arg(std::env::current_exe().expect("this program"))
            .arg(&disk)
            .env(FOLDER, &disk)
            .output();
        let Ok(output) = output else {
            println!("no disk can be mounted without `unshare`");
            return;
        };
        let text = String::from_utf8_lossy(&output.stdout);
        let Some((_, line)) = text.split_once("a full disk: ") else {
            let why = String::from_utf8_lossy(&output.stderr);
            assert!(
                !text.contains("running 1 test"),
                "{kilobytes}k: {text}{why}"
            );
            println!("no disk can be mounted: {why}");
            return;
        };
        assert!(output.status.success(), "{kilobytes}k: {text}");
        told.extend(
            line.lines()
                .next()
                .map(|line| format!("{kilobytes}k: {line}")),
        );
    }
    println!("{}", told.join("\n"));
    assert_eq!(told.len(), 10);
}

/// A run with states and one of long tables on a disk that is too small, after each a run that is small enough, and one
/// on a disk that another fills.
#[test]
#[ignore = "a part of other tests"]
fn on_a_full_disk() {
    let Ok(disk) = std::env::var(FOLDER) else {
        return;
    };
    let folder = Path::new(&disk).join("out");
    let mut endings = Vec::new();
    for (vtu_every, increments) in [(1, 150), (0, 400)] {
        let mut simulation = Simulation::with_increments(increments);
        let mut recording = quiet(simulation.record(&folder));
        recording.plan.vtu_every = vtu_every;
        let result = recording.run(&mut block(0.1));
        endings.push(check_disk(&folder, result.err()));
        let mut simulation = Simulation::with_increments(1);
        let mut recording = quiet(simulation.record(&folder));
        (recording.plan.vtu_every, recording.plan.picture) = (0, String::new());
        let result = recording.run(&mut block(0.1));
        assert_eq!(ending(&files(&folder), ".vtu"), [""; 0]);
        check_disk(&folder, result.err());
        std::fs::remove_dir_all(&folder).expect("removed");
    }
    endings.push(on_a_disk_that_fills(&folder));
    println!("a full disk: {}", endings.join(", "));
}

/// A run on a disk whose room another thread takes from its first step on, and whatever becomes free.
fn on_a_disk_that_fills(folder: &Path) -> String {
    let (begun, ended) = (AtomicBool::new(false), AtomicBool::new(false));
    let fill = || {
        let mut filler = std::fs::File::create(folder.with_file_name("filler")).expect("a file");
        while !ended.load(Ordering::Relaxed) {
            if begun.load(Ordering::Relaxed) {
                let _ = filler.write(&[0; 4096]);
            }
        }
    };
    let result = std::thread::scope(|scope| {
        scope.spawn(fill);
        let mut simulation = Simulation::with_increments(300);
        let recording = quiet(simulation.record(folder)).message(|_| {
            begun.store(true, Ordering::Relaxed);
            String::new()
        });
        let result = recording.run(&mut block(0.1));
        ended.store(true, Ordering::Relaxed);
        result
    });
    check_disk(folder, Some(result.expect_err("a full disk")))
}

/// Checks that a folder tells the error of its run, or that it is complete. Returns the file that is at fault.
fn check_disk(folder: &Path, error: Option<Error>) -> String {
    check_whole(folder);
    let found = files(folder);
    assert_eq!(ending(&found, ".part"), [""; 0]);
    let told = found.contains_key("summary.json").then(|| summary(folder));
    let Some(error) = error else {
        assert_eq!(told.expect("a summary")["status"], "complete");
        return "complete".into();
    };
    let named = path_of(&error).file_name().and_then(|name| name.to_str());
    let named = named.expect("a name");
    if let Some(told) = told {
        assert_eq!(told["status"], "failed");
        let reason = told["reason"].as_str().expect("a reason");
        assert!(
            reason.contains("No space left") && reason.contains(named),
            "{reason} for {error}"
        );
        return named.into();
    }
    // not even the beginning of the run could be told
    assert!(found.len() <= 1, "{:?}", found.keys());
    named.to_owned() + " at the start"
}

/// A limit on the size of files ends a run with an error, not with a signal.
#[test]
fn files_beyond_the_limit_of_the_system() {
    let folder = fresh("limit");
    let (blocks, increments) = (64, 400);
    let before = format!("ulimit -f {blocks};");
    let status = start(&before, &folder, increments)
        .wait()
        .expect("a status");
    assert_eq!(status.code(), Some(2), "{status:?}");
    check_whole(&folder);
    let found = files(&folder);
    assert_eq!(ending(&found, ".part"), [""; 0]);
    let told = summary(&folder);
    assert_eq!(told["status"], "failed");
    let reason = told["reason"].as_str().expect("a reason");
    assert!(
        reason.contains("run_iterations.csv") || reason.contains("run.csv"),
        "{reason}"
    );
    assert!(
        told["steps"].as_u64().is_some_and(|steps| steps > 10),
        "{told}"
    );
}
