"""The notebooks of python/notebooks, executed cell by cell: what they print is what they show.

    .venv/bin/python tests/python/test_notebooks.py      writes what they print, and their pictures, into them
"""

import base64
import contextlib
import io
import json
import pathlib
import re
import sys

import matplotlib
import pytest

matplotlib.use("agg")

from matplotlib import pyplot  # noqa: E402

FOLDER = pathlib.Path(__file__).resolve().parents[2] / "python" / "notebooks"
NOTEBOOKS = sorted(FOLDER.glob("*.ipynb"))


def executed(notebook):
    """Of each code cell, what it printed, and its pictures."""
    names = {"__name__": "__main__"}
    for number, cell in enumerate(notebook["cells"]):
        if cell["cell_type"] == "code":
            said = io.StringIO()
            with contextlib.redirect_stdout(said):
                exec(compile("".join(cell["source"]), f"cell {number}", "exec"), names)
            yield cell, said.getvalue(), [pyplot.figure(number) for number in pyplot.get_fignums()]
            pyplot.close("all")


def shown(cell):
    return "".join(line for output in cell["outputs"] if output["output_type"] == "stream" for line in output["text"])


@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: path.stem)
def test_a_notebook_prints_what_it_shows(path, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    for cell, said, figures in executed(json.loads(path.read_text())):
        said = re.sub(r"^tribo-\w+: \d+ s: at work\n", "", said, flags=re.M)  # the time that a slow machine takes
        assert said == shown(cell), "".join(cell["source"])
        assert len(figures) == sum(output["output_type"] == "display_data" for output in cell["outputs"])


def test_the_notebooks_are_there():
    assert [path.stem for path in NOTEBOOKS] == ["mujoco_joint", "mujoco_teleop", "paper_in_ten_minutes", "rig_from_log_to_header"]


def test_a_joint_in_mujoco_takes_twenty_lines():
    cells = json.loads((FOLDER / "mujoco_teleop.ipynb").read_text())["cells"]
    assert sum(line.strip() != "" for cell in cells if cell["cell_type"] == "code" for line in cell["source"]) <= 20


def png(figure):
    buffer = io.BytesIO()
    figure.savefig(buffer, format="png", dpi=70, metadata={"Software": None})
    return base64.b64encode(buffer.getvalue()).decode()


def main():
    import os
    import tempfile

    for path in NOTEBOOKS:
        notebook = json.loads(path.read_text())
        with tempfile.TemporaryDirectory() as folder:
            os.chdir(folder)
            for cell, said, figures in executed(notebook):
                texts = [{"output_type": "stream", "name": "stdout", "text": said.splitlines(keepends=True)}] if said else []
                cell["outputs"] = texts + [{"output_type": "display_data", "metadata": {}, "data": {"image/png": png(figure)}} for figure in figures]
        path.write_text(json.dumps(notebook, indent=1, ensure_ascii=False) + "\n")
        print(f"{path.name}: {sum(len(cell.get('outputs', [])) for cell in notebook['cells'])} outputs", file=sys.stderr)


if __name__ == "__main__":
    main()
