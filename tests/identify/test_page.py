"""A report's sentences wrap on a phone and on a desk."""

import pathlib
import sys

import pytest

from tribo_identify.report import page

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "browser"))
import chromium  # noqa: E402


@pytest.mark.skipif(chromium.PROGRAM is None, reason="needs chromium")
def test_the_verdict_is_no_wider_than_the_screen(tmp_path):
    verdict = "VERDICT: tuned: " + 20 * "compensation divides the error on a triangle of 5.84 to 14.5 N by 9.6, " + "/a/path" * 30
    (tmp_path / "report.html").write_text(page("Rig", [verdict], []), encoding="utf-8")
    with chromium.chromium() as new_page:
        for width in (390, 1280):
            tab = new_page()
            tab.resize(width, 800)
            tab.open((tmp_path / "report.html").as_uri())
            shown = tab.evaluate("[document.documentElement.scrollWidth, document.querySelector('pre').scrollWidth - document.querySelector('pre').clientWidth]")
            assert shown == [width, 0]
