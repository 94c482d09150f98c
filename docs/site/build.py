#!/usr/bin/env python3
"""The documentation as a site that is searched and read without a network.

    build.py OUT --sim TRIBO_SIM --shim FILE [--link TRIBO_LINK] [--drive TRIBO_DRIVE]

Collects the pages of the tree in OUT/pages and what the programs print besides: keys, parameters, registers, all numbers. With doxygen it
has the reference of the headers, too. mkdocs-material makes OUT/site of them. The shim is iframe-worker's, with which a page that is opened
as a file can be searched; tools/setup site brings both. A link that leads nowhere, also to a heading, is an error, and so is anything that
a page would fetch. Open OUT/site/index.html.
"""

import argparse
import importlib.util
import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
LINK = re.compile(r"(!?)\[([^\]]*)\]\(([^)\s#]+)(#[^)\s]*)?\)")
NOTHING_TO_BUILD_WITH = 77  # ctest skips it
LEFT_OUT = {"build", "node_modules"}
GROUPS = [
    ("Start", ["README.md", "docs/index.md", "docs/expect.md", "docs/firmware-engineer.md", "docs/roboticist.md", "docs/control-engineer.md", "AGENTS.md"]),
    ("Into a drive", ["docs/integration.md", "docs/parameters.md", "docs/numbers.md", "firmware/README.md", "docs/linux.md", "examples/"]),
    ("For a rig", ["docs/your-rig.md", "docs/identification.md", "tools/design/README.md", "host_sim/"]),
    ("Tools", ["docs/tools.md", "docs/sweep.md", "docs/python.md"]),
    ("Look up", ["docs/keys.md", "docs/all-parameters.md", "docs/registers.md", "docs/drive-keys.md", "docs/headers.md"]),
    ("Understand and change", ["docs/architecture.md", "docs/feedforward.md", "research/", "CONTRIBUTING.md", "SECURITY.md", "CHANGELOG.md", "tests/"]),
]


def pages():
    found = []
    for folder, below, names in os.walk(ROOT):
        below[:] = [name for name in below if name not in LEFT_OUT and not name.startswith(".")]
        found += [Path(folder, name).relative_to(ROOT) for name in names if name.endswith(".md")]
    return sorted(found)


def collect(page, folder):
    """The page with what it shows or links to beside it. A folder has no page: its link becomes its name."""

    def with_target(link):
        picture, text, target, _ = link.groups()
        path = (ROOT / page).parent.joinpath(target).resolve()
        if re.match(r"[a-z]+:", target) or path.suffix == ".md" or not path.is_relative_to(ROOT):
            return link[0]
        if path.is_dir():
            return text
        if path.is_file():
            to = folder / path.relative_to(ROOT)
            to.parent.mkdir(parents=True, exist_ok=True)
            shutil.copy(path, to)
        return link[0]

    to = folder / page
    to.parent.mkdir(parents=True, exist_ok=True)
    to.write_text(LINK.sub(with_target, (ROOT / page).read_text(encoding="utf-8")), encoding="utf-8")


def said(*command):
    return subprocess.run([str(part) for part in command], check=True, capture_output=True, text=True).stdout


def print_pages(folder, options):
    """What the programs print: text by page."""
    printed = {
        "keys.md": "# Keys of a scenario\n\n" + said(options.sim, "list", "--markdown"),
        "all-parameters.md": "# All parameters\n\n" + said(options.sim, "list", "--parameters"),
        "numbers.md": said(sys.executable, "-B", ROOT / "tests/bench/numbers_md.py"),
    }
    if options.link:
        printed["registers.md"] = said(options.link, "list", "--markdown")
    if options.drive:
        printed["drive-keys.md"] = "# Keys of tribo-drive\n\n" + said(options.drive, "--keys")
    for name, text in printed.items():
        (folder / "docs" / name).write_text(text, encoding="utf-8")


def add_reference(folder, work):
    """Doxygen's pages of the headers, and one that leads there."""
    text = "There is no doxygen: `tools/setup reference` installs it.\n"
    if shutil.which("doxygen"):
        said(sys.executable, "-B", ROOT / "tools/dev/reference", work)
        shutil.copytree(work / "html", folder / "reference")
        text = "[The reference of the headers](../reference/index.html), by the rooms of the library.\n"
    (folder / "docs/headers.md").write_text(f"# Headers\n\n{text}", encoding="utf-8")


def navigation(folder):
    there = sorted(str(path.relative_to(folder)) for path in folder.rglob("*.md"))
    listed = [(title, [page for entry in entries for page in there if page == entry or (entry.endswith("/") and page.startswith(entry))])
              for title, entries in GROUPS]
    listed.append(("More", [page for page in there if not any(page in some for _, some in listed)]))
    return "".join(f"  - {title}:\n" + "".join(f"      - {page}\n" for page in some) for title, some in listed if some)


def keep_here(site, shim):
    """Without the network: the shim is the site's, and nothing else is fetched."""
    place = site / "assets/javascripts/iframe-worker.js"
    shutil.copy(shim, place)
    for page in site.rglob("*.html"):
        text = page.read_text(encoding="utf-8").replace("https://unpkg.com/iframe-worker/shim", os.path.relpath(place, page.parent))
        page.write_text(text, encoding="utf-8")
        fetched = re.findall(r'''<(?:script|img|link|iframe)\b[^>]*\b(?:src|href)=["']?(https?://[^"' >]+)''', text)
        if fetched:
            sys.exit(f"build.py: {page} would fetch {', '.join(fetched)}")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("out", type=Path)
    parser.add_argument("--sim", required=True)
    parser.add_argument("--shim", required=True, type=Path)
    parser.add_argument("--link")
    parser.add_argument("--drive")
    options = parser.parse_args()
    if not importlib.util.find_spec("material") or not options.shim.exists():
        print("build.py: there is no mkdocs-material, or no iframe-worker: tools/setup site brings them", file=sys.stderr)
        sys.exit(NOTHING_TO_BUILD_WITH)
    folder = options.out / "pages"
    shutil.rmtree(folder, ignore_errors=True)
    for page in pages():
        collect(page, folder)
    print_pages(folder, options)
    add_reference(folder, options.out / "reference")
    settings = Path(__file__).with_name("mkdocs.yml").read_text(encoding="utf-8")
    (options.out / "mkdocs.yml").write_text(f"{settings}nav:\n{navigation(folder)}", encoding="utf-8")
    done = subprocess.run([sys.executable, "-B", "-m", "mkdocs", "build", "--strict", "--config-file", options.out / "mkdocs.yml"],
                          env={**os.environ, "NO_MKDOCS_2_WARNING": "1"}, capture_output=True, text=True, check=False)
    if done.returncode != 0:
        sys.exit(f"{done.stdout}{done.stderr}build.py: mkdocs refuses the pages, see above")
    keep_here(options.out / "site", options.shim)
    print(options.out / "site/index.html")


if __name__ == "__main__":
    main()
