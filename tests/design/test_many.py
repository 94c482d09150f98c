"""Random problems, well-posed, ill-posed and wild; seeds are the test's parameters. study_synthesis.py is the long form."""

import multiprocessing
import os
import time
from concurrent.futures import ProcessPoolExecutor

import numpy as np
import pytest
import scipy.signal
import study_synthesis
from problems import CAUSES, KINDS, contradiction_frequency, ill_posed, well_posed, wild

from tribo_design import pipeline
from tribo_design.config import Design, validate
from tribo_design.errors import DesignError, IllPosedError

TIME_LIMIT = 600


def independent_check(result, data):
    """Closes the sections' loop with scipy and numpy alone: (largest |z|, largest gamma on a grid)."""
    h = data["sample_time_s"]
    zeros, poles = ([complex(r) for r in data["plant"][k]] for k in ("zeros", "poles"))
    gain = data["plant"]["gain"] * np.prod(-np.array(poles)) / (np.prod(-np.array(zeros)) if zeros else 1)
    # In units of the fastest pole, so that the companion form is well scaled.
    unit = max(abs(np.array(poles)))
    degree = len(poles) - len(zeros)
    a, b, c, d = scipy.signal.zpk2ss(np.array(zeros) / unit, np.array(poles) / unit, (gain / unit**degree).real)
    a, b, c, d, _ = scipy.signal.cont2discrete((a, b, c, d), h * unit, "zoh")
    k = None
    for b0, b1, b2, a1, a2 in result.f32:
        s = (np.array([[1 - a1, 1], [-a2, 1]]), np.array([[b1 - a1 * b0], [b2 - a2 * b0]]), np.array([[1.0, 0]]), np.array([[b0]]))
        k = s if k is None else (np.block([[k[0], np.zeros((len(k[0]), 2))], [s[1] @ k[2], s[0]]]), np.vstack([k[1], s[1] @ k[3]]),
                                 np.hstack([s[3] @ k[2], s[2]]), s[3] @ k[3])
    closed = np.block([[a - b @ k[3] @ c, b @ k[2]], [-k[1] @ c, k[0]]])
    radius = np.abs(np.linalg.eigvals(closed)).max()
    omega = np.geomspace(1e-3 / h / 1e3, np.pi / h * 0.999, 400)
    z = np.exp(1j * omega * h)
    g = np.array([(c @ np.linalg.solve(x * np.eye(len(a)) - a, b))[0, 0] for x in z])
    kz = np.array([(k[2] @ np.linalg.solve(x * np.eye(len(k[0])) - k[0], k[1]))[0, 0] + k[3][0, 0] for x in z])
    s = 1 / (1 + g * kz)
    w = data["weights"]
    wp = np.polyval(w["wp"]["num"], 1j * omega) / np.polyval(w["wp"]["den"], 1j * omega)
    wt = np.polyval(w["wT"]["num"], 1j * omega) / np.polyval(w["wT"]["den"], 1j * omega)
    gamma = np.sqrt(abs(wp * s) ** 2 + abs(w["wu"] * kz * s) ** 2 + abs(wt * (1 - s)) ** 2).max()
    return radius, gamma


def one(seed):
    began = time.monotonic()
    data = {**well_posed(seed), "synthesis": {"domain": "continuous", "time_limit_s": TIME_LIMIT}}
    try:
        result = pipeline.synthesize(validate(Design, data, "random"), "0" * 64, "random")
        radius, gamma = independent_check(result, data)
        stated = result.stage("q31").metrics.gamma
        if not radius < 1:
            outcome = f"WRONG: the largest closed-loop pole is {radius}"
        elif not 0.9 * stated < gamma < 1.005 * stated:
            outcome = f"WRONG: gamma on a grid is {gamma}, stated {stated}"
        else:
            outcome = "verified"
    except DesignError as error:
        outcome = f"refused: {error}"
    except Exception as error:  # noqa: BLE001 - the test's very question
        outcome = f"CRASHED: {type(error).__name__}: {error}"
    return seed, outcome, time.monotonic() - began


def pool():
    return ProcessPoolExecutor(max_workers=min(2, os.cpu_count() or 1), mp_context=multiprocessing.get_context("spawn"))


def test_50_continuous_problems_end_in_a_verified_loop_or_an_explained_refusal():
    with pool() as workers:
        outcomes = list(workers.map(one, range(50), chunksize=5))
    wrong = [o for o in outcomes if o[1] != "verified" and not o[1].startswith("refused: ")]
    assert not wrong, wrong
    assert max(seconds for _, _, seconds in outcomes) < TIME_LIMIT
    refused = [o for o in outcomes if o[1].startswith("refused: ")]
    # An explanation names a quantity, a limit and a way out.
    for seed, text, _ in refused:
        assert "limit" in text and ("sample time" in text or "bandwidth" in text or "rad/s" in text), (seed, text)
    verified = len(outcomes) - len(refused)
    print(f"{verified} verified, {len(refused)} refused")
    assert verified >= 30


@pytest.mark.parametrize("seed", range(50))
def test_ill_posed_problem_is_refused_with_the_right_cause(seed):
    data, cause = ill_posed(seed)
    with pytest.raises(DesignError) as error:
        pipeline.synthesize(validate(Design, data, "ill-posed"), "0" * 64, "ill-posed")
    assert isinstance(error.value, IllPosedError), error.value
    assert error.value.cause == cause
    text = str(error.value)
    if cause == "contradicting weights":
        import re

        named = float(re.search(r"contradict each other at ([0-9.e+]+) rad/s", text).group(1))
        assert named == pytest.approx(contradiction_frequency(data), rel=0.2)
    elif "weight" in cause:
        assert "weights.w" in text


def test_every_cause_is_among_the_50():
    assert {ill_posed(seed)[1] for seed in range(50)} == set(CAUSES)


def test_problems_of_every_kind_are_what_an_independent_loop_says():
    """In the default domain: hold, computation delay and dead time inside the synthesis."""
    with pool() as workers:
        outcomes = list(workers.map(study_synthesis.one, range(30), chunksize=5))
    assert not [o for o in outcomes if o[1] == "WRONG"]
    assert sum(o[1] == "verified" for o in outcomes) >= 24
    assert {kind for kind, verdict, _ in outcomes if verdict == "verified"} == set(KINDS)


def one_wild(seed):
    began = time.monotonic()
    try:
        pipeline.synthesize(validate(Design, wild(seed), "wild"), "0" * 64, "wild")
        outcome = "ok"
    except DesignError as error:
        outcome = "ok" if len(str(error)) > 20 else f"WRONG: says only {error}"
    except Exception as error:  # noqa: BLE001
        outcome = f"CRASHED: {type(error).__name__}: {error}"
    return seed, outcome, time.monotonic() - began


def test_wild_problems_end_in_time_and_in_words():
    with pool() as workers:
        outcomes = list(workers.map(one_wild, range(24), chunksize=3))
    assert all(o == "ok" for _, o, _ in outcomes), [o for o in outcomes if o[1] != "ok"]
    assert max(seconds for _, _, seconds in outcomes) < 150  # the solver's limit is 1 s
