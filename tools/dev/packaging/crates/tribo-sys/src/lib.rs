//! tribo's axis and joint, and a force loop whose params were made for one rig (see build.rs), compiled from C. The crate `tribo` is the safe
//! way to them.
#![no_std]

/// Memory of a rig's loop, of the size that force_loop.c checks. It may be moved between two calls.
#[repr(C, align(8))]
pub struct ForceLoop(pub [u8; 1024]);

/// Bytes of what an axis has learned.
pub const LEARNED_BYTES: usize = 108;

/// Most sections of a controller.
pub const SECTIONS_MAX: usize = 4;

/// (b0 + b1/d + b2/d^2) / (1 + a1/d + a2/d^2) with d = z - 1, the delta operator: another filter than with these numbers in z.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default)]
pub struct Section {
    pub b0: f32,
    pub b1: f32,
    pub b2: f32,
    pub a1: f32,
    pub a2: f32,
}

/// Made by `tribo::pi`, `sections`, `paper` and `own`; all 0 is none, which is refused.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default)]
pub struct Controller {
    pub kind: i32,
    pub kp: f32,
    pub ki_per_s: f32,
    pub section_count: u32,
    pub sections: [Section; SECTIONS_MAX],
}

/// Friction to overcome at rest: offset_n + slope |F|.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default)]
pub struct Breakaway {
    /// 1e-6 to 1e6 N.
    pub offset_n: f32,
    /// 0 to 10 N per N.
    pub slope: f32,
}

/// All but still_time_s 0 by default: refused until the rig is in it, and each refusal names the next field. Forces are end-point forces.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct AxisConfig {
    /// Of every tick, 1e-6 to 0.1 s.
    pub sample_time_s: f32,
    /// -1e6 to 0 N.
    pub u_min_n: f32,
    /// 0 to 1e6 N, over u_min_n.
    pub u_max_n: f32,
    /// Largest credible |r| and |y|, up to 1e6 N; 0: twice the larger limit of u.
    pub input_max_n: f32,
    /// |F| around which the rig usually works; 0: a quarter of the larger limit of u.
    pub usual_force_n: f32,
    /// Within a factor of 3; learning corrects it.
    pub positive: Breakaway,
    /// All 0: as the positive.
    pub negative: Breakaway,
    /// Constant load on the arm.
    pub gravity_n: f32,
    /// Damping over stiffness of the arm, up to 1000 ticks; 0: none that is known.
    pub arm_lag_s: f32,
    /// Standard deviation of y; 0: unknown.
    pub noise_n: f32,
    /// 1e-3 to 1e6 rad/s.
    pub actuator_pole_rad_per_s: f32,
    /// 1e-3 to 1e6 rad/s.
    pub sensor_pole_rad_per_s: f32,
    /// Travel of F over which friction builds up; 0: 1/11 of the breakaway.
    pub presliding_n: f32,
    /// r counts as standing after this time without motion, by default 0.2 s; 0: never.
    pub still_time_s: f32,
    pub controller: Controller,
}

impl Default for AxisConfig {
    fn default() -> Self {
        // SAFETY: all fields are numbers, which may be 0.
        Self { still_time_s: 0.2, ..unsafe { core::mem::zeroed() } }
    }
}

#[repr(C)]
#[derive(Clone, Copy, Default)]
pub struct AxisReport {
    pub breakaway_n: [f32; 2],
    pub low_n: [f32; 2],
    pub high_n: [f32; 2],
    pub breakaway_factor: f32,
    pub travel_n: f32,
    pub times_less: f32,
    pub share: f32,
    pub bad_inputs: u32,
    pub limited_ticks: u32,
    pub forgotten: u32,
    pub late: u32,
    pub warnings: u32,
}

/// Units of effort and position are those of your loop.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub struct JointConfig {
    /// Of every tick, 1e-6 to 0.1 s.
    pub sample_time_s: f32,
    /// Limit of |u|, 1e-6 to 1e6.
    pub effort_max: f32,
    /// Least change of q that is motion and no noise: four counts of the encoder.
    pub travel: f32,
    /// Friction as you believe it; half of it is used until it is learned. 0: nothing is.
    pub breakaway: f32,
    /// Of the current loop, 1e-3 to 1e6; 0: fast.
    pub actuator_pole_rad_per_s: f32,
    /// Part of the learned friction that is taken out, 0 to 1.
    pub gain: f32,
    /// Travel of a turn after which positions begin anew, at least 100 travel; 0: they do not.
    pub wrap: f32,
}

#[repr(C)]
#[derive(Clone, Copy, Default)]
pub struct JointReport {
    pub friction: f32,
    pub low: f32,
    pub high: f32,
    pub load: f32,
    pub share: f32,
    pub is_learned: i32,
    pub cause: i32,
    pub bad_inputs: u32,
    pub limited_ticks: u32,
}

extern "C" {
    pub static tribo_sys_loop_period_s: f32;
    pub fn tribo_sys_loop_start(state: *mut ForceLoop);
    pub fn tribo_sys_loop_step(state: *mut ForceLoop, r: f32, y: f32) -> f32;
    pub fn tribo_sys_loop_guard(state: *const ForceLoop) -> i32;

    pub fn tribo_sys_axis_q31_learn(axis: *mut AxisQ31) -> i32;
    pub fn tribo_sys_axis_warning(warnings: *mut u32) -> *const u8;
    pub fn tribo_sys_status_text(status: i32) -> *const u8;
    pub fn tribo_sys_joint_cause_text(cause: i32) -> *const u8;
}

/// Axis and joint in one arithmetic, in a module of that name.
macro_rules! arithmetic {
    ($name:ident, $axis:ident, $joint:ident, $force:ty, $position:ty) => {
        /// Memory of an axis, of the size that axis.c checks. It may be moved between two calls.
        #[repr(C, align(8))]
        pub struct $axis(pub [u8; 1792]);

        /// Memory of a joint, of the size that joint.c checks. It may be moved between two calls.
        #[repr(C, align(8))]
        pub struct $joint(pub [u8; 320]);

        pub mod $name {
            use super::{$axis, $joint, AxisConfig, AxisReport, JointConfig, JointReport};

            extern "C" {
                #[link_name = concat!("tribo_sys_axis_", stringify!($name), "_init")]
                pub fn axis_init(axis: *mut $axis, config: *const AxisConfig, full_scale_n: f32) -> i32;
                #[link_name = concat!("tribo_sys_axis_", stringify!($name), "_change")]
                pub fn axis_change(axis: *mut $axis, config: *const AxisConfig) -> i32;
                #[link_name = concat!("tribo_sys_axis_", stringify!($name), "_step")]
                pub fn axis_step(axis: *mut $axis, r: $force, y: $force) -> $force;
                #[link_name = concat!("tribo_sys_axis_", stringify!($name), "_error")]
                pub fn axis_error(axis: *mut $axis, r: $force, y: $force) -> $force;
                #[link_name = concat!("tribo_sys_axis_", stringify!($name), "_command")]
                pub fn axis_command(axis: *mut $axis, v: $force) -> $force;
                #[link_name = concat!("tribo_sys_axis_", stringify!($name), "_excess")]
                pub fn axis_excess(axis: *const $axis) -> $force;
                #[link_name = concat!("tribo_sys_axis_", stringify!($name), "_report")]
                pub fn axis_report(axis: *mut $axis, report: *mut AxisReport);
                #[link_name = concat!("tribo_sys_axis_", stringify!($name), "_rest")]
                pub fn axis_rest(axis: *mut $axis);
                #[link_name = concat!("tribo_sys_axis_", stringify!($name), "_restore")]
                pub fn axis_restore(axis: *mut $axis);
                #[link_name = concat!("tribo_sys_axis_", stringify!($name), "_export")]
                pub fn axis_export(axis: *mut $axis, bytes: *mut u8);
                #[link_name = concat!("tribo_sys_axis_", stringify!($name), "_import")]
                pub fn axis_import(axis: *mut $axis, bytes: *const u8, size: usize) -> i32;

                #[link_name = concat!("tribo_sys_joint_", stringify!($name), "_init")]
                pub fn joint_init(joint: *mut $joint, config: *const JointConfig) -> i32;
                #[link_name = concat!("tribo_joint_", stringify!($name), "_step")]
                pub fn joint_step(joint: *mut $joint, effort: $force, q_ref: $position, q: $position) -> $force;
                #[link_name = concat!("tribo_joint_", stringify!($name), "_load")]
                pub fn joint_load(joint: *mut $joint, load: $force);
                #[link_name = concat!("tribo_sys_joint_", stringify!($name), "_gain")]
                pub fn joint_gain(joint: *mut $joint, gain: f32) -> i32;
                #[link_name = concat!("tribo_joint_", stringify!($name), "_rest")]
                pub fn joint_rest(joint: *mut $joint);
                #[link_name = concat!("tribo_joint_", stringify!($name), "_restore")]
                pub fn joint_restore(joint: *mut $joint);
                #[link_name = concat!("tribo_sys_joint_", stringify!($name), "_force")]
                pub fn joint_force(joint: *const $joint, force: *mut f32);
                #[link_name = concat!("tribo_sys_joint_", stringify!($name), "_report")]
                pub fn joint_report(joint: *const $joint, report: *mut JointReport);
            }
        }
    };
}

arithmetic!(f32, AxisF32, JointF32, f32, f32);
arithmetic!(q31, AxisQ31, JointQ31, i32, i32);
