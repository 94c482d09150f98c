//! An arm with friction that shares no code with the library, and the triangle that it shall follow.

pub const PERIOD: usize = 10_000;

/// Its breakaway is 20 % above what a config or a rig says.
#[derive(Default)]
pub struct Arm {
    actuator: f32,
    pub force: f32,
    pub reading: f32,
}

impl Arm {
    pub fn step(&mut self, u: f32) {
        let breakaway = 1.2 * (0.007 + 0.3 * self.force.abs());
        self.actuator += 0.18127 * (u - self.actuator);
        let held = self.force.clamp(self.actuator - breakaway, self.actuator + breakaway);
        self.force += 0.11765 * (held - self.force);
        self.reading += 0.05351 * (self.force - self.reading);
    }
}

pub fn reference(tick: usize) -> f32 {
    let phase = (tick % PERIOD) as f32 / PERIOD as f32;
    0.4 + 0.4 * phase.min(1.0 - phase)
}
