"""Drills: every one shipped on the test line is met, is the same each time and with real processes."""

import json
from pathlib import Path

import pytest

from network.errors import InputError
from onboard.duty_parameters import ReleaseRule
from scenario.scenario import load_scenario
from simulation.cabs import Cabs
from simulation.duties import Duties
from simulation.events import MANAGER, WORLD, Author, authors_of
from simulation.faults.script import Property
from study.drilling.drill import Drill, fill_drill, find_drill, run_drill, sentence_of, shipped_drills
from study.record.directory import reserved
from study.runner.run import PartyLink, terminals_of
from tests.nightly import others_nightly
from tests.plain import drill_on_plain
from tests.study.report.page import payload_of

RTRI = [name for name in shipped_drills() if name.startswith("rtri/")]
KARASUYAMA = [name for name in shipped_drills() if name.startswith("karasuyama/")]
EVERY_RUN = (*RTRI[::12], "rtri/101_crossing_power")  # the others at night


@pytest.mark.parametrize("name", shipped_drills())
def test_a_shipped_drill_demands_safety_and_arrival_besides_its_own(name: str) -> None:
    scenario = load_scenario(find_drill(name))
    properties = {e.holds.value for e in scenario.setup.script.expectations if e.holds is not None}
    assert {"everyone_arrives", "no_invariant_broken"} <= properties
    assert scenario.id == name.replace("/", "_")
    assert sentence_of(name) == scenario.name


@pytest.mark.parametrize("name", others_nightly(RTRI, EVERY_RUN))
def test_every_drill_on_the_test_line_is_met(name: str) -> None:
    drill = run_drill(name, PartyLink.SIMULATED)
    assert [f"{v.text}: {v.happened}" for v in drill.verdicts if not v.passed] == []
    setup = drill.run.scenario.setup
    wrong = any(e.holds is Property.NO_INVARIANT_BROKEN and e.absent for e in setup.script.expectations)
    assert bool(drill.run.broken) is wrong  # what persons said wrongly shows, and a drill may expect it
    writers = {
        **dict.fromkeys(drill.run.result.stock_ids, Author.UNIT),
        **dict.fromkeys(terminals_of(setup.line), Author.TERMINAL),
        **dict.fromkeys(setup.line.crossings, Author.CROSSING),
        MANAGER: Author.MANAGER,
        WORLD: Author.WORLD,
    }
    for entry in drill.run.result.journal.entries:
        assert writers.get(entry.who, Author.PERSON) in authors_of(type(entry.event)), entry


# What these expect is the rule of whole routes itself, or the sections that a unit holds by it.
OF_WHOLE_ROUTES = {
    # It comes as far as Ogane, the points of which the train that stands has given back.
    "karasuyama/61_charger_dead_leaving": ("V4, down again, is caught behind it at Karasuyama",),
    "rtri/54_tachometer_over_reads": ("nothing is given back before the arrival tag",),
    "rtri/55_unit_dead_for_good": ("and has found it empty",),
    "rtri/59_unit_barred": ("T3 does not come into its section",),
    "rtri/75_claim_far_behind": ("the manager takes its word",),
    "rtri/75b_claim_off_the_path": ("the manager takes its word",),
    # What a train gives back on its way tells the manager that it has left.
    "rtri/91d_route_back_too_late": ("T1 is asked for its route", "it refuses", "it is not asked again"),
}


@pytest.mark.parametrize("name", others_nightly([*RTRI, *KARASUYAMA], EVERY_RUN[::2]))
def test_every_drill_is_met_where_sections_are_given_back_one_by_one(name: str, tmp_path: Path) -> None:
    operation = load_scenario(find_drill(name)).setup.operation
    file = tmp_path / "by_section.toml"
    file.write_text(
        f'extends = "{find_drill(name)}"\nid = "by_section"\nname = "by section"\n'
        f'[operation]\nrelease = "section"\nreentry = "{operation.reentry.value}"\n'
        f'interlocking = "{operation.interlocking.value}"\n'
    )
    drill = drill_on_plain(file)
    assert drill.run.scenario.setup.operation.release is ReleaseRule.SECTION
    missed = {v.text for v in drill.verdicts if not v.passed}
    assert missed <= set(OF_WHOLE_ROUTES.get(name, ()))


@pytest.mark.nightly
@pytest.mark.parametrize("name", ["karasuyama/09_manager_power", "karasuyama/33_links_flip"])
def test_a_disturbed_day_is_met(name: str) -> None:
    drill = run_drill(name, PartyLink.SIMULATED)
    assert [f"{v.text}: {v.happened}" for v in drill.verdicts if not v.passed] == []
    assert drill.run.broken == ()


def digest(drill: Drill) -> str:
    return drill.run.result.digest


@pytest.mark.parametrize(
    "name",
    others_nightly(
        ["rtri/09_manager_power", "rtri/12_terminal_power", "rtri/24_manager_frozen", "rtri/41_clock_drifts"],
        ["rtri/12_terminal_power"],
    ),
)
def test_a_drill_is_the_same_with_processes_that_are_killed(name: str) -> None:
    assert digest(run_drill(name, PartyLink.ZENOH)) == digest(drill_on_plain(name))


def test_another_seed_is_another_run_and_the_same_seed_the_same() -> None:
    name = "rtri/27_slippery_rail"
    first, again, other = (digest(run_drill(name, PartyLink.SIMULATED, seed)) for seed in (2, 2, 3))
    assert first == again != other


def test_an_expectation_not_met_is_told_and_fails_the_drill(tmp_path: Path) -> None:
    file = tmp_path / "tried.toml"
    file.write_text(
        'extends = "rtri_test_line"\nid = "tried"\n'
        '[[expect]]\ntext = "it breaks"\nevent = { who = "K1", what = "position_fault" }\n'
    )
    drill = drill_on_plain(file)
    assert not drill.passed
    told = json.loads(json.dumps(drill.as_dict()))
    broken, *defaults = told["expectations"]
    assert broken == {"text": "it breaks", "passed": False, "happened": "never happened"}
    assert [item["passed"] for item in defaults] == [True, True]


def test_a_drill_that_does_not_exist_is_refused() -> None:
    with pytest.raises(InputError, match="shipped drill"):
        find_drill("rtri/99_nothing")


def test_of_many_drills_those_are_named_first_that_begin_so() -> None:
    with pytest.raises(InputError, match="one of rtri/09_manager_power, rtri/09b_manager_power_by_hand, "):
        find_drill("rtri/09")


def test_days_are_shipped_for_the_threats_to_transmission() -> None:
    assert {name.split("_", 1)[1] for name in KARASUYAMA if "30" <= name.split("/")[1] < "40"} == {
        "links_delayed",
        "links_duplicate",
        "links_reorder",
        "links_flip",
        "links_loss",
    }


def drill_of(tmp_path: Path, script: str, timetable: str = "") -> Drill:
    file = tmp_path / "tried.toml"
    file.write_text(f'extends = "rtri_test_line"\nid = "tried"\n{timetable}{script}')
    return drill_on_plain(file)


def test_a_stock_that_never_finishes_its_last_duty_has_not_arrived(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Signed off, it stays in its portal; every train has arrived."""
    leave = Duties._leave
    stays = "K1"

    def left_alone(self: Duties, slot: int, step: int) -> None:
        if self._trains.stock_ids[slot] != stays:
            leave(self, slot, step)

    monkeypatch.setattr(Duties, "_leave", left_alone)
    late = '[[fault]]\nkind = "delay"\ntarget = "* -> K1"\nstart = "09:50:00"\nseconds = 0.1\n'
    drill = drill_of(tmp_path, late, 'timetable = "rtri_two_trains"\nlimits.time_limit_s = 600.0\n')
    assert drill.run.result.ended_because == "the time limit of the run"
    assert drill.run.summary["trains_arrived"] == drill.run.summary["trains_planned"]
    assert drill.run.result.unfinished == ("K1",)
    assert not drill.passed
    assert any("K1" in text for text in drill.run.broken)


@pytest.mark.parametrize("start_s", [10, 40, 75])
def test_a_frozen_unit_delays_its_train_and_nothing_else(tmp_path: Path, start_s: int) -> None:
    fault = (
        f'[[fault]]\nkind = "frozen"\ntarget = "K1"\nstart = "10:{start_s // 60:02d}:{start_s % 60:02d}"\n'
    )
    drill = drill_of(tmp_path, fault + "duration_s = 40.0\n", 'timetable = "rtri_two_trains"\n')
    assert drill.passed, drill.verdicts
    begun_s = 36_000.0 + start_s
    said = [
        entry.t_s
        for entry in drill.run.result.journal.entries
        if entry.who == "K1" and begun_s <= entry.t_s < begun_s + 40.0
    ]
    assert said == []  # it does nothing, not even timers


def test_a_frozen_unit_whose_pile_is_not_kept_does_not_get_in(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The switch of the test above: what comes meanwhile is lost instead of waiting."""
    freeze = Cabs.freeze

    def forgetting(self: Cabs, slot: int, step: int, *, frozen: bool) -> None:
        if not frozen:
            self._frozen[slot].clear()
        freeze(self, slot, step, frozen=frozen)

    monkeypatch.setattr(Cabs, "freeze", forgetting)
    fault = '[[fault]]\nkind = "frozen"\ntarget = "K1"\nstart = "10:00:40"\nduration_s = 40.0\n'
    drill = drill_of(tmp_path, fault, 'timetable = "rtri_two_trains"\n')
    assert not drill.passed


def test_what_never_came_due_is_said(tmp_path: Path) -> None:
    """The run is over at a quarter past ten: a fault at eleven at night disturbs nothing, and all expected is met."""
    fault = '[[fault]]\nkind = "frozen"\ntarget = "K1"\nduration_s = 1.0\nstart = '
    drill = drill_of(tmp_path, f'{fault}"10:00:20"\n{fault}"23:00"\n'.replace("frozen", "power_off", 1))
    assert drill.passed
    assert drill.never_due == ("frozen K1",) == tuple(drill.as_dict()["never_due"])


def test_a_drills_directory_shows_the_drill(tmp_path: Path) -> None:
    drill = drill_on_plain("rtri/21_points_stuck")
    out = tmp_path / "out"
    with reserved(out) as place:
        page = fill_drill(drill, place).read_text("utf-8")
    told = json.loads((out / "summary.json").read_text("utf-8"))["drill"]
    assert told["passed"] is True
    assert [item["text"] for item in told["expectations"]] == [v.text for v in drill.verdicts]
    fault, act = told["script"]
    assert fault["fault"] == "stuck P7"
    assert fault["over_s"] == act["begun_s"]  # staff mend it
    assert told["scores"]["last_heal_s"] == act["begun_s"]
    shown = json.dumps(payload_of(page), ensure_ascii=False)
    for verdict in drill.verdicts:
        assert verdict.text in shown
    assert "stuck P7" in shown and "staff: repair_points P7" in shown
    kinds = drill.run.tables.events["kind"].to_list()
    assert {"fault", "fault over", "act"} <= set(kinds)
    assert kinds.count("expectation") == len(drill.verdicts)
