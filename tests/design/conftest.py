import os
from pathlib import Path

os.environ.setdefault("OMP_NUM_THREADS", "1")
os.environ.pop("TRIBO_DESIGN_DEBUG", None)

import pytest
import ruamel.yaml

from tribo_design.cli import main

ROOT = Path(__file__).resolve().parents[2]
PAPER = ROOT / "designs" / "paper.yaml"


@pytest.fixture(scope="session")
def paper_dir(tmp_path_factory):
    """The paper's case, made once through the command line, without plots."""
    out = tmp_path_factory.mktemp("paper") / "out"
    assert main(["synthesize", str(PAPER), "--out", str(out), "--no-plots"]) == 0
    return out


@pytest.fixture(scope="session")
def paper_result():
    from tribo_design.config import load_design
    from tribo_design.pipeline import synthesize

    return synthesize(*load_design(PAPER), PAPER.name)


@pytest.fixture
def paper_data():
    """The paper's design as plain data, to be spoiled."""
    return ruamel.yaml.YAML(typ="safe").load(PAPER.read_text())


@pytest.fixture
def run(capsys):
    """Runs the command line: (exit code, stdout, stderr). Fails on a traceback or an internal error."""

    def call(*arguments):
        capsys.readouterr()
        try:
            code = main([str(a) for a in arguments])
        except SystemExit as stop:  # argparse
            code = stop.code
        out, err = capsys.readouterr()
        assert "Traceback" not in out + err
        assert "internal error" not in err, err
        return code, out, err

    return call
