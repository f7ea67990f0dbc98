//! What Ipopt's derivative checker found, out of what it prints.

use crate::check::{Derivative, Finding};

/// What Ipopt's derivative checker found: see [`Options::derivative_test`](super::Options::derivative_test).
///
/// Ipopt compares with **one-sided** differences (relative step
/// [`derivative_test_perturbation`](super::Options::derivative_test_perturbation)), near the start: up to
/// [`point_perturbation_radius`](super::Options::point_perturbation_radius), 10 unless it is set, away from it but
/// within the bounds. Then it solves; `max_iter(0)` makes a check of the solve. The full Hessian is compared, so that
/// a wrong entry off the diagonal is found twice. [`check::nlp`](crate::check::nlp) does the same without Ipopt.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct DerivativeCheck {
    /// The derivatives that are wrong by more than [`derivative_test_tol`](super::Options::derivative_test_tol).
    pub findings: Vec<Finding>,
    /// How many Ipopt says there are; `None` if the check did not come to its end, because a function failed near
    /// the start.
    pub announced: Option<usize>,
    /// How many of them are missing from `findings`, because this version of Ipopt words them otherwise.
    pub unparsed: usize,
}

impl DerivativeCheck {
    /// Whether the check came to its end and found nothing.
    pub fn is_clean(&self) -> bool {
        self.announced == Some(0) && self.findings.is_empty() && self.unparsed == 0
    }
}

/// Reads what the checker prints.
#[derive(Debug, Default)]
pub(super) struct Reader {
    line: Vec<u8>,
    findings: Vec<Finding>,
    announced: Option<usize>,
    /// Lines that announce an error and are no known one.
    odd: usize,
    /// What the Hessian under test is multiplied by: σ or λᵢ, which is 1.5 in new versions and 1 in old ones.
    factor: Option<f64>,
}

impl Reader {
    pub(super) fn write(&mut self, text: &[u8]) {
        for piece in text.split_inclusive(|&byte| byte == b'\n') {
            self.line.extend_from_slice(piece);
            if piece.ends_with(b"\n") {
                let line = std::mem::take(&mut self.line);
                self.read(&String::from_utf8_lossy(&line));
            }
        }
    }

    /// Ipopt has asked for a Hessian with these factors.
    pub(super) fn hessian(&mut self, sigma: f64, lambda: &[f64]) {
        let mut factors = std::iter::once(&sigma).chain(lambda);
        self.factor = factors.find(|factor| **factor != 0.0).copied();
    }

    fn read(&mut self, line: &str) {
        if let Some(entry) = line.strip_prefix('*') {
            match finding(entry).map(|finding| self.unscaled(finding)) {
                Some(finding) => self.findings.push(finding),
                None => self.odd += 1,
            }
        } else if line.starts_with("No errors detected by derivative checker") {
            self.announced = Some(0);
        } else if let Some(count) = line.strip_prefix("Derivative checker detected ") {
            self.announced = count.split(' ').next().and_then(|n| n.parse().ok());
        }
    }

    fn unscaled(&self, mut finding: Finding) -> Finding {
        if let (
            Derivative::ObjectiveHessian { .. } | Derivative::ConstraintHessian { .. },
            Some(factor),
        ) = (finding.which, self.factor)
        {
            finding.given /= factor;
            finding.estimated /= factor;
        }
        finding
    }

    pub(super) fn finish(self) -> DerivativeCheck {
        let missing = self
            .announced
            .map_or(0, |n| n.saturating_sub(self.findings.len()));
        DerivativeCheck {
            unparsed: missing.max(self.odd),
            findings: self.findings,
            announced: self.announced,
        }
    }
}

/// ` jac_g [    0,    2] = -1.0e+00 v  ~  2.0e+00  [ 1.5e+00]`: given, whether in the pattern, estimated, error.
fn finding(entry: &str) -> Option<Finding> {
    let (name, values) = entry.split_once('=')?;
    let (given, values) = values.split_once('~')?;
    let (estimated, error) = values.split_once('[')?;
    let mut given = given.split_whitespace();
    let number = |text: &str| text.trim().parse().ok();
    let (value, in_pattern) = (number(given.next()?)?, given.next() == Some("v"));
    Some(Finding {
        which: derivative(name, in_pattern)?,
        given: value,
        estimated: number(estimated)?,
        relative_error: number(error.trim().strip_suffix(']')?)?,
    })
}

/// `    0-th constr_hess[    2,    3] `, counted from 0 because the indices of the problem are.
fn derivative(name: &str, in_pattern: bool) -> Option<Derivative> {
    let (kind, indices) = name.trim().strip_suffix(']')?.split_once('[')?;
    let index = |text: &str| text.trim().parse::<usize>().ok();
    let kind = kind.trim();
    if kind == "grad_f" {
        return Some(Derivative::Gradient(index(indices)?));
    }
    let (row, col) = indices.split_once(',')?;
    let (row, col) = (index(row)?, index(col)?);
    match kind {
        "jac_g" => Some(Derivative::Jacobian {
            row,
            col,
            in_pattern,
        }),
        "obj_hess" => Some(Derivative::ObjectiveHessian {
            row,
            col,
            in_pattern,
        }),
        _ => Some(Derivative::ConstraintHessian {
            constraint: index(kind.strip_suffix("-th constr_hess")?)?,
            row,
            col,
            in_pattern,
        }),
    }
}
