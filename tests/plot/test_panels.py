"""What is read and what is put into a picture, before anything draws it."""

import math
import re

import pytest
from conftest import ROOT

from tribo_plot import look, panels
from tribo_plot.cli import best_first
from tribo_plot.runs import PlotError, Run, is_there, read, read_all, read_summary


def made(*paths):
    return {panel.title: panel for panel in panels.make(read_all(list(paths)))}


def names(panel):
    return [line.name for line in panel.lines]


def test_a_run_has_force_error_command_friction_and_what_was_learned(runs):
    shown = made(runs / "feedforward")
    assert list(shown) == ["Force", "Error r − F", "Command u and its parts", "Breakaway L, learned", "Friction against net force",
                           "Hysteresis: net force less friction"]
    assert names(shown["Force"]) == ["measured y", "force F", "reference r"]
    assert names(shown["Command u and its parts"]) == ["the compensation's part", "controller's part", "command u"]
    learned = shown["Breakaway L, learned"].lines[0]
    first, last = learned.high[0] - learned.low[0], learned.high[-1] - learned.low[-1]
    assert first == pytest.approx(0.8 * learned.y[0]) and last < 0.7 * first
    assert "Relays" in made(runs / "paper")


def test_a_loop_is_force_error_and_command_unless_all_is_asked_for(runs, tmp_path):
    assert [panel.title for panel in panels.make(read_all([runs / "feedforward"]), False)] == ["Force", "Error r − F", "Command u"]
    assert names(panels.make(read_all([runs / "feedforward"]), False)[2]) == ["command u"]
    drive = panels.make(read_all([runs / "drive.csv"]), False)
    assert [panel.title for panel in drive] == ["Force", "Error r − F", "Command u", "State and fault, by their numbers", "Ticks"]
    assert [panel.title for panel in panels.make(read_all([runs / "replay.csv"]), False)] == list(made(runs / "replay.csv"))


def test_the_best_run_is_the_strong_line(runs):
    paths = [runs / "off", runs / "feedforward", runs / "paper"]
    assert [run.name for run in best_first(read_all(paths))] == ["feedforward", "paper", "off"]
    assert [run.name for run in best_first(read_all([*paths, runs / "drive.csv"]))][:3] == ["off", "feedforward", "paper"]
    part, _end, _width, dashes, order = look.RUNS[0]
    assert part == 0 and dashes is None and order > look.RUNS[1][4]


def test_the_error_is_r_less_F_in_mN(runs):
    run = made(runs / "off")["Error r − F"]
    columns = read(runs / "off").columns
    assert run.y_label == "mN"
    assert run.lines[0].y[3000] == pytest.approx(1e3 * (columns["r_N"][3000] - columns["F_N"][3000]))


def test_a_replay_a_log_and_a_trace_show_what_they_have(runs, tmp_path):
    replay = made(runs / "replay.csv")
    assert names(replay["Force"])[:2] == ["force F", "F of the model"]
    assert {"What is left: n − f", "Net force and L, over F", "Friction against net force"} <= set(replay)
    drive = made(runs / "drive.csv")
    assert list(drive) == ["Force", "Error r − F", "Command u and its parts", "State and fault, by their numbers", "Ticks"]
    trace = tmp_path / "trace_of_a_fault.csv"
    trace.write_text("t_s,r_N,F_N,u_N,F_hat_N\n0,0.1,0.1,0.2,0.1\n0.001,0.1,0.1,0.2,0.1\n", encoding="ascii")
    assert list(made(trace)) == ["Force", "Error r − F", "Command u and its parts"]


def test_runs_on_top_of_each_other_share_the_reference_and_have_names_of_their_own(runs):
    both = made(runs / "off", runs / "feedforward")
    assert names(both["Force"]).count("reference r") == 1
    assert [line.run for line in both["Error r − F"].lines] == [0, 1]
    (same := runs / "same" / "off").mkdir(parents=True, exist_ok=True)
    (same / "trace.csv").write_bytes((runs / "off/trace.csv").read_bytes())
    assert [run.name for run in read_all([runs / "off", same])] == [f"{runs.name}/off", "same/off"]


def run_of(values, step_s=0.01):
    count = len(values)
    return Run("a", {"t_s": [step_s * i for i in range(count)], "r_N": [0.0] * count, "F_N": values, "u_N": [0.1] * count})


def test_a_start_that_would_flatten_the_rest_is_left_outside_and_said():
    wave = [0.001 * math.sin(i / 50) for i in range(1000)]
    panel = next(panel for panel in panels.make([run_of([-0.4] * 5 + wave)]) if panel.title.startswith("Error"))
    assert panel.y_range == pytest.approx((-1.2, 1.2), rel=0.01)
    assert panel.note == "the start goes to 400"
    late = next(panel for panel in panels.make([run_of(wave + [-0.4] * 5)]) if panel.title.startswith("Error"))
    assert late.y_range is None and not late.note


def test_thinning_keeps_every_peak():
    y = [0.0] * 100_000
    y[51_234], y[51_300] = 7.0, -3.0
    x, thinned = panels.thin(panels.Line("a", "#000000", list(range(100_000)), y), 500)
    assert len(x) == len(thinned) <= 2000
    assert (51_234, 7.0) in zip(x, thinned) and (51_300, -3.0) in zip(x, thinned)


def test_segments_are_not_joined():
    run = run_of([0.1] * 10)
    run.columns["segment"] = [0.0] * 4 + [1.0] * 6
    line = panels.make([run])[0].lines[0]
    assert math.isnan(line.y[4]) and len(line.y) == 11


@pytest.mark.parametrize(
    "text, message",
    [("a,b\n1,2\n", "a header with t_s and signals"), ("t_s,F_N\n", "has no rows"), ("t_s,F_N\n0,1\n# a comment\n0.1,x\n", "a.csv:4: F_N: 'x' is not a number"),
     ("t_s,F_N\n0\n", "a.csv:2: 1 fields, the header has 2"), ("t_s,F_N\n0,1,7\n", "a.csv:2: 3 fields, the header has 2"), ("", "a.csv: is empty"), ("\n \n", "a.csv: a header"),
     ("t_s,F_N\n0,1e308\n", "a.csv:2: F_N: 1e308 is outside -1e+30 to 1e+30"), ("t_s,F_N\n0,-inf\n", "a.csv:2: F_N: -inf is outside"), ("t_s,F_N\n0,1_0\n", "a.csv:2: F_N: '1_0' is not a number"),
     ("t_s,F_N\n0,\x1b[2J\n", r"a.csv:2: F_N: '\x1b[2J' is not a number"), ("t_s,F_N\nnan,1\n", "a.csv:2: t_s: is not a finite number"), ("t_s,F_N\n0,1\n,1\n", "a.csv:3: t_s: is not a finite number"),
     ("t_s,F_N\n0,1\n1,1\n0.5,1\n", "a.csv:4: t_s: 0.5 does not come after 1"), ("t_s,F_N,F_N\n0,1,1\n", "a.csv:1: column F_N appears twice"), (b"\xff\xfet\0", "a.csv: not UTF-8 text (byte 0); save it as UTF-8"),
     ("t_s,F_N\n0,0.5\n1,0.", "the file ends in the middle of the number '0.'"),
     ("t_s,F_N\n" + "0,0.500\n" * 20 + "1,0.5", "the file ends in the middle of the number '0.5'"),
     ("t_s,F_N\n" + "0,1.5e-03\n" * 20 + "1,1.5e-0", "the file ends in the middle of the number '1.5e-0'")],
)
def test_what_cannot_be_read_is_named(tmp_path, text, message):
    (tmp_path / "a.csv").write_bytes(text if isinstance(text, bytes) else text.encode())
    with pytest.raises(PlotError, match=re.escape(message)):
        read(tmp_path / "a.csv")


def test_a_byte_order_mark_is_no_part_of_a_name(tmp_path):
    (tmp_path / "trace.csv").write_text("\ufefft_s,F_N\r\n0,0.5\r\n1,\r\n", encoding="utf-8")
    assert read(tmp_path).columns["F_N"][0] == 0.5
    for summary in ('{"rms_error_N": "x"}', "[]", "{"):
        (tmp_path / "summary.json").write_text(summary, encoding="utf-8")
        with pytest.raises(PlotError, match="summary.json: not as tribo-sim wrote it"):
            read(tmp_path)


@pytest.mark.parametrize("end", ["0.5\n", "0.500"])
def test_a_last_row_that_is_whole_is_read(tmp_path, end):
    (tmp_path / "a.csv").write_text("t_s,F_N\n" + "0,0.500\n" * 20 + f"1,{end}", encoding="utf-8")
    (tmp_path / "b.csv").write_text("t_s,F_N\n0,0.125\n1,0.5", encoding="utf-8")
    assert read(tmp_path / "a.csv").columns["F_N"][20] == 0.5 and read(tmp_path / "b.csv").columns["F_N"][1] == 0.5


def test_a_folder_without_a_run_is_named(tmp_path):
    with pytest.raises(PlotError, match="neither the trace.csv of a run nor the rows.parquet"):
        read(tmp_path)


def test_all_colours_of_all_reports_are_in_one_table():
    sources = [path for path in (ROOT / "tools").rglob("*") if path.suffix in (".py", ".js") and ".venv" not in path.parts]
    assert len(sources) > 40
    others = [path.name for path in sources if re.search(r"['\"]#[0-9A-Fa-f]{6}['\"]", path.read_text(encoding="utf-8"))]
    assert others == ["look.py"]
    assert len({colour for _, colour in look.SIGNALS.values()}) > 12
    assert look.shade("#0072B2", 0) == "#0072B2" and len({look.shade("#0072B2", run) for run in range(4)}) == 4


@pytest.mark.parametrize("text", ["", "{", "[]", "7", "\x00"])
def test_a_summary_that_is_garbage_is_no_absent_one(tmp_path, text):
    (tmp_path / "summary.json").write_text(text)
    with pytest.raises(PlotError, match="summary.json: not as tribo-sim wrote it"):
        read_summary(tmp_path / "summary.json")


def test_what_cannot_be_looked_at_is_not_absent(tmp_path):
    assert read_summary(tmp_path / "summary.json") == {}
    (tmp_path / "summary.json").symlink_to("summary.json")
    with pytest.raises(PlotError, match="summary.json: Too many levels of symbolic links"):
        read_summary(tmp_path / "summary.json")
    with pytest.raises(PlotError, match="File name too long"):
        is_there(tmp_path / ("x" * 300))


def test_a_sweep_that_is_garbage_is_no_absent_one(tmp_path):
    for module in ("pandas", "pyarrow", "matplotlib"):
        pytest.importorskip(module)
    from tribo_plot.sweeps import Sweep

    with pytest.raises(PlotError, match="rows.parquet: there is none"):
        Sweep.read(tmp_path / "rows.parquet")
    (tmp_path / "rows.parquet").write_text("garbage")
    with pytest.raises(PlotError, match="rows.parquet: cannot be read: "):
        Sweep.read(tmp_path / "rows.parquet")
