"""What runs on the host against a stand-in; for a microcontroller the sketch of SimpleFOC is compiled by test_arm.py."""

from conftest import RMS_MAX_UN, make, rms_un


def test_simplefocs_sketch_follows_against_friction_until_a_tick_is_missed(tmp_path):
    out = make("simplefoc", tmp_path, "run")
    assert rms_un(out) < RMS_MAX_UN
    assert "enabled 1" in out
    out = make("simplefoc", tmp_path, "run", "STALL=1")
    assert rms_un(out) > 100 * RMS_MAX_UN
    assert "enabled 0" in out


def test_the_loop_for_moteus_in_cpp_follows_and_stops_with_a_fault(tmp_path):
    assert rms_un(make("moteus", tmp_path, "run")) < RMS_MAX_UN
    make("moteus", tmp_path, "force")
    assert (tmp_path / "force").exists()
