"""examples/simplefoc against its stand-in; for a microcontroller it is compiled by test_arm.py."""

from conftest import RMS_MAX_UN, make, rms_un


def test_the_sketch_follows_against_friction_until_a_tick_is_missed(tmp_path):
    out = make("simplefoc", tmp_path, "run")
    assert rms_un(out) < RMS_MAX_UN
    assert "enabled 1" in out
    out = make("simplefoc", tmp_path, "run", "STALL=1")
    assert rms_un(out) > 100 * RMS_MAX_UN
    assert "enabled 0" in out
