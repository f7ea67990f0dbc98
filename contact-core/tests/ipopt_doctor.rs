//! What the driver says of the Ipopt it runs on.
#![cfg(feature = "ipopt")]

use std::sync::{Mutex, MutexGuard, PoisonError};

use contact_core::{
    ipopt::{Error, Options, Ordering, Solver, Start, Status, diagnose, doctor},
    nlp::{Bounds, Nlp, Pattern, Structure},
};

/// ½ Σᵢⱼ xᵢ xⱼ + ½ |x|² − Σ xᵢ, whose Hessian has no zeros; called back with each objective.
struct Dense<F>(F);

impl<F: FnMut()> Nlp for Dense<F> {
    fn objective(&mut self, x: &[f64], _: bool) -> f64 {
        (self.0)();
        let sum: f64 = x.iter().sum();
        0.5 * sum * sum + 0.5 * x.iter().map(|x| x * x).sum::<f64>() - sum
    }
    fn gradient(&mut self, x: &[f64], _: bool, gradient: &mut [f64]) {
        let sum: f64 = x.iter().sum();
        gradient
            .iter_mut()
            .zip(x)
            .for_each(|(g, x)| *g = sum + x - 1.0);
    }
    fn constraints(&mut self, _: &[f64], _: bool, _: &mut [f64]) {}
    fn jacobian(&mut self, _: &[f64], _: bool, _: &mut [f64]) {}
    fn hessian(&mut self, x: &[f64], _: bool, sigma: f64, _: &[f64], values: &mut [f64]) {
        values.fill(sigma);
        for i in 0..x.len() {
            values[i * (i + 3) / 2] += sigma; // row i starts at i (i + 1) / 2
        }
    }
}

fn dense_solver(n: usize, options: &Options) -> Solver {
    let pattern = Pattern::dense_lower(n);
    let bounds = Bounds::free(n);
    let structure = Structure::new(bounds, Bounds::default(), Pattern::empty(), Some(pattern));
    Solver::new(structure.expect("well formed"), options).expect("valid")
}

/// What is allocated is measured in the whole process, and solvers of other threads are made and dropped meanwhile.
/// Threads that end give back some kilobytes all the same, so that only much is measured.
fn alone() -> MutexGuard<'static, ()> {
    static ALONE: Mutex<()> = Mutex::new(());
    ALONE.lock().unwrap_or_else(PoisonError::into_inner)
}

#[test]
fn a_dense_factor_has_the_size_it_must_have() {
    let _alone = alone();
    let n = 60;
    for ordering in [Ordering::Amd, Ordering::Amf, Ordering::Qamd] {
        let options = Options::new().with("mumps_pivot_order", ordering.code());
        let mut solver = dense_solver(n, &options);
        let solution = solver
            .solve(&mut Dense(|| ()), &Start::at(&vec![0.0; n]))
            .unwrap();
        assert_eq!(solution.status, Status::Solved);
        // (1 1ᵀ + I) x = 1 has x = 1/(n + 1)
        assert!(
            solution
                .x
                .iter()
                .all(|x| (x - 1.0 / (n + 1) as f64).abs() < 1e-12)
        );
        let mumps = solution.statistics.mumps.expect("factorised");
        assert_eq!(mumps.ordering, ordering, "MUMPS has these always");
        assert_eq!(mumps.reallocations, 0);
        // at least the lower triangle, at most the square, and a few indices
        let bytes = mumps.factor_bytes as usize;
        assert!(
            (8 * n * (n + 1) / 2..8 * n * n + 4 * 20 * n).contains(&bytes),
            "{bytes}"
        );
    }
}

/// The share that `mumps_mem_percent` adds is really allocated.
#[test]
fn more_workspace_is_more_workspace() {
    let _alone = alone();
    let n = 600;
    let workspace = |percent: i32| {
        let options = Options::new().with("mumps_mem_percent", percent);
        let start = vec![0.0; n];
        let solution = dense_solver(n, &options).solve(&mut Dense(|| ()), &Start::at(&start));
        solution
            .unwrap()
            .statistics
            .mumps
            .expect("factorised")
            .workspace_bytes
    };
    let (Some(little), Some(much)) = (workspace(50), workspace(1000)) else {
        println!("this system does not tell what is allocated: nothing tested");
        return;
    };
    assert!(little as usize >= 8 * n * (n + 1) / 2, "{little}");
    // 1.5 and 11 times the estimate
    let ratio = much as f64 / little as f64;
    assert!((4.0..12.0).contains(&ratio), "{little} and {much} bytes");
}

#[test]
fn a_diagnosis_names_what_works() {
    let _alone = alone();
    let diagnosis = diagnose().unwrap();
    assert!(
        diagnosis.works("mumps") && !diagnosis.works("wsmp"),
        "{diagnosis}"
    );
    assert!(!diagnosis.works("a solver that nobody wrote"));
    assert_eq!(diagnosis.headers.0, 3);
    // solves have been made, so the library has told by now
    assert_eq!(diagnosis.library, Some(diagnosis.headers));
    assert_eq!(diagnosis.trials.len(), 5);
    let amf = diagnosis.trials.last().expect("five");
    assert_eq!((amf.asked, amf.used), (Ordering::Amf, Ordering::Amf));
    for trial in &diagnosis.trials {
        // H has 27 · 9 entries a point of the interior, half of them stored; the factor has more
        assert!(
            trial.factor_bytes as usize > 8 * 100 * trial.unknowns / 3,
            "{trial:?}"
        );
        assert!(
            trial
                .workspace_bytes
                .is_none_or(|bytes| bytes >= trial.factor_bytes)
        );
        assert!(trial.seconds > 0.0);
    }
    let text = diagnosis.to_string();
    for solver in &diagnosis.linear_solvers {
        assert!(text.contains(solver.name), "{} in\n{text}", solver.name);
    }
    for word in [
        "Ipopt 3.",
        "linear solvers: mumps",
        "BLAS",
        "12288 unknowns",
        "AMF",
    ] {
        assert!(text.contains(word), "`{word}` in\n{text}");
    }
}

#[test]
fn no_diagnosis_inside_a_callback() {
    let _alone = alone();
    let mut found = None;
    let mut dense = Dense(|| found = Some(doctor::inspect().map(|_| ())));
    dense_solver(2, &Options::new())
        .solve(&mut dense, &Start::at(&[0.0; 2]))
        .unwrap();
    assert_eq!(found, Some(Err(Error::Reentrant)));
}
