//! Loops against arms with friction, moved in memory while they run.

mod arm;

use arm::{reference, Arm, PERIOD};
use tribo::{ForceLoop, Guard};

#[test]
fn follows_against_friction_wherever_it_is() {
    let mut axes = [ForceLoop::new(), ForceLoop::new()];
    let mut follower = 0; // the other one holds 0.1 N
    let (mut arm, mut other) = (Arm::default(), Arm::default());
    assert_eq!(axes[0].period_s(), 0.001);
    let mut square = 0.0;
    for tick in 0..2 * PERIOD {
        if tick % 1000 == 999 {
            axes.swap(0, 1); // they change places in memory
            follower = 1 - follower;
        }
        if tick >= PERIOD {
            square += f64::from(reference(tick) - arm.force).powi(2);
        }
        arm.step(axes[follower].step(reference(tick), arm.reading));
        other.step(axes[1 - follower].step(0.1, other.reading));
    }
    let rms = (square / PERIOD as f64).sqrt();
    assert!(rms < 0.2e-3, "RMS error {rms} N");
    assert!((other.force - 0.1).abs() < 0.01, "held {} N", other.force);
    assert_eq!(axes[follower].guard(), Guard::None);
}

#[test]
fn is_finite_without_a_reading() {
    let mut axis = ForceLoop::default();
    for reading in [f32::NAN, f32::INFINITY, 1e30] {
        assert!(axis.step(0.5, reading).is_finite());
        assert!(axis.step(reading, 0.5).is_finite());
    }
}
