"""python -m reproduction --sim TRIBO_SIM --bench TRIBO_TRUTH_BENCH --out DIR [CLAIM...]; research/reproduce calls it."""

import argparse
import pathlib
import sys

from tribo_plot.command_line import Parser

from . import claims, report
from .runs import Runs

DOCUMENT = pathlib.Path(__file__).resolve().parents[2] / "research" / "reproduction.md"


def main():
    parser = Parser(prog="research/reproduce", description="Runs the paper's claims as experiments.")
    parser.add_argument("claims", nargs="*", metavar="CLAIM", help="claims to run (all)")
    parser.add_argument("--list", action="store_true", help="lists the claims")
    parser.add_argument("--update", action="store_true", help="also write research/reproduction.md and .csv")
    parser.add_argument("--sim", required=True, help=argparse.SUPPRESS)
    parser.add_argument("--bench", required=True, help=argparse.SUPPRESS)
    parser.add_argument("--out", required=True, type=pathlib.Path, help=argparse.SUPPRESS)
    options = parser.parse_args()
    if options.list:
        for name, experiment in claims.EXPERIMENTS.items():
            print(f"{name:<10}{experiment.__doc__}")
        return
    if options.update and options.claims:
        parser.error("--update needs all claims")
    for name in options.claims:
        if name not in claims.EXPERIMENTS:
            parser.error(f"no claim '{name}'; there are {', '.join(claims.EXPERIMENTS)}")

    runs = Runs(options.sim, options.bench, options.out / "runs")
    sections = []
    for name in options.claims or claims.EXPERIMENTS:
        experiment = claims.EXPERIMENTS[name]
        print(f"{name}: {experiment.__doc__}", flush=True)
        section = experiment(runs)
        section.name, section.title = name, experiment.__doc__
        for claim in section.claims:
            print(f"  {claim.verdict:<8}{claim.where}: {claim.run}")
        sections.append(section)
    report.write_markdown(options.out / "report.md", sections)
    report.write_html(options.out / "report.html", sections)
    print(f"\n{report.count(sections)}\n{options.out / 'report.html'}, {options.out / 'report.md'}")
    if options.update:
        report.write_summary(DOCUMENT, sections)


if __name__ == "__main__":
    sys.exit(main())
