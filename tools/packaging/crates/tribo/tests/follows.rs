//! The loop against an arm with friction, moved in memory while it runs.

use tribo::{ForceLoop, Guard};

/// As examples/sim: its breakaway is 20 % above what the rig believes.
#[derive(Default)]
struct Arm {
    actuator: f32,
    force: f32,
    reading: f32,
}

impl Arm {
    fn step(&mut self, u: f32) {
        let breakaway = 1.2 * (0.007 + 0.3 * self.force.abs());
        self.actuator += 0.18127 * (u - self.actuator);
        let held = self.force.clamp(self.actuator - breakaway, self.actuator + breakaway);
        self.force += 0.11765 * (held - self.force);
        self.reading += 0.05351 * (self.force - self.reading);
    }
}

#[test]
fn follows_against_friction_wherever_it_is() {
    const PERIOD: usize = 10_000;
    let mut axis = ForceLoop::new();
    assert_eq!(axis.period_s(), 0.001);
    let mut arm = Arm::default();
    let mut square = 0.0;
    for tick in 0..2 * PERIOD {
        if tick % 1000 == 999 {
            axis = *Box::new(axis); // elsewhere, and back
        }
        let phase = (tick % PERIOD) as f32 / PERIOD as f32;
        let reference = 0.4 + 0.4 * phase.min(1.0 - phase);
        if tick >= PERIOD {
            square += f64::from(reference - arm.force).powi(2);
        }
        arm.step(axis.step(reference, arm.reading));
    }
    let rms = (square / PERIOD as f64).sqrt();
    assert!(rms < 0.2e-3, "RMS error {rms} N");
    assert_eq!(axis.guard(), Guard::None);
}

#[test]
fn is_finite_without_a_reading() {
    let mut axis = ForceLoop::default();
    for reading in [f32::NAN, f32::INFINITY, 1e30] {
        assert!(axis.step(0.5, reading).is_finite());
        assert!(axis.step(reading, 0.5).is_finite());
    }
}
