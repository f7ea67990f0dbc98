//! Ipopt without enough memory: the solve says so, is not repeated, and neither hangs nor ends the process.
#![cfg(all(feature = "ipopt", target_os = "linux"))]

use std::env;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use contact_core::ipopt::{Error, Options, Sequence, SequenceSettings, Status};
use contact_core::nlp::{Bounds, Multipliers, Nlp, Pattern, Structure};

const CHILD: &str = "CONTACT_CORE_MEMORY_CHILD";
/// Unknowns of a dense problem, whose factor has 72 MB; MUMPS asks for three times that.
const N: usize = 3000;

/// min ½ Σ (1 + i/n) x_i² − Σ x_i with a Hessian that is dense by its pattern.
struct Dense;

impl Nlp for Dense {
    fn objective(&mut self, x: &[f64], _: bool) -> f64 {
        let terms = x.iter().enumerate();
        terms.map(|(i, x)| 0.5 * weight(i) * x * x - x).sum()
    }

    fn gradient(&mut self, x: &[f64], _: bool, gradient: &mut [f64]) {
        let entries = gradient.iter_mut().zip(x).enumerate();
        entries.for_each(|(i, (g, x))| *g = weight(i) * x - 1.0);
    }

    fn constraints(&mut self, _: &[f64], _: bool, _: &mut [f64]) {}

    fn jacobian(&mut self, _: &[f64], _: bool, _: &mut [f64]) {}

    fn hessian(&mut self, _: &[f64], _: bool, factor: f64, _: &[f64], values: &mut [f64]) {
        let mut values = values.iter_mut();
        for i in 0..N {
            for j in 0..=i {
                if let Some(value) = values.next() {
                    *value = if i == j { factor * weight(i) } else { 0.0 };
                }
            }
        }
    }
}

fn weight(i: usize) -> f64 {
    1.0 + i as f64 / N as f64
}

#[test]
fn a_factor_that_does_not_fit_is_told_as_memory() {
    if env::var_os(CHILD).is_some() {
        return solve();
    }
    let free = said("unlimited");
    assert!(free.contains("told: Solved"), "{free}");
    let size = free.lines().find_map(|line| line.strip_prefix("VmSize:"));
    let size = size.and_then(|size| size.trim().trim_end_matches("kB").trim().parse().ok());
    let size: u64 = size.expect("Linux tells");
    // the workspace alone takes more than 200 MB; OpenBLAS needs 144 MB before there is any
    for (megabytes, expected) in [
        (60, ["told: InsufficientMemory", "told: Memory"]),
        (200, ["told: InsufficientMemory"; 2]),
        (3000, ["told: Solved"; 2]),
    ] {
        let text = said(&(size + 1024 * megabytes).to_string());
        let is_one = expected.iter().any(|expected| text.contains(expected));
        assert!(is_one, "{megabytes} MB: {text}");
    }
}

fn solve() {
    let pattern: Pattern = (0..N).flat_map(|i| (0..=i).map(move |j| (i, j))).collect();
    let structure = Structure::new(
        Bounds::free(N),
        Bounds::default(),
        Pattern::empty(),
        Some(pattern),
    );
    let structure = structure.expect("a structure");
    let settings = SequenceSettings {
        options: Options::new(),
        ..SequenceSettings::default()
    };
    let sequence = Sequence::new(structure, settings, &vec![0.0; N]);
    let mut sequence = sequence.expect("a sequence");
    let warm = Multipliers {
        lower: vec![0.0; N],
        upper: vec![0.0; N],
        constraints: Vec::new(),
    };
    sequence
        .restart(&vec![0.0; N], Some(warm))
        .expect("a start");
    let status = std::fs::read_to_string("/proc/self/status").expect("Linux");
    let size = status.lines().find(|line| line.starts_with("VmSize:"));
    println!("\n{}", size.expect("a size"));
    match sequence.solve(&mut Dense) {
        Ok(run) => {
            println!("told: {:?}", run.solution.status);
            assert_eq!(run.retried, None, "a cold start does not help");
            let is_known =
                [Status::Solved, Status::InsufficientMemory].contains(&run.solution.status);
            assert!(is_known);
        }
        Err(Error::Memory(why)) => println!("told: Memory: {why}"),
        Err(other) => panic!("{other}"),
    }
}

/// What the test says in a process of its own within so many kilobytes.
fn said(kilobytes: &str) -> String {
    let mut child = Command::new("sh")
        .args(["-c", "ulimit -v $0 && exec \"$@\"", kilobytes])
        .arg(env::current_exe().expect("a test program"))
        .args(["a_factor_that", "--nocapture", "--test-threads=1"])
        .env(CHILD, "1")
        .env("OPENBLAS_NUM_THREADS", "1")
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .expect("a shell");
    let end = Instant::now() + Duration::from_secs(120);
    while child.try_wait().expect("a child").is_none() {
        if Instant::now() > end {
            child.kill().expect("a child");
            return "it hangs".into();
        }
        std::thread::sleep(Duration::from_millis(10));
    }
    let output = child.wait_with_output().expect("a child");
    String::from_utf8_lossy(&[output.stdout, output.stderr].concat()).into_owned()
}
