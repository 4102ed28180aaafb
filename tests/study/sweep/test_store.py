"""The directory of a sweep: what does not count is named and run again, and nobody's work is overwritten."""

import json
import re
import shutil
from pathlib import Path

import pytest
from msgspec.structs import replace

import study
from network.errors import InputError
from study.sweep import cluster
from study.sweep.digest import CODE
from study.sweep.go import SweepProgress, sweep_begun
from study.sweep.plan import load_plan
from study.sweep.records import DayOutcome
from study.sweep.report import write_sweep_report
from study.sweep.store import NotSharedError, check_shared, opened_sweep
from study.sweep.table import days_csv, effects, point_rows, summary_of
from study.sweep.worker import Task, run_task
from study.sweep.worth import worth_looking_at
from tests.study.sweep.conftest import DRAW
from tests.study.sweep.here import OneByOne, swept, table
from tests.study.sweep.planted import control_of


def days(out: Path) -> list[Path]:
    return sorted((out / "days").glob("*.json"))


def test_torn_foreign_and_misnamed_days_are_run_again(sweep_file: Path, out: Path, expected: str) -> None:
    swept(sweep_file, out)
    torn, changed, swapped, other = days(out)[:4]
    torn.write_bytes(torn.read_bytes()[:-40])
    changed.write_bytes(changed.read_bytes().replace(b'"seed":', b'"seed": '))
    swapped.write_bytes(other.read_bytes())
    (out / "days" / "notes.txt").write_text("somebody's", "utf-8")
    (out / "days" / ".left-behind").write_text("{", "utf-8")
    state = swept(sweep_file, out)
    assert {refused.name for refused in state.refused} == {torn.name, changed.name, swapped.name, "notes.txt"}
    assert (state.before, state.run) == (21, 3)
    assert table(sweep_file, out) == expected
    assert not (out / "days" / ".left-behind").exists()
    assert (out / "days" / "notes.txt").exists()


def test_more_days_keep_those_that_are_there(sweep_file: Path, out: Path) -> None:
    swept(sweep_file, out, days=4)
    state = swept(sweep_file, out, days=6)
    assert (state.before, state.run) == (8, 4)
    sweep_file.write_text(sweep_file.read_text("utf-8").replace("0.5", "0.7"), "utf-8")
    state = swept(sweep_file, out, days=6)
    assert (state.before, state.run, state.others) == (6, 6, 6)


def test_what_carried_its_days_is_said_and_not_what_is_asked_for_now(sweep_file: Path, out: Path) -> None:
    assert swept(sweep_file, out, days=2).carriers == "plain"
    text = sweep_file.read_text("utf-8")
    sweep_file.write_text(text.replace("[seeds]", 'carrier = "sumo"\n\n[seeds]', 1), "utf-8")
    assert swept(sweep_file, out, days=2).carriers == "plain"
    more = swept(sweep_file, out, days=3)
    assert summary_of(more, out)["carrier"] == "plain and sumo"
    assert "carried by plain and sumo" in write_sweep_report(more, out).read_text("utf-8")


def test_directory_of_something_else_is_left_alone(sweep_file: Path, tmp_path: Path) -> None:
    plan = load_plan(str(sweep_file))
    work = tmp_path / "work"
    work.mkdir()
    (work / "thesis.txt").write_text("years", "utf-8")
    with (
        pytest.raises(InputError, match="a new directory, or that of the sweep tiny"),
        opened_sweep(plan, work),
    ):
        pass
    assert [path.name for path in work.iterdir()] == ["thesis.txt"]
    sweep_file.write_text(sweep_file.read_text("utf-8").replace('id = "tiny"', 'id = "other"'), "utf-8")
    swept(sweep_file, tmp_path / "out")
    with (
        pytest.raises(InputError, match="it is that of the sweep other"),
        opened_sweep(plan, tmp_path / "out"),
    ):
        pass


def test_one_client_at_a_time(sweep_file: Path, out: Path) -> None:
    plan = load_plan(str(sweep_file))
    with opened_sweep(plan, out), pytest.raises(InputError, match="no other client"), opened_sweep(plan, out):
        pass
    with opened_sweep(plan, out):
        pass


def test_days_of_other_code_count_only_if_asked(
    sweep_file: Path, out: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    swept(sweep_file, out, days=2)
    for module in ("go", "worker", "store"):
        monkeypatch.setattr(f"study.sweep.{module}.code_digest", lambda: "0" * 32)
    with pytest.raises(InputError, match="--anyway"):
        swept(sweep_file, out, days=3)
    plan = load_plan(str(sweep_file), 3)
    with opened_sweep(plan, out) as store:
        assert sweep_begun(plan, store, anyway=True).before == 4


def test_worker_of_another_directory_is_refused(sweep_file: Path, out: Path, tmp_path: Path) -> None:
    plan = load_plan(str(sweep_file))
    with opened_sweep(plan, out) as store:
        check_shared(out, store.token)
        with pytest.raises(NotSharedError, match="has no sweep"):
            check_shared(tmp_path / "elsewhere", store.token)
        copy = shutil.copytree(out, tmp_path / "copy")
        header = json.loads((copy / "sweep.json").read_text("utf-8"))
        (copy / "sweep.json").write_text(json.dumps(header | {"token": "another"}), "utf-8")
        with pytest.raises(NotSharedError, match="another sweep"):
            check_shared(copy, store.token)
        for key, other in (("code", "0" * 32), ("made_with", {"numpy": "0"})):
            (out / "sweep.json").write_text(json.dumps(header | {key: other}), "utf-8")
            with pytest.raises(NotSharedError, match="other code than the client"):
                check_shared(out, store.token)


@pytest.mark.parametrize("drawn", ["", DRAW])
@pytest.mark.parametrize("line", ["[trains]\nload_share_mean = 0.45", "no table"])
def test_a_day_of_files_that_have_changed_is_not_filed(
    sweep_file: Path, out: Path, drawn: str, line: str
) -> None:
    """Its name says what was there as the sweep began; what cannot be read any more is no crash of the day."""
    mine = sweep_file.with_name("mine.toml")
    text = 'extends = "rtri_test_line"\nid = "mine"\nname = "Mine"\n'
    mine.write_text(text, "utf-8")
    sweep_file.write_text(
        sweep_file.read_text("utf-8").replace("rtri_test_line", "mine.toml") + drawn, "utf-8"
    )
    plan = load_plan(str(sweep_file))
    with opened_sweep(plan, out) as store:
        mine.write_text(text + line, "utf-8")
        with pytest.raises(NotSharedError, match="have changed since the sweep began"):
            run_task(Task(str(out), store.token, plan.spec(plan.points[0], 0), 0))
    assert not days(out)


SHOWN = ("study.capacity", "study.report", "study.wording")  # what a day is shown by, and not how it goes


def test_what_decides_a_day_is_all_in_the_digest_of_the_code() -> None:
    """The packages of `study` that those of the digest import, apart from what shows a day."""
    root = Path(study.__file__ or "").parents[1]
    files = [file for name in CODE for file in (root / name).rglob("*.py") or [root / name]]
    used = {
        found for file in files for found in re.findall(r"^from (study[\w.]*)", file.read_text("utf-8"), re.M)
    }
    known = tuple(name.removesuffix(".py").replace("/", ".") for name in CODE)
    beside = ("study.sweep.", *SHOWN)
    assert not {name for name in used if not name.startswith((*known, *beside))}


STOP = """
[stop]
figure = "mean_late_s"
narrower_than = 20.0
least_days = 5
"""


def test_days_that_are_there_are_counted_as_they_come(sweep_file: Path, out: Path, tmp_path: Path) -> None:
    """In any order, with a stop rule and without; the same as by going through all names."""
    sweep_file.write_text(sweep_file.read_text("utf-8").replace("days = 12", "days = 25"), "utf-8")

    def counted(state: SweepProgress) -> None:
        names = [name for course in state.courses for name in course.names[: course.days]]
        assert state.there == sum(name in state.records for name in names)

    swept(sweep_file, out, show=counted)
    sweep_file.write_text(sweep_file.read_text("utf-8") + STOP, "utf-8")
    swept(sweep_file, out, show=counted)
    swept(sweep_file, tmp_path / "backwards", show=counted)


def test_point_ends_where_the_rule_says_in_any_order(sweep_file: Path, out: Path, tmp_path: Path) -> None:
    sweep_file.write_text(sweep_file.read_text("utf-8").replace("days = 12", "days = 25") + STOP, "utf-8")
    one_by_one = swept(sweep_file, out, OneByOne())
    backwards = swept(sweep_file, tmp_path / "backwards")
    assert days_csv(one_by_one) == days_csv(backwards)
    first = one_by_one.plan.points[0]
    count = len(one_by_one.days_counted(first))
    assert 5 <= count < 25
    assert one_by_one.stopped_early(first)
    assert one_by_one.run < backwards.run == 50
    width = one_by_one.estimate("mean_late_s").width
    assert width is not None
    assert width < 20.0
    assert count in (looks := one_by_one.plan.looks)
    assert one_by_one.plan.confidence == pytest.approx(1.0 - 0.05 / len(looks))
    fewer = swept(sweep_file, tmp_path / "fewer", days=count - 1)
    assert not fewer.stopped_early(first)


SECOND = '\n[[axis]]\nname = "dwell"\nkey = "unit.dwell_min_s"\nvalues = [20.0, 30.0]\n'
LATE_S = (10.0, 20.0, 60.0, 70.0, 11.0, 22.0, 63.0, 76.0, 15.0, 25.0, 65.0, 79.0, 18.0, 0.0, 66.0, 81.0)


def test_a_sweep_says_what_its_days_are(sweep_file: Path, out: Path) -> None:
    """Four points of four days, one of which crashed: it is in no mean, and its seed in no effect."""
    sweep_file.write_text(sweep_file.read_text("utf-8") + SECOND, "utf-8")
    state = swept(sweep_file, out, days=4)
    for name, late_s in zip((name for course in state.courses for name in course.names), LATE_S, strict=True):
        day, how = state.records[name], DayOutcome.GOOD if late_s else DayOutcome.CRASHED
        changed = replace(day.figures, mean_late_s=late_s, within=(late_s / 100.0, 1.0, 1.0))
        state.records[name] = replace(day, outcome=how, figures=changed if late_s else None)
    rows = point_rows(state)
    found = [row.figures["mean_late_s"] for row in rows]
    assert [one.mean.value for one in found] == [40.0, 43.0, 46.0, 55.0]
    assert [one.less_first.value for one in found] == pytest.approx([0.0, 3.0, 6.0, (8 + 6 + 11) / 3])
    assert [row.outcomes[DayOutcome.CRASHED].value for row in rows] == [0.0, 0.0, 0.0, 0.25]
    effect = [(one.less_first.days, one.less_first.value) for one in effects(state, "mean_late_s")]
    assert effect == [(3, pytest.approx((6 + 4 + 7) / 3)), (3, pytest.approx((2 + 2 + 4) / 3))]
    page = write_sweep_report(state, out).read_text("utf-8")
    (table,) = (part for part in page.split("<table") if ">median<" in part)
    of = dict(zip(*(re.findall(rf"<{tag}[^>]*>([^<]*)</", table) for tag in ("th", "td")), strict=False))
    assert [of[name] for name in ("days", "mean", "5 %", "95 %")] == ["4", "40.0", "11.5", "68.5"]
    for watched, worst in ("mean_late_s", 3), ("within_60_s", 0):
        state.plan.table.watch[:] = [watched]
        crashed, *shown = worth_looking_at(state, out)
        late = [day.record.figures.mean_late_s for day in shown if day.record.figures]
        assert (crashed.record.spec.seed, late[::2], late[-1]) == (2, list(LATE_S[worst::4]), 66.0)


def test_day_that_sumo_carries_otherwise_fails_the_sweep(sweep_file: Path, out: Path) -> None:
    assert swept(sweep_file, out).failures == ()
    shutil.rmtree(out)
    (control_of(out) / "other-10").touch()
    state = swept(sweep_file, out)
    assert len(state.failures) == 2  # the day is at both points
    assert "is another day on SUMO: another, not digest of 11" in state.failures[0]


def test_a_worker_that_fails_without_a_word_sees_no_directory(monkeypatch: pytest.MonkeyPatch) -> None:
    def fails(out: Path, token: str) -> None:
        raise MemoryError

    monkeypatch.setattr(cluster, "check_shared", fails)
    assert "MemoryError" in cluster.missing_on_worker("out", "token")
