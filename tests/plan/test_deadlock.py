"""Situations of a single line with a loop, by hand, and the published ones: who can leave is known."""

import json
from pathlib import Path
from typing import Any, Final

import pytest
from typer.testing import CliRunner

from branchline.cli import app
from network.errors import InputError
from plan import deadlock
from plan.deadlock import can_all_leave, read_situation
from wayside.certificate import CertificateProof

SHARED: Final = Path(__file__).resolve().parents[2] / "../shared/data/deadlock"
DEAD: Final = {
    *(f"sasso_2021_{k}" for k in (2, 6, 7, 9, 10, 11, 12)),
    "sasso_2023_2022_04_12_09_38_07_364bis",
    "sasso_2023_2022_05_06_14_08_34_033bis",
}
# West, a loop of two tracks, east, each 10 long and 1 more with the points; a letter for each direction.
EASTWARD: Final = {"w": ["1e", "2e"], "1e": ["e"], "2e": ["e"], "e": ["out"]}
WESTWARD: Final = {"E": ["1w", "2w"], "1w": ["W"], "2w": ["W"], "W": ["out"]}
OPPOSED: Final = [("w", "W"), ("1e", "1w"), ("2e", "2w"), ("e", "E")]
# A long train stands over the points behind it: into the loop's other track, and out of it the other way.
POINTS: Final = {"1e": ["2e", "W"], "2e": ["1e", "W"], "1w": ["2w", "e"], "2w": ["1w", "e"]}


def situation(path: Path, *trains: tuple[str, int], **of_first: object) -> Path:
    """A file with trains that stand on a route, so long, each with the ways of its direction."""
    ways = {route: EASTWARD if route in EASTWARD else WESTWARD for route, _ in trains}
    routes = [*EASTWARD, *WESTWARD, "out"]
    excluded = {
        r: [r, *(b for a, b in OPPOSED if a == r), *(a for a, b in OPPOSED if b == r)] for r in routes
    }
    found: dict[str, Any] = {
        "trains": [{"id": f"t{k}", "initial_routes": [route]} for k, (route, _) in enumerate(trains)],
        "routes": [{"id": route} for route in routes],
        "train_routes": [
            {"train": f"t{k}", "route": route, "length": length, "next_routes": then}
            for k, (stands, length) in enumerate(trains)
            for route, then in {**ways[stands], "out": []}.items()
        ],
        "conflicts": [
            {"route": route, "length": length, "conflicts": conflicts}
            for route in routes[:-1]
            for length, conflicts in ((10, excluded[route]), (11, POINTS.get(route, [])))
        ],
    }
    found["trains"][0].update(of_first)
    path.write_text(json.dumps(found))
    return path


def verdict(path: Path) -> CertificateProof:
    return can_all_leave(read_situation(path)).proof


def test_two_trains_take_different_tracks_of_the_loop(tmp_path: Path) -> None:
    found = can_all_leave(read_situation(situation(tmp_path / "s.json", ("w", 5), ("E", 5))))
    assert found.proof is CertificateProof.ORDER
    tracks = {train: route for train, route in found.entered if route[0] in "12"}
    assert {route[0] for route in tracks.values()} == {"1", "2"}


def test_a_third_train_in_the_loop_leaves_it_to_nobody(tmp_path: Path) -> None:
    """On either side one waits to come in, and both tracks are taken by trains that have to go out there."""
    stuck = situation(tmp_path / "s.json", ("w", 5), ("E", 5), ("1e", 5), ("2w", 5))
    assert verdict(stuck) is CertificateProof.NONE
    assert verdict(situation(tmp_path / "t.json", ("w", 5), ("1e", 5), ("2w", 5))) is CertificateProof.ORDER


def test_a_train_longer_than_its_track_bars_the_points(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Two trains face away from each other in the loop; the end of each stands where the other has to go out."""
    assert verdict(situation(tmp_path / "short.json", ("1e", 10), ("2w", 10))) is CertificateProof.ORDER
    assert verdict(situation(tmp_path / "one.json", ("1e", 11), ("2w", 10))) is CertificateProof.ORDER
    both = situation(tmp_path / "both.json", ("1e", 11), ("2w", 11))
    assert verdict(both) is CertificateProof.NONE
    monkeypatch.setattr(deadlock, "POINTS_COUNT", False)
    assert verdict(both) is CertificateProof.ORDER


def test_of_two_on_one_route_the_first_leaves_first(tmp_path: Path) -> None:
    behind = situation(tmp_path / "s.json", ("w", 5), ("w", 5), initial_multitrain_prev_trainid=["t1"])
    entered = can_all_leave(read_situation(behind)).entered
    assert next(train for train, _ in entered) == "t1"


def test_trains_on_routes_that_exclude_each_other_are_lost(tmp_path: Path) -> None:
    assert verdict(situation(tmp_path / "s.json", ("w", 5), ("W", 5))) is CertificateProof.NONE


def test_placeholders_and_unusable_routes_do_not_count(tmp_path: Path) -> None:
    file = situation(tmp_path / "s.json", ("e", 5), ("E", 5), is_dummy=True)
    assert verdict(file) is CertificateProof.ORDER
    found = json.loads(file.read_text())
    found["routes"] = [{**route, "is_unusable": route["id"][0] in "12"} for route in found["routes"]]
    file.write_text(json.dumps(found))
    assert can_all_leave(read_situation(file)).entered == ()


@pytest.mark.parametrize(
    ("key", "change"),
    [
        ("initial_routes", {"initial_routes": []}),
        ("initial_routes", {"initial_routes": ["w", "e"]}),
        ("initial_multitrain_prev_trainid", {"initial_multitrain_prev_trainid": ["t9"]}),
    ],
)
def test_what_contradicts_itself_is_named(tmp_path: Path, key: str, change: dict[str, object]) -> None:
    with pytest.raises(InputError) as refused:
        read_situation(situation(tmp_path / "s.json", ("w", 5), **change))
    assert refused.value.key == f"trains[0].{key}"


def test_routes_in_a_circle_are_refused(tmp_path: Path) -> None:
    file = situation(tmp_path / "s.json", ("w", 5))
    file.write_text(file.read_text().replace('"next_routes": ["out"]', '"next_routes": ["w", "out"]'))
    result = CliRunner().invoke(app, ["best", "deadlock", str(file)])
    assert isinstance(result.exception, InputError) and "circle" in str(result.exception)


def test_the_command_says_who_is_in_whose_way(tmp_path: Path) -> None:
    live = situation(tmp_path / "live.json", ("w", 5))
    dead = situation(tmp_path / "dead.json", ("w", 5), ("W", 5))
    result = CliRunner().invoke(app, ["best", "deadlock", str(live), str(dead)])
    alone = CliRunner().invoke(app, ["best", "deadlock", str(live)])
    assert (alone.exit_code, result.exit_code) == (0, 1)
    first, second = result.output.splitlines()
    assert first.startswith("live.json: live: all trains can leave")
    assert "t0 and t1 are in each other's way" in second


@pytest.mark.skipif(not SHARED.is_dir(), reason="the published instances are not here")
@pytest.mark.parametrize("file", sorted(SHARED.glob("*.json")), ids=lambda file: file.stem)
def test_published_verdicts(file: Path) -> None:
    found = can_all_leave(read_situation(file))
    assert found.proof is (CertificateProof.NONE if file.stem in DEAD else CertificateProof.ORDER)
    assert found.steps < 10_000
