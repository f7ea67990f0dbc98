//! The potential energy E(u) and the direct sum over bodies.

use std::ops::Range;

use crate::linear::SymmetricPattern;

/// E : ℝⁿ → ℝ ∪ {+∞} over the FREE unknowns (equation (2) of the paper).
///
/// `gradient` is ∇E (n, UF) and `hessian` fills the lower triangle of ∇²E (UF/UL) at the positions
/// (slots) of `hessian_pattern`, which stays the same for the life of the energy.
/// [`check::energy`](crate::check::energy) compares all three with central differences.
pub trait Energy {
    /// n, the number of free unknowns.
    fn dofs(&self) -> usize;
    /// E(u), `+∞` where u is inadmissible.
    fn value(&self, u: &[f64]) -> f64;
    /// ∇E(u) into `g` (n); overwritten.
    fn gradient(&self, u: &[f64], g: &mut [f64]);
    /// The pattern of the Hessian.
    fn hessian_pattern(&self) -> &SymmetricPattern;
    /// ∇²E(u) into `values` (one per slot); overwritten.
    fn hessian(&self, u: &[f64], values: &mut [f64]);
    /// Ranges of unknowns, ascending, that the Hessian does not couple with each other: one for each body.
    fn blocks(&self) -> Vec<Range<usize>> {
        std::iter::once(0..self.dofs()).collect()
    }
    /// Whether E is quadratic; its Hessian is then evaluated only once.
    fn is_quadratic(&self) -> bool {
        false
    }
    /// The number of functions d_k that describe the domain { u : d_k(u) > 0 } on which E is finite.
    fn domain_len(&self) -> usize {
        0
    }
    /// The domain functions at u into `d`: in elasticity the volume ratios J.
    ///
    /// The interior point method refuses a step that takes some d_k below a tenth of its last
    /// accepted value: elements that collapse within one line search never recover.
    fn domain(&self, _u: &[f64], _d: &mut [f64]) {}
}

/// E(u) = Σ_b E_b(u_b): independent bodies, each with its own contiguous range of unknowns.
pub struct DirectSum<E> {
    parts: Vec<E>,
    /// The first unknown, Hessian entry and domain function of each part, followed by their total number.
    dofs: Vec<usize>,
    entries: Vec<usize>,
    domains: Vec<usize>,
    pattern: SymmetricPattern,
}

impl<E: Energy> DirectSum<E> {
    /// Stacks the parts in the order given.
    pub fn new(parts: Vec<E>) -> Self {
        let totals = |len: &dyn Fn(&E) -> usize| {
            let mut totals = vec![0];
            for part in &parts {
                totals.push(totals[totals.len() - 1] + len(part));
            }
            totals
        };
        DirectSum {
            dofs: totals(&|part| part.dofs()),
            entries: totals(&|part| part.hessian_pattern().len()),
            domains: totals(&|part| part.domain_len()),
            pattern: SymmetricPattern::direct_sum(parts.iter().map(Energy::hessian_pattern)),
            parts,
        }
    }

    /// The parts.
    pub fn parts(&self) -> &[E] {
        &self.parts
    }

    /// The parts themselves.
    pub fn into_parts(self) -> Vec<E> {
        self.parts
    }

    /// The parts, to change their loads. Their numbers of unknowns and their patterns must not change.
    pub fn parts_mut(&mut self) -> &mut [E] {
        &mut self.parts
    }

    /// The range of unknowns of part `b`.
    pub fn range(&self, b: usize) -> Range<usize> {
        self.dofs[b]..self.dofs[b + 1]
    }
}

impl<E: Energy> Energy for DirectSum<E> {
    fn dofs(&self) -> usize {
        self.dofs[self.parts.len()]
    }

    fn value(&self, u: &[f64]) -> f64 {
        let values = self.parts.iter().enumerate();
        values.map(|(b, part)| part.value(&u[self.range(b)])).sum()
    }

    fn gradient(&self, u: &[f64], g: &mut [f64]) {
        for (b, part) in self.parts.iter().enumerate() {
            part.gradient(&u[self.range(b)], &mut g[self.range(b)]);
        }
    }

    fn hessian_pattern(&self) -> &SymmetricPattern {
        &self.pattern
    }

    fn hessian(&self, u: &[f64], values: &mut [f64]) {
        for (b, part) in self.parts.iter().enumerate() {
            let entries = self.entries[b]..self.entries[b + 1];
            part.hessian(&u[self.range(b)], &mut values[entries]);
        }
    }

    fn blocks(&self) -> Vec<Range<usize>> {
        let of_part = |(part, first): (&E, &usize)| {
            let blocks = part.blocks().into_iter();
            let first = *first;
            blocks.map(move |b| first + b.start..first + b.end)
        };
        self.parts
            .iter()
            .zip(&self.dofs)
            .flat_map(of_part)
            .collect()
    }

    fn is_quadratic(&self) -> bool {
        self.parts.iter().all(Energy::is_quadratic)
    }

    fn domain_len(&self) -> usize {
        self.domains[self.parts.len()]
    }

    fn domain(&self, u: &[f64], d: &mut [f64]) {
        for (b, part) in self.parts.iter().enumerate() {
            let domain = self.domains[b]..self.domains[b + 1];
            part.domain(&u[self.range(b)], &mut d[domain]);
        }
    }
}

impl<E: Energy + ?Sized> Energy for &E {
    fn dofs(&self) -> usize {
        (**self).dofs()
    }
    fn value(&self, u: &[f64]) -> f64 {
        (**self).value(u)
    }
    fn gradient(&self, u: &[f64], g: &mut [f64]) {
        (**self).gradient(u, g)
    }
    fn hessian_pattern(&self) -> &SymmetricPattern {
        (**self).hessian_pattern()
    }
    fn hessian(&self, u: &[f64], values: &mut [f64]) {
        (**self).hessian(u, values)
    }
    fn blocks(&self) -> Vec<Range<usize>> {
        (**self).blocks()
    }
    fn is_quadratic(&self) -> bool {
        (**self).is_quadratic()
    }
    fn domain_len(&self) -> usize {
        (**self).domain_len()
    }
    fn domain(&self, u: &[f64], d: &mut [f64]) {
        (**self).domain(u, d)
    }
}

impl<E: Energy + ?Sized> Energy for Box<E> {
    fn dofs(&self) -> usize {
        (**self).dofs()
    }
    fn value(&self, u: &[f64]) -> f64 {
        (**self).value(u)
    }
    fn gradient(&self, u: &[f64], g: &mut [f64]) {
        (**self).gradient(u, g)
    }
    fn hessian_pattern(&self) -> &SymmetricPattern {
        (**self).hessian_pattern()
    }
    fn hessian(&self, u: &[f64], values: &mut [f64]) {
        (**self).hessian(u, values)
    }
    fn blocks(&self) -> Vec<Range<usize>> {
        (**self).blocks()
    }
    fn is_quadratic(&self) -> bool {
        (**self).is_quadratic()
    }
    fn domain_len(&self) -> usize {
        (**self).domain_len()
    }
    fn domain(&self, u: &[f64], d: &mut [f64]) {
        (**self).domain(u, d)
    }
}
