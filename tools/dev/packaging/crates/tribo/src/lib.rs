//! Force control that compensates friction: the feed-forward with the guard, for the rig of `TRIBO_RIG` (see tribo-sys).
//!
//! ```
//! let mut axis = tribo::ForceLoop::new();
//! let u = axis.step(0.5, 0.48); // a reference and a reading in N, once in `axis.period_s()`
//! assert!(u.is_finite());
//! ```
//!
//! A joint with current and encoder needs no force sensor and no rig; it stands behind a loop of yours:
//!
//! ```
//! use tribo::{Joint, JointConfig};
//! let config = JointConfig { sample_time_s: 1e-3, effort_max: 3.0, travel: 0.0015, breakaway: 0.3, actuator_pole_rad_per_s: 0.0, gain: 0.9 };
//! let mut joint = Joint::new(&config)?; // N m and rad
//! let u = joint.step(0.5, 0.1, 0.1); // effort of your loop, where the joint shall be, where it is
//! # Ok::<(), tribo::Refused>(())
//! ```
#![no_std]

mod joint;

pub use joint::{Cause, Force, Joint, JointConfig, Refused, Report};
use tribo_sys::Axis;

/// One axis. `step` is the same C as in a drive; an axis may be moved, and sent to another thread.
pub struct ForceLoop(Axis);

/// Why the guard fades friction.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Guard {
    /// It does not.
    None,
    /// Friction reversed quickly and drove y against r.
    Hunting,
    /// The force broke away again and again with an error of the wrong sign.
    Overshoot,
}

impl ForceLoop {
    /// At rest, nothing learned.
    pub fn new() -> Self {
        let mut axis = Axis([0; 1024]);
        unsafe { tribo_sys::tribo_axis_start(&mut axis) };
        ForceLoop(axis)
    }

    /// The time between two steps that the rig was made for.
    pub fn period_s(&self) -> f32 {
        unsafe { tribo_sys::tribo_axis_period_s }
    }

    /// u in N for the reference and the reading. Finite and within its limits whatever they are; NaN: there was no reading.
    pub fn step(&mut self, r: f32, y: f32) -> f32 {
        unsafe { tribo_sys::tribo_axis_step(&mut self.0, r, y) }
    }

    pub fn guard(&self) -> Guard {
        match unsafe { tribo_sys::tribo_axis_guard(&self.0) } {
            0 => Guard::None,
            1 => Guard::Hunting,
            _ => Guard::Overshoot,
        }
    }
}

impl Default for ForceLoop {
    fn default() -> Self {
        Self::new()
    }
}
