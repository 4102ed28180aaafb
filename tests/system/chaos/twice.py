"""A case run another way: as the first part of its day, which must be the same until then; worked at a desk, which must
be the drill of what was done; and the rest of its ground's day, which must end well.
"""

import tempfile
from dataclasses import replace
from pathlib import Path
from typing import Final

from console.session import Session
from scenario.part_of_day import part_of_day
from scenario.scenario import Scenario, load_scenario
from simulation.setup import STEPS_PER_S
from study.runner.run import CarrierKind
from tests.system.chaos.case import Case
from tests.system.chaos.draw import Draw
from tests.system.chaos.families import Family
from tests.system.chaos.generator import deed
from tests.system.chaos.ground import Ground
from tests.system.chaos.run_one import Verdict, judged, run, undisturbed

DEEDS_MAX: Final = 4
APART_S: Final = (0.1, 200.0)


def differs(family: Family, case: Case, seed: int, nets: Path) -> str:
    """What is not as it must be; empty: nothing. Raises what the simulator raises."""
    draw = Draw(seed, (family.value, "twice"))
    _, course = undisturbed(case.ground, nets)
    with tempfile.TemporaryDirectory(prefix="chaos-") as name:
        folder = Path(name)
        scenario = case.load(folder)
        until_s = float(draw.of("until").one_of(course.moving_s)) + draw.of("until", "s").between(0.0, 1.0, 1)
        return (
            _begun_later(case.ground, draw.of("from"), nets, folder)
            or _of_part(scenario, until_s, nets, folder)
            or _worked(scenario, course.moving_s, draw, nets, folder)
        )


def _begun_later(ground: Ground, draw: Draw, nets: Path, folder: Path) -> str:
    """Whether the rest of the day from a minute on, when nothing fails, does not end well."""
    scenario, _ = undisturbed(ground, nets)
    calls = [call for train in scenario.setup.timetable.trains.values() for call in train.calls]
    first_min, last_min = (round(pick(call.first_s for call in calls) // 60) for pick in (min, max))
    minute = draw.whole(first_min, last_min - 1)
    begins = f"{minute // 60:02d}:{minute % 60:02d}"
    rest = part_of_day(scenario, begins, None)
    result, _ = run(rest, nets, folder / "rest", CarrierKind.PLAIN)
    verdict, kind, _ = judged(result, scenario.setup.line)
    return "" if verdict is Verdict.FINE else f"from {begins}: {kind}"


def _of_part(scenario: Scenario, until_s: float, nets: Path, folder: Path) -> str:
    """Whether the part of the day until a time is other than the whole day is until then."""
    whole, _ = run(scenario, nets, folder / "whole")
    part, _ = run(replace(scenario, setup=replace(scenario.setup, until_s=until_s)), nets, folder / "part")
    before = [entry for entry in whole.journal.entries if entry.t_s < until_s]
    of_part = [entry for entry in part.journal.entries if entry.t_s < until_s]
    if of_part == before:
        return ""
    parted = next((e for e, other in zip(before, of_part, strict=False) if e != other), None)
    return f"part: the day until {until_s:.1f} s is other from {parted.t_s if parted else 'its end'} on"


def _worked(scenario: Scenario, moving_s: tuple[int, ...], draw: Draw, nets: Path, folder: Path) -> str:
    """Whether a run that is worked at a desk is other than the drill of what was done there."""
    with Session(scenario) as session:
        session.run_to(draw.of("from").one_of(moving_s) * STEPS_PER_S)
        for k in range(draw.of("deeds").whole(1, DEEDS_MAX)):
            if session.ended is not None:
                break
            kind, table = deed(scenario.setup, draw.of("deed", str(k)))
            session.fail(table) if kind == "fault" else session.act(table)
            apart_s = draw.of("apart", str(k)).by_size(*APART_S)
            session.run_to(session.step + round(apart_s * STEPS_PER_S))
        digest = session.run_to_end().digest
        drill = folder / "worked.toml"
        drill.write_text(session.drill_text("worked", "worked"), "utf-8")
    replayed, _ = run(load_scenario(str(drill)), nets, folder / "replayed")
    return "" if replayed.digest == digest else "desk: the drill of what was done is another run"
