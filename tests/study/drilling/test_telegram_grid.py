"""The grid of telegrams: instants lie round telegrams, faults come beside a drill's own, and what is bad replays."""

import json
from collections.abc import Callable
from dataclasses import replace
from itertools import pairwise
from pathlib import Path
from typing import Any, Final

import pytest

from branchline import sweeping
from radio.noted import Sent, TookEffect
from scenario.scenario import Scenario, load_scenario
from simulation.events import JournalEntry
from simulation.faults.script import Expectation, Property, ScriptedFault
from simulation.setup import STEPS_PER_S
from study.drilling.drill import drills_in, find_drill
from study.drilling.every_instant import InstantWindow, Progress, SweepOutcomes, sweep
from study.drilling.grid_report import table_of
from study.drilling.moving import staffed
from study.drilling.outcome_class import OutcomeKind, SweptRun
from study.drilling.replay_file import replay_of
from study.drilling.swept_rows import MadeOf, SweptRows, growing_rows
from study.drilling.telegram_grid import AFTER_S, BEFORE_S, FaultChoice, grid_of, shortened_setup
from study.runner.run import simulation_of
from tests.nightly import others_nightly
from tests.plain import drill_on_plain

NAME = "rtri/12_terminal_power"


@pytest.fixture(scope="module")
def drill() -> Scenario:
    return staffed(load_scenario(find_drill(NAME)))


def short(drill: Scenario, chosen: FaultChoice, from_s: float = 36_060.0, to_s: float = 36_100.0) -> Any:  # noqa: ANN401
    return grid_of(drill.setup, chosen, InstantWindow(from_s=from_s, to_s=to_s))


def test_instants_lie_before_and_after_what_its_target_itself_says_and_hears(drill: Scenario) -> None:
    with simulation_of(drill.setup) as simulation:
        entries = simulation.run().journal.entries
    grid = short(drill, FaultChoice.POWER)
    assert {v.name for v in grid.variations} <= {
        f"power_off {p}" for p in ("K1", "block-manager", "A-E", "B-W")
    }
    left_out: set[int] = set()
    for variation in grid.variations:
        party = variation.name.split()[1]
        window = [e for e in entries if 36_060.0 <= e.t_s <= 36_100.0]
        heard = {around(e) for e in window if isinstance(e.event, TookEffect) and e.event.receiver == party}
        said = {around(e) for e in window if isinstance(e.event, Sent) and e.event.source == party}
        of_others = {around(e) for e in window if isinstance(e.event, Sent) and e.event.source != party}
        instants = {*(variation.instants or ())}
        assert {step for pair in heard for step in pair} <= instants
        assert instants <= {step for pair in heard | said for step in pair}
        left_out |= {step for pair in of_others for step in pair} - instants
    assert left_out  # as it is said to the party, which does not hear it yet


def around(entry: JournalEntry) -> tuple[int, int]:
    """The steps before and after an entry."""
    step = round(entry.t_s * STEPS_PER_S)
    return step - 1, step


def test_links_are_cut_one_way_and_only_round_their_own_telegrams(drill: Scenario) -> None:
    grid = short(drill, FaultChoice.LINKS)
    names = {v.name for v in grid.variations}
    assert "cut K1 -> B-W" in names
    assert grid.runs == sum(len(v.instants or ()) for v in grid.variations)
    assert all(" -> " in name for name in names)


@pytest.mark.nightly
def test_what_a_drill_says_of_persons_who_are_wrong_is_its_own_beside_any_fault(drill: Scenario) -> None:
    """Where the silent train is not heard in time, the one on sight comes into the very section (drill 53b)."""
    wrong = Expectation("t", holds=Property.NO_INVARIANT_BROKEN, absent=True, rules=("one-train-a-section",))
    script = replace(drill.setup.script, expectations=(wrong,))
    own = short(replace(drill, setup=replace(drill.setup, script=script)), FaultChoice.POWER).own
    both = SweptRun(OutcomeKind.BROKEN, "invariant one-train-a-section")
    assert both.beside(*own).kind is OutcomeKind.OWN
    assert SweptRun(OutcomeKind.BROKEN, "invariant one-train-a-section, sumo-collision").beside(*own).bad
    assert both.beside(*short(drill, FaultChoice.POWER).own).bad


def test_every_kind_is_on_the_grid(drill: Scenario) -> None:
    kinds = {v.name.split()[0] for v in short(drill, FaultChoice.ALL, 36_000.0, 36_100.0).variations}
    assert {"power_off", "restart", "frozen", "cut", "no_output", "stuck", "gnss_jump", "miss"} <= kinds


def test_a_copy_beside_the_drills_own_faults_is_the_run_of_its_replay_to_the_byte(
    drill: Scenario, tmp_path: Path
) -> None:
    grid = short(drill, FaultChoice.POWER, 36_070.0, 36_074.0)
    swept = sweep(grid.setup, grid.variations, InstantWindow(), jobs=2, beside=grid.setup.script)
    runs = [(v, step) for v in grid.variations for step in (v.instants or ())]
    assert sum(table_of(swept).values()) == len(runs) > 3
    for number, (variation, step) in enumerate(runs[:: len(runs) // 3]):
        file = tmp_path / f"replay_{number}.toml"
        text = replay_of(drill, variation.at(step), file.stem, "found", beside=True)
        file.write_text(text, "utf-8")
        result = drill_on_plain(file).run.result
        assert result.courses[0].item == drill.setup.script.faults[0]
        # the drill's own, and this one
        assert len([c for c in result.courses if isinstance(c.item, ScriptedFault)]) > 1
        assert result.digest == swept.outcomes[variation.name][step].digest


def test_a_folder_is_the_drills_in_it() -> None:
    assert len(drills_in("sidings")) == 6
    assert drills_in(NAME) == (NAME,)


def test_without_a_script_it_is_about_the_first_hour() -> None:
    grid = grid_of(load_scenario(find_drill("rtri/01_normal")).setup, FaultChoice.POWER, InstantWindow())
    assert {v.name.split()[0] for v in grid.variations} == {"power_off"}
    assert 50 < grid.runs < 400


def test_a_sample_is_even_and_follows_from_the_seed(drill: Scenario) -> None:
    grid = short(drill, FaultChoice.LINKS, 36_000.0, 36_160.0)
    every = [(v.name, step) for v in grid.variations for step in v.instants or ()]
    assert grid.of == grid.runs == len(every) > 10
    some = grid.sample(6)
    taken = [every.index((v.name, step)) for v in some.variations for step in v.instants or ()]
    assert (some.runs, some.of) == (6, grid.of)
    assert {b - a for a, b in pairwise(taken)} <= {len(every) // 6, len(every) // 6 + 1}
    assert grid.sample(6) == some
    others = {
        replace(grid, setup=replace(grid.setup, seed=seed)).sample(6).variations for seed in range(2, 8)
    }
    assert len(others) > 1
    assert grid.sample(grid.runs) is grid


def test_what_a_drill_itself_breaks_is_told_apart() -> None:
    wrong = SweptRun(OutcomeKind.BROKEN, "invariant inside-holding, unsafe: ran onto points N")
    known, more = replace_label(wrong, "invariant inside-holding"), replace_label(wrong, "invariant body")
    assert known.beside(wrong).kind is OutcomeKind.OWN
    assert not known.beside(wrong).bad
    assert more.beside(wrong) == more
    dead = SweptRun(OutcomeKind.NOT_ARRIVED, "not every train arrives: K1 waits for nothing")
    assert dead.beside(wrong) == dead
    assert dead.beside(wrong, dead).kind is OutcomeKind.OWN
    crash = SweptRun(OutcomeKind.CRASH, "crash SIGSEGV")
    assert crash.beside(crash).bad
    grid = grid_of(
        staffed(load_scenario(find_drill("rtri/53b_two_wrong_persons"))).setup,
        FaultChoice.POWER,
        InstantWindow(),
    )
    assert "invariant inside-holding" in " ".join(run.label for run in grid.own)


def replace_label(run: SweptRun, label: str) -> SweptRun:
    return SweptRun(run.kind, label)


def test_trains_that_come_later_are_left_out() -> None:
    day = load_scenario("karasuyama_weekday").setup
    assert shortened_setup(day, 1e9) is day
    cut = shortened_setup(day, 7.0 * 3600.0)
    assert 0 < len(cut.timetable.trains) < len(day.timetable.trains)
    assert {d.stock_id for d in cut.timetable.diagrams} == set(cut.trains)


@pytest.mark.nightly
def test_no_train_that_is_left_out_stands_in_the_way_of_one_that_is_kept() -> None:
    """325M begins before the cut and needs the track from which 326M leaves after it."""
    cut = shortened_setup(load_scenario("karasuyama_weekday").setup, 7.5 * 3600.0)
    assert {"325M", "326M"} <= set(cut.timetable.trains)
    with simulation_of(cut) as simulation:
        result = simulation.run()
    assert set(result.trains_arrived) == set(cut.timetable.trains)
    assert result.unfinished == ()


def test_the_command_counts_outcomes_and_takes_no_other_words(
    main: Callable[..., Any], tmp_path: Path
) -> None:
    window = ("--from", "10:01:10", "--to", "10:01:13")
    ended = main("drill", NAME, "--at", "telegrams", *window, "--json", "--out", str(tmp_path / "grid"))
    figures = json.loads(ended.out)
    assert figures["runs"] == sum(figures["by_kind"].values()) > 0
    assert figures["wall_s"] >= 0.0
    assert (tmp_path / "grid" / "sweep.csv").is_file()
    for words, key in (
        (("--at", "seconds"), "--at"),
        (("--at", "telegrams", "--faults", "many"), "--faults"),
    ):
        ended = main("drill", NAME, *words)
        assert ended.code == 2
        assert key in ended.err


FEW: Final = ("rtri/03_block_held", NAME)


@pytest.mark.parametrize("drills", others_nightly([FEW, drills_in("sidings")], [FEW]), ids=len)
def test_a_folder_of_drills_is_a_table(
    drills: tuple[str, ...], main: Callable[..., Any], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(sweeping, "drills_in", {"folder": drills}.__getitem__)
    out = ("--out", str(tmp_path / "grids"))
    figures = json.loads(main("drill", "folder", "--at", "telegrams", "--sample", "1", "--json", *out).out)
    assert len(figures["drills"]) == len(drills)
    assert figures["runs"] == sum(sum(d["by_kind"].values()) for d in figures["drills"])
    assert figures["grid"] == sum(d["grid"] for d in figures["drills"]) > figures["runs"]
    assert figures["bad_runs"] == 0
    assert all((tmp_path / "grids" / d["sweep"] / "sweep.json").is_file() for d in figures["drills"])


@pytest.mark.nightly
@pytest.mark.parametrize(
    ("name", "chosen"),
    [
        ("rtri/01_normal", FaultChoice.LINKS),
        ("rtri/12_terminal_power", FaultChoice.POWER),
        ("karasuyama/12_terminal_power", FaultChoice.LINKS),
    ],
)
def test_nothing_bad_on_a_slice_of_the_grid(
    name: str, chosen: FaultChoice, record_property: Callable[[str, object], None]
) -> None:
    grid = grid_of(staffed(load_scenario(find_drill(name))).setup, chosen, InstantWindow())
    swept = sweep(grid.setup, grid.variations, InstantWindow(), jobs=2, beside=grid.setup.script).beside(
        *grid.own
    )
    record_property("figures", f"grid of telegrams, {name}, {chosen.value}: {table_of(swept)}")
    assert not swept.bad


def test_a_sweep_that_is_stopped_loses_no_run_and_is_gone_on_with(drill: Scenario, tmp_path: Path) -> None:
    grid, out, stops_after = short(drill, FaultChoice.POWER, 36_070.0, 36_074.0), tmp_path / "grid", 3
    made_of = MadeOf("a" * 32, "b" * 32)

    def stop(done: int, _: int) -> None:
        if done == stops_after:
            raise KeyboardInterrupt

    def swept(rows: SweptRows, progress: Progress | None = None) -> SweepOutcomes:
        script = grid.setup.script
        return sweep(grid.setup, grid.variations, InstantWindow(), 1, progress, script, rows)

    with pytest.raises(KeyboardInterrupt), growing_rows(out, made_of, resume=False) as rows:
        swept(rows, stop)
    left = tmp_path / "grid-incomplete" / "sweep.csv"
    with left.open("a") as stream:  # as one that was killed while it wrote
        stream.write("power_off K1,36042.0,late,all arr")
    with growing_rows(out, replace(made_of, code="c" * 32), resume=True) as rows:
        assert (len(rows.taken_up), rows.of_other_code) == (stops_after, stops_after)
        together = swept(rows)
        assert len(rows.rows) == grid.runs > stops_after
    assert not left.parent.exists()
    assert together == swept(SweptRows(None, made_of, {}))
    with pytest.raises(KeyboardInterrupt), growing_rows(out, made_of, resume=False) as rows:
        swept(rows, stop)
    with growing_rows(out, replace(made_of, inputs="d" * 32), resume=True) as rows:
        assert not rows.taken_up


def test_it_covers_what_comes_when_a_long_fault_is_over() -> None:
    """Motors are cut out for 420 s, in which nobody says anything: the first telegrams are of the time after them."""
    scenario = staffed(load_scenario(find_drill("rtri/57_motors_on_a_gradient")))
    (motors,) = scenario.setup.script.faults
    assert motors.trigger.at_s is not None
    over_s = motors.trigger.at_s + (motors.duration_s or 0.0)
    grid = grid_of(scenario.setup, FaultChoice.POWER, InstantWindow())
    steps = {step for variation in grid.variations for step in variation.instants or ()}
    assert min(steps) >= over_s * STEPS_PER_S - 1
    assert max(steps) <= (over_s + AFTER_S) * STEPS_PER_S


def test_what_is_said_long_after_the_script_and_between_its_parts_is_left_out() -> None:
    """Drill 9 without staff: the manager is off for ten minutes; nothing of the middle of them can be new."""
    scenario = load_scenario(find_drill("karasuyama/09_manager_power"))
    (power,) = scenario.setup.script.faults
    grid = grid_of(scenario.setup, FaultChoice.LINKS, InstantWindow())
    times_s = {step / STEPS_PER_S for v in grid.variations for step in v.instants or ()}
    begun_s = power.trigger.at_s or 0.0
    over_s = begun_s + (power.duration_s or 0.0)
    assert min(times_s) >= begun_s - BEFORE_S - 0.1
    assert not [t for t in times_s if begun_s + AFTER_S < t < over_s - BEFORE_S - 0.1]
    assert [t for t in times_s if over_s < t < over_s + 60.0]
    assert max(times_s) <= max(over_s, scenario.setup.script.acts[0].trigger.at_s or 0.0) + AFTER_S
