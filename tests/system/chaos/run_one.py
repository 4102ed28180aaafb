"""Run one case on the simulated link, in this process, and say what became of it: no tables, no report."""

import re
import secrets
import tempfile
import traceback
from dataclasses import dataclass
from enum import Enum
from functools import cache
from pathlib import Path
from types import TracebackType
from typing import Final

from host.units import LocalUnits
from network.model import Line
from onboard.notes import Claimed, EmergencyReleased, Holds, LimitSet, Reported
from radio.keys import KEY_BYTES
from radio.noted import Sent, TelegramDropped, TookEffect
from scenario.scenario import Scenario
from simulation.carriers.road_of_run import road_of, roads_at
from simulation.events import Unsafe, word_of
from simulation.faults.script import Act
from simulation.judge.checkers import Checker
from simulation.loop import Simulation
from simulation.result import RunResult
from simulation.setup import STEPS_PER_S, unit_configs
from study.runner.devices import specs_of
from study.runner.run import CarrierKind, PartyLink, carrier_factory, parties_of
from sumo_cfg.build import net_for
from sumo_cfg.truth_map import NetMap, read_net
from tests.system.chaos.case import Case
from tests.system.chaos.course import Course, course_of, stopped_s
from tests.system.chaos.ground import Ground
from tests.system.chaos.sometimes import come_to

ROOT: Final = Path(__file__).resolve().parents[3]
# What a unit goes on saying although nothing happens.
OF_NO_CAUSE: Final = (
    Sent,
    TookEffect,
    TelegramDropped,
    Holds,
    Reported,
    Claimed,
    LimitSet,
    EmergencyReleased,
)


class Verdict(Enum):
    """What became of a case, the worst first."""

    CRASH = "crash"
    COLLISION = "collision"
    UNSAFE = "unsafe"
    BROKEN = "broken invariant"
    NOT_ARRIVED = "not arrived"
    FINE = "fine"


@dataclass(frozen=True, slots=True)
class Outcome:
    """`kind` is the verdict in words that are the same for the same cause, as far as a run can tell."""

    verdict: Verdict
    kind: str
    details: tuple[str, ...] = ()
    digest: str = ""
    simulated_s: float = 0.0
    stopped_s: float = 0.0
    acts: tuple[Act, ...] = ()
    came: frozenset[str] = frozenset()  # what of `sometimes` it came to

    @property
    def fine(self) -> bool:
        """Whether everything is as it must be."""
        return self.verdict is Verdict.FINE


@cache
def _net_map(path: Path) -> NetMap:
    return read_net(path)


def run(
    scenario: Scenario, nets: Path, state: Path, carrier: CarrierKind = CarrierKind.SUMO
) -> tuple[RunResult, tuple[Act, ...]]:
    """The run of a case, and what its staff did; a road is on SUMO in any case. Raises what the simulator raises."""
    setup = scenario.setup
    road = road_of(setup, roads_at(setup), state)
    net = net_for(setup.line, nets, () if road is None else road.roads)
    master_key = secrets.token_bytes(KEY_BYTES)
    with parties_of(PartyLink.SIMULATED, setup.line.id, specs_of(setup, master_key), state) as parties:
        simulation = Simulation(
            setup,
            carrier_factory(carrier if road is None else CarrierKind.SUMO, setup.line, net),
            parties,
            _net_map(net),
            LocalUnits(unit_configs(setup, master_key)),
            PartyLink.SIMULATED.value,
            road=road,
        )
        acts = [] if simulation.staff is None else simulation.staff.acts
        try:
            return simulation.run(), tuple(acts)
        except Exception as error:
            error.acts = tuple(acts)  # type: ignore[attr-defined]
            raise


def outcome_of(case: Case, nets: Path) -> Outcome:
    """Run the case and judge it."""
    with tempfile.TemporaryDirectory(prefix="chaos-") as name:
        folder = Path(name)
        scenario = case.load(folder)
        try:
            result, acts = run(scenario, nets, folder)
        except Exception as error:
            acts = getattr(error, "acts", ())
            return Outcome(Verdict.CRASH, _crash(error), (traceback.format_exc(),), acts=acts)
    verdict, kind, details = judged(result, scenario.setup.line)
    simulated_s = (result.end_step - result.begin_step) / STEPS_PER_S
    came = come_to(result.journal.entries)
    return Outcome(verdict, kind, details, result.digest, simulated_s, stopped_s(result), acts, came)


def judged(result: RunResult, line: Line) -> tuple[Verdict, str, tuple[str, ...]]:
    """The verdict, its words, and all that is wrong."""
    unsafe = [
        (entry.t_s, f"{entry.event.unit_id} {entry.event.text}")
        for entry in result.journal.entries
        if isinstance(entry.event, Unsafe)
    ]
    broken = [v for v in result.violations if v.checker != Checker.EVERYONE_ARRIVES]
    waiting = [f"{w.stock_id} {w.number} in {w.place} waits for {w.waits_for}" for w in result.waiting]
    details = (
        *result.collisions,
        *(f"{t_s:.1f} s {text}" for t_s, text in unsafe),
        *(f"{v.t_s:.1f} s {v.checker}: {v.text}" for v in broken),
        *waiting,
        *(f"{stock_id} has not finished" for stock_id in result.unfinished),
    )
    if result.collisions:
        return Verdict.COLLISION, "collision", details
    if unsafe:
        return Verdict.UNSAFE, f"unsafe: {_general(unsafe[0][1].partition(' ')[2], result)}", details
    if broken:
        first = min(broken, key=lambda v: v.t_s)
        return Verdict.BROKEN, f"{first.checker}: {_general(first.text, result)}", details
    planned = {*result.trains_planned, *result.empty_planned}
    missing = planned - {*result.trains_arrived, *result.empty_arrived, *result.cut}
    if missing or result.unfinished:
        late = "" if missing else "arrived, but "
        return Verdict.NOT_ARRIVED, f"dead: {late}{_waits(result, line)}", details
    return Verdict.FINE, "fine", ()


def _waits(result: RunResult, line: Line) -> str:
    """What those wait for that wait for no other train, on what kind of section, and what their units said last; all,
    where there are none.
    """
    waits: dict[str, None] = {}
    last = {
        e.who: word_of(type(e.event)) for e in result.journal.entries if not isinstance(e.event, OF_NO_CAUSE)
    }
    for waiting in result.waiting:
        kind = _kind_of_place(waiting.place, line)
        said = last.get(waiting.stock_id, "nothing")
        waits[f"{_general(waiting.waits_for, result)} ({kind}, last {said})"] = None
    own = [text for text in waits if "held: " not in text]
    return " | ".join(sorted(own or waits)) or result.ended_because


def _kind_of_place(place: str, line: Line) -> str:
    """On what kind of section a train stands, by the words of `Duties.place`; a train may wait outside its portal."""
    section_id = place.removeprefix("section ").split()[0]
    return line.sections[section_id].kind.value if section_id in line.sections else "outside"


def _general(text: str, result: RunResult) -> str:
    """Words without the names of this run: units, sections and points become letters."""
    for stock_id in result.stock_ids:
        text = re.sub(rf"\b{re.escape(stock_id)}\b", "U", text)
    text = re.sub(r"\b(?:S\d+|OGN|KRS|HSK)\.\d\d\b|\bP(?:2|5|7|10)\b", "P", text)
    text = re.sub(r"section \S+|sections [\w., -]+", "section X", text)
    return re.sub(r"\d+(?:\.\d+)?", "N", text)


def _crash(error: BaseException) -> str:
    where = ""
    frame: TracebackType | None = error.__traceback__
    while frame is not None:
        file = Path(frame.tb_frame.f_code.co_filename)
        if file.is_relative_to(ROOT) and ".venv" not in file.parts:
            where = f"{file.relative_to(ROOT)}:{frame.tb_frame.f_code.co_name}"
        frame = frame.tb_next
    return f"crash: {type(error).__name__} in {where}"


_COURSES: dict[str, tuple[Scenario, Course]] = {}


def undisturbed(ground: Ground, nets: Path) -> tuple[Scenario, Course]:
    """How the ground runs when nothing fails, on plain track. RuntimeError where it then does not run as it must."""
    if ground.id not in _COURSES:
        case = Case(ground.id, ground)
        with tempfile.TemporaryDirectory(prefix="chaos-") as name:
            folder = Path(name)
            scenario = case.load(folder)
            result, _ = run(scenario, nets, folder, CarrierKind.PLAIN)
        verdict, kind, details = judged(result, scenario.setup.line)
        if verdict is not Verdict.FINE:
            raise RuntimeError(f"{ground.id} without any fault: {kind}: {'; '.join(details)}")
        _COURSES[ground.id] = (scenario, course_of(result))
    return _COURSES[ground.id]
