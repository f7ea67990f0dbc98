//! The free and the prescribed dofs of a body.

/// A displacement component: free, or eliminated because it is prescribed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Dof {
    /// Index among the free unknowns.
    Free(usize),
    /// Index among the prescribed ones.
    Prescribed(usize),
}

impl Dof {
    /// Its value among the free and the prescribed ones.
    fn of(self, free: &[f64], prescribed: &[f64]) -> f64 {
        match self {
            Dof::Free(i) => free[i],
            Dof::Prescribed(i) => prescribed[i],
        }
    }
}

/// Free and prescribed dofs, interleaved per node: dof = D · node + component.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct DofMap {
    dofs: Vec<Dof>,
    free: usize,
    prescribed: usize,
}

impl DofMap {
    /// From a flag for each dof that tells whether it is prescribed.
    pub fn new(is_prescribed: &[bool]) -> Self {
        let mut map = DofMap::default();
        map.extend(is_prescribed);
        map
    }

    /// Appends the dofs of one more body.
    pub fn extend(&mut self, is_prescribed: &[bool]) {
        for &prescribed in is_prescribed {
            self.dofs.push(if prescribed {
                self.prescribed += 1;
                Dof::Prescribed(self.prescribed - 1)
            } else {
                self.free += 1;
                Dof::Free(self.free - 1)
            });
        }
    }

    /// The dof with the given number.
    pub fn get(&self, dof: usize) -> Dof {
        self.dofs[dof]
    }

    /// All dofs.
    pub fn len(&self) -> usize {
        self.dofs.len()
    }

    /// Whether there are no dofs.
    pub fn is_empty(&self) -> bool {
        self.dofs.is_empty()
    }

    /// The number of free dofs.
    pub fn free(&self) -> usize {
        self.free
    }

    /// The number of prescribed dofs.
    pub fn prescribed(&self) -> usize {
        self.prescribed
    }

    /// The value of one dof, given the free and the prescribed values.
    pub fn value(&self, dof: usize, free: &[f64], prescribed: &[f64]) -> f64 {
        self.dofs[dof].of(free, prescribed)
    }

    /// The values of all dofs.
    pub fn expand(&self, free: &[f64], prescribed: &[f64]) -> Vec<f64> {
        let value = |dof: &Dof| dof.of(free, prescribed);
        self.dofs.iter().map(value).collect()
    }
}
