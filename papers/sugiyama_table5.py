"""Table 5 of Sugiyama, Fukuda and Kitano (2017): every row of the test menu, as drills on two lines.

Row 14 is no row of theirs: the failure of table 2 that table 5 leaves out, at three moments.

The paper ran the menu on its own test track and found every reaction as expected. Here each row is one drill or
several (`study/drills/<line>/<row>_*.toml`) on the model of that track and again on a day of the Karasuyama line.
A row passes if every expectation of its drill is met, no invariant is broken and every train arrives.
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import Final

from papers.parameter_sets import LINE
from papers.reproduction import CaseRow, NullMethod, Options, Parameter
from papers.specification import Findings, Specification
from study.drilling.drill import Drill, run_drill, shipped_drills
from study.runner.run import PartyLink

NAME: Final = "sugiyama-table5"
NULL_DRILLS: Final = ("rtri/08b_tachometer_silent", "rtri/13_tag_not_read")
LINES: Final = ("rtri", "karasuyama")
CRITERION: Final = "every expectation met, no invariant broken, every train arrives"
_DRILL: Final = re.compile(r"(?P<line>[a-z]+)/(?P<row>\d\d)[a-z]?_.+")


@dataclass(frozen=True, slots=True)
class Reaction:
    """A row of table 5: what fails, and how the system is expected to react."""

    row: int
    failure: str
    expected: str


TABLE5: Final = (
    Reaction(1, "none: normal (通常時)", "normal operation"),
    Reaction(2, "none: turning back (折返し)", "turning back is carried out"),
    Reaction(3, "none: block wanted while another train is there", "the block cannot be secured"),
    Reaction(
        4,
        "on-board unit: power off, position then fixed",
        "restarts; low speed until position and secured sections are known; then normal speed",
    ),
    Reaction(
        5,
        "on-board unit: power off, position not fixed",
        "restarts; low speed; no tag before the points; low speed goes on until they are passed",
    ),
    Reaction(
        6,
        "on-board unit: transmission to the block manager cut",
        "sections behind cannot be released; released together after recovery",
    ),
    Reaction(
        7,
        "on-board unit: transmission to the terminal cut before the throw is complete",
        "a stop pattern to the points although the section is secured",
    ),
    Reaction(
        8,
        "tachometer: abnormal output, no output",
        "the position is wrong; found against the tags; stopped for a position detection fault",
    ),
    Reaction(
        9,
        "block manager: power off",
        "all sections undefined, trains run within what they secured; restored by hand",
    ),
    Reaction(
        10,
        "block manager: transmission cut",
        "sections behind cannot be released; released together after recovery",
    ),
    Reaction(11, "terminal: transmission cut", "a stop pattern to the points, thrown or not"),
    Reaction(12, "terminal: power off", "a stop pattern to the points, thrown or not"),
    Reaction(13, "tag: not read", "a position detection fault, against the tachometer"),
    Reaction(
        14,
        "block manager and on-board units: power off together (table 2)",
        "nothing is granted; low speed; the picture is restored from the trains' places, then accepted (4.4 (4))",
    ),
)


def drills_of(row: int, line: str) -> tuple[str, ...]:
    """Names of the shipped drills of a row on a line, in order."""
    names: list[str] = []
    for name in shipped_drills():
        match = _DRILL.fullmatch(name)
        if match is not None and match["line"] == line and int(match["row"]) == row:
            names.append(name)
    return tuple(names)


def experiment(options: Options) -> Findings:
    """Run all rows of table 5. `options.quick` leaves out the Karasuyama line."""
    link = PartyLink(options.link)
    wayside = "processes over Zenoh, power off is SIGKILL" if link is PartyLink.ZENOH else "in this process"
    return Findings(
        [
            _row(reaction, line, name, run_drill(name, link, options.seed))
            for line in (LINES[:1] if options.quick else LINES)
            for reaction in TABLE5
            for name in drills_of(reaction.row, line)
        ],
        (
            Parameter("link", link.value, "", f"command line: wayside devices {wayside}"),
            Parameter("seed", options.seed, "", "command line"),
            Parameter(
                "test line", "rtri_test_line", "", "figures 3 to 5; distances assumed, see the line file"
            ),
            Parameter("moments of the failures", "in the drill files", "", "assumed: the paper gives none"),
        ),
        ["the paper: under every condition the train was controlled safely (section 5)"],
    )


def idle_rows(options: Options) -> list[CaseRow]:
    """The null method: drills in which nothing fails; what is expected of a failure must not be met then."""
    by_number = {reaction.row: reaction for reaction in TABLE5}
    return [
        _row(
            by_number[int(name.split("/")[1][:2])],
            LINES[0],
            name,
            run_drill(name, PartyLink.SIMULATED, options.seed, failing=False),
        )
        for name in NULL_DRILLS
    ]


def _row(reaction: Reaction, line: str, name: str, drill: Drill) -> CaseRow:
    what = f"row {reaction.row}, {line}: {reaction.failure} ({name.split('/')[1]})"
    happened = "; ".join(
        f"{'' if verdict.passed else 'NOT MET: '}{verdict.text}: {verdict.happened}"
        for verdict in drill.verdicts
    )
    sound = drill.passed and not drill.run.broken
    broken = "" if not drill.run.broken else "; " + "; ".join(drill.run.broken)
    return CaseRow(what, reaction.expected, happened + broken, sound, CRITERION)


reproduce: Final = Specification(
    NAME,
    "Table 5: test menu of system failures",
    experiment,
    NullMethod("nothing fails", tuple(f"({name.split('/')[1]})" for name in NULL_DRILLS), idle_rows),
    LINE,
    "quick: the test line only; without --quick also the Karasuyama line",
)
