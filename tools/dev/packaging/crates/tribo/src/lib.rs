//! Takes friction out of motor drives: a force axis, a joint without a force sensor, and a loop whose params `tribo-sim params` made.
//!
//! ```
//! use tribo::{pi, Axis, AxisConfig, Breakaway};
//! let mut axis = Axis::new(&AxisConfig {
//!     sample_time_s: 1e-3,
//!     u_min_n: -2.0,
//!     u_max_n: 2.0,
//!     positive: Breakaway { offset_n: 0.007, slope: 0.3 },
//!     actuator_pole_rad_per_s: 200.0,
//!     sensor_pole_rad_per_s: 55.0,
//!     controller: pi(1.0, 56.0),
//!     ..Default::default()
//! })?;
//! let u = axis.step(0.5, 0.48); // a reference and a reading in N, every millisecond
//! # assert!(u.is_finite());
//! # Ok::<(), tribo::Refused>(())
//! ```
//!
//! A joint with current and encoder needs no force sensor; it stands behind a loop of yours:
//!
//! ```
//! use tribo::{Joint, JointConfig};
//! let config = JointConfig { sample_time_s: 1e-3, effort_max: 3.0, travel: 0.0015, breakaway: 0.3, actuator_pole_rad_per_s: 0.0, gain: 0.97, wrap: 0.0 };
//! let mut joint = Joint::new(&config)?; // N m and rad
//! let u = joint.step(0.5, 0.1, 0.1); // effort of your loop, where the joint shall be, where it is
//! # Ok::<(), tribo::Refused>(())
//! ```
//!
//! With a PID, an observer or a library of yours the tick of an axis has two halves, and `excess` is for its integral:
//!
//! ```
//! # use tribo::{own, Axis, AxisConfig, Breakaway};
//! # let config = AxisConfig {
//! #     sample_time_s: 1e-3,
//! #     u_min_n: -2.0,
//! #     u_max_n: 2.0,
//! #     positive: Breakaway { offset_n: 0.007, slope: 0.3 },
//! #     actuator_pole_rad_per_s: 200.0,
//! #     sensor_pole_rad_per_s: 55.0,
//! #     ..Default::default()
//! # };
//! let mut axis = Axis::new(&AxisConfig { controller: own(), ..config })?;
//! let mut integral = 0.0;
//! let e = axis.error(0.5, 0.48);
//! integral += 0.11 * e;
//! let u = axis.command(1.9 * e + integral);
//! integral += 0.11 * axis.excess();
//! # assert!(u.is_finite() && integral.is_finite());
//! # Ok::<(), tribo::Refused>(())
//! ```
//!
//! `AxisQ31` and `JointQ31` are both in fixed point, for a processor without an FPU.
//!
//! `ForceLoop` is the loop of the header in `TRIBO_RIG` (see tribo-sys): smaller, as no set-up is linked, and fixed when it is compiled.
//!
//! ```
//! let mut axis = tribo::ForceLoop::new();
//! let u = axis.step(0.5, 0.48); // once in `axis.period_s()`
//! assert!(u.is_finite());
//! ```
#![no_std]

mod axis;
mod joint;
mod refused;

pub use axis::{own, paper, pi, sections, Axis, AxisConfig, AxisQ31, AxisReport, Breakaway, Controller, Section, LEARNED_BYTES, SECTIONS_MAX};
pub use joint::{Cause, Force, Joint, JointConfig, JointQ31, Report};
pub use refused::Refused;

/// The loop of one rig. `step` is the same C as in a drive; a loop may be moved, and sent to another thread.
pub struct ForceLoop(tribo_sys::ForceLoop);

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
        let mut axis = tribo_sys::ForceLoop([0; 1024]);
        unsafe { tribo_sys::tribo_sys_loop_start(&mut axis) };
        ForceLoop(axis)
    }

    /// The time between two steps that the rig was made for.
    pub fn period_s(&self) -> f32 {
        unsafe { tribo_sys::tribo_sys_loop_period_s }
    }

    /// u in N for the reference and the reading. Finite and within its limits whatever they are; NaN: there was no reading.
    pub fn step(&mut self, r: f32, y: f32) -> f32 {
        unsafe { tribo_sys::tribo_sys_loop_step(&mut self.0, r, y) }
    }

    pub fn guard(&self) -> Guard {
        match unsafe { tribo_sys::tribo_sys_loop_guard(&self.0) } {
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
