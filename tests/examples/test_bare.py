"""examples/bare in QEMU, from the reset vector."""

import pytest

from conftest import RMS_MAX_UN, make, rms_un


@pytest.mark.parametrize("core", ["m4f", "m0plus"])
def test_the_loop_follows_against_friction(core, tmp_path):
    out = make("bare", tmp_path, f"run-{core}")
    assert rms_un(out) < RMS_MAX_UN
    assert "off" not in out


@pytest.mark.parametrize("core", ["m4f", "m0plus"])
def test_the_board_is_off_without_its_sensor(core, tmp_path):
    out = make("bare", tmp_path, f"run-{core}", "EXTRA=-DSENSOR_DIES_AT=5000", status=1)
    assert out.startswith("off\n")
    assert rms_un(out) > RMS_MAX_UN
