"""The worked studies: files that are read, figures of theory that are those of the pages, and a cheap cut cable."""

import re
from pathlib import Path

import pytest

from documents import second_loop, studies
from documents.accidents import ACCIDENTS
from network.clock import clock
from scenario.scenario import load_scenario
from simulation.settings import Interlocking
from study.drilling.drill import find_drill
from study.sweep.plan import load_plan
from tests.plain import run_on_plain
from vehicle.train_file import load_train, shipped_train

FILES = sorted(studies.FOLDER.glob("*/*.toml"))
SWEEPS = [file for file in FILES if file.stem.endswith("_sweep")]
SCENARIOS = [file for file in FILES if file not in SWEEPS and not file.stem.endswith("_times")]
PAGES = {page.name: page.read_text("utf-8") for page in sorted(studies.FOLDER.glob("*.md"))}


@pytest.mark.parametrize("file", SCENARIOS, ids=lambda file: file.stem)
def test_a_scenario_of_a_study_is_read(file: Path) -> None:
    assert load_scenario(str(file)).id == file.stem


@pytest.mark.parametrize("file", SWEEPS, ids=lambda file: file.stem)
def test_a_sweep_of_a_study_is_read(file: Path) -> None:
    assert load_plan(str(file)).table.id == file.stem


def test_every_file_and_picture_is_named_and_there() -> None:
    named = {link for text in PAGES.values() for link in re.findall(r"\]\(([\w./-]+)\)", text)}
    assert {str(file.relative_to(studies.FOLDER)) for file in (*SCENARIOS, *SWEEPS)} <= named
    for link in named:
        assert (studies.FOLDER / link).exists(), link


def test_every_block_is_in_one_page_and_filled() -> None:
    blocks = [studies.blocks_in(text) for text in PAGES.values()]
    made = (*studies.THEORY, *studies.OF_RUNS, "left-out")  # the last one by documents.steps_left_out
    made += tuple(f"{accident.key}-{table}" for accident in ACCIDENTS for table in ("ways", "sensitivity"))
    assert sorted(name for found in blocks for name in found) == sorted(made)
    assert all(text.startswith("| ") for found in blocks for text in found.values())


def block(name: str) -> str:
    return next(found[name] for text in PAGES.values() if name in (found := studies.blocks_in(text)))


def test_a_block_is_written_where_it_belongs() -> None:
    text = "a\n<!-- made: x -->\nold\n<!-- /made -->\nb\n<!-- made: y -->\nstays\n<!-- /made -->\n"
    assert studies.blocks_in(studies.with_blocks(text, {"x": "new\n"})) == {"x": "new\n", "y": "stays\n"}


def test_the_intervals_of_the_page_are_those_that_work() -> None:
    """As it is, and with the two loops that are run; the others at night."""
    rows = list(studies.choices(second_loop.CHOICES[:3]))
    assert block("choices").splitlines()[: len(rows)] == rows


def test_the_timetables_are_those_of_the_page() -> None:
    for name, _, _ in second_loop.CASES:
        setup = load_scenario(studies.scenario_of(f"second_loop/{name}")).setup
        first = [t.calls[0].departure_s for t in setup.timetable.trains.values() if t.direction > 0]
        every_min = (first[1] - first[0]) // 60  # type: ignore[operator]
        assert clock(first[0] or 0) == "06:00:00"
        assert f"{every_min} min" in block("choices")


def test_a_minute_less_is_too_little() -> None:
    """The rule that decides: where a stretch is taken for longer than the interval no timetable is made."""
    legs = second_loop.legs_of(second_loop.line_with("NIT"), load_train(shipped_train(second_loop.TRAIN)))
    assert second_loop.is_possible(second_loop.even_timetable(legs, 26 * 60), hours=2)
    with pytest.raises(ValueError, match="OGN - KRS is taken for 1530 s"):
        second_loop.even_timetable(legs, 25 * 60)


@pytest.mark.nightly
def test_headways_are_those_of_the_page() -> None:
    assert studies.block_text(studies.headways()) == block("headways")


def test_a_cut_cable_stops_a_centre_and_nothing_on_board() -> None:
    """The paper's line in place of a day: the drills of the page, with its measures."""
    found: dict[Interlocking, tuple[int, float]] = {}
    for name in ("80_cable_cut_central", "80b_cable_cut_on_board"):
        scenario = load_scenario(find_drill(f"rtri/{name}"))
        stops = run_on_plain(scenario).tables.stops
        arrived = studies.arrived_within(stops, 36_001.0, 36_301.0)
        found[scenario.setup.operation.interlocking] = (
            arrived,
            studies.lost_min(stops, scenario.setup.timetable),
        )
    assert found[Interlocking.CENTRAL][0] == 0
    assert found[Interlocking.ONBOARD][0] == 1
    assert found[Interlocking.CENTRAL][1] > found[Interlocking.ONBOARD][1] + 2.0


@pytest.mark.nightly
@pytest.mark.timeout(3600)
def test_all_figures_are_those_of_the_pages(tmp_path: Path) -> None:
    runs = studies.StudyRuns(tmp_path)
    made = {name: studies.block_text(rows()) for name, rows in studies.THEORY.items()}
    made |= {name: studies.block_text(rows(runs)) for name, rows in studies.OF_RUNS.items()}
    for name, text in made.items():
        assert text == block(name), name
