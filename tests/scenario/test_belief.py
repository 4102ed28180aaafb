"""`[belief]`: what units go by is laid beside what is so, and never in its place."""

from pathlib import Path

import numpy as np
import pytest

from network.errors import InputError
from scenario.scenario import load_scenario
from simulation.carriers.plain_track import PlainTrack
from simulation.judge.checkers import Checker
from simulation.setup import STEP_S, Setup
from simulation.world.roster import draw_up
from simulation.world.trains import Trains
from tests.plain import run_on_plain

RELEASED = Checker.RELEASE_BEHIND_REAR.value
BASE = 'extends = "rtri_test_line"\nid = "s"\n'
SLOW = "[belief.line]\nadd = { limits = [ { from_km = 0.0, to_km = 1.41, speed_kmh = 18 } ] }\n"


def setup_of(folder: Path, text: str) -> Setup:
    file = folder / "s.toml"
    file.write_text(BASE + text, "utf-8")
    return load_scenario(str(file)).setup


def placed(setup: Setup) -> Trains:
    lengths_m = {piece.id: round(piece.length_m, 6) for piece in setup.line.pieces.values()}
    trains = Trains(setup, PlainTrack(lengths_m, STEP_S))
    trains.place(0, draw_up(setup.believed_line, setup.timetable, {"K1": 40.0}, 0.0)["K1"][0])
    return trains


def pattern_rows(trains: Trains) -> np.ndarray:
    """The path database that the unit goes by."""
    duty = trains.duties[0]
    assert duty is not None
    return trains.pool.pattern_of(trains.rows_of(0, duty.mission.path))


def test_without_one_units_believe_what_is_so(tmp_path: Path) -> None:
    setup = setup_of(tmp_path, "")
    assert setup.belief is None
    assert setup.believed_line is setup.line
    assert setup.believed_train("K1") is setup.trains["K1"]


def test_a_limit_that_only_units_know_is_in_their_patterns_and_nowhere_else(tmp_path: Path) -> None:
    setup = setup_of(tmp_path, SLOW)
    assert all(not alignment.limits for alignment in setup.line.alignments.values())
    trains = placed(setup)
    assert pattern_rows(trains)["permitted_mps"].max() <= 5.0
    assert trains.pool.profile["limit_mps"].min() > 5.0
    assert pattern_rows(placed(setup_of(tmp_path, "")))["permitted_mps"].max() > 5.0


def test_who_is_longer_than_its_unit_believes_is_judged_as_it_is(tmp_path: Path) -> None:
    """Its 40 m are still on the points when the unit has 1.2 m of it beyond them, and gives them back."""
    text = '[operation]\nrelease = "section"\n[belief.trains]\nK1 = "oda_scale_car"\n'
    (tmp_path / "s.toml").write_text(BASE + text, "utf-8")
    run = run_on_plain(tmp_path / "s.toml")
    broken = {violation.subject for violation in run.result.violations if violation.checker == RELEASED}
    assert broken >= {"5 K1"}


def test_a_tag_lies_where_it_is_and_is_expected_where_it_is_believed(tmp_path: Path) -> None:
    setup = setup_of(tmp_path, '[belief.line]\nset = { "tags.1.km" = 0.05 }\n')
    real, believed = setup.line.tags[1], setup.believed_line.tags[1]
    assert believed.position_m == pytest.approx(50.0)
    assert real.position_m == pytest.approx(60.0)
    assert setup.believed_line.pieces == setup.line.pieces


def test_a_unit_may_be_wrong_about_its_train(tmp_path: Path) -> None:
    """It goes by the BR 642's masses and brakes; the body is still the EV-E301 of the scenario."""
    setup = setup_of(tmp_path, '[belief.trains]\nK1 = "br642"\n')
    trains = placed(setup)
    assert trains.kinds[0].mass_empty_kg != trains.bodies[0].mass_empty_kg
    assert trains.bodies[0].mass_empty_kg == setup.trains["K1"].row["mass_empty_kg"][0]
    assert np.array_equal(trains.stock["board"]["kind"][0], setup.believed_train("K1").row[0])


@pytest.mark.parametrize(
    ("text", "key"),
    [
        ('[belief.line]\nset = { "tags.999.km" = 0.05 }\n', "belief.line.set"),
        ('[belief.line]\nremove_tracks = ["4"]\n', "belief.line"),
        ('[belief.trains]\nK9 = "br642"\n', "belief.trains.K9"),
        ('[belief.trains]\nK1 = "br6420"\n', "belief.trains.K1"),
        ("[belief]\ntrains = 3\n", "belief.trains"),
        ("[belief]\ntag = 3\n", "belief.tag"),
    ],
)
def test_what_cannot_be_believed_is_refused_by_its_key(tmp_path: Path, text: str, key: str) -> None:
    with pytest.raises(InputError) as refused:
        setup_of(tmp_path, text)
    assert refused.value.key.startswith(key)
    assert refused.value.file.endswith("s.toml")
