//! Damages the mesh files of the tests at random for a while and reads them: nothing may panic, hang, or take much more
//! memory than the file has bytes. What does is kept under `tests/meshes/found`, where the tests find it.
//!
//! `make fuzz-readers SECONDS=60 SEED=1`, or with arguments: seconds, seed.

mod support;

use std::collections::{BTreeMap, HashSet};
use std::error::Error;
use std::hash::{DefaultHasher, Hash, Hasher};
use std::panic::catch_unwind;
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

use support::mutation::{Random, damaged};

/// No file may take longer than this.
const PATIENCE: Duration = Duration::from_secs(2);
/// Longer files are not tried.
const LONGEST: usize = 64 << 10;
/// Damaged files worth damaging further.
const KEPT: usize = 4000;

/// The file that is being read, and since when.
type Current = Arc<Mutex<(Instant, Vec<u8>)>>;

fn keep(kind: &str, file: &[u8]) -> std::io::Result<()> {
    let mut hasher = DefaultHasher::new();
    file.hash(&mut hasher);
    let folder = support::folder().join("found");
    std::fs::create_dir_all(&folder)?;
    let path = folder.join(format!("{kind}_{:016x}.msh", hasher.finish()));
    println!("{kind}: {}", path.display());
    std::fs::write(&path, file)
}

/// Ends the program, the file kept, if reading one never ends.
fn watch(current: Current) {
    loop {
        std::thread::sleep(PATIENCE);
        let current = current.lock().expect("nothing panics while it is held");
        if current.0.elapsed() > 10 * PATIENCE {
            keep("hang", &current.1).expect("a folder to write to");
            std::process::exit(1);
        }
    }
}

/// What is wrong, without numbers and what stands in quotes, for files that differ here are worth keeping.
fn outline(error: &contact_fem::Error) -> String {
    let text = error.to_string();
    let mut text: String = text.split(['`', '"']).step_by(2).collect();
    text.retain(|c| c.is_ascii_alphabetic() || c == ' ');
    text.truncate(200);
    text
}

fn main() -> Result<(), Box<dyn Error>> {
    let mut arguments = std::env::args().skip(1);
    let seconds = arguments.next().map_or(Ok(60), |s| s.parse())?;
    let seed = arguments.next().map_or(Ok(1), |s| s.parse())?;
    let end = Instant::now() + Duration::from_secs(seconds);
    let mut corpus: Vec<Vec<u8>> = support::mesh_files().into_iter().map(|f| f.1).collect();
    let originals = corpus.len();
    println!("{originals} files, {seconds} s, seed {seed}");
    std::panic::set_hook(Box::new(|_| {}));
    let current: Current = Arc::new(Mutex::new((Instant::now(), Vec::new())));
    let watched = Arc::clone(&current);
    std::thread::spawn(|| watch(watched));

    let mut random = Random(seed);
    let mut seen = HashSet::new();
    let mut outcomes: BTreeMap<String, u64> = BTreeMap::new();
    let (mut runs, mut read, mut failures, mut most) = (0_u64, 0_u64, 0, 0);
    while Instant::now() < end && failures < 100 {
        let among = [originals, corpus.len()][random.below(2)];
        let mut file = corpus[random.below(among)].clone();
        for _ in 0..1 + random.below(4) {
            let other = &corpus[random.below(corpus.len())];
            file = damaged(&file, other, &mut random);
        }
        file.truncate(LONGEST);
        *current.lock().expect("the watch does not panic") = (Instant::now(), file.clone());
        let start = Instant::now();
        let work = || support::read_fully(&file);
        let (peak, result) = support::memory::peak_of(|| catch_unwind(work));
        let failed = match &result {
            Err(_) => Some("panic"),
            Ok(_) if start.elapsed() > PATIENCE => Some("slow"),
            Ok(_) if peak > support::allowance(&file) => Some("memory"),
            Ok(_) => None,
        };
        if let Some(kind) = failed {
            keep(kind, &file)?;
            failures += 1;
        }
        runs += 1;
        most = most.max(peak / file.len().max(1024));
        if let Ok((readable, errors)) = result {
            read += u64::from(readable);
            for error in &errors {
                *outcomes.entry(outline(error)).or_default() += 1;
            }
            let outcome: Vec<String> = errors.iter().take(2).map(outline).collect();
            if corpus.len() < KEPT && seen.insert(outcome) {
                corpus.push(file);
            }
        }
    }
    for (outcome, times) in &outcomes {
        println!("{times:>9}  {outcome}");
    }
    println!("{runs} files, {read} of them readable, {failures} failures");
    println!("at most {most} bytes of memory for a byte of a file of 1 kB or more");
    match failures {
        0 => Ok(()),
        _ => Err("reading failed: see the files kept".into()),
    }
}
