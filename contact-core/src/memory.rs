//! Memory: what a run will need, by an estimate, and what the system has left for it.
//!
//! Most of what a solve takes is the factor of its linear systems, whose size follows from their pattern. A run compares
//! its [`MemoryNeed`] with what is [`left`] before it begins, since afterwards there is no good end: BLAS libraries wait for
//! ever, the system ends the process, or a linear solver fails as if the problem were at fault.

use std::fmt;
use std::fs::read_to_string;
use std::path::Path;

#[cfg(feature = "linear")]
use crate::linear::{Analysis, FactorError, Ordering, SymmetricPattern};
#[cfg(feature = "linear")]
use crate::{ContactProblem, Energy, Equilibrium, Error};

/// What a run will take beyond what the process has already (bytes), by an estimate.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct MemoryNeed {
    /// All of it.
    pub bytes: u64,
    /// The factor and the workspace of its computation.
    pub factor: u64,
}

/// What limits the memory of a process.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum MemoryLimit {
    /// The limit of its address space (`ulimit -v`).
    AddressSpace,
    /// The limit of its data (`ulimit -d`).
    Data,
    /// The limit of its control group, as of a container or a job.
    ControlGroup,
    /// The memory that the machine has free.
    System,
    /// [`Budget::memory`](crate::Budget::memory).
    Budget,
}

impl fmt::Display for MemoryLimit {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            MemoryLimit::AddressSpace => "the limit of address space (`ulimit -v`)",
            MemoryLimit::Data => "the limit of data (`ulimit -d`)",
            MemoryLimit::ControlGroup => "the limit of the control group",
            MemoryLimit::System => "the machine's free memory",
            MemoryLimit::Budget => "the run's budget",
        })
    }
}

/// The memory that one limit leaves.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct MemoryLeft {
    /// How much (bytes).
    pub bytes: u64,
    /// What limits it.
    pub limit: MemoryLimit,
}

/// Too little memory.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum MemoryError {
    /// Before a run or a solve, by an estimate.
    #[error(
        "{what} needs about {} of memory, and {} are left by {limit}: raise the limit, coarsen the mesh, or take a solver that needs less",
        megabytes(*needed), megabytes(*left)
    )]
    TooLittle {
        /// What needs it.
        what: &'static str,
        /// How much (bytes).
        needed: u64,
        /// How much there is (bytes).
        left: u64,
        /// What limits it.
        limit: MemoryLimit,
    },
    /// During a solve.
    #[error(
        "{what} has run out of memory at {unknowns} unknowns: raise the limit of memory, coarsen the mesh, or take a solver that needs less"
    )]
    Exhausted {
        /// What has.
        what: &'static str,
        /// The unknowns of the problem.
        unknowns: usize,
    },
}

/// In MB of a million bytes.
fn megabytes(bytes: u64) -> String {
    let number = bytes as f64 / 1e6;
    match number < 10.0 {
        true => format!("{number:.1} MB"),
        false => format!("{number:.0} MB"),
    }
}

impl fmt::Display for MemoryNeed {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (all, factor) = (megabytes(self.bytes), megabytes(self.factor));
        write!(f, "{all}, of which the factor takes {factor}")
    }
}

impl fmt::Display for MemoryLeft {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} by {}", megabytes(self.bytes), self.limit)
    }
}

/// What the limit that is nearest leaves; `None` where the system does not tell (Linux does).
pub fn left() -> Option<MemoryLeft> {
    limits().into_iter().min_by_key(|left| left.bytes)
}

/// The limit of address space or data that is nearest, where there is one. Unlike the others, it makes allocations fail.
pub fn hard_limit() -> Option<MemoryLeft> {
    let is_hard =
        |left: &MemoryLeft| matches!(left.limit, MemoryLimit::AddressSpace | MemoryLimit::Data);
    let hard = limits().into_iter().filter(is_hard);
    hard.min_by_key(|left| left.bytes)
}

/// [`MemoryError::TooLittle`] if there is less than that left.
///
/// # Errors
/// That one.
pub fn check(what: &'static str, needed: u64) -> Result<(), MemoryError> {
    match left() {
        Some(MemoryLeft { bytes, limit }) if bytes < needed => Err(MemoryError::TooLittle {
            what,
            needed,
            left: bytes,
            limit,
        }),
        _ => Ok(()),
    }
}

/// Whether `solver` has enough memory for a run on `problem`, and what the user allows.
#[cfg(feature = "linear")]
pub(crate) fn check_run(
    solver: &dyn Equilibrium,
    problem: &dyn ContactProblem,
    budget: Option<u64>,
) -> Result<(), Error> {
    let allowed = budget.map(|bytes| MemoryLeft {
        bytes,
        limit: MemoryLimit::Budget,
    });
    let all = left().into_iter().chain(allowed);
    let Some(nearest) = all.min_by_key(|left| left.bytes) else {
        return Ok(());
    };
    // an analysis takes its time
    if MemoryNeed::at_most(problem.energy().hessian_pattern()) <= nearest.bytes {
        return Ok(());
    }
    let compare = |needed: u64| match needed > nearest.bytes {
        true => Err(Error::Memory(MemoryError::TooLittle {
            what: solver.choice(problem).solver,
            needed,
            left: nearest.bytes,
            limit: nearest.limit,
        })),
        false => Ok(()),
    };
    // the analysis has to have room, too
    compare(beside(problem.energy().hessian_pattern()))?;
    match solver.memory(problem) {
        Some(need) => compare(need.bytes),
        None => Ok(()),
    }
}

fn limits() -> Vec<MemoryLeft> {
    let read = |path: &str| read_to_string(path).unwrap_or_default();
    let (limits, status) = (read("/proc/self/limits"), read("/proc/self/status"));
    let within = |limit, name, used| {
        let all = soft_limit_of(&limits, name)?;
        let bytes = all.saturating_sub(kilobytes(&status, used)?);
        Some(MemoryLeft { bytes, limit })
    };
    let group = group_left(
        &read("/proc/self/cgroup"),
        Path::new("/sys/fs/cgroup"),
        &|path| read_to_string(path).ok(),
    );
    let machine = read("/proc/meminfo");
    let free = kilobytes(&machine, "MemAvailable:");
    let free = free.map(|free| free + kilobytes(&machine, "SwapFree:").unwrap_or(0));
    let of = |bytes: Option<u64>, limit| bytes.map(|bytes| MemoryLeft { bytes, limit });
    let all = [
        within(MemoryLimit::AddressSpace, "Max address space", "VmSize:"),
        within(MemoryLimit::Data, "Max data size", "VmData:"),
        of(group, MemoryLimit::ControlGroup),
        of(free, MemoryLimit::System),
    ];
    all.into_iter().flatten().collect()
}

/// The soft limit (bytes) of this name in the text of `/proc/self/limits`; `None` where it is unlimited.
fn soft_limit_of(limits: &str, name: &str) -> Option<u64> {
    let line = limits.lines().find_map(|line| line.strip_prefix(name))?;
    line.split_whitespace().next()?.parse().ok()
}

/// The bytes of a line in kilobytes.
fn kilobytes(text: &str, name: &str) -> Option<u64> {
    let line = text.lines().find_map(|line| line.strip_prefix(name))?;
    let number: u64 = line.trim().strip_suffix("kB")?.trim().parse().ok()?;
    number.checked_mul(1024)
}

/// What the control group of the process and those above leave (bytes), from the text of `/proc/self/cgroup` and the
/// files below `root`. Pages of files that the system can drop do not count as used.
fn group_left(groups: &str, root: &Path, read: &dyn Fn(&Path) -> Option<String>) -> Option<u64> {
    let mut least: Option<u64> = None;
    for line in groups.lines() {
        let mut parts = line.splitn(3, ':').skip(1);
        let (Some(names), Some(path)) = (parts.next(), parts.next()) else {
            continue;
        };
        let (top, files) = match names {
            "" => (
                root.to_owned(),
                ["memory.max", "memory.current", "inactive_file"],
            ),
            _ if names.split(',').any(|name| name == "memory") => (
                root.join("memory"),
                [
                    "memory.limit_in_bytes",
                    "memory.usage_in_bytes",
                    "total_inactive_file",
                ],
            ),
            _ => continue,
        };
        let [limit, usage, droppable] = files;
        let mut folder = top.join(path.trim_start_matches('/'));
        loop {
            let number = |name: &str| read(&folder.join(name))?.trim().parse::<u64>().ok();
            if let Some((limit, usage)) = number(limit).zip(number(usage)) {
                let stat = read(&folder.join("memory.stat")).unwrap_or_default();
                let mut lines = stat.lines().filter_map(|line| line.split_once(' '));
                let dropped = lines.find(|(name, _)| *name == droppable);
                let dropped: u64 = dropped.and_then(|(_, n)| n.parse().ok()).unwrap_or(0);
                let left = limit.saturating_sub(usage.saturating_sub(dropped));
                least = Some(least.map_or(left, |least| least.min(left)));
            }
            if folder == top || !folder.pop() {
                break;
            }
        }
    }
    least
}

/// Linear algebra beside a factor, and the records of a step: bytes for each entry of the Hessian and each unknown.
/// Measured on discs and beams, see `docs/robustness.md`.
#[cfg(feature = "linear")]
const ENTRY: u64 = 100;
#[cfg(feature = "linear")]
const UNKNOWN: u64 = 1000;
/// Stacks, tables, the text of a file and what the allocator keeps.
#[cfg(feature = "linear")]
const LEAST: u64 = 16 << 20;
/// Of what MUMPS estimates for Ipopt's system, without a share that is added: a factor of K, so many times, and bytes for
/// each entry.
#[cfg(feature = "linear")]
const SYSTEM: f64 = 1.3;
#[cfg(feature = "linear")]
const SYSTEM_ENTRY: u64 = 150;

#[cfg(feature = "linear")]
impl MemoryNeed {
    /// Of the library's own factors for the Hessians of this energy, body by body.
    ///
    /// # Errors
    /// A pattern too large to be analysed, or for the memory there is.
    pub fn of_energy(energy: &dyn Energy) -> Result<Self, Error> {
        let pattern = energy.hessian_pattern();
        check("the analysis of a linear system", beside(pattern))?;
        let mut blocks = energy.blocks();
        blocks.retain(|block| !block.is_empty());
        let analyses = Analysis::of_blocks(pattern, &blocks, &Ordering::MinimumDegree)?;
        let factor = analyses.iter().map(Analysis::bytes).sum();
        Ok(MemoryNeed {
            factor,
            bytes: factor + beside(pattern),
        })
    }

    /// Of Ipopt's systems by MUMPS, which adds so many `percent` to its estimate (`mumps_mem_percent`).
    ///
    /// # Errors
    /// As [`MemoryNeed::of_energy`].
    pub fn of_ipopt(pattern: &SymmetricPattern, percent: f64) -> Result<Self, FactorError> {
        check("the analysis of a linear system", beside(pattern))?;
        let analysis = Analysis::new(pattern, &Ordering::MinimumDegree)?;
        let own = (8 * analysis.fill()) as f64;
        let factor = (own * SYSTEM * (1.0 + percent.max(0.0) / 100.0)) as u64;
        Ok(MemoryNeed {
            factor,
            bytes: factor + beside(pattern) + SYSTEM_ENTRY * pattern.len() as u64,
        })
    }

    /// The most that factors of this pattern can take, without an analysis.
    pub(crate) fn at_most(pattern: &SymmetricPattern) -> u64 {
        let n = pattern.dim() as u64;
        let dense = n.saturating_mul(n + 1).saturating_mul(4);
        dense.saturating_mul(16).saturating_add(beside(pattern)) + (256 << 20)
    }
}

#[cfg(feature = "linear")]
fn beside(pattern: &SymmetricPattern) -> u64 {
    LEAST + ENTRY * pattern.len() as u64 + UNKNOWN * pattern.dim() as u64
}

#[cfg(test)]
mod tests {
    use super::*;

    const LIMITS: &str = "\
Limit                     Soft Limit           Hard Limit           Units     
Max data size             unlimited            unlimited            bytes     
Max address space         307200000            unlimited            bytes     
";

    #[test]
    fn limits_are_read_as_the_system_writes_them() {
        assert_eq!(
            soft_limit_of(LIMITS, "Max address space"),
            Some(307_200_000)
        );
        assert_eq!(soft_limit_of(LIMITS, "Max data size"), None);
        assert_eq!(soft_limit_of("", "Max data size"), None);
        let status = "Name:\tx\nVmSize:\t    1234 kB\nVmData:\t x kB\n";
        assert_eq!(kilobytes(status, "VmSize:"), Some(1234 * 1024));
        assert_eq!(kilobytes(status, "VmData:"), None);
    }

    /// A job of 1000 in a slice of 500, of which 300 are used and 100 of these can be dropped.
    #[test]
    fn the_nearest_control_group_limits() {
        let files = |path: &Path| -> Option<String> {
            let text = match path.to_str()? {
                "/cg/slice/job/memory.max" => "1000\n",
                "/cg/slice/job/memory.current" => "200\n",
                "/cg/slice/memory.max" => "500\n",
                "/cg/slice/memory.current" => "300\n",
                "/cg/slice/memory.stat" => "anon 200\ninactive_file 100\n",
                "/cg/memory.max" => "max\n",
                "/cg/memory.current" => "400\n",
                "/cg/memory/old/memory.limit_in_bytes" => "90\n",
                "/cg/memory/old/memory.usage_in_bytes" => "50\n",
                _ => return None,
            };
            Some(text.into())
        };
        let left = |groups: &str| group_left(groups, Path::new("/cg"), &files);
        assert_eq!(left("0::/slice/job\n"), Some(300));
        assert_eq!(left("0::/slice\n"), Some(300));
        assert_eq!(left("0::/\n"), None);
        assert_eq!(left("9:cpu:/a\n4:memory,hugetlb:/old\n"), Some(40));
        assert_eq!(left("0::/slice/job\n4:memory:/old\n"), Some(40));
        assert_eq!(left(""), None);
        assert_eq!(left("nonsense"), None);
    }

    #[test]
    fn what_is_left_is_told_on_linux_and_compared() {
        let Some(left) = left() else { return };
        assert!(left.bytes > 1_000_000, "{left}");
        check("a little", 1).expect("there");
        let needed = u64::MAX;
        let error = check("the world", needed).expect_err("too much");
        let text = error.to_string();
        assert!(
            text.contains("the world") && text.contains("coarsen"),
            "{text}"
        );
        assert!(matches!(error, MemoryError::TooLittle { needed: n, .. } if n == needed));
    }
}
