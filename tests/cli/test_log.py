"""Logs as they come: names, units, separators, stamps, several files; and what `replay` says of the params."""

import math
import os
import random
import re

import pytest

from conftest import numbers, read_csv

GOOD = "t_s,u_N,F_N\n0,0.1,0.01\n0.001,0.2,0.02\n0.002,0.3,0.03\n"

WAYS = {
    "names": (GOOD.replace("t_s,u_N,F_N", "time,torque cmd,\"force, measured\""),
              ["--column", "t=time", "--column", "u=torque cmd", "--column", "F=force, measured"]),
    "numbers of columns": (GOOD, ["--column", "t=#1", "--column", "u=#2", "--column", "F=#3"]),
    "no header": (GOOD.split("\n", 1)[1], ["--column", "t=#1", "--column", "u=#2", "--column", "F=#3"]),
    "semicolons": (GOOD.replace(",", ";"), []),
    "decimal commas": (GOOD.replace(",", ";").replace(".", ","), []),
    "decimal commas, no header": (GOOD.split("\n", 1)[1].replace(",", ";").replace(".", ","),
                                  ["--column", "t=#1", "--column", "u=#2", "--column", "F=#3"]),
    "tabs": (GOOD.replace(",", "\t"), []),
    "blanks": ("# " + GOOD.replace(",", "  "), []),
    "comments": ("# of the rig\n#, made today\n" + GOOD, []),
    "comments before a header that is one": ("# of the rig\n# " + GOOD, []),
    "indented blanks": (GOOD.replace(",", "   ").replace("\n0", "\n   0").replace("\n", " \n"), []),
    "Windows": (GOOD.replace("\n", "\r\n"), []),
    "milliseconds and millinewton": ("t_s,u_N,F_N\n0,100,10\n1,200,20\n2,300,30\n",
                                     ["--unit", "t=ms", "--unit", "u=mN", "--unit", "F=mN"]),
    "torque": ("t_s,u_N,F_N\n0,0.02,0.01\n0.001,0.04,0.02\n0.002,0.06,0.03\n", ["--unit", "u=N m", "--scale", "u=5"]),
    "sign": ("t_s,u_N,F_N\n0,-0.1,0.01\n0.001,-0.2,0.02\n0.002,-0.3,0.03\n", ["--scale", "u=-"]),
    "scale and bias": ("t_s,u_N,F_N\n0,0.3,0.01\n0.001,0.5,0.02\n0.002,0.7,0.03\n", ["--scale", "u=0.5", "--bias", "u=-0.05"]),
    "sensor under its own name": (GOOD.replace("F_N", "y_N"), []),
    "Excel's separator": ("sep=;\r\n" + GOOD.replace(",", ";").replace(".", ",").replace("\n", "\r\n"), []),
    "Excel's separator in quotes": ('"sep=\t"\n' + GOOD.replace(",", "\t"), []),
    "quoted decimal commas": ("t_s,u_N,F_N\n" + "".join(",".join(f'"{x}"'.replace(".", ",") for x in line.split(",")) + "\n" for line in GOOD.split("\n")[1:4]), []),
    "a byte order mark": ("\ufeff" + GOOD, []),
    "a byte order mark before Excel's separator": ("\ufeffsep=;\n" + GOOD.replace(",", ";"), []),
    "returns alone": (GOOD.replace("\n", "\r"), []),
    "units": (GOOD.replace("\n", "\ns,N,N\n", 1), []),
    "units in brackets and an empty line": (GOOD.replace("\n", "\n(s),(N),(N)\n\n", 1), []),
    "the unit is said, whatever is written": (GOOD.replace("\n", "\ns,N,mN\n", 1), ["--unit", "F=N"]),
    "the unit is said as it is written": ("t_s,u_N,F_N\nms,N,[mN]\n0,0.1,10\n1,0.2,20\n2,0.3,30\n", ["--unit", "t=ms", "--unit", "F=mN"]),
    "units behind the names": (GOOD.replace("t_s,u_N,F_N", "t [s],cmd (N),F [counts]"), ["--column", "t=t [s]", "--column", "u=cmd (N)", "--column", "F=F [counts]"]),
    "units and types": (GOOD.replace("\n", "\ns,N,N\ndouble,double,double\n", 1), []),
    "a preamble": ("Recorder 5.1\nDate;2024-05-01\nSampling rate;1000;Hz\n\nChannels;3\n" + GOOD.replace(",", ";"), []),
    "a preamble with words of the header": ("Channels: t_s, u_N, F_N\nu_N,drive\n" + GOOD, []),
    "a preamble of numbers": ("3,1000\n1.5,2\n" + GOOD, []),
    "a preamble above numbers of columns": ("Recorder 5.1\nRate,1000\n\n" + GOOD, ["--column", "t=#1", "--column", "u=#2", "--column", "F=#3"]),
    "a preamble above no header": ("Recorder 5.1\nRate 1000\n" + GOOD.split("\n", 1)[1], ["--column", "t=#1", "--column", "u=#2", "--column", "F=#3"]),
    "LabVIEW, whose rows have no comment": ("LabVIEW Measurement\t\nSeparator\tTab\n***End_of_Header***\t\nt_s\tu_N\tF_N\tComment\n" + GOOD.split("\n", 1)[1].replace(",", "\t"), []),
    "a comment at the end": (GOOD + "# stopped by the user\n", []),
    "words at the end": (GOOD + "\nEnd of recording\nRows,three\n", []),
    "comments among the rows": (GOOD.replace("\n0.001", "\n% marker\n// another\n\n0.001"), []),
    "separators at the ends": (GOOD.replace("\n", ",\n"), []),
    "separators at the ends of rows": (GOOD.replace("\n0", "@0").replace("\n", ",\n").replace("@", ",\n").replace("F_N,", "F_N"), []),
    "words in a column": (GOOD.replace("u_N,", "u_N,state,").replace("0.1,", "0.1,RUN,").replace("0.2,", "0.2,RUN,").replace("0.3,", "0.3,STOP,"), []),
    "names of UTF-8": (GOOD.replace("F_N", "Kraft µN ü"), ["--column", "F=Kraft µN ü"]),
    "a quote in a name": (GOOD.replace("F_N", '"F ""load"""'), ["--column", 'F=F "load"']),
    "numbers with signs and powers": ("t_s;u_N;F_N\n+0;+1,0E-1;1e-2\n1e-3;2E-1;0,2e-1\n2.0e-3;0.3;3.0E-2\n", []),
}


@pytest.mark.parametrize("way", WAYS)
def test_a_log_is_read_as_it_comes(sim, way):
    content, options = WAYS[way]
    sim.write("log.csv", content)
    sim.ok("log", "log.csv", *options, "--out", "clean.csv")
    clean = read_csv(sim.folder / "clean.csv")
    assert list(clean) == ["t_s", "u_N", "F_N", "segment"]
    assert clean["t_s"] == pytest.approx([0, 0.001, 0.002], abs=1e-15)
    assert clean["u_N"] == pytest.approx([0.1, 0.2, 0.3], rel=1e-8)
    assert clean["F_N"] == pytest.approx([0.01, 0.02, 0.03], rel=1e-8)
    assert clean["segment"] == (0, 0, 0)


def test_the_true_force_goes_before_the_sensors(sim):
    sim.write("log.csv", "t_s,u_N,y_N,F_N\n0,0,1,2\n0.001,0,1,2\n")
    assert sim.ok("log", "log.csv").splitlines()[1] == "0,0,2,0"
    assert sim.ok("log", "log.csv", "--column", "F=y_N").splitlines()[1] == "0,0,1,0"


def test_position_and_speed_are_read(sim):
    sim.write("log.csv", "t_s,u_N,pos,w_deg_per_s\n0,0,1,3\n0.001,0,2,4\n")
    assert sim.ok("log", "log.csv", "--column", "x=pos", "--unit", "x=rad").splitlines()[:2] == [
        "t_s,u_N,x_deg,w_deg_per_s,segment", "0,0,57.2957795,3,0"]


@pytest.mark.parametrize("one", ["u", "F", "x", "v", "r"])
@pytest.mark.parametrize("other", ["t", "u", "F", "x", "v", "r"])
def test_a_column_for_two_roles_is_read_into_both(sim, one, other):
    """Each with its own scale; so is the one that has the force by default. Memory that nobody wrote would be noise under MALLOC_PERTURB_."""
    names, of = {"t": "t_s", "u": "u_N", "F": "F_N", "x": "x_deg", "v": "w_deg_per_s", "r": "r_N"}, {"t": 0, "u": 1, "y": 2}
    rows = [[k * 0.001, 0.1 + 0.3 * k, 7.0 - 2.0 * k] for k in range(40)]
    sim.write("log.csv", "t_s,u_N,y_N\n" + "".join(",".join(f"{x:.9g}" for x in row) + "\n" for row in rows))
    for column in ("y_N", "u_N", "t_s"):
        result = sim("log", "log.csv", "--column", f"{one}={column}", "--scale", f"{one}=3", *(["--column", f"{other}={column}"] if other not in (one, "t") else []), "--out", "out.csv",
                     env={**os.environ, "MALLOC_PERTURB_": "85"})
        assert result.returncode == 0, result.stderr
        out = read_csv(sim.folder / "out.csv")
        assert out[names[one]] == pytest.approx([3 * row[of[column[0]]] for row in rows], rel=1e-8)
        if other not in (one, "t"):
            assert out[names[other]] == pytest.approx([row[of[column[0]]] for row in rows], rel=1e-8)
        if "F" not in (one, other):
            assert out["F_N"] == pytest.approx([row[2] for row in rows], rel=1e-8)


NAMES = {"F": "F_N", "x": "x_deg", "v": "w_deg_per_s", "r": "r_N"}


@pytest.mark.parametrize("command", ["log", "replay"])
@pytest.mark.parametrize("option", ["--scale F=2", "--scale v=-", "--bias r=0.1", "--bias F=0", "--unit F=mN", "--unit x=mm", "--unit v=rad/s"])
def test_an_option_for_a_column_that_a_log_does_not_have_is_refused(sim, command, option):
    name = NAMES[option.split()[1][0]]
    sim.write("log.csv", GOOD.replace(",F_N", ",temperature"))
    sim.fails(f"{option}: log.csv:1:1: no column is named {name}; there are t_s, u_N, temperature", command, "log.csv", *option.split())
    sim.write("rows.csv", GOOD.split("\n", 1)[1])
    sim.fails(f"{option}: rows.csv:1:1: no header, so no column is named {name}; there are #1 to #3",
              command, "rows.csv", "--column", "t=#1", "--column", "u=#2", *option.split())
    sim.write("with.csv", GOOD.replace(",F_N", f",{name}"))
    sim.fails(f"{option}: log.csv:1:1: no column is named {name}; there are t_s, u_N, temperature", command, "with.csv", "log.csv", *option.split())
    assert sim(command, "with.csv", *option.split()).returncode == 0


def test_the_sensors_force_is_one(sim):
    """For whatever needs a force."""
    sim.write("log.csv", "# a preamble, of words\n" + GOOD.replace("F_N", "y_N"))
    assert sim.ok("log", "log.csv", "--scale", "F=2").splitlines()[:3] == ["t_s,u_N,F_N,segment", "0,0.1,0.02,0", "0.001,0.2,0.04,0"]
    sim.ok("replay", "log.csv", "--force", "measured")


LONG = ["t_s,u_N,F_N", *(f"{k / 1000:.3f},{k},{2 * k}" for k in range(100))]
BROKEN = {
    "a field too many": ("0.050,50,100,7", "log.csv:52:14: more fields than the header's 3"),
    "a field too few": ("0.050,50", "log.csv:52:7: 2 fields, the header has 3"),
    "no number": ("0.050,x,100", "log.csv:52:7: u_N: 'x' is not a number"),
    "not a number": ("0.050,NaN,100", "log.csv:52:7: u_N: 'NaN' is not a finite number"),
    "nothing": ("0.050,,100", "log.csv:52:7: u_N: '' is not a number"),
    "half of a line": ("0.0", "log.csv:52:1: 1 fields, the header has 3"),
    "an open quote": ('0.050,"50,100', "log.csv:52:7: a quote is opened and not closed in its line"),
    "a number without an end": ("0.050," + "1" * 500 + ",100", "log.csv:52:7: u_N: '" + "1" * 40 + "' is outside -1e+30 to 1e+30"),
}


@pytest.mark.parametrize("case", BROKEN)
def test_a_broken_row_is_left_out_and_bridged(sim, case):
    row, what = BROKEN[case]
    sim.write("log.csv", "\n".join(LONG[:51] + [row] + LONG[52:]) + "\n")
    result = sim("log", "log.csv", "--out", "out.csv")
    assert result.returncode == 0, result.stderr
    assert result.stderr == f"log.csv: 1 of 100 rows are broken, left out and bridged; the first: {what}\n"
    out = read_csv(sim.folder / "out.csv")
    assert out["t_s"] == pytest.approx([k / 1000 for k in range(100)], abs=1e-9) and set(out["segment"]) == {0}
    assert out["u_N"] == pytest.approx(list(range(100)), abs=1e-6) and out["F_N"] == pytest.approx(list(range(0, 200, 2)), abs=1e-6)


CUT = {
    "behind a point": "0.099,99.500,0.",
    "before all digits behind the point": "0.099,99.500,0.40",
    "before the point": "0.099,99.500,4",
}


@pytest.mark.parametrize("case", CUT)
@pytest.mark.parametrize("command", ["log", "replay"])
def test_a_last_row_that_is_cut_in_a_number_is_left_out(sim, case, command):
    rows = ["t_s,u_N,F_N", *(f"{k / 1000:.3f},{k:.3f},{k / 7:.3f}" for k in range(99))]
    sim.write("log.csv", "\n".join([*rows, CUT[case]]))
    result = sim(command, "log.csv", "--out", "out.csv")
    number = CUT[case].rsplit(",", maxsplit=1)[1]
    assert result.returncode == 0, result.stderr
    assert result.stderr.startswith("log.csv: 1 of 100 rows are broken, left out and bridged; the first: "
                                    f"log.csv:101:14: F_N: the file ends in the middle of the number '{number}'\n")
    assert len(read_csv(sim.folder / "out.csv")["t_s"]) == 99
    sim.write("log.csv", "\n".join([*rows, CUT[case]]) + "\n")  # whole, whatever it is
    assert sim(command, "log.csv", "--out", "out.csv").stderr.count("middle") == 0
    assert len(read_csv(sim.folder / "out.csv")["t_s"]) == 100


def test_a_short_log_that_is_cut_in_a_number_is_refused(sim):
    for separator, number in ((",", "0."), (";", "0,")):
        sim.write("log.csv", f"t_s{separator}u_N\n0{separator}1\n1{separator}1\n2{separator}{number}")
        sim.fails("log.csv:4:3: u_N: the file ends in the middle of the number '0.'", "log", "log.csv")
    sim.write("exponent.csv", "t_s,u_N\n" + "".join(f"{k}e-03,1.5e-01\n" for k in range(25)) + "25e-03,1.5e-0")
    assert "the file ends in the middle of the number '1.5e-0'" in sim("log", "exponent.csv").stderr


@pytest.mark.parametrize("last", ["0.123", "0.5", "1", "2.25"])
def test_a_last_row_without_a_newline_is_read(sim, last):
    """Where the numbers above have no common form, a short one may be whole."""
    above = [0.25, 0.125, 3] if last != "0.123" else [0.125]
    rows = [f"{k},{above[k % len(above)]}" for k in range(40)]
    sim.write("log.csv", "\n".join(["t_s,u_N", *rows, f"40,{last}"]))
    assert len(sim.ok("log", "log.csv").splitlines()) == 42


def test_many_broken_rows_are_a_broken_log(sim):
    rows = [line + ",7" if k in (20, 30, 40, 50, 60) else line for k, line in enumerate(LONG)]
    sim.write("log.csv", "\n".join(rows) + "\n")
    assert "5 of 100 rows are broken" in sim("log", "log.csv", "--out", "out.csv").stderr
    rows[70] += ",7"
    sim.write("log.csv", "\n".join(rows) + "\n")
    sim.fails("log.csv:21:13: more fields than the header's 3, and 5 more rows of 100 are broken", "log", "log.csv")


def test_words_among_the_rows_count_as_broken(sim):
    """A header in the midst: the logger was started again."""
    sim.write("log.csv", "\n".join(LONG[:51] + LONG[:1] + LONG[51:]) + "\n")
    result = sim("log", "log.csv", "--out", "out.csv")
    assert result.returncode == 0 and "1 of 101 rows are broken" in result.stderr


def test_a_row_that_is_missing_is_not_bridged_for_a_broken_one(sim):
    sim.write("log.csv", "\n".join(LONG[:20] + LONG[21:51] + ["0.050,x,1"] + LONG[52:]) + "\n")
    result = sim("log", "log.csv")
    assert result.returncode == 1 and "log.csv:21:1: t_s: 0.002 s after the row before" in result.stderr


@pytest.mark.parametrize("coding", ["utf-16", "utf-16-le", "utf-16-be", "utf-32"])
def test_wide_characters_are_named(sim, coding):
    sim.write("log.csv", GOOD.encode(coding))
    sim.fails(f"log.csv: is {'UTF-32' if coding == 'utf-32' else 'UTF-16'} text; save it as UTF-8", "log", "log.csv")



def with_stray(stamps):
    """A log of 2000 rows at 1 kHz, some with other stamps."""
    return "t_s,u_N\n" + "".join(f"{stamps.get(k, k / 1000)},0\n" for k in range(2000))


REFUSED = {
    "torque without a scale": (GOOD, ["--unit", "u=N m"], "--unit u=...: is not a force: give --scale u=NUMBER, the N for one of this unit"
                               " (1/lever for a torque in N m)"),
    "no such column": (GOOD, ["--column", "u=torque"], "log.csv:1:1: no column is named torque; there are t_s, u_N, F_N"),
    "no such number": (GOOD.split("\n", 1)[1], ["--column", "t=#1", "--column", "u=#9"],
                       "log.csv:1:1: no header, so no column is named #9; there are #1 to #3"),
    "mapped force": (GOOD, ["--column", "F=force"], "log.csv:1:1: no column is named force; there are t_s, u_N, F_N"),
    "near a name": (GOOD.replace("u_N", "Torque_Cmd"), ["--column", "u=torque_cnd"], "log.csv:1:1: no column is named torque_cnd, did you mean Torque_Cmd?; there are t_s, Torque_Cmd, F_N"),
    "milliseconds in the line of units": (GOOD.replace("\n", "\n[ms],[N],[N]\n", 1), [], "log.csv: column t_s is in ms: confirm this by --unit t=ms, or give --unit t=s if it is not"),
    "microseconds in the name": (GOOD.replace("t_s", "t_us"), ["--column", "t=t_us"], "log.csv: column t_us is in us: confirm this by --unit t=us, or give --unit t=s if it is not"),
    "milliseconds in a name of words": (GOOD.replace("t_s", "Time ms"), ["--column", "t=Time ms"], "log.csv: column Time ms is in ms: confirm this by --unit t=ms, or give --unit t=s if it is not"),
    "millinewton in the name": (GOOD.replace("F_N", "force_mN"), ["--column", "F=force_mN"], "log.csv: column force_mN is in mN: confirm this by --unit F=mN, or give --unit F=N if it is not"),
    "ampere in the name": (GOOD.replace("u_N", "i_q_A"), ["--column", "u=i_q_A"], "log.csv: column i_q_A is in A: confirm this by --unit u=A --scale u=NEWTON, or give --unit u=N if it is not"),
    "millinewton behind the name": (GOOD.replace("F_N", "F (raw) [mN]"), ["--column", "F=F (raw) [mN]"], "log.csv: column F (raw) [mN] is in mN: confirm this by --unit F=mN, or give --unit F=N if it is not"),
    "ampere in the line of units": (GOOD.replace("\n", "\ns;A;N\n".replace(";", ","), 1), [], "log.csv: column u_N is in A: confirm this by --unit u=A --scale u=NEWTON, or give --unit u=N if it is not"),
    "millinewton of the sensor": (GOOD.replace("F_N", "y_N").replace("\n", "\ns,N,mN\n", 1), [], "log.csv: column F_N is in mN: confirm this by --unit F=mN, or give --unit F=N if it is not"),
    "a name without its unit": (GOOD.replace("u_N", "torque [Nm]"), ["--column", "u=Torque"], "log.csv:1:1: no column is named Torque, did you mean torque [Nm]?; there are t_s, torque [Nm], F_N"),
    "one column": (GOOD.replace(",", "|"), [], "log.csv:1:1: no column is named t_s, did you mean t_s|u_N|F_N?; the only column is t_s|u_N|F_N"),
    "below a preamble": ("Rig,7\nDate: today\n" + GOOD.replace("t_s", "clock"), [], "log.csv:3:1: no column is named t_s; there are clock, u_N, F_N"),
    "falling stamps": ("t_s,u_N\n0.003,0\n0.002,0\n0.001,0\n0,0\n", ["--resample"], "log.csv:3:1: t_s: falls from row to row: the log runs backwards"),
    "stamps that begin anew": ("t_s,u_N\n" + "".join(f"{k % 50 / 1000},0\n" for k in range(100)), ["--resample"],
                               "log.csv:52:1: t_s: goes back by 0.049 s, to 0 s: the clock begins anew here; split the log here and pass both files as one experiment"),
    "nan in every row": ("t_s,u_N\n" + "nan,nan\n" * 30, [], "log.csv:2:1: t_s: 'nan' is not a finite number, and no row has numbers"),
    "nan in the only row": ("t_s,u_N\nnan,nan\n", [], "log.csv:2:1: t_s: 'nan' is not a finite number, and no row has numbers"),
    "infinity in the only row": ("t_s,u_N\n-Inf,-Inf\n", [], "log.csv:2:1: t_s: '-Inf' is not a finite number, and no row has numbers"),
    "nan below units": ("t_s,u_N\ns,N\nnan,inf\n", [], "log.csv:3:1: t_s: 'nan' is not a finite number, and no row has numbers"),
    "units and no rows": ("t_s,u_N\ns,N\n", [], "log.csv:3:1: no rows after the header"),
    "a stray stamp ahead": ("t_s,u_N\n" + "".join(f"{1e30 if k == 50 else k / 1000},0\n" for k in range(100)), [], "log.csv:52:1: t_s: 1e+30 s is far from the stamps before and after it: remove this row; --resample then bridges the gap"),
    "a stray stamp back": ("t_s,u_N\n" + "".join(f"{0 if k == 50 else k / 1000},0\n" for k in range(100)), ["--resample"], "log.csv:52:1: t_s: 0 s is far from the stamps before and after it: remove this row; --resample then bridges the gap"),
    "a stray stamp at the start": (with_stray({0: 77}), [], "log.csv:2:1: t_s: 77 s is far from the stamps after it: remove this row"),
    "a stray stamp back in the second row": (with_stray({1: -5}), [], "log.csv:3:1: t_s: -5 s is far from the stamps before and after it: remove this row; --resample then bridges the gap"),
    "a stray stamp at the end": (with_stray({1999: -3}), ["--resample"], "log.csv:2001:1: t_s: -3 s is far from the stamps before it: remove this row"),
    "a stray stamp ahead in the row before the last": (with_stray({1998: 77}), [], "log.csv:2000:1: t_s: 77 s is far from the stamps before and after it: remove this row; --resample then bridges the gap"),
    "two stray stamps ahead": (with_stray({50: 77, 51: 78}), [], "log.csv:52:1: t_s: 2 stamps from 77 s on are far from those before and after them: remove these 2 rows; --resample then bridges the gap"),
    "two stray stamps back": (with_stray({50: -3, 51: -2}), ["--resample"], "log.csv:52:1: t_s: 2 stamps from -3 s on are far from those before and after them: remove these 2 rows; --resample then bridges the gap"),
    "a stray stamp ahead and one back": (with_stray({50: 77, 51: -3}), [], "log.csv:52:1: t_s: 2 stamps from 77 s on are far from those before and after them: remove these 2 rows; --resample then bridges the gap"),
    "two stray stamps at the start": (with_stray({0: 77, 1: 78}), [], "log.csv:2:1: t_s: 2 stamps from 77 s on are far from those after them: remove these 2 rows"),
    "three stray stamps at the end": (with_stray({1997: -3, 1998: -2, 1999: -1}), [], "log.csv:1999:1: t_s: 3 stamps from -3 s on are far from those before them: remove these 3 rows"),
    "a clock that begins anew near the end": (with_stray({1996: 0, 1997: 0.001, 1998: 0.002, 1999: 0.003}), [], "log.csv:1998:1: t_s: goes back by 1.995 s, to 0 s: the clock begins anew here; split the log here and pass both files as one experiment"),
    "a clock that begins anew near the start": (with_stray({k: 77 + k / 1000 for k in range(4)}), [], "log.csv:6:1: t_s: goes back by 76.999 s, to 0.004 s: the clock begins anew here; split the log here and pass both files as one experiment"),
    "rows without end": ("t_s,u_N\n0,0\n1,0\n2,0\n", ["--resample=1e-9"], "log.csv: 2 s at --resample=1e-09 are 2e+09 rows, and a log may have 50000000: --resample=8e-08 makes fewer"),
    "stamps twice": ("t_s,u_N\n0,0\n0,0\n0.001,0\n0.002,0\n", [], "log.csv:3:1: t_s: 0 does not come after 0; 1 stamps appear twice, 0 go back (--resample repairs this)"),
    "behind comments": ("# a\n# b\nt_s,u_N\n0,0\n0.001,x\n", [], "log.csv:5:7: u_N: 'x' is not a number"),
    "back in time behind comments": ("# a\nt_s,u_N\n0,0\n0.001,0\n0,0\n", [], "log.csv:5:1: t_s: 0 does not come after 0.001; 0 stamps appear twice, 1 go back (--resample repairs this)"),
    "back in time without a header": ("0,0\n0.001,0\n0,0\n", ["--column", "t=#1", "--column", "u=#2"], "log.csv:3:1: #1: 0 does not come after 0.001; 0 stamps appear twice, 1 go back (--resample repairs this)"),
    "comments only": ("# a\n# b\n", [], "log.csv:1:1: no column is named t_s; the only column is a"),
    "one stamp": ("t_s,u_N\n0,0\n0,0\n", ["--resample"], "log.csv: all stamps are the same"),
    "gaps only": ("t_s,u_N\n0,0\n1,0\n2,0\n", ["--resample", "--gap", "0.1"], "log.csv: no two rows without a gap between them"),
    "a missing file": (GOOD, ["none.csv"], "none.csv: cannot be opened: No such file or directory"),
}


@pytest.mark.parametrize("case", REFUSED)
def test_what_cannot_be_read_is_refused(sim, case):
    content, options, message = REFUSED[case]
    sim.write("log.csv", content)
    sim.fails(message, "log", "log.csv", *options, "--out", "out.csv")
    assert not (sim.folder / "out.csv").exists()


@pytest.mark.parametrize("case", [case for case, (_, _, message) in REFUSED.items() if ": remove th" in message])
def test_the_advice_to_remove_rows_leads_to_a_log_that_is_read(sim, case):
    content, _, message = REFUSED[case]
    lines, (line, count) = content.splitlines(), re.search(r"log.csv:(\d+):.*remove (?:this row|these (\d) rows)", message).groups()
    del lines[int(line) - 1:int(line) - 1 + int(count or 1)]
    sim.write("log.csv", "\n".join(lines) + "\n")
    result = sim("log", "log.csv", *(["--resample"] if "--resample" in message else []), "--out", "out.csv")
    assert result.returncode == 0, result.stderr


def test_a_wrong_unit_lists_the_known_units(sim):
    sim.write("log.csv", GOOD)
    for unit in ("u=ms", "t=N", "u=lbf"):
        result = sim("log", "log.csv", "--unit", unit)
        assert result.returncode == 2 and result.stderr.startswith(f"tribo-sim: --unit {unit}: units are s, ms, us")


def test_the_clean_log_is_not_written_over_the_log(sim):
    sim.write("log.csv", GOOD)
    sim.fails("log: --out log.csv is the same file as the log log.csv (tribo-sim --help lists the commands)",
              "log", "log.csv", "--out", "log.csv", status=2)
    assert (sim.folder / "log.csv").read_text(encoding="ascii") == GOOD


def test_jitter_and_small_gaps_are_repaired_and_reported(sim):
    stamps = [0, 1.2, 2, 3, 3, 4.1, 5, 8, 9, 10, 11]
    sim.write("log.csv", "t_s,u_N\n" + "".join(f"{t},{2 * t}\n" for t in stamps))
    result = sim("log", "log.csv", "--unit", "t=ms", "--resample", "--out", "out.csv")
    assert result.returncode == 0
    assert result.stderr == ("log.csv: resampled 11 rows to 12 at 0.001 s: 5 intervals off by more than 1 %, 1 gaps"
                             " (the longest 0.003 s), 1 stamps twice, 0 out of order, split at 0 gaps\n")
    out = read_csv(sim.folder / "out.csv")
    assert out["t_s"] == pytest.approx([k * 0.001 for k in range(12)])
    assert out["u_N"] == pytest.approx([2 * k for k in range(12)], abs=1e-8)


def test_rows_out_of_order_are_put_in_order(sim):
    rows = list(range(100))
    rows[30], rows[31], rows[60], rows[62] = 31, 30, 62, 60
    sim.write("log.csv", "t_s,u_N\n" + "".join(f"{k / 1000},{k * k}\n" for k in rows))
    result = sim("log", "log.csv", "--resample", "--out", "out.csv")
    assert result.returncode == 0 and ", 3 out of order," in result.stderr, result.stderr
    out = read_csv(sim.folder / "out.csv")
    assert out["t_s"] == pytest.approx([k / 1000 for k in range(100)]) and out["u_N"] == pytest.approx([k * k for k in range(100)], abs=1e-6)


def stamps_of(interval, first, rows, form):
    return "t_s,u_N\n" + "".join(f"{form % (first + k * interval)},{k % 7}\n" for k in rows)


@pytest.mark.parametrize("interval, first, form", [(0.00025, 300, "%.7g"), (0.00025, 99.9, "%.7g"), (1 / 3000, 0, "%.4f"), (1 / 4096, 0, "%.4f"), (0.00025, 300, "%.6e")])
@pytest.mark.parametrize("unit", [1, 1000])
def test_stamps_that_are_rounded_as_they_are_written_are_those_of_an_even_clock(sim, interval, first, form, unit):
    """A logger's %.7g has steps of 0.1 ms from 100 s on."""
    sim.write("log.csv", stamps_of(interval * unit, first * unit, range(2000), form if unit == 1 or "f" not in form else "%.1f"))
    for more in ([], ["--resample"]):
        run = sim("log", "log.csv", "--unit", "t=s" if unit == 1 else "t=ms", "--out", "out.csv", *more)
        assert run.returncode == 0 and "are those of an even clock" in run.stderr
        out = read_csv(sim.folder / "out.csv")
        assert out["t_s"] == pytest.approx([first + k * interval for k in range(2000)], abs=1e-4)
        assert out["t_s"][1] - out["t_s"][0] == pytest.approx(interval, rel=1e-3)
        assert out["u_N"] == pytest.approx([k % 7 for k in range(2000)], abs=1e-6)


UNEVEN = {"a row is missing": [k for k in range(2000) if k != 900], "a row is late": [*range(900), 900.8, *range(901, 2000)],
          "the clock's rate changes": [*range(1000), *(1000 + 1.02 * k for k in range(1000))]}


@pytest.mark.parametrize("case", UNEVEN)
def test_stamps_that_are_uneven_beyond_their_digits_are_refused(sim, case):
    sim.write("log.csv", stamps_of(0.00025, 300, UNEVEN[case], "%.7g"))
    run = sim("log", "log.csv")
    assert run.returncode == 1 and "s after the row before, where the log's interval is" in run.stderr


def test_a_gap_beyond_the_bound_splits_the_log(sim):
    stamps = [0, 1, 2, 3, 53, 54, 55]
    sim.write("log.csv", "t_s,u_N\n" + "".join(f"{t / 1000},{t}\n" for t in stamps))
    result = sim("log", "log.csv", "--resample", "--out", "out.csv")
    assert "split at 1 gaps" in result.stderr
    assert read_csv(sim.folder / "out.csv")["segment"] == (0, 0, 0, 0, 1, 1, 1)
    assert len(read_csv(sim.folder / "out.csv")["t_s"]) == 7
    sim("log", "log.csv", "--resample", "--gap", "0.06", "--out", "out.csv")
    bridged = read_csv(sim.folder / "out.csv")
    assert set(bridged["segment"]) == {0} and len(bridged["t_s"]) == 56
    assert bridged["u_N"] == pytest.approx([k for k in range(56)], abs=1e-6)


def test_resampling_to_another_interval(sim):
    sim.write("log.csv", GOOD)
    sim("log", "log.csv", "--resample=0.0005", "--out", "out.csv")
    assert read_csv(sim.folder / "out.csv")["u_N"] == pytest.approx([0.1, 0.15, 0.2, 0.25, 0.3])


def test_several_files_are_one_experiment(sim):
    sim.write("a.csv", GOOD)
    sim.write("b.csv", GOOD.replace("0.1", "0.5"))
    result = sim("log", "a.csv", "b.csv", "--out", "out.csv")
    assert result.stderr == "a.csv: the stamps of 1 files are moved to follow the file before\n"
    out = read_csv(sim.folder / "out.csv")
    assert out["segment"] == (0, 0, 0, 1, 1, 1)
    assert out["u_N"] == (0.1, 0.2, 0.3, 0.5, 0.2, 0.3)
    assert all(b > a for a, b in zip(out["t_s"], out["t_s"][1:]))
    sim.write("slow.csv", "t_s,u_N,F_N\n0,0,0\n0.002,0,0\n")
    sim.fails("slow.csv: its interval is 0.002 s, that of the file before 0.001 s (--resample makes them equal)",
              "log", "a.csv", "slow.csv")
    sim.write("blind.csv", "t_s,u_N\n0,0\n0.001,0\n")
    sim.fails("blind.csv: column F_N is in one file and not in another", "log", "a.csv", "blind.csv")


def test_each_segment_restarts_the_compensator(sim):
    rows = [(k * 0.001, 0.3 * math.sin(k / 150)) for k in range(1000)]
    text = "t_s,u_N\n" + "".join(f"{t:.3f},{u:.9g}\n" for t, u in rows)
    sim.write("a.csv", text)
    once = sim.ok("replay", "a.csv").splitlines()[1:]
    twice = sim("replay", "a.csv", "a.csv").stdout.splitlines()[1:]
    parts = [line.rpartition(",") for line in twice]
    assert [line.split(",", 1)[1] for line, _, _ in parts] == [line.split(",", 1)[1] for line in once] * 2
    assert [segment for _, _, segment in parts] == ["0"] * 1000 + ["1"] * 1000


def slow_triangle(sim, name="log.csv", L=lambda F: 0.007 + 0.3 * F, u_of=lambda u: u, F_of=lambda F: F, noise=0.001, turns=4, dt=0.005,
                  motion=False):
    """An arm that stands within L and slides beyond it, whatever the library thinks: u goes up and down between 0.3 and 0.9 N."""
    source = random.Random(3)
    F, lines = 0.25, []
    for k in range(int(turns * 20 / dt)):
        t = k * dt
        phase = t / 20 % 1
        u = 0.3 + 0.6 * (2 * phase if phase < 0.5 else 2 - 2 * phase)
        before = F
        if u - F > L(F):
            F += (u - F - L(F)) / (1 + 0.3)
        elif u - F < -L(F):
            F += (u - F + L(F)) / (1 - 0.3)
        row = f"{t:.3f},{u_of(u):.9g},{F_of(F) + source.gauss(0, noise):.9g}"
        lines.append(row + (f",{F - before:.9g}" if motion else ""))
    sim.write(name, "t_s,u_N,F_N" + (",w_deg_per_s" if motion else "") + "\n" + "\n".join(lines) + "\n")


def verdict(sim, *options, log="log.csv"):
    out = sim.ok("replay", log, "--force", "measured", "--out", "out.csv", *options)
    return [line[10:] for line in out.splitlines() if line.startswith("verdict")], out


def breakaway(sim, offset, slope):
    sim.write("p.yaml", f"friction:\n  breakaway: {{offset_N: {offset}, slope: {slope}}}\n")
    return ["--params", "p.yaml"]


def test_params_that_fit_are_reported_as_such(sim):
    slow_triangle(sim)
    words, out = verdict(sim)
    assert words == ["the params fit this log"]
    assert float(out.split("sliding   at ")[1].split()[0]) == pytest.approx(1, abs=0.03)
    assert float(out.split("opposes the motion in ")[1].split()[0]) > 99


@pytest.mark.parametrize("times", [1.5, 3, 20])
def test_an_L_that_is_too_large_is_named_though_nothing_is_left_over(sim, times):
    slow_triangle(sim, noise=0)
    words, out = verdict(sim, *breakaway(sim, 0.007 * times, 0.3 * times))
    assert len(words) == 1 and words[0].endswith(f"the arm slides at {1 / times:.2f} of it")
    assert float(words[0].split("L is ")[1].split()[0]) == pytest.approx(times, rel=0.05)
    if times == 20:
        assert float(out.split("less f    rms ")[1].split()[0]) < 1e-3


def test_an_L_that_is_too_small_is_named(sim):
    slow_triangle(sim)
    words, _ = verdict(sim, *breakaway(sim, 0.0035, 0.15))
    assert len(words) == 1 and float(words[0].split("slides at ")[1].split()[0]) == pytest.approx(2, rel=0.05)


def test_a_wrong_sign_is_named(sim):
    slow_triangle(sim, u_of=lambda u: -u)
    words, _ = verdict(sim)
    assert len(words) == 1 and words[0].startswith("wrong sign")
    assert verdict(sim, "--scale", "u=-")[0] == ["the params fit this log"]


@numbers
def test_a_loop_that_takes_u_back_at_each_slip_has_no_wrong_sign(sim):
    sim.trace("triangle", "--set", "reference.period_s=60", "--set", "compensator.gain=0", "--set", "metrics.start_s=0")
    options = ["--column", "F=y_N"]
    assert verdict(sim, *options, log="trace_of_run/trace.csv")[0] == ["the params fit this log"]
    assert verdict(sim, *options, "--scale", "u=-", log="trace_of_run/trace.csv")[0][0].startswith("wrong sign")


@pytest.mark.parametrize("duration", [4, 9])
def test_a_right_log_of_one_direction_has_no_wrong_sign(sim, duration):
    sim.trace("triangle", "--set", f"duration_s={duration}", "--set", "metrics.start_s=0")
    words, _ = verdict(sim, "--column", "F=y_N", log="trace_of_run/trace.csv")
    assert words == ["F slides in one direction only: L cannot be told from scale and bias of u"]


@pytest.mark.parametrize("scale", [0.6, 0.85, 1.2])
def test_a_wrong_scale_is_named_with_its_factor(sim, scale):
    slow_triangle(sim, u_of=lambda u: u * scale)
    words, _ = verdict(sim)
    assert len(words) == 1 and words[0].startswith("wrong scale")
    assert float(words[0].split("multiply u by ")[1].split()[0]) == pytest.approx(1 / scale, rel=0.03)


@pytest.mark.parametrize("factor", [1000, 0.001])
def test_units_off_by_a_thousand_are_named(sim, factor):
    slow_triangle(sim, F_of=lambda F: F * factor, noise=0)
    words, _ = verdict(sim)
    assert len(words) == 1 and words[0].startswith("units: ")


def test_a_silent_sensor_is_named(sim):
    slow_triangle(sim, F_of=lambda F: 0.4, noise=0)
    assert verdict(sim)[0] == ["F does not move: the sensor is silent, or u stays within stiction; nothing can be said about L"]


def test_one_direction_says_nothing_about_L(sim):
    slow_triangle(sim, turns=0.5)
    words, _ = verdict(sim)
    assert "F slides in one direction only: L cannot be told from scale and bias of u" in words


def test_a_log_without_a_force_is_not_judged(sim):
    sim.write("log.csv", GOOD.replace("F_N", "other"))
    out = sim.ok("replay", "log.csv", "--out", "out.csv")
    assert "the log has no force" in out and "u - F" not in out


@numbers
def test_the_sign_of_friction_power_is_of_the_motion_where_it_is_known(sim):
    slow_triangle(sim, motion=True)
    _, out = verdict(sim)
    assert "friction opposes the motion in 100 % of these ticks (by the log's motion)" in out
    _, out = verdict(sim, "--scale", "v=-")
    assert "friction opposes the motion in 0 % of these ticks (by the log's motion)" in out


def test_the_columns_are_force_and_residual(sim):
    slow_triangle(sim)
    verdict(sim)
    out = read_csv(sim.folder / "out.csv")
    assert list(out)[-2:] == ["F_N", "residual_N"]
    assert out["residual_N"] == pytest.approx([n - f for n, f in zip(out["n_N"], out["f_hat_N"])], abs=1e-7)


def test_the_verdicts_figures_are_those_of_the_table(sim):
    slow_triangle(sim)
    _, text = verdict(sim)
    out = read_csv(sim.folder / "out.csv")
    rms = lambda x: math.sqrt(sum(v * v for v in x) / len(x))
    shown = [float(line.split(word)[1].split()[0].rstrip(",")) for line in text.splitlines()[1:3] for word in ("rms", "peak")]
    expected = [rms(out["n_N"]), max(map(abs, out["n_N"])), rms(out["residual_N"]), max(map(abs, out["residual_N"]))]
    assert shown == pytest.approx(expected, rel=1e-3)
    limit = sum(abs(f) >= 0.999 * L for f, L in zip(out["f_hat_N"], out["L_N"])) / len(out["L_N"])
    assert float(text.split("f at L ")[1].split()[0]) == pytest.approx(100 * limit, rel=0.01)
    switches = sum(a != b for a, b in zip(out["Q"], out["Q"][1:]))
    assert float(text.split("Q switches ")[1].split()[0]) == pytest.approx(switches / 80, rel=0.01)
