//! What tests/support/doors.c does, by the crate: `doors f32|q31 axis CONTROLLER NUMBER...`, `doors f32|q31 joint`.

use std::io::stdin;

use tribo::{own, paper, pi, sections, Axis, AxisConfig, AxisQ31, Breakaway, Joint, JointConfig, JointQ31, Section};

const CONFIG: AxisConfig = AxisConfig {
    sample_time_s: 1e-3,
    u_min_n: -2.0,
    u_max_n: 2.0,
    input_max_n: 0.0,
    usual_force_n: 0.0,
    positive: Breakaway { offset_n: 0.007, slope: 0.3 },
    negative: Breakaway { offset_n: 0.0, slope: 0.0 },
    gravity_n: 0.0,
    arm_lag_s: 0.0,
    noise_n: 0.0,
    actuator_pole_rad_per_s: 200.0,
    sensor_pole_rad_per_s: 55.0,
    presliding_n: 0.0,
    still_time_s: 0.2,
    controller: own(),
};

/// An axis whose forces are words.
trait Words: Sized {
    fn made(config: &AxisConfig) -> Self;
    fn tuned(&mut self, config: &AxisConfig);
    fn stepped(&mut self, r: i32, y: i32) -> i32;
    fn halves(&mut self, r: i32, y: i32, v: i32) -> [i32; 3];
}

fn float(word: i32) -> f32 {
    f32::from_bits(word as u32)
}

fn word(x: f32) -> i32 {
    x.to_bits() as i32
}

impl Words for Axis {
    fn made(config: &AxisConfig) -> Self {
        Axis::new(config).unwrap()
    }

    fn tuned(&mut self, config: &AxisConfig) {
        self.change(config).unwrap();
    }

    fn stepped(&mut self, r: i32, y: i32) -> i32 {
        word(self.step(float(r), float(y)))
    }

    fn halves(&mut self, r: i32, y: i32, v: i32) -> [i32; 3] {
        let e = self.error(float(r), float(y));
        let u = self.command(float(v));
        [e, u, self.excess()].map(word)
    }
}

impl Words for AxisQ31 {
    fn made(config: &AxisConfig) -> Self {
        AxisQ31::new(config, 8.0).unwrap()
    }

    fn tuned(&mut self, config: &AxisConfig) {
        self.change(config).unwrap();
    }

    fn stepped(&mut self, r: i32, y: i32) -> i32 {
        let u = self.step(r, y);
        self.learn();
        u
    }

    fn halves(&mut self, r: i32, y: i32, v: i32) -> [i32; 3] {
        let e = self.error(r, y);
        let u = self.command(v);
        self.learn();
        [e, u, self.excess()]
    }
}

fn rows() -> impl Iterator<Item = Vec<i32>> {
    stdin().lines().map(|line| line.unwrap().split(' ').map(|word| word.parse().unwrap()).collect())
}

fn play_axis<A: Words>(kind: &str, numbers: &[f32]) {
    let first: Vec<Section> = numbers.chunks(5).map(|x| Section { b0: x[0], b1: x[1], b2: x[2], a1: x[3], a2: x[4] }).collect();
    let with = |x: f32| match kind {
        "pi" => pi(x, 110.0),
        "sections" => {
            let mut own = first.clone();
            own[0] = Section { b0: x * own[0].b0, b1: x * own[0].b1, b2: x * own[0].b2, ..own[0] };
            sections(&own)
        }
        "paper" => paper(),
        _ => own(),
    };
    let mut before = if kind == "pi" { 1.9 } else { 1.0 };
    let mut axis = A::made(&AxisConfig { controller: with(before), ..CONFIG });
    for row in rows() {
        if kind == "own" {
            let [e, u, excess] = axis.halves(row[0], row[1], row[2]);
            println!("{e} {u} {excess}");
            continue;
        }
        if float(row[2]) != before {
            before = float(row[2]);
            axis.tuned(&AxisConfig { controller: with(before), ..CONFIG });
        }
        axis = *Box::new(axis); // it may move
        println!("{}", axis.stepped(row[0], row[1]));
    }
}

fn play_joint(q31: bool) {
    let config = JointConfig {
        sample_time_s: 1e-3,
        effort_max: 1.0,
        travel: if q31 { 4.0 } else { 4.0 / 8192.0 },
        breakaway: 0.0,
        actuator_pole_rad_per_s: 0.0,
        gain: 0.97,
        wrap: 0.0,
    };
    let (mut single, mut fixed) = (Joint::new(&config).unwrap(), JointQ31::new(&JointConfig { travel: 4.0, ..config }).unwrap());
    for row in rows() {
        if q31 {
            fixed.load(row[3]);
            println!("{}", fixed.step(row[0], row[1], row[2]));
        } else {
            single.load(float(row[3]));
            println!("{}", word(single.step(float(row[0]), float(row[1]), float(row[2]))));
        }
    }
}

fn main() {
    let words: Vec<String> = std::env::args().collect();
    let numbers: Vec<f32> = words.iter().skip(4).map(|word| float(word.parse().unwrap())).collect();
    match (words[1].as_str(), words[2].as_str()) {
        ("f32", "axis") => play_axis::<Axis>(&words[3], &numbers),
        ("q31", "axis") => play_axis::<AxisQ31>(&words[3], &numbers),
        (arithmetic, _) => play_joint(arithmetic == "q31"),
    }
}
