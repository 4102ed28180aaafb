"""The page as a file: 500 trains in a megabyte, nothing asked of any host, no name that becomes markup."""

import json
import re
from base64 import b64decode
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import polars as pl
import pytest

from network.timetable import TimetableTrain
from study.record.parts import PagePart, TextTable
from study.record.tables import ROWS, RunTables
from study.report import report
from study.report.bundle import PREFIX, import_map, modules
from study.report.courses import FINEST_FIRST
from study.report.data import ReportedRun
from study.report.report import BYTES_AIMED, write_report
from tests.study.report.many_trains import busy_day
from tests.study.report.page import payload_of
from tests.study.report.test_face import characters_of

HOSTILE = "</script><img src=x onerror=alert(1)><!-- courses of trains -->"
HOSTILE_TEXTS = (
    HOSTILE,
    "\"'><svg onload=alert(1)>",
    "{{ 7 * 7 }}",
    "/* Japanese characters of this page */",
)


@pytest.mark.nightly
def test_five_hundred_trains_fit_into_a_megabyte(tmp_path: Path) -> None:
    day = busy_day(500)
    assert len(day.courses) == 500
    path = write_report(tmp_path, day.line, day.timetable, day.tables, {})
    assert path.stat().st_size <= BYTES_AIMED
    tolerance = payload_of(path.read_text("utf-8"))["tolerance"]
    assert tolerance["m"] <= FINEST_FIRST[2].place_m


def test_a_small_day_is_drawn_as_fine_as_can_be(tmp_path: Path, weekday: ReportedRun) -> None:
    path = write_report(tmp_path, weekday.line, weekday.timetable, weekday.tables, {})
    assert payload_of(path.read_text("utf-8"))["tolerance"]["m"] == FINEST_FIRST[0].place_m


def test_a_page_that_would_be_too_large_is_drawn_coarser(
    tmp_path: Path, weekday: ReportedRun, monkeypatch: pytest.MonkeyPatch
) -> None:
    fine = write_report(tmp_path / "fine", weekday.line, weekday.timetable, weekday.tables, {})
    aimed = fine.stat().st_size - 1
    monkeypatch.setattr(report, "BYTES_AIMED", aimed)
    path = write_report(tmp_path / "coarse", weekday.line, weekday.timetable, weekday.tables, {})
    assert path.stat().st_size <= aimed
    tolerance = payload_of(path.read_text("utf-8"))["tolerance"]["m"]
    assert tolerance > FINEST_FIRST[0].place_m
    monkeypatch.setattr(report, "BYTES_AIMED", 1_000)  # no page is so small: as coarse as can be, and written
    path = write_report(tmp_path / "least", weekday.line, weekday.timetable, weekday.tables, {})
    assert payload_of(path.read_text("utf-8"))["tolerance"]["m"] == FINEST_FIRST[-1].place_m


def hostile_run(day: ReportedRun) -> ReportedRun:
    """A run in which whoever writes the files names everything as badly as they can."""
    line = day.line
    stations = {
        key: replace(station, name=HOSTILE_TEXTS[i % 4], name_ja=HOSTILE_TEXTS[(i + 1) % 4])
        for i, (key, station) in enumerate(line.stations.items())
    }
    (number, train) = next(iter(day.timetable.trains.items()))
    trains: dict[str, TimetableTrain] = {**day.timetable.trains}
    del trains[number]
    trains[HOSTILE] = replace(train, number=HOSTILE)
    named = pl.when(pl.col("train") == number).then(pl.lit(HOSTILE)).otherwise(pl.col("train")).alias("train")
    frames = {name: getattr(day.tables, name) for name in ROWS}
    tables = {
        key: frame.with_columns(named) if "train" in frame.columns else frame for key, frame in frames.items()
    }
    tables["events"] = tables["events"].with_columns(pl.lit(HOSTILE).alias("text"))
    return ReportedRun(
        replace(line, name=HOSTILE, name_ja=HOSTILE, stations=stations, assumed=HOSTILE_TEXTS),
        replace(day.timetable, head=day.timetable.head.model_copy(update={"name": HOSTILE}), trains=trains),
        RunTables(**tables),
    )


def test_no_name_becomes_markup(tmp_path: Path, make_day: Callable[[str, str], ReportedRun]) -> None:
    day = make_day("rtri_test_line", "rtri_crossing")
    plain = write_report(tmp_path / "plain", day.line, day.timetable, day.tables, {}).read_text("utf-8")
    run = hostile_run(day)
    facts = {
        "scenario": HOSTILE,
        "broken": [HOSTILE],
        "violations": [HOSTILE],
        "parties": [HOSTILE],
        "seed": HOSTILE,
    }
    part = PagePart(HOSTILE, HOSTILE, grids=(TextTable((HOSTILE,), ((HOSTILE,),)),), notes=(HOSTILE,))
    page = write_report(tmp_path, run.line, run.timetable, run.tables, facts, first=(part,)).read_text(
        "utf-8"
    )
    assert "<img" not in page and "<svg" not in page
    assert page.count("<script") == plain.count("<script") == page.count("</script>")
    assert "{{ 7 * 7 }}" in page
    assert payload_of(page)["courses"]
    assert HOSTILE in {train["number"] for train in payload_of(page)["trains"]}


def test_modules_import_only_each_other_and_are_in_the_map() -> None:
    urls = json.loads(import_map())["imports"]
    assert {name.removeprefix(PREFIX) for name in urls} == set(modules())
    for name, text in modules().items():
        assert set(re.findall(r'\bfrom "(.*?)"', text)) <= {f"./{other}" for other in modules()}
        packed = b64decode(urls[PREFIX + name].partition("base64,")[2]).decode("utf-8")
        assert set(re.findall(r'\bfrom "(.*?)"', packed)) <= set(urls)
        assert packed.count("\n") == text.count("\n")


@pytest.mark.parametrize(
    "word", ["innerHTML", "outerHTML", "insertAdjacentHTML", "document.write", "eval(", "http:", "https:"]
)
def test_modules_make_no_markup_of_text_and_ask_no_host(word: str) -> None:
    assert [name for name, text in modules().items() if word in text] == []


def test_the_font_has_the_characters_of_what_is_packed_and_of_the_words(
    tmp_path: Path, weekday: ReportedRun
) -> None:
    stations = {
        key: replace(s, name_ja="轟鷺") if key == "OGN" else s for key, s in weekday.line.stations.items()
    }
    line = replace(weekday.line, stations=stations)
    page = write_report(tmp_path, line, weekday.timetable, weekday.tables, {}).read_text("utf-8")
    (face,) = re.findall(r"@font-face \{.*?\}", page)
    assert set("轟鷺運転曲線番線時刻表") <= characters_of(face)
