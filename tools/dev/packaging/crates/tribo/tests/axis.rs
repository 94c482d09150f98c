//! What axes say of themselves and refuse, after an arm with friction that shares no code with them. The project's tests compare their ticks with
//! those of the library's own calls, with each controller, tuned and moved in memory.

mod arm;

use arm::{reference, Arm, PERIOD};
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
    presliding_n: 0.0,
    still_time_s: 0.2,
    controller: pi(1.9, 110.0),
};

/// Three periods.
fn play(mut step: impl FnMut(f32, f32) -> f32) {
    let mut arm = Arm::default();
    for tick in 0..3 * PERIOD {
        arm.step(step(reference(tick), arm.reading));
    }
}

const BREAKAWAY_N: f32 = 1.2 * (0.007 + 0.3 * 0.5); // at the usual force
const OTHER_RIG: AxisConfig = AxisConfig { positive: Breakaway { offset_n: 0.1, slope: 0.0 }, ..CONFIG };

#[test]
fn says_what_it_learned_and_hands_it_on() {
    let mut first = Axis::new(&CONFIG).unwrap();
    play(|r, y| first.step(r, y));
    let report = first.report();
    assert!(report.low_n[0] < BREAKAWAY_N && BREAKAWAY_N < report.high_n[0], "{report:?}");
    assert_eq!((report.share, report.bad_inputs, report.warnings().count()), (1.0, 0, 0));
    let bytes = first.export();
    let mut second = Axis::new(&CONFIG).unwrap();
    second.import(&bytes).unwrap();
    assert_eq!(second.report().breakaway_n, report.breakaway_n);
    let mut corrupt = bytes;
    corrupt[20] ^= 1;
    assert!(second.import(&corrupt).unwrap_err().to_string().contains("checksum"));
    assert!(second.import(&bytes[1..]).unwrap_err().to_string().contains("version"));
    assert!(Axis::new(&OTHER_RIG).unwrap().import(&bytes).unwrap_err().to_string().contains("rig"));
    first.change(&AxisConfig { controller: pi(1.0, 60.0), ..CONFIG }).unwrap();
    assert!((first.report().breakaway_n[0] - report.breakaway_n[0]).abs() < 1e-4);
    assert!(first.change(&AxisConfig { sample_time_s: 2e-3, ..CONFIG }).unwrap_err().to_string().contains("sample_time_s"));
}

#[test]
fn tells_a_controller_of_the_callers_of_the_limit() {
    let own = AxisConfig { controller: own(), ..CONFIG };
    let mut axis = Axis::new(&own).unwrap();
    axis.error(0.5, 0.5);
    assert_eq!((axis.command(50.0), axis.report().limited_ticks), (2.0, 1));
    assert!(axis.excess() < -40.0);
    let mut axis = AxisQ31::new(&own, FULL_SCALE_N).unwrap();
    axis.error(q31(0.5), q31(0.5));
    assert_eq!((axis.command(q31(5.0)), axis.report().limited_ticks), (q31(2.0), 1));
    assert!(newtons(axis.excess()) < -2.0);
}

#[test]
fn refuses_in_words_field_by_field_and_is_finite_whatever_comes() {
    let refused = |config: AxisConfig| Axis::new(&config).err().unwrap().to_string();
    assert!(refused(AxisConfig::default()).contains("sample_time_s"));
    assert_eq!(AxisConfig::default().still_time_s, 0.2); // what a caller leaves out is as in C
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
fn says_in_fixed_point_what_it_learned_and_hands_it_on() {
    let mut axis = AxisQ31::new(&CONFIG, FULL_SCALE_N).unwrap();
    play(|r, y| {
        let u = axis.step(q31(r), q31(y));
        axis.learn();
        newtons(u)
    });
    let report = axis.report();
    assert!(report.low_n[0] < BREAKAWAY_N && BREAKAWAY_N < report.high_n[0] && report.travel_n > 1.0, "{report:?}");
    assert_eq!((report.share, report.late, report.warnings().count()), (1.0, 0, 0));
    let bytes = axis.export();
    let mut second = AxisQ31::new(&CONFIG, FULL_SCALE_N).unwrap();
    second.import(&bytes).unwrap();
    assert_eq!(second.report().breakaway_n, report.breakaway_n);
    assert!(Axis::new(&CONFIG).unwrap().import(&bytes).unwrap_err().to_string().contains("version"));
    let mut coarser = AxisQ31::new(&CONFIG, 4.0).unwrap(); // what is learned does not depend on the full scale
    coarser.import(&bytes).unwrap();
    assert!((coarser.report().breakaway_n[0] - report.breakaway_n[0]).abs() < 1e-7 * BREAKAWAY_N, "{:?}", coarser.report());
    assert!(AxisQ31::new(&OTHER_RIG, FULL_SCALE_N).unwrap().import(&bytes).unwrap_err().to_string().contains("rig"));
    assert!(axis.change(&AxisConfig { sample_time_s: 2e-3, ..CONFIG }).is_err());
    axis.restore();
}

#[test]
fn a_tick_in_fixed_point_does_not_learn_and_says_so() {
    let mut axis = AxisQ31::new(&CONFIG, FULL_SCALE_N).unwrap();
    play(|r, y| newtons(axis.step(q31(r), q31(y))));
    assert!(axis.report().late > 100 && axis.report().travel_n == 0.0, "{:?}", axis.report());
    assert!(axis.learn() && !axis.learn());
}

#[test]
fn refuses_sections_and_full_scales_in_words() {
    let refused = |controller| Axis::new(&AxisConfig { controller, ..CONFIG }).err().unwrap().to_string();
    assert!(refused(sections(&[])).contains("section_count"));
    assert!(refused(sections(&[Section::default(); 5])).contains("section_count"));
    assert!(refused(sections(&[Section::default()])).contains("section"));
    assert!(Axis::new(&AxisConfig { controller: paper(), ..CONFIG }).is_ok());
    for full_scale_n in [1.0, f32::NAN] {
        assert!(AxisQ31::new(&CONFIG, full_scale_n).err().unwrap().to_string().contains("full_scale_n"));
    }
}
