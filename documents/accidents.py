"""The tables and pictures of docs/studies/accidents.md: `python -m documents.accidents` runs their days and writes them.

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

from documents.accidents_pictures import Panel, TrainPath, draw_panels
from network.clock import clock
from network.model import Line
from network.units import mps
from scenario.scenario import Scenario, load_scenario
from simulation.events import Collision, SignalActed, SignalPassed, WrongDeparture
from simulation.line_signals.machine import Aspect
from simulation.result import RunResult, TraceSpan
from simulation.setup import STEPS_PER_S, Setup
from study.drilling.drill import find_drill
from study.runner.run import PartyLink, execute
from vehicle.train_file import TrainType
from wayside.said import Refused

ROOT: Final = Path(__file__).resolve().parents[1]
FILE: Final = Path("docs/studies/accidents.md")
LISTS: Final = ROOT / "documents/station_lists"
BEGIN: Final = "<!-- made: {name} -->\n"
END: Final = "<!-- /made -->"


@dataclass(frozen=True, slots=True)
class Accident:
    """One accident: its drills by how the line is worked, when and where it happened, and how near a run is to come."""

    name: str
    as_it_was: str
    ways: Mapping[str, str]
    at_s: float
    within_s: float
    km: float
    within_m: float
    window_s: tuple[float, float]  # of its picture

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


SHIGARAKI: Final = Accident(
    "Shigaraki 1991",
    "shigaraki/01_as_it_was",
    MappingProxyType(
        {
            "as it was": "shigaraki/01_as_it_was",
            "as it was, but the detector works": "shigaraki/04_detector_works",
            "by the centre": "shigaraki/03_by_the_centre",
            "on board": "shigaraki/02_on_board",
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
    "mangfall/01_as_it_was",
    MappingProxyType(
        {
            "as it was": "mangfall/01_as_it_was",
            "by the centre": "mangfall/03_by_the_centre",
            "on board": "mangfall/02_on_board",
        }
    ),
    at_s=6 * 3600 + 46 * 60 + 56.0,
    within_s=30.0,
    km=30.3,
    within_m=200.0,
    window_s=(6 * 3600 + 42 * 60.0, 6 * 3600 + 56 * 60.0),
)
ACCIDENTS: Final = (SHIGARAKI, BAD_AIBLING)


def run_of(scenario: Scenario) -> RunResult:
    """Its day."""
    return execute(scenario, PartyLink.SIMULATED).result


def meeting_of(result: RunResult, line: Line) -> Meeting | None:
    """When and where trains collided; the place is half way between the last samples of both fronts."""
    found = next((e for e in result.journal.entries if isinstance(e.event, Collision)), None)
    if found is None:
        return None
    slots = range(len(result.stock_ids))
    fronts_m = [_place_m(result, slot, result.trace[result.trace["slot"] == slot][-1]) for slot in slots]
    return Meeting(found.t_s, published_km(line, sum(fronts_m) / len(fronts_m) / 1000.0))


def _place_m(result: RunResult, slot: int, sample: np.void) -> float:
    span: TraceSpan = [s for s in result.spans if s.slot == slot and s.from_step <= int(sample["step"])][-1]
    front_m = float(sample["position_m"])
    index = max(i for i, start_m in enumerate(span.starts_m) if start_m <= front_m)
    entry_m, run_m = span.entries_m[index], front_m - span.starts_m[index]
    return entry_m + span.direction * run_m


def published_km(line: Line, km: float) -> float:
    """A place of the line in published kilometres: those of its list, evenly between two stations, as the track's geometry
    is a little longer.
    """
    listed = tomllib.loads((LISTS / f"{line.id}.toml").read_text("utf-8"))["stations"]
    own = [line.stations[row["id"]].position_m / 1000.0 for row in listed]
    official = [float(row["km"]) for row in listed]
    i = max((i for i, at in enumerate(own[:-1]) if at <= km), default=0)
    return official[i] + (km - own[i]) * (official[i + 1] - official[i]) / (own[i + 1] - own[i])


def refusals(result: RunResult) -> Iterator[str]:
    """Who refused what, or passed what at stop, in the order of the journal; each once."""
    said: dict[str, None] = {}
    for entry in result.journal.entries:
        match entry.event:
            case Refused(unit_id=unit, other_id=other, section_ids=sections) if other:
                said[f"{entry.who} refused {unit} section {', '.join(sections)}, which {other} had"] = None
            case SignalActed(does=does, signal_id=signal) if does in ("send_off", "substitute"):
                said[f"{entry.who}: {does} at {signal}"] = None
            case SignalPassed(unit_id=unit, signal_id=signal, aspect=aspect) if aspect != Aspect.CLEAR.value:
                said[f"{unit} passed {signal} at {aspect}"] = None
            case WrongDeparture(signal_id=signal, stops=stops, works=works):
                kept = f"kept {', '.join(stops)} at stop" if works else "held nothing"
                said[f"the detector of {signal} {kept}"] = None
            case _:
                pass
    yield from said


def runs_of(accident: Accident) -> dict[str, tuple[Scenario, RunResult]]:
    """The day in each way of working the line."""
    scenarios = {label: load_scenario(find_drill(name)) for label, name in accident.ways.items()}
    return {label: (scenario, run_of(scenario)) for label, scenario in scenarios.items()}


def ways(accident: Accident, runs: Mapping[str, tuple[Scenario, RunResult]]) -> Iterator[str]:
    """A row for each way of working the line."""
    yield "| the line worked | collision | trains arrived | who refused what, who passed what |"
    yield "|---|---|---|---|"
    for label, (scenario, result) in runs.items():
        meeting = meeting_of(result, scenario.setup.line)
        where = "none" if meeting is None else f"**{meeting.words(accident)}**"
        yield f"| {label} | {where} | {len(result.trains_arrived)} | {'; '.join(refusals(result))} |"


def picture(accident: Accident, runs: Mapping[str, tuple[Scenario, RunResult]], file: Path) -> None:
    """Where the trains were, a panel for each way."""
    panels: list[Panel] = []
    places_km: dict[str, float] = {}
    for label, (scenario, result) in runs.items():
        line = scenario.setup.line
        meeting = meeting_of(result, line)
        collision = None if meeting is None else (meeting.at_s, meeting.km)
        places_km = {s.name: published_km(line, s.position_m / 1000.0) for s in line.stations.values()}
        paths = [_path(result, line, slot) for slot in range(len(result.stock_ids))]
        panels.append(Panel(label, paths, collision))
    draw_panels(file, panels, places_km, (accident.at_s, accident.km), accident.window_s)


def _path(result: RunResult, line: Line, slot: int) -> TrainPath:
    samples = result.trace[result.trace["slot"] == slot]
    number = next(s.number for s in result.spans if s.slot == slot)
    at_s = tuple(float(sample["step"]) / STEPS_PER_S for sample in samples)
    km = tuple(published_km(line, _place_m(result, slot, sample) / 1000.0) for sample in samples)
    return TrainPath(number, at_s, km)


# what rests on what -----------------------------------------------------------------------------------------------

Change = Callable[[Setup], Setup]


def acts_later(who: str, by_s: float) -> Change:
    """Somebody's acts by signals come later, by so much."""

    def change(setup: Setup) -> Setup:
        settings = setup.line_signals
        if settings is None:
            raise ValueError("no [line_signals]")
        acts = tuple(
            act.model_copy(update={"at_s": act.at_s + by_s}) if act.who == who else act
            for act in settings.act
        )
        return replace(setup, line_signals=settings.model_copy(update={"act": acts}))

    return change


def line_speed(factor: float) -> Change:
    """Trains may run faster or slower all along the line, but for its curves."""

    def change(setup: Setup) -> Setup:
        settings = setup.line_signals
        if settings is None:
            raise ValueError("no [line_signals]")
        line_mps = factor * setup.line.max_speed_mps
        line = replace(setup.line, max_speed_mps=line_mps)
        return replace(
            setup,
            line=line,
            line_signals=settings.model_copy(update={"speed_kmh": line_mps / mps(1.0)}),
        )

    return change


def traction(stock_id: str, factor: float) -> Change:
    """A train pulls more or less at every speed."""

    def change(setup: Setup) -> Setup:
        kind: TrainType = setup.trains[stock_id]
        row = kind.row.copy()
        for name in ("traction_curve_n", "traction_force_max_n", "traction_power_max_w"):
            row[name] = row[name] * factor
        row.flags.writeable = False
        return replace(setup, trains={**setup.trains, stock_id: replace(kind, row=row)})

    return change


def load(share: float) -> Change:
    """Both trains are as full as that."""
    return lambda setup: replace(setup, load=setup.load.model_copy(update={"load_share_mean": share}))


def dwell(seconds: float) -> Change:
    """Trains stand so long at halts, at least."""
    return lambda setup: replace(
        setup,
        timetable=replace(setup.timetable, head=setup.timetable.head.model_copy(update={"dwell_min_s": seconds})),
    )


CHANGES: Final[Mapping[str, Mapping[str, Change]]] = MappingProxyType(
    {
        SHIGARAKI.name: MappingProxyType(
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
        BAD_AIBLING.name: MappingProxyType(
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
    }
)


def sensitivity(accident: Accident) -> Iterator[str]:
    """A row for each change, by itself."""
    scenario = load_scenario(find_drill(accident.as_it_was))
    yield "| changed | collision (from what is published) |"
    yield "|---|---|"
    cases: dict[str, Change] = {"nothing": lambda setup: setup, **CHANGES[accident.name]}
    for label, change in cases.items():
        setup = change(scenario.setup)
        meeting = meeting_of(run_of(replace(scenario, setup=setup)), setup.line)
        row = f"| {label} | {'none' if meeting is None else meeting.words(accident)} |"
        sys.stderr.write(row + "\n")
        yield row


def put(page: Path, name: str, rows: Iterator[str]) -> None:
    """Write a table between its marks of a page."""
    begin, text = BEGIN.format(name=name), page.read_text("utf-8")
    head, _, rest = text.partition(begin)
    _, _, tail = rest.partition(END)
    page.write_text(head + begin + "\n".join(rows) + "\n" + END + tail, "utf-8")


def main(root: Path = ROOT) -> None:
    """Write tables and pictures."""
    for accident in ACCIDENTS:
        runs = runs_of(accident)
        put(root / FILE, f"{accident.key}-ways", ways(accident, runs))
        picture(accident, runs, root / FILE.with_suffix("") / f"{accident.key}.png")
        put(root / FILE, f"{accident.key}-sensitivity", sensitivity(accident))


if __name__ == "__main__":
    main()
