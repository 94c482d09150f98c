//! Axes against an arm with friction that shares no code with them, moved in memory while they run.

use tribo::{own, paper, pi, sections, Axis, AxisConfig, AxisQ31, Breakaway, Section};

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
    controller: pi(1.9, 110.0),
};
const PERIOD: usize = 10_000;

/// Its breakaway is 20 % above what the config says.
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

fn reference(tick: usize) -> f32 {
    let phase = (tick % PERIOD) as f32 / PERIOD as f32;
    0.4 + 0.4 * phase.min(1.0 - phase)
}

/// RMS error over the last of three periods.
fn error_of(mut step: impl FnMut(f32, f32) -> f32) -> f64 {
    let mut arm = Arm::default();
    let mut square = 0.0;
    for tick in 0..3 * PERIOD {
        if tick >= 2 * PERIOD {
            square += f64::from(reference(tick) - arm.force).powi(2);
        }
        arm.step(step(reference(tick), arm.reading));
    }
    (square / PERIOD as f64).sqrt()
}

/// The PI of CONFIG, by itself.
fn plain_pi() -> impl FnMut(f32) -> f32 {
    let mut integral = 0.0;
    move |e| {
        integral += 0.11 * e;
        1.9 * e + integral
    }
}

#[test]
fn takes_friction_out_wherever_it_is_and_says_what_it_learned() {
    let mut pi = plain_pi();
    let without = error_of(|r, y| pi(r - y));
    let mut axes = [Axis::new(&CONFIG).unwrap(), Axis::new(&CONFIG).unwrap()];
    let (mut follower, mut tick, mut other) = (0, 0, Arm::default()); // the other one holds 0.1 N
    let with = error_of(|r, y| {
        tick += 1;
        if tick % 1000 == 0 {
            axes.swap(0, 1); // they change places in memory
            follower = 1 - follower;
        }
        other.step(axes[1 - follower].step(0.1, other.reading));
        axes[follower].step(r, y)
    });
    assert!(without > 10.0 * with, "RMS error {without} N without, {with} N with");
    assert!((other.force - 0.1).abs() < 0.01, "held {} N", other.force);
    let report = axes[follower].report();
    let breakaway = 1.2 * (0.007 + 0.3 * 0.5); // at the usual force
    assert!(report.low_n[0] < breakaway && breakaway < report.high_n[0], "{report:?}");
    assert_eq!((report.share, report.bad_inputs, report.warnings().count()), (1.0, 0, 0));
}

#[test]
fn a_controller_of_the_callers_in_between_is_as_good() {
    let mut pi = plain_pi();
    let without = error_of(|r, y| pi(r - y));
    let mut axis = Axis::new(&AxisConfig { controller: own(), ..CONFIG }).unwrap();
    let mut pi = plain_pi();
    let with = error_of(|r, y| {
        let e = axis.error(r, y);
        axis.command(pi(e))
    });
    assert!(without > 10.0 * with, "RMS error {without} N without, {with} N with");
    assert_eq!(axis.excess(), 0.0);
    assert_eq!((axis.command(50.0), axis.report().limited_ticks), (2.0, 1));
    assert!(axis.excess() < -40.0);
}

#[test]
fn a_change_does_not_move_u_and_keeps_what_is_learned() {
    let mut axis = Axis::new(&CONFIG).unwrap();
    let mut arm = Arm::default();
    let mut u = 0.0;
    for tick in 0..2 * PERIOD + 2000 {
        u = axis.step(reference(tick), arm.reading);
        arm.step(u);
    }
    let learned = axis.report().breakaway_n;
    axis.change(&AxisConfig { controller: pi(1.0, 60.0), ..CONFIG }).unwrap();
    axis.change(&AxisConfig { controller: pi(0.9, 50.0), ..CONFIG }).unwrap(); // a second one before the tick
    let mut moved = Box::new(axis);
    let next = moved.step(reference(2 * PERIOD + 2000), arm.reading);
    assert!((next - u).abs() < 0.01, "u went from {u} to {next} N");
    assert!((moved.report().breakaway_n[0] - learned[0]).abs() < 1e-4); // it goes on from there
    assert!(moved.change(&AxisConfig { sample_time_s: 2e-3, ..CONFIG }).unwrap_err().to_string().contains("sample_time_s"));
    moved.change(&CONFIG).unwrap();
    let last = moved.step(reference(2 * PERIOD + 2001), arm.reading);
    assert!((last - next).abs() < 0.01, "u went from {next} to {last} N");
}

#[test]
fn what_is_learned_can_be_handed_on() {
    let mut first = Axis::new(&CONFIG).unwrap();
    error_of(|r, y| first.step(r, y));
    let bytes = first.export();
    let mut second = Axis::new(&CONFIG).unwrap();
    second.import(&bytes).unwrap();
    assert_eq!(second.report().breakaway_n, first.report().breakaway_n);
    let mut corrupt = bytes;
    corrupt[20] ^= 1;
    assert!(second.import(&corrupt).unwrap_err().to_string().contains("checksum"));
    assert!(second.import(&bytes[1..]).unwrap_err().to_string().contains("version"));
    let mut other = Axis::new(&AxisConfig { positive: Breakaway { offset_n: 0.1, slope: 0.0 }, ..CONFIG }).unwrap();
    assert!(other.import(&bytes).unwrap_err().to_string().contains("rig"));
}

#[test]
fn refuses_in_words_field_by_field_and_is_finite_whatever_comes() {
    let refused = |config: AxisConfig| Axis::new(&config).err().unwrap().to_string();
    assert!(refused(AxisConfig::default()).contains("sample_time_s"));
    assert!(refused(AxisConfig { u_max_n: f32::NAN, ..CONFIG }).contains("u_max_n"));
    assert!(refused(AxisConfig { positive: Breakaway::default(), ..CONFIG }).contains("offset_n"));
    assert!(refused(AxisConfig { sensor_pole_rad_per_s: 0.0, ..CONFIG }).contains("sensor_pole_rad_per_s"));
    assert!(refused(AxisConfig { controller: Default::default(), ..CONFIG }).contains("controller"));
    assert!(refused(AxisConfig { controller: pi(0.0, 1.0), ..CONFIG }).contains("kp"));
    let mut axis = Axis::new(&CONFIG).unwrap();
    for bad in [f32::NAN, f32::INFINITY, -1e30] {
        assert!(axis.step(0.5, bad).abs() <= 2.0 && axis.step(bad, 0.5).abs() <= 2.0);
    }
    let report = axis.report();
    assert_eq!(report.bad_inputs, 6);
    assert!(report.warnings().any(|sentence| sentence.contains("bad_inputs")));
    axis.restore();
}

const FULL_SCALE_N: f32 = 8.0;

fn q31(force_n: f32) -> i32 {
    (f64::from(force_n) / f64::from(FULL_SCALE_N) * 2147483648.0) as i32
}

fn newtons(force: i32) -> f32 {
    (f64::from(force) / 2147483648.0 * f64::from(FULL_SCALE_N)) as f32
}

#[test]
fn fixed_point_takes_friction_out_by_what_it_learned() {
    let mut pi = plain_pi();
    let without = error_of(|r, y| pi(r - y));
    let mut axes = [AxisQ31::new(&CONFIG, FULL_SCALE_N).unwrap(), AxisQ31::new(&CONFIG, FULL_SCALE_N).unwrap()];
    let (mut follower, mut tick) = (0, 0);
    let with = error_of(|r, y| {
        tick += 1;
        if tick % 1000 == 0 {
            axes.swap(0, 1); // they change places in memory
            follower = 1 - follower;
        }
        let u = axes[follower].step(q31(r), q31(y));
        axes[follower].learn();
        newtons(u)
    });
    assert!(without > 10.0 * with, "RMS error {without} N without, {with} N with");
    let report = axes[follower].report();
    let breakaway = 1.2 * (0.007 + 0.3 * 0.5);
    assert!(report.low_n[0] < breakaway && breakaway < report.high_n[0] && report.travel_n > 1.0, "{report:?}");
    assert!((report.breakaway_n[0] - breakaway).abs() < 0.05 * breakaway, "{report:?}");
    assert_eq!((report.share, report.late, report.warnings().count()), (1.0, 0, 0));

    let mut second = AxisQ31::new(&CONFIG, FULL_SCALE_N).unwrap();
    second.import(&axes[follower].export()).unwrap();
    assert_eq!(second.report().breakaway_n, report.breakaway_n);
    let mut single = Axis::new(&CONFIG).unwrap();
    assert!(single.import(&axes[follower].export()).unwrap_err().to_string().contains("version"));
    let mut coarser = AxisQ31::new(&CONFIG, 4.0).unwrap(); // what is learned does not depend on the full scale
    coarser.import(&axes[follower].export()).unwrap();
    assert!((coarser.report().breakaway_n[0] - report.breakaway_n[0]).abs() < 1e-7 * breakaway, "{:?}", coarser.report());
    let mut other = AxisQ31::new(&AxisConfig { positive: Breakaway { offset_n: 0.1, slope: 0.0 }, ..CONFIG }, FULL_SCALE_N).unwrap();
    assert!(other.import(&axes[follower].export()).unwrap_err().to_string().contains("rig"));
}

#[test]
fn a_tick_in_fixed_point_does_not_learn_and_says_so() {
    let mut axis = AxisQ31::new(&CONFIG, FULL_SCALE_N).unwrap();
    let mut pi = plain_pi();
    error_of(|r, y| {
        axis.step(q31(r), q31(y));
        pi(r - y)
    });
    assert!(axis.report().late > 100 && axis.report().travel_n == 0.0, "{:?}", axis.report());
    assert!(axis.learn() && !axis.learn());
}

#[test]
fn a_controller_of_the_callers_in_fixed_point() {
    let mut pi = plain_pi();
    let without = error_of(|r, y| pi(r - y));
    let mut axis = AxisQ31::new(&AxisConfig { controller: own(), ..CONFIG }, FULL_SCALE_N).unwrap();
    let mut pi = plain_pi();
    let with = error_of(|r, y| {
        let e = newtons(axis.error(q31(r), q31(y)));
        let u = axis.command(q31(pi(e)));
        axis.learn();
        newtons(u)
    });
    assert!(without > 10.0 * with, "RMS error {without} N without, {with} N with");
    assert_eq!(axis.excess(), 0);
    assert_eq!((axis.command(q31(5.0)), axis.report().limited_ticks), (q31(2.0), 1));
    assert!(newtons(axis.excess()) < -2.0);
}

#[test]
fn fixed_point_changes_without_a_jump_and_refuses_in_words() {
    let mut axis = AxisQ31::new(&CONFIG, FULL_SCALE_N).unwrap();
    let mut arm = Arm::default();
    let mut u = 0.0;
    for tick in 0..PERIOD {
        u = newtons(axis.step(q31(reference(tick)), q31(arm.reading)));
        axis.learn();
        arm.step(u);
    }
    axis.change(&AxisConfig { controller: pi(1.0, 60.0), ..CONFIG }).unwrap();
    let mut moved = Box::new(axis);
    let next = newtons(moved.step(q31(reference(PERIOD)), q31(arm.reading)));
    assert!((next - u).abs() < 0.01, "u went from {u} to {next} N");
    moved.restore();
    assert!(AxisQ31::new(&CONFIG, 1.0).err().unwrap().to_string().contains("full_scale_n"));
    assert!(AxisQ31::new(&CONFIG, f32::NAN).err().unwrap().to_string().contains("full_scale_n"));
    assert!(moved.change(&AxisConfig { sample_time_s: 2e-3, ..CONFIG }).is_err());
}

#[test]
fn sections_are_the_controller_they_say() {
    let mut gains = Axis::new(&CONFIG).unwrap();
    let b0 = 1.9 + 0.5 * 0.11;
    let same = sections(&[Section { b0, b1: b0 + 0.11, b2: 0.11, a1: 1.0, a2: 0.0 }]);
    let mut own = Axis::new(&AxisConfig { controller: same, ..CONFIG }).unwrap();
    for tick in 0..PERIOD {
        let r = reference(tick);
        assert!((gains.step(r, 0.9 * r) - own.step(r, 0.9 * r)).abs() < 1e-5);
    }
    let refused = |controller| Axis::new(&AxisConfig { controller, ..CONFIG }).err().unwrap().to_string();
    assert!(refused(sections(&[])).contains("section_count"));
    assert!(refused(sections(&[Section::default(); 5])).contains("section_count"));
    assert!(refused(sections(&[Section::default()])).contains("section"));
    assert!(Axis::new(&AxisConfig { controller: paper(), ..CONFIG }).is_ok());
}
