"""`branchline best`: what it prints, writes and refuses."""

import json
import re
from collections.abc import Callable
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

from branchline.best_interval import _rows as interval_rows  # pyright: ignore[reportPrivateUsage]
from branchline.best_robust import _rows as robust_rows  # pyright: ignore[reportPrivateUsage]

WEEKDAY = "karasuyama_weekday"


def test_a_proof_is_recounted_and_one_with_a_number_changed_refused(
    main: Callable[..., Any], tmp_path: Path
) -> None:
    found = main("best", "interval", WEEKDAY, "--proof", "proof.json", "--json")
    assert found.code == 0, found.err
    least_s = found.figures()["interval_s"]
    assert found.figures()["excluded_s"] == [[0, least_s - 1]]
    assert main("best", "interval", WEEKDAY, "--check", "proof.json").code == 0
    told = main("best", "interval", WEEKDAY).out
    an_hour = f"{3600 / least_s:.2f} trains an hour each way"
    assert f"least interval {least_s} s ({least_s / 60:.1f} min), {an_hour}\n" in told
    assert re.search(r"^waits: \d+ s of all trains together, least that it can be$", told, re.MULTILINE)
    text = (tmp_path / "proof.json").read_text("utf-8")
    (tmp_path / "proof.json").write_text(text.replace(str(least_s - 1), str(least_s)), "utf-8")
    refused = main("best", "interval", WEEKDAY, "--check", "proof.json")
    assert (refused.code, str(least_s) in refused.out) == (1, True)
    assert main("best", "interval", WEEKDAY, "--set-late", "--check", "proof.json").code == 1
    (tmp_path / "proof.json").write_text(json.dumps(json.loads(text) | {"excluded": []}), "utf-8")
    nothing = main("best", "interval", WEEKDAY, "--check", "proof.json")
    assert (nothing.code, nothing.out) == (1, "it excludes no interval\n")


def test_two_trains_each_way_are_twice_as_many_and_waits_that_are_not_proven_are_told() -> None:
    pattern, proof = SimpleNamespace(trains_each_way=2), SimpleNamespace(excluded=())
    found: Any = SimpleNamespace(
        interval_s=1800, each_s=900.0, waits_s=60.0, least_waits=False, in_tenths_s=1799.5, circle=None,
        pattern=pattern, proof=proof, circles=list[object],
    )  # fmt: skip
    first, waits = interval_rows(found)[:2]
    assert first.endswith("1800 s (30.0 min), 4.00 trains an hour each way")
    assert waits == "waits: 60 s of all trains together, perhaps more than it need be"


def test_delays_on_fresh_days_stand_beside_those_trained_on() -> None:
    day: Any = SimpleNamespace(times={}, trained_s=12.0, fresh_s=34.0)
    found: Any = SimpleNamespace(
        training_seeds=(1, 2, 3), fresh_seeds=(4, 5), bound_s=9.0, problem=SimpleNamespace(trains={}),
        as_it_is=day, placed=day,
    )  # fmt: skip
    line: Any = None
    heads, row, _ = robust_rows(line, found, {"as it is": day})
    assert heads.split()[8:] == ["3", "days", "trained", "on", "2", "fresh", "days"]
    assert row.split() == ["as", "it", "is", "12.00", "s", "34.00", "s"]


def test_the_answer_is_a_scenario(main: Callable[..., Any]) -> None:
    assert main("best", "loops", WEEKDAY, "--at", "NIT", "--out", "loop.toml").code == 0
    checked = main("check", "loop.toml")
    assert checked.code == 0, checked.out
    two = main("best", "trains", WEEKDAY, "--every", "90", "--out", "two.toml")
    many, longest = two.out.splitlines()[:2]
    assert (two.code, many) == (0, "2 trains each way every 90 min: as many as can be")
    assert re.fullmatch(r"a train each way has HSK.1 for .* s of 5400 s", longest)
    assert main("check", "two.toml").code == 0


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (("interval", "rtri_test_line"), "from one end to the other"),
        (("interval", WEEKDAY, "--out", f"{WEEKDAY}.toml"), "another name"),
        (("interval", "mine.toml", "--out", "mine.toml"), "another name"),
        (("interval", WEEKDAY, "--out", "mine.toml"), "exists already"),
        (("loops", WEEKDAY, "--out", "day.toml"), "exists already"),
        (("trains", WEEKDAY, "--out", "day.json"), "NAME.toml"),
        (("loops", WEEKDAY, "--at", "OGN"), "a halt"),
        (("trains", "rtri_test_line"), "from one end to the other"),
        (("robust", WEEKDAY), "[late]"),
        (("roster", "isumi_weekday", "--turn", "3600"), "turn back"),
        (("equipment", WEEKDAY, "--cost", "loop"), "loop=100"),
        (("equipment", WEEKDAY, "--without", "lop"), "loop"),
    ],
)
def test_what_cannot_be_asked_is_said(
    main: Callable[..., Any], tmp_path: Path, words: tuple[str, ...], said: str
) -> None:
    """Nothing that stands already is written over: `mine` and the timetable that would lie beside `day`."""
    mine = f'extends = "{WEEKDAY}"\nid = "mine"\nname = "mine"\n'
    for name in ("mine.toml", "day_times.toml"):
        (tmp_path / name).write_text(mine, "utf-8")
    ended = main("best", *words)
    assert ended.code == 2
    assert said in ended.err
    assert {path.read_text("utf-8") for path in tmp_path.glob("*.*")} == {mine}


def test_a_roster_is_written_recounted_and_refused_with_a_number_changed(
    main: Callable[..., Any], tmp_path: Path
) -> None:
    found = main("best", "roster", WEEKDAY, "--out", "three.toml", "--proof", "why.json", "--json")
    assert found.code == 0, found.err
    assert (found.figures()["today"], found.figures()["least"]) == (4, 3)
    assert main("check", "three.toml").code == 0
    assert main("best", "roster", WEEKDAY, "--check", "why.json").code == 0
    text = (tmp_path / "why.json").read_text("utf-8")
    (tmp_path / "why.json").write_text(text.replace('"sets": 3', '"sets": 4'), "utf-8")
    assert main("best", "roster", WEEKDAY, "--check", "why.json").code == 1


def test_equipment_for_so_many_trains_is_a_scenario_with_a_proof(main: Callable[..., Any]) -> None:
    left_out = ("--without", "limits", "--without", "blocks", "--without", "quick_radio")
    words = ("best", "equipment", WEEKDAY, "--trains", "2.5", *left_out)
    found = main(*words, "--out", "loop.toml", "--proof", "why.json")
    assert found.code == 0, found.err
    assert "2.5 trains an hour each way, evenly spaced, cost 100: a loop at Niita; every 1287 s" in found.out
    assert main("check", "loop.toml").code == 0
    assert main(*words, "--check", "why.json").code == 0


@pytest.mark.nightly
def test_no_equipment_is_enough_for_too_many_trains(main: Callable[..., Any]) -> None:
    words = ("best", "equipment", WEEKDAY, "--trains", "9", "--loops", "0", "--without", "limits")
    assert main(*words).code == 1


def test_reserves_are_placed_as_a_scenario_and_a_sweep_of_fresh_days(main: Callable[..., Any]) -> None:
    found = main(
        "best", "robust", "karasuyama_late", "--days", "3", "--fresh", "4", "--out", "placed.toml", "--json"
    )
    assert found.code == 0, found.err
    trained_s = {name: mean_s["trained"] for name, mean_s in found.figures()["mean_delay_s"].items()}
    assert trained_s["placed"] <= min(trained_s["as it is"], trained_s["spread evenly"])
    assert main("check", "placed.toml").code == 0
    assert main("sweep", "placed_days.toml", "--check").code == 0


@pytest.mark.nightly
def test_a_line_with_eight_loops_has_its_bound(main: Callable[..., Any], tmp_path: Path) -> None:
    """Ten stations 2 km apart: 12 trains an hour each way are excluded, 12 in both ways fit, and the answer runs."""
    rows = ["id,name,km,tracks", *(f"S{i},Station {i},{2 * i},{2 if 0 < i < 9 else 1}" for i in range(10))]
    (tmp_path / "eight.csv").write_text("\n".join(rows) + "\n", "utf-8")
    assert main("new", "line", "eight.csv", "eight.toml", "--scenario", "day.toml").code == 0
    found = main("best", "interval", "day.toml", "--out", "least.toml", "--proof", "why.json", "--json")
    assert found.code == 0, found.err
    ((from_s, to_s),) = found.figures()["excluded_s"]
    assert from_s <= 1
    assert to_s >= 3600 // 12
    assert to_s + 1 == found.figures()["interval_s"] <= 3600 // 6
    assert main("best", "interval", "day.toml", "--check", "why.json").code == 0
    assert main("check", "least.toml").code == 0


def test_sets_turn_on_two_tracks_by_turns_where_that_is_quicker(
    main: Callable[..., Any], tmp_path: Path
) -> None:
    """Four kilometres of single track between two ends, the whole line one leg: turning is what takes time."""
    interval_s: dict[int, float] = {}
    for tracks in (1, 2):
        (tmp_path / "hill.csv").write_text(
            f"name,id,km,tracks\nAsa,ASA,0,{tracks}\nBato,BAT,4,{tracks}\n", "utf-8"
        )
        assert main("new", "line", "hill.csv", "hill.toml", "--scenario", "day.toml").code == 0
        found = main("best", "interval", "day.toml", "--out", "least.toml", "--proof", "why.json", "--json")
        assert found.code == 0, found.err
        figures = found.figures()
        assert figures["trains_each_way"] == tracks
        interval_s[tracks] = figures["interval_s"] / tracks
        assert main("best", "interval", "day.toml", "--check", "why.json").code == 0
        assert main("check", "least.toml").code == 0
        every = ("best", "trains", "day.toml", "--every", "60", "--json")
        most = main(*every).figures()
        assert most["trains"] <= most["at_most"] <= 3600 // most["held_s"]
        assert interval_s[tracks] * most["trains"] <= 3600 < interval_s[tracks] * (most["trains"] + 2)
        for path in tmp_path.iterdir():
            path.unlink()
    # Four kilometres at 85 km/h take 169 s, and no two trains are on them; with one track at either end there is room
    # for one set alone, and nobody runs while it turns.
    assert 2 * 169 < interval_s[2] < interval_s[1]


def test_nothing_is_proven_of_loops_where_no_train_runs_from_end_to_end(main: Callable[..., Any]) -> None:
    ended = main("best", "loops", "rtri_test_line")
    assert ended.code == 1
    assert "from one end to the other" in ended.out and "proven" not in ended.out


def test_a_search_says_what_it_looks_for(main: Callable[..., Any], monkeypatch: pytest.MonkeyPatch) -> None:
    """The first is Hoshakuji's track by its time; that many fit. Were a third in doubt, it would say so."""
    monkeypatch.setattr("branchline.progress.SILENT_S", 0.05)
    asked = ("best", "trains", WEEKDAY, "--every", "120")
    told = main(*asked).err
    assert re.search(r"^best trains: \d+ s so far, 3 trains each way of at most 3$", told, re.MULTILINE)
    figures = {"trains": 2, "at_most": 3, "undecided": [3], "work": 8.0, "held_s": 2200.0}
    found = SimpleNamespace(**figures, section_id="HSK.1", waits=None)
    monkeypatch.setattr("plan.most_trains.most_trains", lambda *_: found)
    assert main(*asked, "--json").figures().items() >= figures.items()
    told = main(*asked).out
    assert "2 trains each way every 120 min: no more than 3 can be\n" in told
    assert "neither found nor excluded: 3 (work 8.00; more of it by --work)\n" in told
