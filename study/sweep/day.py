"""One day of a sweep in a process that has run others: the day of `branchline run`, without what a sweep never shows.

Nothing is kept of a day but its record. Two days of one specification give the same record in any process, whatever
ran there before: what is kept between days is read from files and never written to.
"""

from __future__ import annotations

import shlex
from collections import OrderedDict
from collections.abc import Callable, Sequence
from contextlib import ExitStack
from dataclasses import dataclass
from pathlib import Path
from typing import Final, Self

from host.scratch import scratch
from network.clock import clock
from network.errors import InputError
from network.model import Line
from scenario.scenario import Scenario, load_scenario, with_seed
from simulation.carriers.carrier import Carrier
from simulation.carriers.road import Road
from simulation.events import EventType, Unsafe
from simulation.journal import Journal
from simulation.judge.checkers import Checker
from simulation.result import Ending, RunResult
from simulation.setup import Setup
from study.measures.day_figures import EVENTS, day_figures
from study.outcome import Outcome, outcome_of
from study.runner.crash import exception_line
from study.runner.outcome import broken_rules, unfinished, waiting_said
from study.runner.run import TEMPORARY, CarrierKind, RunOptions, carrier_factory, run_to_end
from study.sweep.records import DayOutcome, DayRecord, DaySpec
from sumo_cfg.build import net_for
from sumo_cfg.road_net import RoadAt
from sumo_cfg.truth_map import NetMap, read_net

SCENARIOS_KEPT: Final = 4  # a worker is given days of one point after the other
# All that an outcome is told by beside what the checkers found, and figures are made of.
KEPT_EVENTS: Final[tuple[EventType, ...]] = (Unsafe, *EVENTS)

ScenarioOf = Callable[[DaySpec], Scenario]
ReplayOf = Callable[[DaySpec], str]


@dataclass(frozen=True, slots=True)
class _BuiltNet:
    file: Path
    map: NetMap


def scenario_of(spec: DaySpec) -> Scenario:
    """The scenario of a day that is at no point of a grid. InputError otherwise."""
    if spec.point:
        expected = "a day without one: whoever reads the sweep's file knows what a point changes"
        raise InputError(spec.scenario, "point", spec.point, expected)
    return load_scenario(spec.scenario)


def replay_of(spec: DaySpec) -> str:
    """The command that runs a day again, with its report."""
    return f"branchline run {shlex.quote(spec.scenario)} --seed {spec.seed} --carrier {shlex.quote(spec.carrier)}"


class ProcessCache:
    """What a process keeps from one day to the next: scenarios as loaded, nets as built and read.

    `scenario_of` gives the scenario of a day with its point applied; its seed does not matter. `replay_of` gives the
    command with which a day is run again.
    """

    def __init__(self, scenario_of: ScenarioOf = scenario_of, replay_of: ReplayOf = replay_of) -> None:
        self.replay_of: Final = replay_of
        self._scenario_of = scenario_of
        self._scenarios: OrderedDict[tuple[object, ...], Scenario] = OrderedDict()
        self._nets: OrderedDict[tuple[int, bool], tuple[Line, _BuiltNet]] = OrderedDict()
        self._stack = ExitStack()
        self._folder: Path | None = None

    def __enter__(self) -> Self:
        self._folder = self._stack.enter_context(scratch(TEMPORARY))
        return self

    def __exit__(self, *_: object) -> None:
        self._stack.close()
        self._folder = None

    @property
    def folder(self) -> Path:
        """Where nets are built. RuntimeError outside the context."""
        if self._folder is None:
            raise RuntimeError("used outside its context")
        return self._folder

    def scenario(self, spec: DaySpec) -> Scenario:
        """The scenario of a day, with its seed. Raises InputError."""
        key = (spec.scenario, spec.inputs, repr(spec.point), repr(spec.drawn))
        found = self._scenarios.get(key)
        if found is None:
            found = self._scenario_of(spec)
            self._scenarios[key] = found
            if len(self._scenarios) > SCENARIOS_KEPT:
                self._scenarios.popitem(last=False)
        return with_seed(found, spec.seed)

    def net(self, line: Line, roads: Sequence[RoadAt] = ()) -> tuple[Path, NetMap]:
        """The net of a line, with `roads` or without, and what it says of itself."""
        key = (id(line), bool(roads))  # the line is held too, so that its number stays its own
        held = self._nets.get(key)
        if held is None:
            file = net_for(line, self.folder, roads)
            known = next((net for _, net in self._nets.values() if net.file == file), None)
            held = (line, known or _BuiltNet(file, read_net(file)))
            self._nets[key] = held
            if len(self._nets) > SCENARIOS_KEPT:
                self._nets.popitem(last=False)
        return held[1].file, held[1].map


def run_day(spec: DaySpec, index: int, warm: ProcessCache) -> DayRecord:
    """Run a day. A bug ends in a record of a crashed day; what the machine lacks, and bad input, are raised."""
    carriers: list[Carrier] = []
    try:
        return _run(spec, index, warm, carriers)
    except Exception as error:
        if outcome_of(error) is not Outcome.BUG:
            raise
        why = f"{exception_line(error)}; again: {warm.replay_of(spec)}"
        return DayRecord(spec, index, DayOutcome.CRASHED, why, None)
    finally:
        for carrier in carriers:
            carrier.close()


def _run(spec: DaySpec, index: int, warm: ProcessCache, carriers: list[Carrier]) -> DayRecord:
    scenario = warm.scenario(spec)
    kind = CarrierKind(spec.carrier)
    roads = kind.roads(scenario.setup)
    net, seen = warm.net(scenario.setup.line, roads)
    make = carrier_factory(kind, scenario.setup.line, net)

    def noted(begin_s: float, road: Road | None) -> Carrier:
        carriers.append(make(begin_s, road))
        return carriers[-1]

    with scratch(TEMPORARY) as folder:
        course = RunOptions(noted, seen, folder, journal=lambda: Journal(kept=KEPT_EVENTS), roads=roads)
        setup, result = run_to_end(scenario, course)
    return record_of(spec, index, result, setup)


def record_of(spec: DaySpec, index: int, result: RunResult, setup: Setup) -> DayRecord:
    """What is kept of a day that came to an end."""
    figures = day_figures(result, setup)
    outcome, why = outcome_of_day(result)
    if outcome is DayOutcome.NOT_ARRIVED and figures.deadlock:
        outcome, why = DayOutcome.DEADLOCK, f"{', '.join(figures.deadlock)} wait for one another; {why}"
    return DayRecord(spec, index, outcome, why, figures, result.digest, result.motion_digest)


def outcome_of_day(result: RunResult) -> tuple[DayOutcome, str]:
    """What became of a day that came to an end, the gravest first, and why; no words for a good one."""
    broken = sorted(broken_rules(result))
    dead = [(t_s, text) for t_s, text in broken if text.startswith(f"{Checker.NO_DEAD_STATE}: ")]
    unsafe = [found for found in broken if found not in dead]
    missing = unfinished(result)
    waiting = [waiting_said(waiting).en for waiting in result.waiting] if missing else []
    if unsafe:
        t_s, text = unsafe[0]
        more = f", and {len(unsafe) - 1} more" if unsafe[1:] else ""
        return DayOutcome.BROKEN, f"{clock(int(t_s))} {text}{more}"
    if dead:
        t_s, text = dead[0]
        return DayOutcome.DEADLOCK, "; ".join([f"{clock(int(t_s))} {text}", *waiting])
    if result.ended_because is Ending.STALLED:
        return DayOutcome.DEADLOCK, "; ".join(waiting or missing)
    if missing:
        return DayOutcome.NOT_ARRIVED, "; ".join([*missing, *waiting])
    return DayOutcome.GOOD, ""
