"""The firmware's loop on the emulated target computes the host's, to the last bit."""

import json

import pytest

# Of triangle, from rest and with both turns; in asymmetric everything differs by direction, there is noise, and the command
# reaches its limits. What the guards find:
GUARDS = {"guarded": "hunting", "guarded feedforward": "overshoot", "without a sensor": None}
SCENARIOS = {
    "feedforward": ["asymmetric", "--set", "duration_s=5", "--set", "reference.period_s=1.6", "--set", "metrics.start_s=0",
                    "--set", "sensor.noise_N=0.001", "--set", "compensator.method=feedforward"],
    "guarded": ["triangle", "--set", "compensator.method=paper", "--set", "duration_s=5", "--set", "reference.period_s=2", "--set", "metrics.start_s=0", "--set",
                "plant.friction.breakaway.offset_N=0.0035", "--set", "plant.friction.breakaway.slope=0.15", "--set",
                "compensator.gain=1", "--set", "compensator.guard.on=yes"],
    "guarded feedforward": ["triangle", "--set", "duration_s=5", "--set", "reference.period_s=0.4", "--set", "metrics.start_s=0",
                            "--set", "compensator.method=feedforward", "--set", "compensator.friction.breakaway.slope=1.5",
                            "--set", "plant.friction.breakaway={offset_N: 0.002, slope: 0.02}",
                            "--set", "compensator.feedforward.trust=1", "--set",
                            "compensator.guard={on: yes, stray_N: 0.001}"],
    "without a sensor": ["asymmetric", "--set", "duration_s=5", "--set", "reference.period_s=2", "--set", "metrics.start_s=0",
                         "--set", "sensor.noise_N=0.001", "--set", "compensator.sensor=none"],
    "triangle": ["triangle", "--set", "compensator.method=paper", "--set", "duration_s=5", "--set", "reference.period_s=2", "--set", "metrics.start_s=0"],
    "asymmetric": ["asymmetric", "--set", "compensator.method=paper", "--set", "duration_s=5", "--set", "reference.period_s=2", "--set", "metrics.start_s=0",
                   "--set", "sensor.noise_N=0.001", "--set", "limits.u_max_N=0.7"],
}


@pytest.mark.parametrize("arithmetic", ["f32", "q31"])
@pytest.mark.parametrize("scenario", SCENARIOS)
def test_target_computes_the_bits_of_the_host_and_its_trace_is_that_of_a_run_there(sim, target, scenario, arithmetic):
    out = sim.ok(*SCENARIOS[scenario], "--target", target, "--arith", arithmetic, "--json", "--out", "on_target")
    summary = json.loads(out)
    print(f"{target} {arithmetic} {scenario}: {summary['lock_step_ticks_per_s']:.0f} ticks a second")
    assert (summary["target"], summary["arithmetic"]) == (target, arithmetic)
    assert summary["ticks"] == 5000
    assert summary["different_ticks"] == 0
    assert summary["bad_inputs"] == 0
    assert (summary["limited_ticks"] > 0) == (scenario == "asymmetric")
    assert summary.get("guard") == GUARDS.get(scenario, "none")
    assert json.loads((sim.folder / "on_target" / "summary.json").read_text()) == summary
    sim.ok(*SCENARIOS[scenario], "--arith", arithmetic, "--out", "on_host")
    assert (sim.folder / "on_target" / "trace.csv").read_bytes() == (sim.folder / "on_host" / "trace.csv").read_bytes()


def test_a_breakaway_table_and_other_sections_reach_the_target(sim, target):
    scenario = sim.folder / "table.yaml"
    scenario.write_text("duration_s: 1\n"
                        "reference: {kind: sine, low_N: 0.2, high_N: 0.6, period_s: 0.5}\n"
                        "controller: {kind: delta, sections: [{b0: 2.0, b1: 1.5, b2: 0.3, a1: 0.9, a2: 0.05}]}\n"
                        "compensator: {gain: 0.7, friction: {breakaway: {table: ["
                        "{force_N: 0.1, positive_N: 0.03, negative_N: 0.05}, {force_N: 0.3, positive_N: 0.1, negative_N: 0.08},"
                        "{force_N: 0.5, positive_N: 0.2, negative_N: 0.12}]}}}\n")
    for arithmetic in ["f32", "q31"]:
        assert "the same bits as the host" in sim.ok(scenario, "--target", target, "--arith", arithmetic)
