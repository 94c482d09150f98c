"""examples/bare in QEMU, from the reset vector."""

import pytest

from conftest import RMS_MAX_UN, make, rms_un


CORES = ["m4f", "m0plus"]


@pytest.fixture(scope="module", name="build")
def _build(tmp_path_factory):
    return tmp_path_factory.mktemp("bare")


@pytest.mark.parametrize("core", CORES)
def test_the_loop_follows_against_friction(core, build):
    out = make("bare", build, f"run-{core}")
    assert rms_un(out) < RMS_MAX_UN
    assert "off" not in out


@pytest.mark.parametrize("core", CORES)
def test_the_board_is_off_without_its_sensor(core, build):
    out = make("bare", build, "--what-if=simulated_board.c", f"run-{core}", "EXTRA=-DSENSOR_DIES_AT=5000", status=1)
    assert out.startswith("off\n")
    assert rms_un(out) > RMS_MAX_UN
