//! What a run tells the application's logger, by the target `contact`. A process has one logger, so this test has a program of its own.

use std::sync::Mutex;

use contact_fem::mesh::generators::{Diagonals, linspace, rectangle};
use contact_fem::{Body, Error, NeoHookean, Obstacle, Scene, Simulation};
use log::{Level, LevelFilter, Log, Metadata, Record};

static LINES: Mutex<Vec<(Level, String)>> = Mutex::new(Vec::new());

struct Kept;

impl Log for Kept {
    fn enabled(&self, metadata: &Metadata<'_>) -> bool {
        metadata.target() == "contact"
    }

    fn log(&self, record: &Record<'_>) {
        if self.enabled(record.metadata()) {
            let line = (record.level(), record.args().to_string());
            LINES.lock().expect("no panic in a line").push(line);
        }
    }

    fn flush(&self) {}
}

/// A block on a floor, pressed by a share of its height.
fn pressed(by: f64) -> Result<Scene<2>, Error> {
    let mesh = rectangle(
        &linspace(0.0, 1.0, 4),
        &linspace(0.0, 1.0, 4),
        Diagonals::Alternating,
    )?;
    let mut block = Body::new(mesh, NeoHookean::new(100.0, 0.3)?);
    block.prescribe("top", [Some(0.0), Some(-by)])?;
    let mut scene = Scene::new();
    let block = scene.add("block", block);
    scene.obstacle(
        "floor",
        block.on("bottom"),
        Obstacle::half_space([0.0, 0.0], [0.0, 1.0])?,
    )?;
    Ok(scene)
}

#[test]
fn a_run_tells_its_phases_steps_iterations_and_end() -> Result<(), Error> {
    log::set_logger(&Kept).expect("the first logger");
    log::set_max_level(LevelFilter::Debug);

    let history = Simulation::with_increments(2).run(&mut pressed(0.1)?.problem()?)?;
    assert!(history.is_complete());
    let lines = std::mem::take(&mut *LINES.lock().expect("no panic in a line"));
    let of = |level: Level| {
        lines
            .iter()
            .filter(move |(own, _)| *own == level)
            .map(|(_, line)| line.as_str())
    };
    // one line for the phase, one an attempt, and one at the end
    let attempts = &history.run.attempts;
    assert_eq!(of(Level::Info).count(), 2 + attempts.len(), "{lines:?}");
    for attempt in attempts {
        let begin = format!(
            "load factor {}: converged, {} iterations",
            attempt.to,
            attempt.iterations.len()
        );
        assert_eq!(
            of(Level::Info)
                .filter(|line| line.starts_with(&begin))
                .count(),
            1,
            "{begin}: {lines:?}"
        );
    }
    assert_eq!(of(Level::Info).next_back(), Some("the run is complete"));
    let iterations: usize = attempts
        .iter()
        .map(|attempt| attempt.iterations.len())
        .sum();
    let told = of(Level::Debug).filter(|line| line.contains(", iteration "));
    assert_eq!(told.count(), iterations, "{lines:?}");
    assert_eq!(of(Level::Warn).count(), 0, "{lines:?}");

    // pressed by more than its height, it cannot come to the end
    let mut simulation = Simulation::with_increments(1);
    simulation.load_steps.max_halvings = 2;
    let history = simulation.run(&mut pressed(1.2)?.problem()?)?;
    assert!(!history.is_complete());
    let lines = std::mem::take(&mut *LINES.lock().expect("no panic in a line"));
    let last = lines.last().expect("some lines");
    assert_eq!(last.0, Level::Warn);
    assert!(
        last.1
            .starts_with("the run ends: not converged beyond load factor"),
        "{last:?}"
    );
    Ok(())
}
