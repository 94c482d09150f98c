"""Writes the report, one row per claim, as Markdown with figures in a folder and as one HTML file."""

import base64
import csv
import dataclasses
import html
import io

AGREES, PARTLY, DIFFERS = "agrees", "partly", "differs"


@dataclasses.dataclass
class Claim:
    """One statement of the paper and its result."""

    where: str
    paper: str
    run: str
    verdict: str
    choice: str = ""  # the choice made here, if the text leaves one


@dataclasses.dataclass
class Section:
    claims: list
    figure: object = None
    table: tuple = ()  # header, then rows
    name: str = ""  # of the experiment, as is the title
    title: str = ""


def judge(holds, partly=False):
    return AGREES if holds else PARTLY if partly else DIFFERS


def png(figure):
    buffer = io.BytesIO()
    figure.savefig(buffer, format="png", dpi=110, metadata={"Software": None})
    return buffer.getvalue()


HEADER = ("where", "the paper says", "this run shows", "verdict", "where the text leaves a choice")


def claim_rows(claims):
    return [(claim.where, claim.paper, claim.run, claim.verdict, claim.choice) for claim in claims]


def markdown_table(header, rows):
    lines = ["| " + " | ".join(header) + " |", "|" + "---|" * len(header)]
    return "\n".join(lines + ["| " + " | ".join(row) + " |" for row in rows])


def count(sections):
    claims = [claim for section in sections for claim in section.claims]
    where = {verdict: [claim.where for claim in claims if claim.verdict == verdict] for verdict in (AGREES, PARTLY, DIFFERS)}
    sentences = [f"{len(where[AGREES])} of {len(claims)} claims agree."]
    sentences += [f"{title}: {'; '.join(where[verdict])}." for verdict, title in ((PARTLY, "These agree in part"), (DIFFERS, "These do not agree"))
                  if where[verdict]]
    return " ".join(sentences)


INTRODUCTION = (
    "The paper is \"Friction Hysteresis Modeling and Force Control in a Constrained "
    "Single-link Arm\" (DOI 10.1115/1.4004580). `tribo-sim` ran its claims. The paper's "
    "figures come from its rig, or from its own simulation with inputs that it does not list. The plant here is the paper's model, "
    "Eqs. (7), (9) and (10), with its parameters. The inputs follow its description."
)


def write_markdown(path, sections):
    """Writes the Markdown report. The pictures go into a folder next to it, which has its name."""
    pictures = path.with_suffix("")
    pictures.mkdir(exist_ok=True)
    parts = ["# The paper's claims, reproduced", INTRODUCTION, count(sections)]
    for section in sections:
        parts.append(f"## {section.title}")
        parts.append(markdown_table(HEADER, claim_rows(section.claims)))
        if section.table:
            parts.append(markdown_table(section.table[0], section.table[1:]))
        if section.figure is not None:
            (pictures / f"{section.name}.png").write_bytes(png(section.figure))
            parts.append(f"![{section.title}]({pictures.name}/{section.name}.png)")
    path.write_text("\n\n".join(parts) + "\n", encoding="utf-8")


def write_summary(path, sections):
    """Writes the result of each claim for the repository, to `path` and a CSV file next to it. The report has what the paper says, the choices and the figures."""
    parts = ["# The paper's claims, reproduced", INTRODUCTION,
             f"[{path.stem}.csv]({path.stem}.csv) has the result of each run. `research/reproduce --update` runs the claims and writes both files. The report, whose name it prints, "
             "has what the paper says in each place, and the figures.", count(sections)]
    path.write_text("\n\n".join(parts) + "\n", encoding="utf-8")
    with open(path.with_suffix(".csv"), "w", newline="", encoding="utf-8") as file:
        rows = csv.writer(file, lineterminator="\n")
        rows.writerow(("where", "this run shows", "verdict"))
        rows.writerows((claim.where, claim.run, claim.verdict) for section in sections for claim in section.claims)


STYLE = """body{font:15px/1.5 sans-serif;max-width:72em;margin:2em auto;padding:0 1em}
table{border-collapse:collapse;margin:1em 0}td,th{border:1px solid #ccc;padding:.3em .6em;text-align:left;vertical-align:top}
img{max-width:100%}.agrees{background:#dff0e4}.partly{background:#fdf1d0}.differs{background:#f8dcd4}"""


def html_table(header, rows):
    head = "".join(f"<th>{html.escape(cell)}</th>" for cell in header)
    body = "".join(
        "<tr>"
        + "".join(
            f'<td class="{cell}">{cell}</td>' if cell in (AGREES, PARTLY, DIFFERS) else f"<td>{html.escape(cell)}</td>"
            for cell in row
        )
        + "</tr>"
        for row in rows
    )
    return f"<table><tr>{head}</tr>{body}</table>"


def write_html(path, sections):
    parts = [f"<h1>The paper's claims, reproduced</h1><p>{html.escape(INTRODUCTION)}</p><p>{html.escape(count(sections))}</p>"]
    for section in sections:
        parts.append(f"<h2>{html.escape(section.title)}</h2>{html_table(HEADER, claim_rows(section.claims))}")
        if section.table:
            parts.append(html_table(section.table[0], section.table[1:]))
        if section.figure is not None:
            picture = base64.b64encode(png(section.figure)).decode()
            parts.append(f'<img alt="{html.escape(section.title)}" src="data:image/png;base64,{picture}">')
    path.write_text(
        '<!DOCTYPE html><html lang="en"><meta charset="utf-8"><title>The paper\'s claims, reproduced</title>'
        f"<style>{STYLE}</style>{''.join(parts)}</html>\n",
        encoding="utf-8",
    )
