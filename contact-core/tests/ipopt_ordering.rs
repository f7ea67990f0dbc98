//! The ordering that the driver chooses for MUMPS.
#![cfg(feature = "ipopt")]

use contact_core::{
    ipopt::{Options, Ordering, Solver, Start, Status},
    nlp::{Bounds, Nlp, Pattern, Structure},
};

/// ½ xᵀH x − Σ xᵢ, whose H has a band of −1 below a diagonal that outweighs it.
struct Banded {
    n: usize,
    band: usize,
}

impl Banded {
    fn pattern(&self) -> Pattern {
        let row = |i: usize| (i.saturating_sub(self.band)..=i).map(move |j| (i, j));
        (0..self.n).flat_map(row).collect()
    }

    fn diagonal(&self) -> f64 {
        2.0 * self.band as f64 + 1.0
    }

    /// The ordering that MUMPS used on it.
    fn ordering(&mut self, options: &Options) -> Ordering {
        let n = self.n;
        let structure = Structure::new(
            Bounds::free(n),
            Bounds::default(),
            Pattern::empty(),
            Some(self.pattern()),
        );
        let mut solver = Solver::new(structure.unwrap(), options).unwrap();
        let solution = solver.solve(self, &Start::at(&vec![0.0; n])).unwrap();
        assert_eq!(solution.status, Status::Solved);
        solution.statistics.mumps.expect("factorised").ordering
    }

    fn asked_for(&mut self, ordering: Ordering) -> Ordering {
        self.ordering(&Options::new().with("mumps_pivot_order", ordering.code()))
    }
}

impl Nlp for Banded {
    fn objective(&mut self, x: &[f64], _: bool) -> f64 {
        let mut gradient = vec![0.0; self.n];
        self.gradient(x, true, &mut gradient);
        let pairs = gradient.iter().zip(x);
        pairs.map(|(g, x)| 0.5 * (g - 1.0) * x).sum()
    }
    fn gradient(&mut self, x: &[f64], _: bool, gradient: &mut [f64]) {
        for i in 0..self.n {
            gradient[i] += self.diagonal() * x[i] - 1.0;
            for j in i.saturating_sub(self.band)..i {
                gradient[i] -= x[j];
                gradient[j] -= x[i];
            }
        }
    }
    fn hessian(&mut self, _: &[f64], _: bool, sigma: f64, _: &[f64], values: &mut [f64]) {
        for (value, (row, col)) in values.iter_mut().zip(self.pattern().iter()) {
            *value = sigma * if row == col { self.diagonal() } else { -1.0 };
        }
    }
}

/// Entries of the Hessian a variable: 2, as on a line; a little less than 15; and a little less than 17.
const SPARSE: usize = 1;
const LESS: usize = 14;
const DENSE: usize = 16;

#[test]
fn large_problems_are_ordered_by_their_density() {
    for band in [SPARSE, LESS] {
        let mut large = Banded { n: 10_001, band };
        assert_eq!(large.ordering(&Options::new()), Ordering::Amf);
    }
    let mut dense = Banded {
        n: 10_001,
        band: DENSE,
    };
    // Not every MUMPS was built with PORD.
    let pord = dense.asked_for(Ordering::Pord);
    assert_ne!(pord, Ordering::Amf);
    assert_eq!(dense.ordering(&Options::new()), pord);
    if pord != Ordering::Pord {
        println!("this MUMPS has {pord} in place of PORD");
    }
    assert_eq!(dense.asked_for(Ordering::Amd), Ordering::Amd, "as asked");
}

/// As meshes of linear tetrahedra are; quadratic ones are denser.
#[test]
fn larger_ones_of_medium_density_are_left_to_metis() {
    let mut larger = Banded {
        n: 20_001,
        band: DENSE,
    };
    let metis = larger.asked_for(Ordering::Metis);
    assert_eq!(larger.ordering(&Options::new()), metis);
    // Not every MUMPS was built with METIS.
    if metis != Ordering::Metis {
        println!("this MUMPS has {metis} in place of METIS");
    }
    let mut denser = Banded {
        n: 20_001,
        band: 2 * DENSE,
    };
    let pord = denser.asked_for(Ordering::Pord);
    assert_eq!(denser.ordering(&Options::new()), pord);
}

/// MUMPS takes minimum fill for both, where the driver would take PORD for the dense one.
#[test]
fn others_are_left_to_mumps() {
    for band in [SPARSE, DENSE] {
        let mut small = Banded { n: 10_000, band };
        let automatic = small.asked_for(Ordering::Automatic);
        assert_eq!(small.ordering(&Options::new()), automatic);
    }
}
