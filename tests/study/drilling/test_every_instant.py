"""Sweeps: a forked run is the run of the drill at that time, classes are told, and what is bad can be replayed."""

import json
import os
import signal
from collections.abc import Callable
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any, Final

import psutil
import pytest

from network.errors import InputError
from scenario.scenario import Scenario, load_scenario
from simulation.faults.devices import Restart
from simulation.faults.script import ActKind, ScriptedFault, Trigger
from simulation.faults.table import FAULTS
from simulation.late.settings import Late
from simulation.people import People
from simulation.setup import STEPS_PER_S
from simulation.world import kernel
from study.drilling.drill import find_drill, run_drill
from study.drilling.every_instant import InstantWindow, SweepOutcomes, Variation, sweep
from study.drilling.forks import CopyDied, Forks, result_of_copy
from study.drilling.grid_report import classes_of, ranges_of
from study.drilling.moving import SINGLES, single_faults, what_is_moved
from study.drilling.outcome_class import OutcomeKind
from study.drilling.replay_file import replay_of
from study.runner.run import PartyLink
from tests.nightly import others_nightly
from tests.scenario.own import own_scenario

TEN: Final = 36_000.0  # T1's departure


def restart(unit: str, after_s: float = 0.0) -> Variation:
    failure = ScriptedFault(Restart(target=unit), Trigger())
    return Variation(f"restart {unit}", ((round(after_s * STEPS_PER_S), failure),), (), frozenset({unit}))


def sweep_of(
    scenario: Scenario, *variations: Variation, every_s: float, from_s: float, to_s: float
) -> SweepOutcomes:
    return sweep(scenario.setup, variations, InstantWindow(every_s, from_s, to_s), jobs=2)


@pytest.fixture(scope="module")
def two_trains(tmp_path_factory: pytest.TempPathFactory) -> Scenario:
    return own_scenario(tmp_path_factory.mktemp("two"), 'timetable = "rtri_two_trains"\n', "rtri_test_line")


# a copy ---------------------------------------------------------------------------------------------------------------


def dies(number: signal.Signals) -> int:
    os.kill(os.getpid(), number)
    return 0


def fails() -> int:
    raise ValueError("planted\nhere")


def test_what_copies_find_and_how_they_die() -> None:
    with Forks(int, 2) as copies:
        for number in range(5):
            copies.start(("square", number), partial(pow, number, 2))
        copies.start(("signal", 0), partial(dies, signal.SIGSEGV))
        copies.start(("error", 0), fails)
        copies.start(("silent", 0), partial(os._exit, 3))
        copies.wait()
    assert [copies.results["square", number] for number in range(5)] == [0, 1, 4, 9, 16]
    assert copies.results["signal", 0] == CopyDied("SIGSEGV", "ended by SIGSEGV")
    assert copies.results["error", 0] == CopyDied("ValueError", "ValueError: planted here")
    assert copies.results["silent", 0] == CopyDied("exit", "ended with code 3 and no result")


def test_copies_are_gone_when_the_context_ends() -> None:
    before = psutil.Process().children()
    with pytest.raises(KeyError), Forks(int, 1) as copies:
        copies.start(("waits", 0), partial(dies, signal.SIGSTOP))
        assert len(psutil.Process().children()) == len(before) + 1
        raise KeyError
    assert psutil.Process().children() == before


# a forked run is the drill's ------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "name",
    others_nightly(["rtri/09_manager_power", "rtri/04_unit_power_position_fixed"], ["rtri/09_manager_power"]),
)
def test_a_forked_run_is_the_run_of_its_replay_to_the_byte(name: str, tmp_path: Path) -> None:
    """Faults with a duration, acts after them, events made times; instants at a stand and on the way."""
    scenario = load_scenario(find_drill(name))
    variation = what_is_moved(scenario).variation
    swept = sweep_of(scenario, variation, every_s=47.4, from_s=TEN - 12.3, to_s=TEN + 70.0)
    runs = swept.outcomes[scenario.id]
    assert len(runs) == 2
    assert len({outcome.digest for outcome in runs.values()}) == 2
    for number, (step, outcome) in enumerate(runs.items()):
        file = tmp_path / f"replay_{number}.toml"
        file.write_text(replay_of(scenario, variation.at(step), file.stem, outcome.label), "utf-8")
        drill = run_drill(str(file), PartyLink.SIMULATED)
        assert drill.run.result.digest == outcome.digest
        assert drill.passed is not outcome.bad
        assert drill.run.summary["late_s_max"] == pytest.approx(outcome.late_s, abs=0.06)


def test_a_drill_is_moved_as_one_piece() -> None:
    """`rtri/09`: the fault waits for T1's departure, 5 s after it, and the act has a time of its own, 10:05:30."""
    scenario = load_scenario(find_drill("rtri/09_manager_power"))
    found = what_is_moved(scenario)
    departed_s = next(
        e.t_s
        for e in run_drill("rtri/09_manager_power", PartyLink.SIMULATED).run.result.journal.entries
        if type(e.event).__name__ == "FaultBegan"
    )
    ((fault_at, fault),) = found.variation.faults
    ((act_at, act),) = found.variation.acts
    assert (fault_at, fault.duration_s, found.left_out) == (0, 240.0, ())
    assert act.kind is ActKind.REENTER_ASSISTED
    assert act_at == round((TEN + 330.0 - departed_s) * STEPS_PER_S)
    script = found.variation.at(360_100)
    assert script.faults[0].trigger == Trigger(at_s=36_010.0)
    assert script.acts[0].trigger == Trigger(at_s=(360_100 + act_at) / STEPS_PER_S)
    assert found.variation.stocks == {"K1", "K2"}  # it aims at no unit


def test_what_an_act_does_before_the_fault_is_moved_with_it(two_trains: Scenario) -> None:
    early = replace(
        restart("K1"), faults=((0, restart("K1").faults[0][1]), (-50, restart("K2").faults[0][1]))
    )
    assert early.first == -50
    swept = sweep_of(two_trains, early, every_s=5.0, from_s=TEN, to_s=TEN + 10.0)
    assert list(swept.outcomes[early.name]) == [360_000, 360_050, 360_100]


def test_what_cannot_be_moved_is_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="that can be moved"):
        what_is_moved(load_scenario(find_drill("rtri/01_normal")))
    file = tmp_path / "never.toml"
    file.write_text(
        'extends = "rtri_test_line"\nid = "never"\nname = "never"\n[[fault]]\nkind = "restart"\ntarget = "K1"\n'
        'start = { who = "K1", what = "position_fault" }\n',
        "utf-8",
    )
    with pytest.raises(InputError, match=r"fault\[0\].start.*happens in the drill itself"):
        what_is_moved(load_scenario(str(file)))


# a unit that starts again as its train begins to move -----------------------------------------------------------------


@pytest.mark.parametrize("departure_s", others_nightly([TEN, TEN + 420.0], [TEN]))
def test_a_restart_at_any_moment_of_a_departure_is_no_crash(two_trains: Scenario, departure_s: float) -> None:
    """Traction builds up for some tenths after the order; whoever moves then without driving tells the carrier."""
    swept = sweep_of(two_trains, restart("K1"), every_s=0.8, from_s=departure_s + 0.4, to_s=departure_s + 2.8)
    assert len(swept.outcomes["restart K1"]) == 4
    assert not swept.bad


def test_without_being_told_the_carrier_disagrees(
    two_trains: Scenario, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The switch of the test above: only stock that drives or rolls as a stretch begins is told of."""

    def untold(stock: Any, track: Any, sheet: kernel.Sheet, *rest: Any) -> tuple[int, int, int]:  # noqa: ANN401
        told = kernel.list_movers(stock, sheet)
        done, used, _ = kernel.advance(stock, track, sheet, *rest)
        return done, used, told

    monkeypatch.setattr("simulation.foreseen.advance", untold)
    at_once = replace(two_trains, setup=replace(two_trains.setup, people=People(times=0.0)))
    swept = sweep_of(at_once, restart("K1"), every_s=0.8, from_s=TEN + 0.4, to_s=TEN + 2.8)
    assert "crash CarrierDisagrees" in {outcome.label for outcome in swept.outcomes["restart K1"].values()}
    assert swept.bad


# what is told ---------------------------------------------------------------------------------------------------------


def test_instants_are_told_as_ranges() -> None:
    assert ranges_of([360_000, 360_010, 360_020, 360_050, 360_085], 10) == [
        "10:00:00 to 10:00:02",
        "10:00:05",
        "10:00:08.5",
    ]


def test_every_kind_of_fault_is_swept_alone(two_trains: Scenario) -> None:
    assert set(SINGLES) == set(FAULTS)
    variations = single_faults(two_trains.setup)
    names = [variation.name for variation in variations]
    assert len(set(names)) == len(names)
    assert not two_trains.setup.line.chargers
    assert not two_trains.setup.line.crossings
    of_crossings = {kind for kind, fault in FAULTS.items() if fault.aims_at == "level crossing"}
    nowhere = {"charger_dead", "marker_missing", *of_crossings}
    assert not two_trains.setup.line.markers
    assert {name.split()[0] for name in names} == set(FAULTS) - nowhere
    for target in ("K1", "K2", "block-manager"):
        assert {f"power_off {target}", f"restart {target}", f"frozen {target}"} <= set(names)
    tags = [variation for variation in variations if variation.name.startswith("miss")]
    assert 0 < len(tags) < len(two_trains.setup.line.tags)  # the others are passed by no train
    assert all(variation.instants for variation in tags)
    assert not any(variation.acts for variation in variations)  # what people do, staff do by what they see


DEAD: Final = """
extends = "rtri_test_line"
id = "dead"
name = "A unit that dies for good"
[[fault]]
kind = "power_off"
target = "K1"
start = "10:00:30"
"""


def test_a_sweep_for_a_person_and_for_a_program(main: Callable[..., Any], tmp_path: Path) -> None:
    """A unit that stays dead: its train does not arrive, unless it had arrived before."""
    (tmp_path / "dead.toml").write_text(DEAD, "utf-8")
    asked = ("drill", "dead.toml", "--sweep", "--every", "40", "--out", "found")
    ended = main(*asked)
    assert ended.code == 1, ended.err
    assert "BAD   dead: not every train arrives: K1 waits for" in ended.out
    assert f"replay: {tmp_path}/found/replay_01.toml" in ended.out
    told = main(*asked, "--json")
    figures = told.figures()
    assert told.code == 1 and figures["bad"] is True
    bad = [found for found in figures["classes"] if found["bad"]]
    assert bad and bad[0]["ranges"][0].startswith("09:59:50")
    # none is too late
    assert {found["kind"] for found in figures["classes"]} <= {"not_arrived", "on_time", "late"}
    rows = (tmp_path / "found" / "sweep.csv").read_text("utf-8").splitlines()
    assert len(rows) == figures["runs"] + 1
    assert json.loads((tmp_path / "found" / "sweep.json").read_text("utf-8"))["classes"] == figures["classes"]
    replayed = main("drill", "found/replay_01.toml", "--json")
    assert replayed.code == 1
    assert replayed.figures()["summary"]["digest"] in rows[1]


def test_an_instant_after_the_run_is_not_applicable(two_trains: Scenario) -> None:
    swept = sweep_of(two_trains, restart("K1"), every_s=20.0, from_s=TEN + 510.0, to_s=TEN + 590.0)
    kinds = [outcome.kind for outcome in swept.outcomes["restart K1"].values()]
    assert kinds[0] is not OutcomeKind.NOT_APPLICABLE
    assert kinds[-1] is OutcomeKind.NOT_APPLICABLE


def test_a_good_sweep_ends_with_0(main: Callable[..., Any]) -> None:
    ended = main("drill", "rtri/20_route_given_back", "--sweep", "--from", "09:59:40", "--to", "09:59:40")
    assert ended.code == 0, ended.out
    assert "1 runs, one every 1 s" in ended.out
    assert "good" in ended.out and "BAD" not in ended.out


@pytest.mark.parametrize(
    ("options", "named"),
    [
        (("--from", "noon"), "--from"),
        (("--from", "10:10", "--to", "10:00"), "--to"),
        (("--link", "zenoh"), "--link"),
        (("--every", "0"), "--every"),
    ],
)
def test_what_a_sweep_cannot_do_is_refused(
    main: Callable[..., Any], options: tuple[str, ...], named: str
) -> None:
    ended = main("drill", "rtri/04_unit_power_position_fixed", "--sweep", *options)
    assert (ended.code, ended.out) == (2, "")
    assert named in ended.err


@pytest.mark.nightly
def test_what_a_drill_says_wrong_people_break_is_not_bad_where_it_is_moved(
    main: Callable[..., Any], monkeypatch: pytest.MonkeyPatch
) -> None:
    swept: list[SweepOutcomes] = []  # run once, judged twice

    def once(*given: Any) -> SweepOutcomes:  # noqa: ANN401 - as `sweep` takes it
        if not swept:
            swept.append(sweep(*given))
        return swept[0]

    monkeypatch.setattr("branchline.sweeping.sweep", once)
    window = ("--every", "40", "--from", "10:00", "--to", "10:00")
    for excused, code in ((True, 0), (False, 1)):
        if not excused:
            monkeypatch.setattr("branchline.sweeping.expected_breaks", lambda script: ())
        ended = main("drill", "rtri/53b_two_wrong_persons", "--sweep", *window)
        assert ended.code == code
        assert ("wrong only as the drill itself expects" in ended.out) is excused
        assert ("BAD" in ended.out) is not excused


@pytest.mark.nightly
def test_the_classes_of_a_sweep_have_the_gravest_last(two_trains: Scenario) -> None:
    swept = sweep_of(two_trains, restart("K1"), every_s=20.0, from_s=TEN - 10.0, to_s=TEN + 110.0)
    order = list(OutcomeKind)
    kinds = [order.index(found.kind) for found in classes_of(swept)]
    assert kinds == sorted(kinds)
    assert sum(len(found.steps) for found in classes_of(swept)) == 7


def test_a_copy_that_fails_where_one_result_is_needed_says_so() -> None:
    with pytest.raises(RuntimeError, match="ValueError: planted here"):
        result_of_copy(int, fails)


def test_a_day_on_which_something_fails_by_itself_is_not_swept(two_trains: Scenario) -> None:
    table = {"kind": "motors", "cut_out": 1, "mtbf_h": 0.1, "source": "t"}
    table["seconds"] = {"distribution": "fixed", "mean_s": 60.0}
    late = Late.model_validate({"failures": {"motors": table}})
    with pytest.raises(InputError, match="no failures"):
        sweep(replace(two_trains.setup, late=late), [], InstantWindow(), 1)
