//! tribo's force loop, compiled from C for one rig (see build.rs). The crate `tribo` is the safe way to it.
#![no_std]

/// Memory of an axis, of the size that axis.c checks. It may be moved between two calls.
#[repr(C, align(8))]
pub struct Axis(pub [u8; 1024]);

extern "C" {
    pub static tribo_axis_period_s: f32;
    pub fn tribo_axis_start(axis: *mut Axis);
    pub fn tribo_axis_step(axis: *mut Axis, r: f32, y: f32) -> f32;
    pub fn tribo_axis_guard(axis: *const Axis) -> i32;
}
