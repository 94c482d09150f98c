"""Loop figures, discretisation, sections and quantisation against scipy and python-control."""

import control as ct
import numpy as np
import pytest
import scipy.signal

from tribo_design import discretise, quantise, reduction, sections
from tribo_design.config import Discretisation, Ramp, Reduction
from tribo_design.errors import DesignError
from tribo_design.loop import Continuous, Loop, SampledPlant, SampledSections, SampledZpk
from tribo_design.exact import zpk_of
from tribo_design.systems import state_space
from tribo_design.zpk import Zpk

H = 1e-3
K = Zpk([-55, -200, -139 + 203j, -139 - 203j], [-0.002, -340.23, -167.14 + 293.43j, -167.14 - 293.43j], 1.48)
OMEGA = np.geomspace(1e-4, 0.999 * np.pi / H, 300)


def z_of(omega):
    return np.exp(1j * omega * H)


def scipy_response(zpk, method, omega=OMEGA):
    """scipy's discretisation of K(s), evaluated at z."""
    a, b, c, d, _ = scipy.signal.cont2discrete(scipy.signal.zpk2ss(zpk.zeros, zpk.poles, zpk.gain), H, method)
    return np.array([(c @ np.linalg.solve(z * np.eye(len(a)) - a, b) + d)[0, 0] for z in z_of(omega)])


@pytest.mark.parametrize("method, scipys", [("tustin", "bilinear"), ("zoh", "zoh")])
def test_discretisation_is_scipys(method, scipys):
    mine = discretise.discretise(K, Discretisation(method=method), H)
    omega = OMEGA[OMEGA > 1]  # below, scipy's z form has lost the slow pole's digits
    assert np.allclose(SampledZpk(mine, H).response(omega), scipy_response(K, scipys, omega), rtol=1e-6)


def test_prewarped_tustin_is_python_controls_and_exact_at_its_frequency():
    w = 300.0
    mine = discretise.discretise(K, Discretisation(method="tustin-prewarped", prewarp_rad_s=w), H)
    # The steady gain is K(s)'s by the rule, the response at w is K(jw) by the prewarping.
    assert np.allclose(SampledZpk(mine, H).response([w]), K([1j * w]), rtol=1e-9)
    k = Zpk([-50.0], [-5.0, -400.0], 3.0)
    theirs = ct.sample_system(ct.zpk(k.zeros, k.poles, k.gain), H, method="bilinear", prewarp_frequency=w)
    mine = discretise.discretise(k, Discretisation(method="tustin-prewarped", prewarp_rad_s=w), H)
    omega = np.geomspace(1, 3000, 50)
    assert np.allclose(SampledZpk(mine, H).response(omega), theirs(z_of(omega)), rtol=1e-6)


def test_matched_maps_roots_by_exp():
    mine = discretise.discretise(K, Discretisation(method="matched"), H)
    assert np.allclose(np.sort_complex(1 + mine.poles), np.sort_complex(np.exp(K.poles * H)), rtol=1e-12)
    assert np.allclose(np.sort_complex(1 + mine.zeros), np.sort_complex(np.exp(K.zeros * H)), rtol=1e-12)
    assert mine.at_zero() == pytest.approx(K.at_zero(), rel=1e-12)


@pytest.mark.parametrize("method", ["tustin", "matched", "zoh"])
def test_an_integrator_keeps_its_velocity_gain(method):
    k = Zpk([-20.0], [0.0], 2.0)  # 2 (s + 20)/s: 40/s at rest
    mine = discretise.discretise(k, Discretisation(method=method), H)
    assert 0 in mine.poles
    omega = np.array([1e-3])
    assert np.abs(SampledZpk(mine, H).response(omega)) == pytest.approx(40 / omega, rel=1e-5)


@pytest.mark.parametrize("method", ["tustin", "matched", "zoh"])
def test_a_zero_at_rest_keeps_its_slope(method):
    k = Zpk([0.0], [-20.0], 3.0)  # 3 s/(s + 20): 0.15 s at rest
    mine = discretise.discretise(k, Discretisation(method=method), H)
    assert np.abs(SampledZpk(mine, H).response([1e-3])) == pytest.approx([0.15e-3], rel=1e-5)


def test_zero_order_hold_without_feedthrough_is_refused():
    with pytest.raises(DesignError, match="feedthrough"):
        discretise.discretise(Zpk([], [-1.0], 1.0), Discretisation(method="zoh"), H)


@pytest.mark.parametrize("delay", [0.0, 0.3e-3, 1e-3, 1.4e-3])
def test_sampled_plant_is_the_continuous_one_seen_through_hold_and_delay(delay):
    """Compares with a time simulation by scipy at 1/100 of the sample time."""
    poles = np.array([-55, -200, -139 + 203j, -139 - 203j])
    plant = Zpk([], poles, 1.0).with_value_at(0, 0.86)
    sampled = SampledPlant(state_space(plant), H, delay)
    u = np.random.default_rng(3).standard_normal(40)
    fine = 100
    late = int(round(delay / H * fine))
    held = np.r_[np.zeros(late), np.repeat(u, fine)][: 40 * fine]
    a, b, c, d, _ = scipy.signal.cont2discrete(scipy.signal.zpk2ss([], poles, plant.gain), H / fine, "zoh")
    y = scipy.signal.dlsim((a, b, c, d, H / fine), held)[1][::fine, 0]
    s = sampled.space
    mine = scipy.signal.dlsim((s.A + np.eye(len(s.A)), s.B, s.C, s.D, H), u)[1][:, 0]
    assert np.allclose(mine, y, rtol=1e-7, atol=1e-9)
    order, value, slope = sampled.near_zero()
    assert order == 0 and value == pytest.approx(0.86, rel=1e-9)
    # The slope in d is -(sum of time constants + delay + hold), from the response just above rest.
    d = 1e-6
    near = (s.C @ np.linalg.solve(d * np.eye(len(s.A)) - s.A, s.B) + s.D)[0, 0]
    assert slope == pytest.approx((near - value) / d, rel=1e-3)


def test_margins_are_python_controls():
    plant, k = Zpk([], [-1, -2, -3], 6.0), Zpk([-1.5], [-0.1, -30.0], 40.0)
    m = Loop(Continuous(plant), Continuous(k)).metrics()
    loop = ct.zpk(plant.zeros, plant.poles, plant.gain) * ct.zpk(k.zeros, k.poles, k.gain)
    gm, pm, _, wpc, wgc, _ = ct.stability_margins(loop)
    assert m.gain_margin == pytest.approx(gm, rel=1e-6)
    assert m.phase_margin_deg == pytest.approx(pm, rel=1e-6)
    assert m.delay_margin_s == pytest.approx(np.radians(pm) / wgc if wgc < wpc else np.radians(pm) / wpc, rel=1e-2)
    sensitivity, complementary = ct.feedback(1, loop), ct.feedback(loop, 1)
    assert m.max_s == pytest.approx(ct.system_norm(sensitivity, "inf"), rel=1e-5)
    assert m.max_t == pytest.approx(ct.system_norm(complementary, "inf"), rel=1e-5)
    assert abs(complementary(1j * m.bandwidth_rad_s)) == pytest.approx(np.sqrt(0.5), rel=1e-6)
    assert np.all(np.abs(complementary(1j * np.linspace(0.001, 0.999, 100) * m.bandwidth_rad_s)) > np.sqrt(0.5))
    assert m.stable


def test_margins_of_a_sampled_loop_are_python_controls():
    h, plant, k = 0.05, Zpk([], [-1, -2, -3], 6.0), Zpk([-0.05, -1.0], [-0.005, -0.5], 0.4)
    loop = Loop(SampledPlant(state_space(plant), h, 0.07), SampledZpk(k, h), h=h)
    parts = [ct.ss(np.asarray(s.A) + np.eye(s.nstates), s.B, s.C, s.D, h) for s in (state_space(k), loop.plant.space)]
    gm, pm, _, _, wgc, _ = ct.stability_margins(ct.series(*parts))
    m = loop.metrics()
    assert m.gain_margin == pytest.approx(gm, rel=1e-6) and m.phase_margin_deg == pytest.approx(pm, rel=1e-6)


def test_an_unstable_loop_is_called_unstable_in_both_times():
    plant = Zpk([], [-1, -2, -3], 6.0)
    assert not Loop(Continuous(plant), Continuous(Zpk([], [], 12.0))).is_stable()  # critical gain 10
    assert Loop(Continuous(plant), Continuous(Zpk([], [], 8.0))).is_stable()
    sampled = SampledPlant(state_space(plant), 0.2)
    a, b, c, d, _ = scipy.signal.cont2discrete(scipy.signal.zpk2ss([], [-1, -2, -3], 6.0), 0.2, "zoh")
    for gain in (2.0, 4.0, 5.0, 6.0, 7.0, 9.0):
        radius = np.abs(np.linalg.eigvals(a - gain * b @ c)).max()
        assert Loop(sampled, SampledZpk(Zpk([], [], gain), 0.2), h=0.2).is_stable() == (radius < 1), gain


def test_the_gain_margin_at_the_nyquist_frequency_counts():
    """First order, sampled: z = a - K b reaches -1 at K = (1 + a)/b, a crossing that no sign change of Im L shows."""
    h = 0.5
    a, b = np.exp(-2 * h), 1 - np.exp(-2 * h)
    loop = Loop(SampledPlant(state_space(Zpk([], [-2.0], 2.0)), h), SampledZpk(Zpk([], [], 0.7), h), h=h)
    assert loop.metrics().gain_margin == pytest.approx((1 + a) / b / 0.7, rel=1e-9)


@pytest.mark.parametrize("h", [None, 0.01])
@pytest.mark.parametrize("k, duration", [(Zpk([-5.0], [0.0], 4.0), 12), (Zpk([-5.0], [-0.01], 4.0), 12), (Zpk([], [], 0.8), 1)])
def test_ramp_error_is_what_a_simulation_shows(h, k, duration):
    plant = Zpk([], [-30.0], 60.0)
    ramp = Ramp(rate_n_per_s=0.5, duration_s=duration)
    if h is None:
        loop = Loop(Continuous(plant), Continuous(k), ramp=ramp)
    else:
        loop = Loop(SampledPlant(state_space(plant), h, 0.003), SampledZpk(discretise.tustin(k, h), h), h=h, ramp=ramp)
    time, r, y, _ = loop.responses(ramp.duration_s + (h or 0), ramp.rate_n_per_s)
    at_end = np.argmin(abs(time - ramp.duration_s))
    assert loop.ramp_error() == pytest.approx((r - y)[at_end], rel=1e-3)


def test_state_space_and_back():
    rng = np.random.default_rng(5)
    for _ in range(30):
        n = int(rng.integers(1, 8))
        poles, zeros = [], []
        for roots, count in ((poles, n), (zeros, int(rng.integers(0, n + 1)))):
            while len(roots) < count:
                size = 10 ** rng.uniform(-2, 4)
                if count - len(roots) > 1 and rng.random() < 0.4:
                    roots += [size * complex(-0.5, 0.866), size * complex(-0.5, -0.866)]
                else:
                    roots.append(-size)
        system = Zpk(zeros, poles, rng.uniform(0.5, 2))
        omega = np.geomspace(1e-3, 1e5, 80)
        space = state_space(system)
        assert space.nstates == n
        assert np.allclose(Continuous(space=space).response(omega), system(1j * omega), rtol=1e-6, atol=1e-12 * np.abs(system(1j * omega)).max())
        assert np.allclose(zpk_of(space)(1j * omega), system(1j * omega), rtol=1e-4, atol=1e-9 * np.abs(system(1j * omega)).max())


def test_modal_reduction_removes_what_is_fast_and_what_cancels():
    full = Zpk([-10.001, -4e5, -77], [-10.0, -1e-2, -500.0, -5e5, -1e9], 1e12)
    found = reduction.candidates(Continuous(full), Reduction(method="modal", cancellation_percent=1), H)
    assert found[0].zpk.order == 2
    assert np.allclose(sorted(found[0].zpk.poles.real), [-500, -0.01])
    assert found[0].zpk.at_zero() == pytest.approx(full.at_zero(), rel=1e-4)
    assert [c.zpk.order for c in found] == sorted(c.zpk.order for c in found)


def test_balanced_reduction_is_balred():
    k = Zpk([-20.0, -21.0], [-1.0, -30.0, -300.0], 50.0)
    found = reduction.candidates(Continuous(k), Reduction(method="balanced", digits=12), H)
    assert [c.zpk.order for c in found] == [1, 2, 3]
    theirs = ct.balred(ct.ss(ct.zpk(k.zeros, k.poles, k.gain)), 2)
    omega = np.geomspace(0.1, 1000, 40)
    assert np.allclose(found[1].zpk(1j * omega), theirs(1j * omega), rtol=1e-6)


# Sections.

def random_controller(rng, order):
    """K(z) in d, biproper, stable, with a slow pole."""
    roots = []
    for count, slow in ((order, True), (order, False)):
        out = [complex(-2e-6)] if slow else []
        while len(out) < count:
            if count - len(out) > 1 and rng.random() < 0.5:
                p = rng.uniform(0.2, 0.95) * np.exp(1j * rng.uniform(0.1, 2.5)) - 1
                out += [p, np.conj(p)]
            else:
                out.append(complex(rng.uniform(0.1, 0.95) - 1))
        roots.append(out)
    return Zpk(roots[1], roots[0], rng.uniform(0.5, 3))


@pytest.mark.parametrize("order", range(1, 9))
def test_sections_multiply_up_to_the_controller(order):
    rng = np.random.default_rng(order)
    system = random_controller(rng, order)
    cascade = sections.make_cascade(system, H)
    assert len(cascade.sections) == (order + 1) // 2
    mine = SampledSections(cascade.sections, H)
    assert np.allclose(mine.response(OMEGA), SampledZpk(system, H).response(OMEGA), rtol=1e-9)
    # The library's terms, and the slow pole last.
    for b0, b1, b2, a1, a2 in cascade.sections:
        assert 0 <= a2 < a1 and 4 - 2 * a1 + a2 > 0 and abs(b0) >= 1e-6
    if order > 1:
        slowest = [min(abs(np.roots([1, a1, a2]))) for _, _, _, a1, a2 in cascade.sections]
        assert np.argmin(slowest) == len(slowest) - 1


def test_a_pure_gain_is_one_section():
    cascade = sections.make_cascade(Zpk([], [], 3.0), H)
    assert len(cascade.sections) == 1
    assert np.allclose(SampledSections(cascade.sections, H).response(OMEGA), 3.0, rtol=1e-12)
    quantise.to_q31(quantise.to_f32(cascade.sections), 2.0, -2.0, 2.0)


@pytest.mark.parametrize("order", [3, 4, 6, 8])
def test_earlier_sections_have_gain_1_at_rest_and_known_peaks(order):
    """The worst input within 1 for a section is the sign of its impulse response, reversed."""
    cascade = sections.make_cascade(random_controller(np.random.default_rng(40 + order), order), H)
    sos = sections.to_z(cascade.sections)
    for i in range(len(sos) - 1):
        b2, a2 = cascade.sections[i][[2, 4]]
        assert abs(b2 / a2) == pytest.approx(1, rel=1e-12)
        impulse = scipy.signal.sosfilt(sos[: i + 1], np.r_[1, np.zeros(4000)])
        peak = np.abs(scipy.signal.sosfilt(sos[: i + 1], np.sign(impulse[::-1]))).max()
        assert peak == pytest.approx(cascade.peaks[i], rel=1e-6)
        assert peak <= 2.0 ** sections.node_scale(cascade.peaks[i]) < 2 * max(peak, 1) + 1e-9


@pytest.mark.parametrize("scales", [[0, 0], [3, 1]])
def test_stated_noise_is_what_rounding_makes(scales):
    system = Zpk([-0.05, -0.18, -0.147 + 0.176j, -0.147 - 0.176j], [-0.01, -0.29, -0.187 + 0.245j, -0.187 - 0.245j], 1.5)
    cascade = sections.make_cascade(system, H)
    rng = np.random.default_rng(1)
    lsb = 1e-6
    x = rng.uniform(-0.3, 0.3, 40000)

    def filtered(x, rounded):
        w = np.zeros((len(cascade.sections), 2))
        out = np.empty(len(x))
        for k, v in enumerate(x):
            for i, (b0, b1, b2, a1, a2) in enumerate(cascade.sections):
                y = b0 * v + w[i, 0]
                grain = lsb * 2 ** scales[i]
                y = np.round(y / grain) * grain if rounded else y
                w[i] = w[i, 0] + b1 * v - a1 * y + w[i, 1], w[i, 1] + b2 * v - a2 * y
                v = y
            out[k] = v
        return out

    noise = np.std(filtered(x, True) - filtered(x, False)) / lsb
    assert noise == pytest.approx(sections.rounding_noise(cascade.sections, scales), rel=0.1)


def test_no_other_grouping_is_less_noisy():
    import itertools

    system = random_controller(np.random.default_rng(9), 4)
    best = sections.make_cascade(system, H)
    least = sections.rounding_noise(best.sections, [sections.node_scale(best.peaks[0]), 0])
    tried = 0
    for poles, zeros in sections._groupings(system):
        for order in itertools.permutations(range(2)):
            if min(abs(p) for p in poles[order[-1]]) > 1e-5:
                continue
            rows, peaks = sections._unit_gains(np.array([sections._section(zeros[i], poles[i]) for i in order]), system)
            assert sections.rounding_noise(rows, [sections.node_scale(peaks[0]), 0]) >= least * 0.999
            tried += 1
    assert tried == best.tried > 1


@pytest.mark.parametrize("system, words", [
    (Zpk([-0.1], [0.1], 1.0), "unstable"), (Zpk([-0.1], [-2.5], 1.0), "unstable"), (Zpk([-0.1, -0.2], [0, 0], 1.0), "one integrator"),
    (Zpk([], [-0.1], 1.0), "feedthrough"), (Zpk([-0.1], [-0.2], 1e8), "1e\\+06"), (Zpk([-0.1] * 9, [-0.2] * 9, 1.0), "order 9")])
def test_what_the_library_would_refuse_is_refused(system, words):
    with pytest.raises(DesignError, match=words):
        sections.make_cascade(system, H)


# Quantisation.

def test_q31_is_within_its_quantum_of_f32_and_keeps_slow_poles():
    for order in (1, 2, 4, 6, 8):
        cascade = sections.make_cascade(random_controller(np.random.default_rng(70 + order), order), H)
        f32 = quantise.to_f32(cascade.sections)
        q31 = quantise.to_q31(f32, 2.0, -2.0, 2.0).q31
        values = q31.values()
        before = q31.input_scale
        for row, wanted, s in zip(values, f32, q31.sections):
            by = 2.0 ** (s["scale"] - before)
            quanta = [by * 2.0**-28, by * 2.0**-28, by * 2.0 ** (-28 - s["shift"]), 2.0**-28, 2.0 ** (-60 - s["shift"])]
            assert np.all(np.abs(row - wanted) <= 0.501 * np.array(quanta))
            before = s["scale"]
        slow = np.abs(SampledSections(values, H).poles()).min()
        assert slow == pytest.approx(2e-6 / H, rel=1e-5)


def test_the_librarys_refusal_is_passed_on_in_its_words():
    for row, words in (([1.0, 0.5, 0.01, 0.3, -0.1], "unit circle"), ([0.0, 0.5, 0.01, 0.3, 0.1], "b0"), ([2e6, 0.5, 0.01, 0.3, 0.1], "1e6")):
        with pytest.raises(DesignError, match=f"library refuses.*{words}"):
            quantise.to_q31([row], 2.0, -2.0, 2.0)


def test_conditioning_is_1_with_zeros_inside_and_not_with_a_zero_at_minus_1():
    inside = quantise.to_q31([[1.5, 0.5, 0.05, 0.3, 0.01]], 2.0, -2.0, 2.0)
    assert inside.conditioning == pytest.approx(1, rel=1e-6)
    on = quantise.to_q31([[1.0, 2.0, 0.0, 0.3, 0.01]], 2.0, -2.0, 2.0)
    assert abs(on.conditioning) <= 1 and on.conditioning != pytest.approx(1)


def test_f32_is_numpys_rounding():
    row = [[1 / 3, -2.7e-7, 1e6, 0.1, 5.81535546e-07]]
    assert np.array_equal(quantise.to_f32(row)[0], np.float32(row[0]).astype(float))
