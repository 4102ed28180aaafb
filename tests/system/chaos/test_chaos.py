"""Random cases of one to twelve faults that heal, with truthful staff: nothing unsafe happens, and every train arrives.

A slice in every test, all of them in `make nightly`; each chunk leaves a line of figures at the end. A case that fails
is made small and left as a drill; once its cause is mended it is kept in `replays/`, which are run here one by one.
"""

from collections.abc import Callable
from itertools import pairwise
from pathlib import Path
from shutil import copytree
from typing import Final

import pytest

from simulation.judge.checkers import Checker
from simulation.loop import Simulation
from study.drilling.drill import run_drill
from study.runner.run import PartyLink
from tests.nightly import others_nightly
from tests.system.chaos.campaign import none_fails
from tests.system.chaos.families import Family
from tests.system.chaos.generator import case_of
from tests.system.chaos.twice import differs
from tests.system.switchboard import RunWith

SLICE: Final = (
    (Family.TEST_LINE, 0, 2),
    (Family.HOUR, 0, 1),
    (Family.LINES, 0, 1),
    (Family.CROSSINGS, 0, 1),
    (Family.WIDE, 3, 4),
)
ALL: Final = {
    Family.TEST_LINE: 4000,
    **dict.fromkeys((Family.HOUR, Family.LINES, Family.CROSSINGS, Family.WIDE), 500),
}
CHUNK: Final = 250
CHUNKS: Final = tuple(
    (family, low, high) for family, count in ALL.items() for low, high in pairwise(range(0, count + 1, CHUNK))
)
FOLDER: Final = Path(__file__).parent / "replays"  # a folder each, as `replay.write` makes it
REPLAYS: Final = tuple(
    sorted(path.name for path in FOLDER.glob("*") if (path / f"{path.name}.toml").is_file())
)

WITHOUT: Final = {  # what some were mended by
    "crossings_217": "guards_no_road_far_ahead",
    "crossings_5343": "staff_speak_from_memory",
    "crossings_41": "waits_for_a_crossing_beyond_its_mark",
    "grid_05": "keeps_what_is_off_its_way",
    "test_3467": "takes_the_end_of_a_claim_for_a_release",
    "test_3705": "keeps_what_is_of_no_use",
    "test_4299": "departs_before_the_driver_has_looked",
    "test_20034": "goes_on_as_if_it_had_been_on",
    "test_20271": "staff_say_no_more_than_what_is_so",
    "test_80700": "tells_no_unit_what_persons_added",
    "test_81142": "keeps_what_others_say_that_it_holds",
    "test_90273": "staff_unbar_at_once",
    "test_100127": "staff_unbar_nobody_while_restoring",
    "test_100434": "departs_before_the_driver_has_looked",
    "test_101114": "crews_enter_the_next_number_in_any_case",
    "hour_101049": "waits_for_the_radio_without_a_position",
    "test_120890": "staff_call_nobody_back",
    "lines_110128": "waits_where_no_radio_reaches",
    "swarm_test_93": "overtakes_before_a_portal",
}
NOT_BY_TRAINS: Final[dict[str, str]] = {  # what sees that which the trains that come do not show
    "crossings_217": Checker.CROSSING_OPEN,
    "crossings_5343": Checker.INSIDE_HOLDING,
    "test_80700": "every train reaches its station",
    "test_120890": "every train reaches its station",
    "test_20034": Checker.WITHIN_BOUNDS,
    "grid_05": Checker.NO_DEAD_STATE,
}
AS_STATED: Final = ""
AT_ONCE: Final = "[people]\ntimes = 0.0\n"
EVERY_RUN: Final = REPLAYS[::20]

Record = Callable[[str, object], None]


def _run(family: Family, low: int, high: int, nets: Path, found: Path, record: Record) -> None:
    figures = none_fails(family, range(low, high), nets, found)
    record("figures", f"chaos, {family.value} {low} to {high - 1}: {figures}")
    assert figures.runs == high - low
    assert figures.faults >= figures.runs


def _ids(chunk: tuple[Family, int, int]) -> str:
    return f"{chunk[0].value}-{chunk[1]}"


@pytest.mark.parametrize("chunk", SLICE, ids=_ids)
def test_a_slice(chunk: tuple[Family, int, int], nets: Path, tmp_path: Path, record_property: Record) -> None:
    _run(*chunk, nets, tmp_path, record_property)


@pytest.mark.nightly
@pytest.mark.parametrize("chunk", CHUNKS, ids=_ids)
def test_all(chunk: tuple[Family, int, int], nets: Path, tmp_path: Path, record_property: Record) -> None:
    _run(*chunk, nets, tmp_path, record_property)


@pytest.mark.parametrize("seeds", others_nightly((range(42, 43), range(60)), [range(42, 43)]), ids=len)
def test_a_case_run_another_way_is_the_same(seeds: range, nets: Path) -> None:
    """As a part of its day, and worked at a desk."""
    cases = ((seed, case_of(Family.WIDE, seed, nets)) for seed in seeds)
    assert [found for seed, case in cases if (found := differs(Family.WIDE, case, seed, nets))] == []


@pytest.mark.nightly
def test_a_deed_that_cuts_nothing_is_seen(nets: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """It then comes where the stretch ends that was foreseen."""
    monkeypatch.setattr(Simulation, "_cut", lambda _simulation, _step: None)
    cases = ((seed, case_of(Family.WIDE, seed, nets)) for seed in range(20))
    assert any("desk" in differs(Family.WIDE, case, seed, nets) for seed, case in cases)


@pytest.mark.parametrize(
    "people",
    [pytest.param(AS_STATED, id="as-stated"), pytest.param(AT_ONCE, id="at-once", marks=pytest.mark.nightly)],
)
@pytest.mark.parametrize("name", others_nightly(REPLAYS, EVERY_RUN))
def test_what_failed_once_does_not_fail_again(name: str, people: str, tmp_path: Path) -> None:
    """With people as its file states them; and with people who act at once, for whom many were written."""
    folder = tmp_path / name
    copytree(FOLDER / name, folder)
    drill = folder / "with_people.toml"
    drill.write_text(f'extends = "{name}.toml"\nid = "{name}"\nname = "{name}"\n{people}', "utf-8")
    verdicts = run_drill(str(drill), PartyLink.SIMULATED).verdicts
    assert [v.happened for v in verdicts if not v.passed] == []


@pytest.mark.parametrize("name", others_nightly(WITHOUT, ["test_3705"]))
def test_it_fails_again_without_what_mended_it(name: str, run_with: RunWith) -> None:
    _, objections = run_with(str(FOLDER / name / f"{name}.toml"), WITHOUT[name])
    assert str(NOT_BY_TRAINS.get(name, Checker.EVERYONE_ARRIVES)) in objections
