"""Writes docs/substitute-working.md from `simulation.procedure`: `python -m documents.substitute [FILE]`."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path
from types import MappingProxyType
from typing import Final

from documents.page import write_page
from simulation.people import Pause, People
from simulation.procedure import PROCEDURES, WITHIN_STATION, Post, ProcedureRow, Regime, before_entry
from simulation.substitute.persons import NOT_YET_THERE
from simulation.substitute.sight import REFUSALS

FILE: Final = Path("docs/substitute-working.md")
HEAD: Final = """\
# Substitute working

Made by `make docs` from `simulation/procedure.py`; do not edit.

With `[substitute]` in a scenario or a drill people work the line while the block manager is off, instead of
waiting. Units are cut out, trains are driven by hand at {speed} km/h at most, and people alone keep them apart:
**one pilot belongs to a section between stations, and no train comes in without him**. That is the third regime
beside interlocking on board and by a centre. `branchline drill karasuyama/95_substitute_working` shows two
hours of it; [the study](studies/steps-left-out.md) shows what comes of each step that is left out.

```toml
[people]
react = true          # afterwards staff restore the picture of the line

[substitute]
regime = "pilot_by_telephone"
staffed = ["HSK", "KRS"]

[[substitute.left_out]]   # people go on as though it had been done
step = "agree"
block = "OGN-KRS"
train = "326M"
```

A step is done once all that it needs is done and the world lets it be done, after a time that is drawn from
`[people]` ([scenario files](files/scenario.md)). What is said to the other end by telephone is read back, which
its time includes. A step that is left out is written into the journal (`step_left_out`), and nothing refuses it
but equipment: a unit that is not cut out does not let its train go, points do not lie for a train that nobody
set them for. What cannot be done without it falls too: nobody agrees who was not asked, nobody acts at a
station to which nobody came.
"""
PERSONS: Final = """
## By persons

{posts} are roles that a person can take over, at the desk ([desk.md](desk.md)) or in a drill; the program plays the
others. A step in the tables waits for the person whose it is, of both operators for either, and takes the time that it
takes the program. A role can be given back at any moment, and the program goes on from the book.

```toml
[[act]]
kind = "take_role"
target = "operator OGN"
start = "06:45:00"

[[act]]
kind = "do_step"          # or leave_out_step
target = "operator OGN"
step = "ask"
block = "OGN-KRS"
train = "326M"
start = "07:31:00"
```

A step may be done before what it needs, before what it waits for has come, or for another train than that in the book;
the journal then has `step_out_of_order` before it. As a train is let go, what should have been done for it and was not
counts as left out. Refused (`step_refused`) is only what equipment or bodies do not let be done: {refusals}
([decision 184](decisions/184-persons-in-roles.md)).
"""
TAIL: Final = """
## The pilot's rule

Its checker (`pilots-leave`) goes by the truth and by what was written down as done. A train whose unit is cut
out comes into a section between stations only after {needs}, and after the train before it was reported
arrived. Where a pilot has a section, no train comes in under authority. `inside-holding` and
`proven-before-entry` are about trains under authority and say nothing of units that are cut out; that two
trains are in one section is a breach whoever leads them, and no rule can be switched off.

## Sources, and what is assumed

- When it may begin, one pilot for a section with a red armband, his presence or his ticket, an operator at each
  end who agree by telephone, one operator alone and the pilot always aboard where a train comes back, the
  dispatcher with an occupancy display and radio instead of operators: rules for the operation of railways
  (鉄道運転規則, Ordinance 15 of 1987), articles 130 to 146.
- The operator who is sent to an unstaffed place first, the section confirmed clear before the pilot is chosen,
  the consent of the other end before each train, the pilot's leaving confirmed at the other end: the ministry's
  account before the transport committee of the House of Councillors, 30 May 1991.
- That a change of working is agreed once the last train has arrived: JNR rules for train operation (運転取扱基準規程,
  1972), chapter 3.
- Assumed: who cranks points and when; that a unit is cut out by its driver; all times; that trains go through a
  section in the order of the plan; that the dispatcher of `pilot_by_dispatcher` can have points set at once, as
  at a CTC.
- Where trains follow each other in one direction, all but the last have the pilot's ticket (指導券) by
  `pilot_by_telephone`; by the others, and where it comes otherwise, he goes back by road in `reach_s` (assumed).
- A unit that was cut out has forgotten, and is commissioned again ([decision
  178](decisions/178-a-unit-cut-out-forgets.md)).

## What is not there

Trains that run through a station without stopping, trains on batteries, a change of pilots, a second failure
meanwhile that would need a rescue train (伝令法). While people work the line, staff who react see to nothing else.
"""
NAMES: Final = MappingProxyType(
    {
        Regime.TELEPHONE: "指導通信式: `pilot_by_telephone`",
        Regime.SHUTTLE: "指導式: `pilot_shuttle`",
        Regime.DISPATCHER: "指導指令式: `pilot_by_dispatcher`",
    }
)


def _table(rows: Sequence[ProcedureRow]) -> Iterator[str]:
    people = People()
    yield "| when | step | who | to whom | says | needs | waits until | mean time |"
    yield "|---|---|---|---|---|---|---|---|"
    for row in rows:
        needs = ", ".join(f"`{step.value}`" for step in row.needs)
        each = " each" if row.pause is Pause.CRANK else ""
        time = f"{people.mean_s(row.pause):g} s{each} (`{row.pause.value}`)"
        says = row.says.format(block="A–B", train="N")
        yield (
            f"| {row.part.value} | `{row.step.value}` | {row.who.value} | {row.to.value} | {says} | {needs}"
            f" | {row.waits} | {time} |"
        )


def document() -> str:
    """The page."""
    parts = [HEAD.replace("{speed}", "45")]
    for regime, rows in PROCEDURES.items():
        parts.append(f"\n## {NAMES[regime]}\n\n" + "\n".join(_table(rows)) + "\n")
    parts.append(
        "\n## Within a station, and between it and its portal\n\n" + "\n".join(_table(WITHIN_STATION)) + "\n"
    )
    needs = ", ".join(f"`{step.value}`" for step in before_entry(Regime.TELEPHONE))
    posts = ", ".join(f"`{post.value}`" for post in Post)
    refusals = "; ".join((*REFUSALS, NOT_YET_THERE))
    parts.append(PERSONS.replace("{posts}", posts).replace("{refusals}", refusals))
    parts.append(TAIL.replace("{needs}", needs))
    return "".join(parts)


if __name__ == "__main__":
    write_page(document, FILE)
