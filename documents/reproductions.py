"""Writes docs/reproductions.md from what the reproductions came to: `python -m documents.reproductions [FILE]`.

Running them takes half an hour, so what the page needs of each is kept in `KEPT` and only taken anew where names are
asked for: `python -m documents.reproductions --run [NAME ...]`, all of `branchline reproduce list` without a name.
"""

from __future__ import annotations

import json
import sys
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any, Final, cast

from documents.counted import slices
from documents.page import write_page
from papers.reproduction import CaseRow, Options, Reproduction
from papers.specification import REPRODUCTIONS, reproduction

FILE: Final = Path("docs/reproductions.md")
KEPT: Final = Path(__file__).with_suffix(".json")
RUN: Final = "--run"
NONE: Final = "-"

HEAD: Final = """\
# Results of the reproductions

Made from `documents/reproductions.json`, which `make reproductions` writes by running them (half an hour); do not edit.
Each row is a name of `branchline reproduce list`, with the case that tests the paper's idea, and the same experiment
without the idea, which must fail ([decision 063](decisions/063-what-a-reproduction-must-fail-without.md)). The last
column counts the criteria that are met. Below, every criterion that is missed is listed with its size and reason, then
how figures depend on assumptions. `branchline reproduce NAME` prints all cases and parameters with their origin.

| name | case | published | ours | criterion | without the idea | its figure | met |
|---|---|---|---|---|---|---|---|
"""
MISSED: Final = "\n## Criteria that are missed\n"
HANGS: Final = (
    "\n## How figures depend on assumptions\n\nNot judged: the same experiment with another assumption.\n"
)


def kept_of(found: Reproduction) -> dict[str, Any]:
    """What the page needs of a reproduction, as it is kept."""
    without = found.null.case("")
    nulls = {row.case.removeprefix(without): row for row in found.rows if row.case.startswith(without)}
    own = [row for row in found.rows if not row.case.startswith(without)]
    judged = [row for row in own if row.judged]
    idea = [row for row in judged if row.case in nulls]
    idea = idea or [row for row in judged if row.case.endswith(found.null.fails)]  # of another number of runs
    leads = next((row for row in idea if row.passed), idea[0] if idea else None)
    first = next(iter(nulls.values()))
    null = first if leads is None else nulls.get(leads.case, first)
    return {
        "title": found.title,
        "slice": found.slice,
        "leads": None if leads is None else _row(leads),
        "null_method": found.null.name,
        "null": _row(null),
        "null_case": null.case.removeprefix(without),
        "null_held": all(row.passed for row in nulls.values()),
        "judged": len(judged),
        "missed": [_row(row) for row in judged if not row.passed],
        "hangs_on": [_row(row) for row in own if not row.judged],
    }


def _row(row: CaseRow) -> dict[str, Any]:
    return {"case": row.case, "paper": row.paper, "ours": row.ours, "criterion": row.criterion}


def run_reproductions(names: Sequence[str]) -> None:
    """Run reproductions and keep what the page needs of them; what is kept of the others stays."""
    for name in names:
        found = kept_of(reproduction(name)(Options()))
        whole = {**kept_outcomes(), name: found}
        text = json.dumps(
            {key: whole[key] for key in sorted(whole)}, indent=1, ensure_ascii=False, default=str
        )
        aside = KEPT.with_suffix(".new")
        aside.write_text(text + "\n", encoding="utf-8")
        aside.replace(KEPT)
        sys.stdout.write(f"{name}: {len(found['missed'])} of {found['judged']} missed\n")


def kept_outcomes() -> dict[str, Any]:
    """What was kept, by name."""
    found: dict[str, Any] = json.loads(KEPT.read_text("utf-8")) if KEPT.exists() else {}
    return found


def document(whole: Mapping[str, Any] | None = None) -> str:
    """The page of what is kept."""
    found = kept_outcomes() if whole is None else whole
    lines = [_line(name, found.get(name)) for name in sorted(REPRODUCTIONS)]
    text = HEAD + "".join(lines)
    if missed := "".join(_listed(found, "missed")):
        text += MISSED + missed
    if hangs := "".join(_listed(found, "hangs_on")):
        text += HANGS + hangs
    return text


def _line(name: str, one: Mapping[str, Any] | None) -> str:
    if one is None:
        return f"| `{name}` | never run for this page |" + f" {NONE} |" * 6 + "\n"
    leads = one["leads"] or {
        "case": one["null_case"],
        "paper": one["null"]["paper"],
        "ours": None,
        "criterion": "",
    }
    met = f"{one['judged'] - len(one['missed'])} of {one['judged']}"
    met += "".join(f" (**{text}**)" for text in slices({name: one}).values())
    without = one["null_method"] + ("" if one["null_held"] else " (**meets it too**)")
    if leads in one["missed"]:  # of the cases by which the idea is told apart it meets none
        without += " (**neither meets it, which shows nothing**)"
    cells = (
        f"`{name}`",
        leads["case"],
        leads["paper"],
        leads["ours"],
        leads["criterion"],
        without,
        one["null"]["ours"]
        if leads["case"] == one["null_case"]  # else of another case, which is named: 9 of 10 are not 9 of 100
        else {one["null_case"]: one["null"]["ours"]},
    )
    return "| " + " | ".join(cell_text(cell) for cell in cells) + f" | {met} |\n"


def _listed(found: Mapping[str, Any], key: str) -> Iterator[str]:
    """Rows of every name, below the name."""
    for name in sorted(name for name in REPRODUCTIONS if name in found and found[name][key]):
        yield f"\n`{name}`\n\n"
        for row in found[name][key]:
            paper = "" if row["paper"] is None else f"published: {cell_text(row['paper'])}; "
            yield f"- {cell_text(row['case'])}. {paper}ours: {cell_text(row['ours'])}. {cell_text(row['criterion'])}.\n"


def cell_text(value: object) -> str:
    """A value for a cell: pairs with commas, those within others in brackets; what would end a cell is escaped."""
    if value is None or value == "":
        return NONE
    if isinstance(value, Mapping):
        parts: list[str] = []
        for key, inner in cast("Mapping[str, object]", value).items():
            said = cell_text(inner)
            parts.append(f"{key}: ({said})" if isinstance(inner, Mapping) else f"{key}: {said}")
        text = ", ".join(parts)
    elif isinstance(value, list | tuple):
        text = ", ".join(cell_text(inner) for inner in cast("Sequence[object]", value))
    elif isinstance(value, bool):
        text = "yes" if value else "no"
    else:
        text = f"{value:.6g}" if isinstance(value, float) else str(value)
    return text.replace("|", "\\|").replace("\n", " ")


if __name__ == "__main__":
    if sys.argv[1:2] == [RUN]:
        run_reproductions(sys.argv[2:] or sorted(REPRODUCTIONS))
        sys.argv[1:] = []
    write_page(document, FILE)
