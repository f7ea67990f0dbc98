//! The free and the prescribed dofs of a body.

/// A displacement component: free, or eliminated because it is prescribed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Dof {
    /// Index among the free unknowns.
    Free(usize),
    /// Index among the prescribed ones. Free ones may add to it, see [`DofMap::ties`].
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

/// A dof that free ones add to: u = ū + Σ c u_i, with the prescribed ū. Nodes that slide along a plane have one.
#[derive(Clone, Debug, PartialEq)]
pub struct DependentDof {
    /// The dof.
    pub dof: usize,
    /// Index of ū among the prescribed unknowns.
    pub prescribed: usize,
    /// Free unknowns with their coefficients c (no unit).
    pub free: Vec<(usize, f64)>,
}

/// Free and prescribed dofs, interleaved per node: dof = D · node + component.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct DofMap {
    dofs: Vec<Dof>,
    free: usize,
    prescribed: usize,
    /// In ascending order of dofs.
    ties: Vec<DependentDof>,
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

    /// Lets free dofs, with coefficients, add to a prescribed one. Ties come in ascending order of their dofs.
    pub(crate) fn tie(&mut self, dof: usize, others: impl Iterator<Item = (usize, f64)>) {
        let Dof::Prescribed(prescribed) = self.dofs[dof] else {
            return;
        };
        let free = others.filter_map(|(other, c)| match self.dofs[other] {
            Dof::Free(i) => Some((i, c)),
            Dof::Prescribed(_) => None,
        });
        let free = free.collect();
        self.ties.push(DependentDof {
            dof,
            prescribed,
            free,
        });
    }

    /// The dofs that free ones add to, in ascending order; most bodies have none.
    pub fn ties(&self) -> &[DependentDof] {
        &self.ties
    }

    /// The free unknowns that a dof varies with, and its slope by each.
    pub(crate) fn slopes(&self, dof: usize) -> impl Iterator<Item = (usize, f64)> {
        let (own, tied) = match self.dofs[dof] {
            Dof::Free(i) => (Some((i, 1.0)), None),
            Dof::Prescribed(_) => (None, self.tie_of(dof)),
        };
        own.into_iter()
            .chain(tied.into_iter().flat_map(|tie| tie.free.iter().copied()))
    }

    fn tie_of(&self, dof: usize) -> Option<&DependentDof> {
        let place = self.ties.binary_search_by_key(&dof, |tie| tie.dof);
        place.ok().map(|place| &self.ties[place])
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
        let own = self.dofs[dof].of(free, prescribed);
        match self.ties.is_empty() {
            true => own,
            false => {
                let added = self.tie_of(dof).map(|tie| tie.added(free));
                own + added.unwrap_or(0.0)
            }
        }
    }

    /// The values of all dofs.
    pub fn expand(&self, free: &[f64], prescribed: &[f64]) -> Vec<f64> {
        let value = |dof: &Dof| dof.of(free, prescribed);
        let mut all: Vec<f64> = self.dofs.iter().map(value).collect();
        for tie in &self.ties {
            all[tie.dof] += tie.added(free);
        }
        all
    }

    /// The forces on all dofs from those conjugate to the free and to the prescribed unknowns: of a free dof without what ties add
    /// to it.
    pub(crate) fn forces(&self, free: &[f64], prescribed: &[f64]) -> Vec<f64> {
        match self.ties.is_empty() {
            true => self.expand(free, prescribed),
            false => {
                let mut own = free.to_vec();
                for tie in &self.ties {
                    for (i, c) in &tie.free {
                        own[*i] -= c * prescribed[tie.prescribed];
                    }
                }
                let value = |dof: &Dof| dof.of(&own, prescribed);
                self.dofs.iter().map(value).collect()
            }
        }
    }
}

impl DependentDof {
    fn added(&self, free: &[f64]) -> f64 {
        self.free.iter().map(|(i, c)| c * free[*i]).sum()
    }
}
