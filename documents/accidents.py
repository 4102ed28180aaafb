"""Tables and pictures of docs/studies/accidents.md: `python -m documents.accidents` runs their days and writes them.

What of a day is published is in its drill; here are the published time and place of the collision, against which the
run is held, and how far both move when what was assumed, or stated as "about", is another.
"""

from __future__ import annotations

import sys
import tomllib
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from types import MappingProxyType
from typing import Final

import numpy as np
import polars as pl

from documents.studies import block_text, with_blocks
from documents.studies_pictures import train_graphs
from network.clock import clock
from network.model import Line
from network.units import mps
from scenario.scenario import load_scenario
from simulation.events import Collision, SignalActed, SignalPassed, WrongDeparture
from simulation.line_signals.machine import Aspect
from simulation.line_signals_settings import LineSignals, SignalDeed
from simulation.setup import Setup
from study.drilling.drill import find_drill
from study.report.data import ReportedRun
from study.runner.run import FinishedRun, PartyLink, execute
from wayside.said import Refused

ROOT: Final = Path(__file__).resolve().parents[1]
FILE: Final = Path("docs/studies/accidents.md")
LISTS: Final = ROOT / "documents/station_lists"
UNCHECKED: Final = (SignalDeed.SEND_OFF.value, SignalDeed.SUBSTITUTE.value)  # by the machine
SIGNS: Final = MappingProxyType({"o": "the accident, as published", "x": "trains collide in this run"})
Change = Callable[[Setup], Setup]


@dataclass(frozen=True, slots=True)
class Accident:
    """One accident: its drills by how the line is worked, what is changed to see what it rests on, when and where it
    happened, and how near a run is to come.
    """

    name: str
    ways: Mapping[str, str]
    changes: Mapping[str, Change]
    at_s: float
    within_s: float
    km: float
    within_m: float
    window_s: tuple[float, float]  # of its picture

    @property
    def as_it_was(self) -> str:
        """The drill of the day."""
        return next(iter(self.ways.values()))

    @property
    def key(self) -> str:
        """What its tables and its picture are called."""
        return self.as_it_was.partition("/")[0]


@dataclass(frozen=True, slots=True)
class Meeting:
    """Where and when two trains of a run collided, in kilometres as published."""

    at_s: float
    km: float

    def words(self, accident: Accident) -> str:
        """With how far that is from what is published."""
        away_s, away_m = self.at_s - accident.at_s, 1000.0 * (self.km - accident.km)
        return f"{clock(round(self.at_s))}, km {self.km:.2f} ({away_s:+.0f} s, {away_m:+.0f} m)"


def run_of(drill: str, change: Change | None = None) -> FinishedRun:
    """Its day."""
    scenario = load_scenario(find_drill(drill))
    setup = scenario.setup if change is None else change(scenario.setup)
    return execute(replace(scenario, setup=setup), PartyLink.SIMULATED)


def meeting_of(run: FinishedRun) -> Meeting | None:
    """When and where trains collided; the place is half way between the last samples of both fronts."""
    found = next((e for e in run.result.journal.entries if isinstance(e.event, Collision)), None)
    if found is None:
        return None
    before = run.tables.trajectory.filter(pl.col("t_s") <= found.t_s)
    fronts_m = [rows["kilometrage_m"][-1] for _, rows in before.group_by("unit")]
    return Meeting(found.t_s, _published_km(run.scenario.setup.line, float(np.mean(fronts_m)) / 1000.0))


def _published_km(line: Line, km: float) -> float:
    own, official = kilometres(line)
    return float(np.interp(km, own, official))


def kilometres(line: Line) -> tuple[list[float], list[float]]:
    """Of its stations, the line's own and those of its list: the track's geometry is a little longer."""
    listed = tomllib.loads((LISTS / f"{line.id}.toml").read_text("utf-8"))["stations"]
    own = [line.stations[row["id"]].position_m / 1000.0 for row in listed]
    return own, [float(row["km"]) for row in listed]


def refusals(run: FinishedRun) -> Iterator[str]:
    """Who refused what, or passed what at stop, in the order of the journal; each once."""
    said: dict[str, None] = {}
    for entry in run.result.journal.entries:
        match entry.event:
            case Refused(unit_id=unit, other_id=other, section_ids=sections) if other:
                said[f"{entry.who} refused {unit} section {', '.join(sections)}, which {other} had"] = None
            case SignalActed(does=does, signal_id=signal) if does in UNCHECKED:
                said[f"{entry.who}: {does} at {signal}"] = None
            case SignalPassed(unit_id=unit, signal_id=signal, aspect=aspect) if aspect != Aspect.CLEAR.value:
                said[f"{unit} passed {signal} at {aspect}"] = None
            case WrongDeparture(signal_id=signal, stops=stops, works=works):
                kept = f"kept {', '.join(stops)} at stop" if works else "held nothing"
                said[f"the detector of {signal} {kept}"] = None
            case _:
                pass
    yield from said


def ways(accident: Accident, runs: Mapping[str, FinishedRun]) -> Iterator[str]:
    """A row for each way of working the line."""
    yield "| the line worked | collision | trains arrived | who refused what, who passed what |"
    yield "|---|---|---|---|"
    for label, run in runs.items():
        meeting = meeting_of(run)
        where = "none" if meeting is None else f"**{meeting.words(accident)}**"
        yield f"| {label} | {where} | {len(run.result.trains_arrived)} | {'; '.join(refusals(run))} |"


def picture(accident: Accident, runs: Mapping[str, FinishedRun], file: Path) -> None:
    """Train graphs, a panel for each way; a cross where trains collide, a circle where they did in truth."""
    line = next(iter(runs.values())).scenario.setup.line
    own, official = kilometres(line)
    place_m = 1000.0 * float(np.interp(accident.km, official, own))
    marks: list[dict[str, tuple[float, float]]] = []
    for run in runs.values():
        meeting = meeting_of(run)
        marks.append({"o": (accident.at_s, place_m)})
        if meeting is not None:
            marks[-1]["x"] = (meeting.at_s, 1000.0 * float(np.interp(meeting.km, official, own)))
    shown = [
        (label, ReportedRun(line, run.scenario.setup.timetable, run.tables)) for label, run in runs.items()
    ]
    train_graphs(file, shown, accident.window_s, marks=marks, meanings=SIGNS)


def sensitivity(accident: Accident) -> Iterator[str]:
    """A row for each change, by itself."""
    yield "| changed | collision (from what is published) |"
    yield "|---|---|"
    for label, change in {"nothing": None, **accident.changes}.items():
        meeting = meeting_of(run_of(accident.as_it_was, change))
        row = f"| {label} | {'none' if meeting is None else meeting.words(accident)} |"
        sys.stderr.write(row + "\n")
        yield row


# what is changed --------------------------------------------------------------------------------------------------


def with_signals(setup: Setup, change: Callable[[LineSignals], Mapping[str, object]]) -> Setup:
    """The setup with some keys of its line signals changed. ValueError where it has none."""
    if setup.line_signals is None:
        raise ValueError(f"{setup.name} has no [line_signals]")
    changed = setup.line_signals.model_copy(update=dict(change(setup.line_signals)))
    return replace(setup, line_signals=changed)


def acts_later(who: str, by_s: float) -> Change:
    """Somebody's acts by signals come later, by so much."""

    def later(settings: LineSignals) -> Mapping[str, object]:
        moved = [a.model_copy(update={"at_s": a.at_s + by_s * (a.who == who)}) for a in settings.act]
        return {"act": tuple(moved)}

    return lambda setup: with_signals(setup, later)


def line_speed(factor: float) -> Change:
    """Trains may run faster or slower all along the line, but for its curves."""

    def change(setup: Setup) -> Setup:
        line = replace(setup.line, max_speed_mps=factor * setup.line.max_speed_mps)
        return with_signals(replace(setup, line=line), lambda _: {"speed_kmh": line.max_speed_mps / mps(1.0)})

    return change


def traction(stock_id: str, factor: float) -> Change:
    """A train pulls more or less at every speed."""

    def change(setup: Setup) -> Setup:
        row = setup.trains[stock_id].row.copy()
        for name in ("traction_curve_n", "traction_force_max_n", "traction_power_max_w"):
            row[name] = row[name] * factor
        return replace(setup, trains={**setup.trains, stock_id: replace(setup.trains[stock_id], row=row)})

    return change


def load(share: float) -> Change:
    """Both trains are as full as that."""
    return lambda setup: replace(setup, load=setup.load.model_copy(update={"load_share_mean": share}))


def dwell(seconds: float) -> Change:
    """Trains stand so long at halts, at least."""

    def change(setup: Setup) -> Setup:
        head = setup.timetable.head.model_copy(update={"dwell_min_s": seconds})
        return replace(setup, timetable=replace(setup.timetable, head=head))

    return change


SHIGARAKI: Final = Accident(
    "Shigaraki 1991",
    MappingProxyType(
        {
            "as it was": "shigaraki/01_as_it_was",
            "as it was, but the detector works": "shigaraki/04_detector_works",
            "as it was, but the lever as it was built": "shigaraki/05_as_it_was_built",
            "by the centre": "shigaraki/03_by_the_centre",
            "on board": "shigaraki/02_on_board",
        }
    ),
    MappingProxyType(
        {
            "501D leaves 15 s sooner": acts_later("signalman KBK", -15.0),
            "501D leaves 15 s later": acts_later("signalman KBK", 15.0),
            "501D leaves at 10:18, as some sources have it": acts_later("signalman KBK", -60.0),
            "534D leaves 15 s sooner": acts_later("operator SGR", -15.0),
            "534D leaves 15 s later": acts_later("operator SGR", 15.0),
            "534D leaves at 10:24, as some sources have it": acts_later("operator SGR", -60.0),
            "line speed 5 % less": line_speed(0.95),
            "line speed 5 % more": line_speed(1.05),
            "501D pulls 5 % less": traction("JR", 0.95),
            "501D pulls 5 % more": traction("JR", 1.05),
            "trains half as full": load(0.5),
            "534D stands 30 s at halts": dwell(30.0),
        }
    ),
    at_s=10 * 3600 + 35 * 60.0,
    within_s=60.0,
    km=9.1,
    within_m=200.0,
    window_s=(10 * 3600 + 10 * 60.0, 10 * 3600 + 50 * 60.0),
)
BAD_AIBLING: Final = Accident(
    "Bad Aibling 2016",
    MappingProxyType(
        {
            "as it was": "mangfall/01_as_it_was",
            "by the centre": "mangfall/03_by_the_centre",
            "on board": "mangfall/02_on_board",
        }
    ),
    MappingProxyType(
        {
            "the dispatcher acts 15 s sooner": acts_later("dispatcher AIB", -15.0),
            "the dispatcher acts 15 s later": acts_later("dispatcher AIB", 15.0),
            "79505 stands 20 s at Kurpark": dwell(20.0),
            "79505 stands 45 s at Kurpark": dwell(45.0),
            "line speed 5 % less": line_speed(0.95),
            "line speed 5 % more": line_speed(1.05),
            "79506 pulls 20 % less": traction("ET355", 0.8),
            "79505 pulls 20 % less": traction("ET325", 0.8),
            "both trains full": load(1.0),
        }
    ),
    at_s=6 * 3600 + 46 * 60 + 56.0,
    within_s=30.0,
    km=30.3,
    within_m=200.0,
    window_s=(6 * 3600 + 37 * 60.0, 6 * 3600 + 60 * 60.0),
)
ACCIDENTS: Final = (SHIGARAKI, BAD_AIBLING)


def main(root: Path = ROOT) -> None:
    """Write tables and pictures."""
    made: dict[str, str] = {}
    for accident in ACCIDENTS:
        runs = {label: run_of(drill) for label, drill in accident.ways.items()}
        picture(accident, runs, root / FILE.with_suffix("") / f"{accident.key}.png")
        made[f"{accident.key}-ways"] = block_text(ways(accident, runs))
        made[f"{accident.key}-sensitivity"] = block_text(sensitivity(accident))
    page = root / FILE
    page.write_text(with_blocks(page.read_text("utf-8"), made), "utf-8")


if __name__ == "__main__":
    main()
