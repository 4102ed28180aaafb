"""The driving laws that there are. A new one is a file of its own and one entry in LAWS.

A law is a compiled function of its own row, the tick's CUE, the unit, the train as believed, its behaviour, the path
database and the plans; it returns the notch it asks for (> 0 power, < 0 brake) and sets `cue.ceiling_mps`. What keeps
the train safe or brings it to the mark lies outside (`onboard.notches`): the stronger brake counts.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Annotated, Any, Final, Protocol, cast

import numpy as np
from numpy.typing import NDArray

from network.files.toml_input import Record
from onboard.driving.laws.by_hand import ByHandRow, by_hand
from onboard.driving.laws.cue import CueRow
from onboard.driving.laws.driver import DRAWN, Driver, DriverRow, driver
from onboard.driving.laws.follow_plan import FollowPlan, FollowPlanRow, follow_plan
from onboard.driving.laws.fuzzy_notes import fuzzy_run_note
from onboard.driving.laws.fuzzy_records import PredictiveFuzzy, PredictiveFuzzyRow
from onboard.driving.laws.hold_speed import HoldSpeedRow, hold_speed
from onboard.driving.laws.optimal import Optimal, OptimalRow, optimal
from onboard.driving.laws.pid import Pid, PidRow, pid
from onboard.driving.laws.predictive_fuzzy import predictive_fuzzy
from onboard.notes import Note
from onboard.records import BehaviourRow, UnitRow
from vehicle.compiled import compiled_lines
from vehicle.record import dtype_of
from vehicle.records import TrainRow


@dataclass(frozen=True, slots=True)
class Law:
    """One law: its compiled function, named as scenarios name it, and the class of its own row.

    `settings`: the table of a scenario with its figures, which the row has under that name. `drawn`: fields of the
    row that are drawn for each stock, standard normal. `plans`: it follows a plan, which the unit makes at each
    departure, and anew when the train is off it by more than the setting `replan_after_s`; the setting
    `regeneration_share` counts in it. `stops`: it brings the train to the mark by itself, without TASC. `run_note`:
    what the journal says of a run that has just ended, of its row. `by_person`: a person sets its notch during the run,
    so that no scenario chooses it.
    """

    function: Callable[..., float]
    row: type
    settings: type[Record] | None = None
    drawn: tuple[str, ...] = ()
    plans: bool = False
    stops: bool = False
    run_note: Callable[[Any], Note | None] | None = None
    by_person: bool = False

    @property
    def name(self) -> str:
        """Name in scenarios."""
        return self.function.__name__


LAWS: Final = (
    Law(hold_speed, HoldSpeedRow),
    Law(follow_plan, FollowPlanRow, FollowPlan),
    Law(optimal, OptimalRow, Optimal, plans=True),
    Law(pid, PidRow, Pid, stops=True),
    Law(driver, DriverRow, Driver, drawn=DRAWN),
    Law(predictive_fuzzy, PredictiveFuzzyRow, PredictiveFuzzy, stops=True, run_note=fuzzy_run_note),
    Law(by_hand, ByHandRow, stops=True, by_person=True),
)
LAW_NAMES: Final = tuple(law.name for law in LAWS if not law.by_person)  # of those that a scenario may choose


class LawsRow(Protocol):
    """Which law drives, and a row for each of them under its name."""

    number: int
    stops: Annotated[int, "1: this law brings the train to the mark by itself"]


def note_of_run(laws: LawsRow) -> Note | None:
    """What the law that drives has to tell the journal of the run that has just ended."""
    law = LAWS[laws.number]
    return None if law.run_note is None else law.run_note(getattr(laws, law.name))


LawsRow.__annotations__.update({law.name: law.row for law in LAWS})
LAWS_ROW: Final = dtype_of(LawsRow)

Rows = NDArray[np.void]
Ask = Callable[[LawsRow, CueRow, UnitRow, TrainRow, BehaviourRow, Rows, Rows], float]


def _ask() -> Ask:
    """A chain of ifs over the table."""
    given = "cue, unit, train, behaviour, path, plan"
    lines = [f"def ask(laws, {given}):"]
    for number, name in enumerate(law.name for law in LAWS):
        lines += [f"    if laws.number == {number}:", f"        return {name}(laws.{name}, {given})"]
    lines += ["    return -train.brake_notches"]
    return cast("Ask", compiled_lines(lines, {law.name: law.function for law in LAWS}, __name__))


ask: Final = _ask()
