"""`branchline check`, and what `branchline run` does with a plan that cannot work."""

import shutil
from collections.abc import Callable
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import polars as pl
import pytest

from branchline.checking import _print_found  # pyright: ignore[reportPrivateUsage]
from branchline.drilling import tell_of_plan
from scenario.scenario import load_scenario
from study.feasibility.finding import Feasibility, Finding, FindingKind, Severity
from tests.trains import day_of

LINE = Path(__file__).parents[1] / "examples/line"


@pytest.fixture
def valley(tmp_path: Path) -> Callable[..., None]:
    """Put the example line where the test is, with changes in its timetable or line."""

    def put(*changes: tuple[str, str]) -> None:
        for path in LINE.iterdir():
            text = path.read_text("utf-8")
            for old, new in changes:
                text = text.replace(old, new)
            (tmp_path / path.name).write_text(text, "utf-8")

    return put


ONE_TRACK = ('track = "2"', 'track = "1"')


def test_a_good_plan_shows_its_meets(main: Callable[..., Any], valley: Callable[..., None]) -> None:
    valley()
    checked = main("check", "valley_day.toml")
    assert checked.code == 0
    assert checked.out.startswith(
        "good: it runs as printed\nimpossible: 0, late: 0, tight: 0\nscenario: valley_day\n"
    )
    assert checked.out.endswith("meet: 10:04 1 and 2 at Mori on tracks 1 and 2\nmeets: 1\n")


def test_a_plan_that_cannot_work_is_shown_with_train_place_and_minute(
    main: Callable[..., Any], valley: Callable[..., None]
) -> None:
    valley(ONE_TRACK)
    checked = main("check", "valley_day.toml")
    assert checked.code == 1
    assert checked.out.startswith("impossible: it never goes on; 2 is to come to track 1 at Mori at 10:04")
    assert "\nimpossible: 2, late: 0, tight: 0\n" in checked.out
    assert "meet: 10:04 1 and 2 at Mori on tracks 1 and 1: they cannot pass\n" in checked.out
    assert (
        "impossible: track occupied: 2 is to come to track 1 at Mori at 10:04, and needs it from 10:00;"
        " 1 has it until 10:09:30; track 2 is free then\n"
    ) in checked.out
    figures = main("check", "valley_day.toml", "--json").figures()
    finding, circle = figures["findings"]
    assert circle["kind"] == "trains wait for each other"
    keys = ("kind", "severity", "trains", "place", "minute")
    assert [finding[key] for key in keys] == ["track occupied", "impossible", ["1", "2"], "MRI", "10:04"]
    assert (figures["outcome"], figures["impossible"], figures["tight"]) == ("broken", 2, 0)


@pytest.mark.parametrize("free", [True, False])
def test_a_track_that_is_free_has_a_platform_where_passengers_get_on(
    main: Callable[..., Any], valley: Callable[..., None], free: bool
) -> None:
    """Both are on track 1; the up train's stop at Mori is one for passengers, or only to let the other pass."""
    platform = ('section = "MRI.2", platform_from_km = 2.96, platform_to_km = 3.04,', 'section = "MRI.2",')
    operational = ('"MRI", track = "2"', '"MRI", operational = true, track = "1"')
    valley(platform, *([operational] if free else []), ONE_TRACK)
    checked = main("check", "valley_day.toml")
    assert checked.code == 1
    assert ("track 2 is free then" in checked.out) is free, checked.out


def test_one_cause_is_told_once_and_other_causes_are_not_left_out(capfd: pytest.CaptureFixture[str]) -> None:
    """30 trains on one leg that is too fast; a set that stays, and another at the same station; two tags that lack."""

    def finding(
        kind: FindingKind, trains: tuple[str, ...], place: str, remedy: str, short_s: float | None
    ) -> Finding:
        text = f"{' '.join(trains)} {place}"
        return Finding(kind, Severity.IMPOSSIBLE, trains, place, 36_000.0, text, remedy, short_s)

    legs = [finding(FindingKind.LEG, (str(n),), "A-B", f"at {n}", 90.0) for n in range(30)]
    stays = [
        finding(FindingKind.TERMINAL, (who, str(n)), "B", "another", None) for who in "XY" for n in range(3)
    ]
    tags = [finding(FindingKind.TAG, ("0", "1"), "B", f"a tag at km {km}", None) for km in (1, 2)]
    _print_found(Feasibility((), (*legs, *stays, *tags)), load_scenario("rtri_test_line").setup.line)
    lines = capfd.readouterr().out.splitlines()
    assert lines == [
        "impossible: running time: 0 A-B; at 0 (and 29 more like it, A-B: 1 at 10:00, 2 at 10:00, 3 at 10:00,"
        " 4 at 10:00, …)",
        "impossible: terminal track occupied: X 0 B; another (and 2 more like it, B: X and 1 at 10:00,"
        " X and 2 at 10:00)",
        "impossible: terminal track occupied: Y 0 B; another (and 2 more like it, B: Y and 1 at 10:00,"
        " Y and 2 at 10:00)",
        "impossible: tag missing: 0 1 B; a tag at km 1",
        "impossible: tag missing: 0 1 B; a tag at km 2",
        "meets: 0",
    ]


def test_json_keeps_every_finding(main: Callable[..., Any]) -> None:
    checked = main("check", "karasuyama_without_loop")
    assert (
        checked.out.count("\nimpossible: opposing trains: ")
        == checked.out.count("\nlate: opposing trains: ")
        == 1
    )
    figures = main("check", "karasuyama_without_loop", "--json").figures()
    assert sum(f["kind"] == "opposing trains" for f in figures["findings"]) == 10


@pytest.mark.parametrize(
    ("change", "told"),
    [
        (ONE_TRACK, "2 is to come to track 1 at Mori at 10:04"),
        (("tags = [\n", "tags = []\nother = [\n"), ""),
    ],
)  # fmt: skip
def test_a_plan_that_cannot_work_is_not_run(
    main: Callable[..., Any], valley: Callable[..., None], tmp_path: Path, change: tuple[str, str], told: str
) -> None:
    valley(change)
    if not told:
        _without_tags(tmp_path / "valley.toml")
        told = "1 would stop perhaps 18 m off its mark at Mori at 10:04"
    ended = main("run", "valley_day.toml", "--json", "--out", "out")
    assert ended.code == 2
    assert ended.figures()["outcome"] == "bad input"
    assert ended.err.count("\n") == 1
    assert told in ended.err
    assert "branchline check valley_day.toml shows all, --anyway runs it all the same" in ended.err
    assert not (tmp_path / "out").exists()


def test_a_plan_that_runs_late_is_run_and_told(main: Callable[..., Any], valley: Callable[..., None]) -> None:
    valley(('arrival = "10:09:30" },\n]\n\n[[trains]]', 'arrival = "10:06:30" },\n]\n\n[[trains]]'))
    checked = main("check", "valley_day.toml")
    assert checked.code == 0
    assert "late: running time: 1 leaves Mori at 10:05 and has 60 s for 3.0 km to Kawa" in checked.out
    ended = main("run", "valley_day.toml", "--json", "--out", "out")
    assert ended.code == 0
    assert "late: it runs, but not as printed; 1 would come to Kawa at " in ended.err
    (late,) = (
        f for f in main("check", "valley_day.toml", "--json").figures()["findings"] if f["kind"] == "lateness"
    )
    assert ended.figures()["late_s_max"] == pytest.approx(late["short_s"], abs=10.0)


def _without_tags(path: Path) -> None:
    before, _, rest = path.read_text("utf-8").partition("tags = []\n")
    path.write_text(before + rest.partition("]\n\n[line]")[1][3:] + rest.partition("]\n\n[line]")[2], "utf-8")


def test_the_two_agree_on_every_shipped_scenario_name(main: Callable[..., Any]) -> None:
    refused = main("run", "karasuyama_without_loop", "--json")
    checked = main("check", "karasuyama_without_loop", "--json")
    assert (refused.code, checked.code) == (2, 1)
    first = checked.figures()["findings"][0]
    assert f"{first['text']}; {first['remedy']}; 1 more" in refused.err


def test_what_has_a_time_before_the_run_is_said_to_begin_with_it(
    main: Callable[..., Any], tmp_path: Path
) -> None:
    """Its one train leaves at 10:00 where it stands: the run begins ten minutes before."""
    fault = '[[fault]]\nkind = "frozen"\ntarget = "K1"\nduration_s = 1.0\nstart = '
    head = 'extends = "rtri_test_line"\nid = "tried"\nname = "tried"\n'
    text = f'{head}{fault}"09:49:59"\n{fault}"09:50:00"\n{fault}"09:49:59"\nafter_s = 1.0\n'
    (tmp_path / "tried.toml").write_text(text, "utf-8")
    said = "before the run begins, at 09:50:00, and so with it: frozen K1 (09:49:59)"
    assert main("check", "tried.toml", "--json").figures()["early"] == said
    assert main("check", "rtri_test_line", "--json").figures()["early"] == ""


def test_a_drill_that_failed_says_whether_its_plan_could_work(capfd: pytest.CaptureFixture[str]) -> None:
    for name, said in (
        ("karasuyama_without_loop", "321M and 322M would meet at Ogane"),
        ("rtri_test_line", ""),
    ):
        done: Any = SimpleNamespace(run=SimpleNamespace(scenario=load_scenario(name)))
        tell_of_plan(done)
        told = capfd.readouterr().err
        assert said in told if said else told == ""


@pytest.mark.nightly
def test_anyway_runs_it_all_the_same(
    main: Callable[..., Any], valley: Callable[..., None], tmp_path: Path
) -> None:
    valley(ONE_TRACK)
    ended = main("run", "valley_day.toml", "--anyway", "--json", "--out", "out")
    assert ended.code in (0, 1)
    figures = ended.figures()
    assert figures["trains_planned"] == 2
    assert figures["trains_arrived"] < 2 or figures["late_s_max"] > 300.0
    assert (tmp_path / "out/report.html").is_file()
    shutil.rmtree(tmp_path / "out")


def test_of_two_that_leave_in_the_same_second_the_one_goes_first_that_does_so_in_the_run(
    main: Callable[..., Any], tmp_path: Path
) -> None:
    (tmp_path / "abc.csv").write_text("name,km,tracks\nA,0,2\nB,4,1\nC,8,2\n", "utf-8")
    assert main("new", "line", "abc.csv", "abc.toml", "--scenario", "day.toml").code == 0
    text = 'timetable = { id = "day_times", line = "abc", dwell_min_s = 20 }\n'
    for name, n, to in (("slow", 1, "06:20"), ("fast", 2, "06:10")):
        text += day_of(f"{name} down, stabled to stabled: A {n} -/06:00; C {n} {to}/-", **{f"V{n}": name})
    (tmp_path / "day_times.toml").write_text(text, "utf-8")
    assert "fast is to follow slow at 06:00" in main("check", "day.toml").out
    assert main("run", "day.toml", "--anyway", "--carrier", "plain", "--out", "run").code == 0
    stops = pl.read_parquet(tmp_path / "run/stops.parquet").filter(station="A")
    assert stops.sort("departure_s")["train"].to_list() == ["slow", "fast"]
