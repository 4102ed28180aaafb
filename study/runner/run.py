"""Run a scenario: build the world, run it, write the run directory."""

from __future__ import annotations

import json
import secrets
import time
from collections.abc import Callable, Generator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from enum import Enum
from itertools import chain, product
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

from host.parties import Parties
from host.party import PartySpec
from host.scratch import scratch
from host.unit import PartyUnits, unit_specs
from host.units import LocalUnits
from network.errors import InputError
from network.model import Line
from radio.keys import KEY_BYTES
from scenario.fleet_file import learned_json
from scenario.scenario import Scenario
from simulation.carriers.carrier import Carrier
from simulation.carriers.road import CarrierOf, Road
from simulation.carriers.road_of_run import road_of, roads_at
from simulation.carriers.road_shown import ObstacleDetectors
from simulation.carriers.sumo_api import STEP_DELAY_MS, GuiWindow
from simulation.journal import Journal
from simulation.loop import Progress, Simulation
from simulation.result import Ending, RunResult
from simulation.setup import STEP_S, STEPS_PER_S, Setup, unit_configs
from simulation.world.roster import drawn_up
from study.collect.battery import battery_summary, battery_tables
from study.collect.crossings import hours_run
from study.collect.energy import StockMake
from study.collect.late import late_part, late_summary
from study.collect.road import road_table
from study.collect.tables_of_run import tables_of
from study.feasibility.check import feasibility
from study.measures.driving import driving_table
from study.measures.localisation import localisation_summary
from study.measures.register_holds import section_holds
from study.measures.running_times import planned_legs
from study.measures.second_opinion import comparisons_of
from study.measures.summary import summarise
from study.measures.waits import waits_of
from study.record.directory import (
    FORMAT,
    FORMAT_KEY,
    INPUTS_FILE,
    JOURNAL_FILE,
    LEARNED_FILE,
    REPORT_FILE,
    SHOWN_FILE,
    SUMMARY_FILE,
    Reserved,
    digests_of_tables,
    reserved,
    write_whole,
)
from study.record.marks import DrillShown
from study.record.parts import PagePart
from study.record.shown import shown_of
from study.record.tables import RunTables, make_table
from study.report.beside import Beside
from study.report.report import write_report
from study.runner.collector import collecting_rarely
from study.runner.crash import bugs_named
from study.runner.devices import specs_of
from study.runner.outcome import missing_said, outside_design, rules_said, unfinished, waiting_said
from study.wording.phrase import Phrase
from sumo_cfg.build import net_for
from sumo_cfg.road_net import RoadAt
from sumo_cfg.scenery import scenery_xml
from sumo_cfg.truth_map import NetMap, read_net

if TYPE_CHECKING:  # only who listens needs what reads certificates
    from host.elsewhere import Elsewhere

TEMPORARY: Final = "branchline-"
TRAJECTORY_ROOM_BPS: Final = 50  # bytes of the trajectory a second; 41 on the weekday of the Karasuyama line
SCENERY_FILE: Final = "scenery.add.xml"


class PartyLink(Enum):
    """How telegrams reach the wayside devices: inside this process, or processes over Zenoh."""

    SIMULATED = "simulated"
    ZENOH = "zenoh"


class UnitsAt(Enum):
    """Where the event-driven part of on-board units runs."""

    SIMULATOR = "simulator"
    PROCESSES = "processes"


class CarrierKind(Enum):
    """What carries the trains."""

    SUMO = "sumo"
    PLAIN = "plain"
    SUMO_GUI = "sumo-gui"  # SUMO with a window on the run

    @property
    def shown(self) -> bool:
        """Whether a window shows the run."""
        return self is CarrierKind.SUMO_GUI

    def roads(self, setup: Setup) -> tuple[RoadAt, ...]:
        """The roads that it carries: plain track has none."""
        return () if self is CarrierKind.PLAIN else roads_at(setup)


@dataclass(frozen=True, slots=True)
class FinishedRun:
    """A finished run. `failures` are what makes it a failure, one sentence each."""

    scenario: Scenario
    result: RunResult
    summary: dict[str, Any]
    tables: RunTables
    failures: tuple[Phrase, ...]

    @property
    def stopped(self) -> bool:
        """Whether somebody ended it before its time."""
        return self.result.ended_because is Ending.STOPPED

    @property
    def broken(self) -> tuple[str, ...]:
        """The failures in English."""
        return tuple(said.en for said in self.failures)


@dataclass(frozen=True, slots=True)
class RunOptions:
    """How a scenario is run: what carries the trains and who takes part. `folder` is for what parties keep.

    `make` makes the carrier of the last day, `make_before` that of the days of learning before it (None: the same).
    """

    make: CarrierOf
    net: NetMap
    folder: Path
    link: PartyLink = PartyLink.SIMULATED
    units: UnitsAt = UnitsAt.SIMULATOR
    make_before: CarrierOf | None = None
    watch: Callable[[Parties], Parties] | None = None
    journal: Callable[[], Journal] = Journal
    stop: Callable[[], bool] | None = None
    roads: tuple[RoadAt, ...] = ()  # those in the net
    elsewhere: Elsewhere | None = None


@collecting_rarely()
def run_to_end(
    scenario: Scenario, course: RunOptions, progress: Progress | None = None
) -> tuple[Setup, RunResult]:
    """Run a scenario to its end: the setup of its last day, and what that left behind. Raises Crashed for a bug.

    Whom somebody wants to `stop` gives back the day of which that is the end.
    """
    setup = scenario.setup
    # Random, so that nobody can know it: what the bytes of a code are decides nothing in a run.
    master_key = secrets.token_bytes(KEY_BYTES)
    on_board = unit_configs(setup, master_key)
    specs = specs_of(setup, master_key)
    apart = course.units is UnitsAt.PROCESSES
    if apart:
        specs = (*specs, *unit_specs(on_board))
    while True:
        last = setup.day >= scenario.setup.tuning.days
        state = course.folder / f"day-{setup.day}"
        state.mkdir()
        with parties_of(course.link, setup.line.id, specs, state, course.elsewhere) as own:
            parties = own if course.watch is None else course.watch(own)
            simulation = Simulation(
                setup,
                course.make if last else course.make_before or course.make,
                parties,
                course.net,
                PartyUnits(parties) if apart else LocalUnits(on_board),
                course.link.value,
                course.journal(),
                road_of(setup, course.roads, state),
            )
            with bugs_named(scenario.id, simulation, processes=course.link is PartyLink.ZENOH):
                result = simulation.run(progress, course.stop)
        if result.ended_because is Ending.STOPPED:
            return replace(setup, until_s=result.end_step / STEPS_PER_S), result
        if last:
            return setup, result
        setup = setup.next_day(result.learned)


@collecting_rarely()
def execute(
    scenario: Scenario,
    link: PartyLink,
    *,
    units: UnitsAt = UnitsAt.SIMULATOR,
    carrier: CarrierKind = CarrierKind.SUMO,
    progress: Progress | None = None,
    wrap: Callable[[Carrier], Carrier] | None = None,
    watch: Callable[[Parties], Parties] | None = None,
    journal: Path | None = None,
    delay_ms: int = STEP_DELAY_MS,
    stop: Callable[[], bool] | None = None,
    say: Callable[[str], None] | None = None,
    elsewhere: Elsewhere | None = None,
) -> FinishedRun:
    """Run a scenario and compute its tables and summary. Writes nothing that stays, unless there is a file in which its
    `journal` is to grow. Raises Crashed for a bug.

    With `[tuning] days` the same day runs that often, the trains learning; the result is that of the last one.
    `wrap` may put something around the carrier, to watch what it is asked to do, and `watch` around the parties;
    `delay_ms` is how long sumo-gui takes over a step; once `stop` is true the run ends where it is. `say`
    is told what is computed after the last train. `elsewhere`: parties that people start on other machines.
    """
    with scratch(TEMPORARY) as folder:
        setup = scenario.setup
        roads = carrier.roads(setup)
        net = net_for(setup.line, folder, roads)
        window = GuiWindow(folder / SCENERY_FILE, delay_ms)
        make = carrier_factory(carrier, setup.line, net, window)
        # Days of learning pass without a window.
        make_before = carrier_factory(CarrierKind.SUMO, setup.line, net) if carrier.shown else make
        started = time.perf_counter()
        course = RunOptions(
            make if wrap is None else lambda begin_s, road: wrap(make(begin_s, road)),
            read_net(net),
            folder,
            link,
            units,
            make_before,
            watch,
            lambda: Journal(journal),
            stop,
            roads,
            elsewhere,
        )
        setup, result = run_to_end(scenario, course, progress)
        wall_s = time.perf_counter() - started
    stage = say or _in_silence
    stage("computing the tables")
    fleet = {stock_id: StockMake.of_kind(kind) for stock_id, kind in setup.trains.items()}
    holds = section_holds(result, setup.line, setup.lengths_m)
    duties = chain.from_iterable(drawn_up(setup, setup.line).values())
    booked = tables_of(result, setup.line, fleet, holds, planned_legs(setup), duties, setup.latest_end_s)
    stage("comparing with second opinions")
    opinions = comparisons_of(result, setup, booked.energy, booked.layovers)
    tables = replace(
        booked,
        driving=driving_table(result, setup, booked.margins, booked.stops),
        comparisons=opinions,
        waits=make_table("waits", waits_of(result, setup, holds)),
        **battery_tables(result.battery, setup),
        road=road_table(result.road, product(setup.roads, hours_run(result))),
    )
    failures = broken_said(result, setup)
    summary = {
        FORMAT_KEY: FORMAT,
        "scenario": scenario.id,
        "seed": setup.seed,
        "link": link.value,
        "carrier": carrier.value,
        "digest": result.digest,
        "motion_digest": result.motion_digest,
        **summarise(tables, setup.timetable, setup.latest_end_s),
        "latest_end_s": setup.latest_end_s,
        "battery": battery_summary(tables.battery, setup),
        "localisation": localisation_summary(tables, result.fixes),
        "late": late_summary(result, setup),
        "empty_workings_planned": len(result.empty_planned),
        "empty_workings_arrived": len(result.empty_arrived),
        "invariants_broken": len(result.violations),
        "collisions": len(result.collisions),
        "changes": [change.model_dump() for change in scenario.inputs.changes],
        "violations": [f"{v.t_s:.1f} s {v.checker}: {v.text}" for v in result.violations],
        "ended_because": result.ended_because.value,
        "outside_design": list(outside_design(result)),
        "unfinished": list(unfinished(result)),
        "uncommissioned": list(result.uncommissioned),
        "broken": [said.en for said in failures],
        "simulated_s": (result.end_step - result.begin_step) * STEP_S,
        "wall_s": round(wall_s, 3),
    }
    run_so_far = replace(scenario, setup=replace(scenario.setup, until_s=setup.until_s))
    return FinishedRun(run_so_far, result, summary, tables, failures)


@contextmanager
def simulation_of(
    setup: Setup,
    road_in: Callable[[Path], Road] | None = None,
    detectors: ObstacleDetectors | None = None,
    carrier: CarrierKind = CarrierKind.SUMO,
) -> Generator[Simulation]:
    """A simulation with all parties in this process, ready to `begin`; its carrier is released at the end.

    `road_in` makes another road than the line's, with its files in a folder, and other `detectors` hear of obstacles.
    """
    with scratch(TEMPORARY) as folder:
        road = road_of(setup, carrier.roads(setup), folder) if road_in is None else road_in(folder)
        net = net_for(setup.line, folder, () if road is None else road.roads)
        master_key = secrets.token_bytes(KEY_BYTES)
        units = LocalUnits(unit_configs(setup, master_key))
        with parties_of(PartyLink.SIMULATED, setup.line.id, specs_of(setup, master_key), folder) as parties:
            make = carrier_factory(carrier, setup.line, net)
            link = PartyLink.SIMULATED.value
            simulation = Simulation(
                setup, make, parties, read_net(net), units, link, road=road, detectors=detectors
            )
            try:
                yield simulation
            finally:
                simulation.close()


def _in_silence(_stage: str) -> None:
    """Nobody is told."""


@dataclass(frozen=True, slots=True)
class RunExtras:
    """What a run directory has beside what every run has: parts of the report, files (text, by name), another run."""

    parts: tuple[PagePart, ...] = ()
    files: Mapping[str, str] = field(default_factory=dict[str, str])
    beside: Beside | None = None


NO_MORE: Final = RunExtras()


def end_room_bytes(setup: Setup) -> int:
    """What the largest file of a day's end takes, by its trains' planned time on the way; see `Reserved.hold_room`."""
    on_the_way_s = sum(
        train.calls[-1].last_s - train.calls[0].first_s for train in setup.timetable.trains.values()
    )
    return TRAJECTORY_ROOM_BPS * on_the_way_s


def write_run(run: FinishedRun, out: Path, drill: DrillShown | None = None) -> Path:
    """Write the run directory: all of it or nothing. Returns the path of the report.

    Raises InputError as `check_out` does, and when the directory cannot be written.
    """
    with reserved(out) as place:
        return fill_run(run, place, drill)


def fill_run(
    run: FinishedRun, place: Reserved, drill: DrillShown | None = None, more: RunExtras = NO_MORE
) -> Path:
    """Write a run into the directory reserved, and put that in its place; a run that was stopped goes beside it.

    Returns the path of the report.
    """
    if run.stopped:
        place.name_incomplete()
    _write_files(run, place, drill, more)
    place.put_in_place()
    if run.result.journal.file == place.journal:
        run.result.journal.moved(place.out / JOURNAL_FILE)
    return place.out / REPORT_FILE


def _write_files(run: FinishedRun, place: Reserved, drill: DrillShown | None, more: RunExtras) -> None:
    """All files of a run. The journal may be there already; what is worth most comes first."""
    folder, out, journal = place.folder, place.out, run.result.journal
    setup = run.scenario.setup
    place.free_room()
    if journal.file == place.journal:
        journal.spill()
    else:
        place.journal.write_bytes(journal.to_bytes())
    run.tables.write(folder)
    if run.result.learned:
        write_whole(folder / LEARNED_FILE, learned_json(run.result.learned).encode())
    summary = run.summary | {"out": str(out)}
    inputs = run.scenario.inputs
    summary_text = json.dumps(summary, indent=2, ensure_ascii=False) + "\n"
    write_whole(folder / SUMMARY_FILE, summary_text.encode())
    write_whole(folder / INPUTS_FILE, inputs.as_json().encode())
    for name, text in more.files.items():
        write_whole(folder / name, text.encode())
    drawn = late_part(setup)
    parts = more.parts if drawn is None else (*more.parts, drawn)
    shown = replace(
        shown_of(run.result, run.failures, terminals_of(setup.line), drill, digests_of_tables(folder)),
        parts=parts,
    )
    write_whole(folder / SHOWN_FILE, shown.as_json())  # last: with it the report can be made again
    facts, tuned = shown.facts(summary, inputs), shown.tuned(run.result.learned)
    write_report(folder, setup.line, setup.timetable, run.tables, facts, tuned, drill, parts, more.beside)


def broken_said(result: RunResult, setup: Setup) -> tuple[Phrase, ...]:
    """What makes a run a failure: broken rules, what is missing to its end, and who waits for what."""
    broken = [said for _, said in rules_said(result)]
    missing = missing_said(result)
    broken += missing
    if missing:
        broken += [waiting_said(waiting) for waiting in result.waiting]
        broken += [Phrase(finding.sentence) for finding in feasibility(setup).not_as_printed]
    return tuple(broken)


def terminals_of(line: Line) -> tuple[str, ...]:
    """Point terminals of a line."""
    return tuple(sorted({points.terminal_id for points in line.points.values()}))


def carrier_factory(
    kind: CarrierKind,
    line: Line,
    net: Path,
    window: GuiWindow | None = None,
) -> CarrierOf:
    """How the loop makes its carrier. The `net` has the roads that this is given; plain track is given none.

    Where the kind is `shown`, the scenery of the line is written where `window` has it.
    """
    if kind is CarrierKind.SUMO_GUI:
        from simulation.carriers.window import WindowCarrier

        shown = window or GuiWindow()
        if shown.scenery is not None:
            shown.scenery.write_bytes(scenery_xml(line))
        return lambda begin_s, road: WindowCarrier(net, begin_s, shown, road)
    if kind is CarrierKind.SUMO:
        from simulation.carriers.sumo import SumoCarrier
        from simulation.carriers.sumo_road import SumoRoadCarrier

        return lambda begin_s, road: (
            SumoCarrier(net, begin_s) if road is None else SumoRoadCarrier(net, begin_s, road)
        )
    from simulation.carriers.plain_track import PlainTrack

    return lambda _begin_s, _road: PlainTrack.of_line(line, STEP_S)


@contextmanager
def parties_of(
    link: PartyLink,
    line_id: str,
    specs: tuple[PartySpec, ...],
    folder: Path,
    elsewhere: Elsewhere | None = None,
) -> Generator[Parties]:
    """The parties, in this process or as processes; gone when the context ends, however it ends."""
    if link is PartyLink.ZENOH:
        from host.over_zenoh import ZenohParties

        with ZenohParties(line_id, specs, folder, elsewhere) as processes:
            yield processes
        return
    from host.local import LocalParties

    with LocalParties(specs) as local:
        yield local


def link_of(name: str) -> PartyLink:
    """The link of that name; InputError otherwise."""
    try:
        return PartyLink(name)
    except ValueError:
        raise InputError("command line", "--link", name, "simulated or zenoh") from None


def carrier_of(name: str) -> CarrierKind:
    """The carrier of that name, without a window; InputError otherwise."""
    if name not in {CarrierKind.SUMO.value, CarrierKind.PLAIN.value}:
        raise InputError("command line", "--carrier", name, "sumo or plain")
    return CarrierKind(name)


def units_at(name: str, link: PartyLink) -> UnitsAt:
    """Where units run, by that name; InputError otherwise, and for processes without Zenoh between them."""
    try:
        at = UnitsAt(name)
    except ValueError:
        raise InputError("command line", "--units", name, "simulator or processes") from None
    if at is UnitsAt.PROCESSES and link is not PartyLink.ZENOH:
        raise InputError("command line", "--units", name, "--link zenoh, which processes need")
    return at
