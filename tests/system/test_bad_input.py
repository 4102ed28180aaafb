"""Bad input through the command: one line that names file, key, value and what was expected; nothing written."""

import re
from collections.abc import Callable, Mapping
from itertools import product
from pathlib import Path
from typing import Any

import pytest

from network.files.shipped import shipped_line, shipped_timetable
from tests.nightly import others_nightly
from vehicle.train_file import shipped_train

LINE = shipped_line("rtri_test_line").read_text("utf-8")
TIMES = shipped_timetable("rtri_test_line").read_text("utf-8")
TRAIN = shipped_train("ev_e301").read_text("utf-8")
BASE = 'extends = "rtri_test_line"\nid = "s"\n'
OWN_TRAIN = BASE + '[trains]\ndefault = "v.toml"'
GRADIENT = "gradients = [{ from_km = 0.0, to_km = 1.41, permille = 0.0 }]"
GAP = (
    "gradients = [{ from_km = 0.0, to_km = 0.5, permille = 0.0 },"
    " { from_km = 0.6, to_km = 1.41, permille = 3.0 }]"
)


def changed(text: str, old: str, new: str) -> str:
    assert old in text
    return text.replace(old, new)


def section(name: str, from_km: float, to_km: float) -> str:
    return f'\n[[sections]]\nid = "{name}"\nkind = "between"\nfrom_km = {from_km}\nto_km = {to_km}\n'


# what is wrong: files, then what the message must hold
CASES: Mapping[str, tuple[dict[str, str], tuple[str, ...]]] = {
    "unknown station in the timetable": (
        {"s.toml": BASE + 'timetable = "t.toml"', "t.toml": changed(TIMES, 'station = "B"', 'station = "Z"')},
        ("t.toml: trains[0].calls[1].station is 'Z'", "A, B"),
    ),
    "overlapping sections": (
        {"s.toml": BASE + 'line = "l.toml"', "l.toml": LINE + section("X", 0.6, 0.7)},
        ("l.toml: sections[13].from_km is 0.6", "0.88, where 6 ends"),
    ),
    "tracks on the same rails": (
        {
            "s.toml": BASE + 'line = "l.toml"',
            "l.toml": changed(LINE, "to_km = 1.05\noffset_m = 4.0", "to_km = 1.05"),
        },
        ("l.toml: sections[", ".from_km is 0.94", "offset_m"),
    ),
    "gap in the gradient table": (
        {"s.toml": BASE + 'line = "l.toml"', "l.toml": changed(LINE, GRADIENT, GAP)},
        ("l.toml: alignments[0].gradients[1].from_km is 0.6", "0.5", "gap"),
    ),
    "tag outside the line": (
        {"s.toml": BASE + 'line = "l.toml"', "l.toml": changed(LINE, "km = 0.535", "km = 9.535")},
        ("l.toml: tags[20].km is 9.535", "0.53 to 0.88"),
    ),
    "train longer than its platform track": (
        {
            "s.toml": BASE + '[trains]\ndefault = "v.toml"',
            "v.toml": changed(TRAIN, "length_m = 40.0", "length_m = 110.0"),
        },
        ("s.toml: train T1 at A track 1", "110.0 m", "at most 75.0 m"),
    ),
    "missing line file": (
        {"s.toml": BASE + 'line = "none.toml"'},
        ("s.toml: line is 'none.toml'", "existing file", "karasuyama"),
    ),
    "unknown line": ({"s.toml": BASE + 'line = "none"'}, ("s.toml: line is 'none'", "rtri_test_line")),
    "missing timetable": (
        {"s.toml": BASE + 'timetable = "none.toml"'},
        ("s.toml: timetable is 'none.toml'", "existing file"),
    ),
    "timetable of another line": (
        {"s.toml": BASE + 'timetable = "karasuyama_weekday"'},
        ("karasuyama_weekday.toml: timetable.line is 'karasuyama'", "rtri_test_line"),
    ),
    "unknown train": (
        {"s.toml": BASE + '[trains.stock]\nK1 = "none"'},
        ("s.toml: trains.stock.K1 is 'none'", "ev_e301"),
    ),
    "unknown stock": ({"s.toml": BASE + '[trains.stock]\nK9 = "ev_e301"'}, ("s.toml: trains.stock.K9", "K1")),
    "TOML syntax error": ({"s.toml": BASE + "seed = = 2"}, ("s.toml", "valid TOML", "line 3, column 8")),
    "syntax error in the line": (
        {"s.toml": BASE + 'line = "l.toml"', "l.toml": LINE + "[[tags"},
        ("l.toml", "valid TOML"),
    ),
    "unknown key": ({"s.toml": BASE + "sed = 2"}, ("s.toml: sed is 2", "no such key")),
    "unknown key of a table": ({"s.toml": BASE + "[air]\nlos = 0.1"}, ("s.toml: air.los is 0.1", "no such key")),
    "unknown parameter": (
        {"s.toml": BASE + "[driving]\nstop_gain = 1.0"},
        ("s.toml: driving.stop_gain is 1.0", "one of", "stop_gain_per_s"),
    ),
    "parameter that cannot be": (
        {"s.toml": BASE + "[driving]\nstop_deceleration_mps2 = 0.0"},
        ("s.toml: driving.stop_deceleration_mps2 is 0.0", "0.01 to 3.5 m/s^2"),
    ),
    "share above 1": (
        {"s.toml": BASE + "[driving]\nservice_guaranteed_share = 1.5"},
        ("s.toml: driving.service_guaranteed_share is 1.5", "0.01 to 1"),
    ),
    "a brake for which the rail has no grip": (
        {"s.toml": BASE + "[driving]\ndesign_adhesion_share = 0.5"},
        ("s.toml: driving.emergency_guaranteed_share is 0.8", "at most 0.64", "design_adhesion_share = 0.5"),
    ),
    "wheels five times too large": (
        {"s.toml": BASE + "[sensors]\nwheel_factor_sigma = 5.0"},
        ("s.toml: sensors.wheel_factor_sigma is 5.0", "0 to 0.1"),
    ),
    "wheels that creep by more than units allow for": (
        {"s.toml": BASE + "[sensors]\ncreep_share = 0.006"},
        ("s.toml: sensors.creep_share is 0.006", "at most 0.005", "unit.wheel_scale_limit"),
    ),
    "an efficiency that no machine has": (
        {"s.toml": OWN_TRAIN,
         "v.toml": changed(TRAIN, "efficiency_traction = 0.85", "efficiency_traction = 1e-9")},
        ("v.toml: energy.efficiency_traction is 1e-09", "0.05 to 1 (efficiency)"),
    ),
    "a train that weighs nothing": (
        {"s.toml": OWN_TRAIN, "v.toml": changed(TRAIN, "mass_empty_t = 77.9", "mass_empty_t = 1e-9")},
        ("v.toml: body.mass_empty_t is 1e-09", "0.05 to 100000 t"),
    ),
    "light for a city": (
        {"s.toml": OWN_TRAIN,
         "v.toml": changed(TRAIN, "auxiliary_power_kw = 30.0", "auxiliary_power_kw = 1e18")},
        ("v.toml: energy.auxiliary_power_kw is 1e+18", "0 to 5000 kW"),
    ),
    "nonsense by a patch": (
        {"s.toml": BASE + '[patch.train.ev_e301]\ntimes = { mass_empty_t = 1e-9 }'},
        ("s.toml: patch.train.ev_e301.times.", "mass_empty_t", "0.05 to 100000 t"),
    ),
    "the emergency brake first": (
        {"s.toml": BASE + "[driving]\nemergency_margin_mps = 0.5"},
        ("s.toml: driving.emergency_margin_mps is 0.5", "at least driving.service_margin_mps = 0.6"),
    ),
    "wrong type": ({"s.toml": BASE + 'seed = "2"'}, ("s.toml: seed is '2'", "integer")),
    "negative seed": ({"s.toml": BASE + "seed = -2"}, ("s.toml: seed is -2", "0")),
    "faster than a step": ({"s.toml": BASE + "[air]\ndelay_min_s = 0.01"}, ("s.toml: air.delay_min_s is 0.01", "0.1")),
    "mean below the least": (
        {"s.toml": BASE + "[air]\ndelay_min_s = 0.5\ndelay_mean_s = 0.2"},
        ("s.toml: air.delay_mean_s is 0.2", "at least 0.5"),
    ),
    "patch of an unknown track": (
        {"s.toml": BASE + '[patch.line]\nremove_tracks = ["Z.2"]'},
        ("s.toml: patch.line.remove_tracks[0] is 'Z.2'", "platform track"),
    ),
    "extends nothing known": ({"s.toml": 'extends = "none"'}, ("s.toml: extends is 'none'", "karasuyama_weekday")),
    "extends itself": ({"s.toml": 'extends = "s"'}, ("s.toml: extends is 's'", "does not extend itself")),
    "extends in a circle": (
        {"s.toml": 'extends = "t"', "t.toml": 'extends = "s"'},
        ("t.toml: extends is 's'", "does not extend itself"),
    ),
    "a time without quotes": (
        {"s.toml": BASE + "[[fault]]\nkind = 'delay'\ntarget = '*'\nseconds = 1\nstart = 06:00:00\nend = '06:01'"},
        ("s.toml: fault[0].start is '06:00:00'", 'expected "06:00:00", in quotes'),
    ),
    "empty": ({"s.toml": ""}, ("s.toml: id", "missing")),
}  # fmt: skip


def check_one_line(ended: Any, parts: tuple[str, ...]) -> None:  # noqa: ANN401
    assert ended.code == 2, ended
    if ended.out:  # with --json the same as an object
        message = ended.err.removeprefix("error: ").removesuffix("\n")
        assert ended.figures() == {"outcome": "bad input", "message": message}
    assert ended.err.startswith("error: ")
    assert ended.err.count("\n") == 1, ended.err
    assert "; expected " in ended.err
    assert not re.search(r"one of one of|None", ended.err)
    for part in parts:
        assert part in ended.err


@pytest.mark.parametrize(
    ("verb", "case"),
    others_nightly(
        product(["run", "check"], CASES),
        {("run", case) for case in CASES} | {("check", min(CASES))},
        columns=True,
    ),
)
def test_one_line_and_nothing_written(main: Callable[..., Any], tmp_path: Path, verb: str, case: str) -> None:
    given, parts = CASES[case]
    for name, text in given.items():
        (tmp_path / name).write_text(text, "utf-8")
    check_one_line(main(verb, "s.toml", "--json"), parts)
    assert {path.name for path in tmp_path.iterdir()} == set(given)


@pytest.mark.parametrize(
    ("arguments", "parts"),
    [
        (("run", "no_such_scenario"), ("no_such_scenario", "karasuyama_weekday, ", "rtri_test_line")),
        (("run", "none.toml"), ("none.toml", "existing file")),
        (("run", "."), (".", "a .toml file or a shipped scenario")),
        (("run", "rtri_test_line", "--link", "radio"), ("--link is 'radio'", "simulated or zenoh")),
        (("run", "rtri_test_line", "--carrier", "rail"), ("--carrier is 'rail'", "sumo or plain")),
        (("reproduce", "no_such_thing"), ("no_such_thing", "sugiyama")),
        (("drill", "no_such_drill"), ("no_such_drill",)),
        (("check", "no_such_scenario"), ("no_such_scenario", "karasuyama_weekday")),
    ],
)
def test_wrong_words_on_the_command_line(
    main: Callable[..., Any], tmp_path: Path, arguments: tuple[str, ...], parts: tuple[str, ...]
) -> None:
    check_one_line(main(*arguments), parts)
    assert list(tmp_path.iterdir()) == []


def test_a_file_that_is_no_text(main: Callable[..., Any], tmp_path: Path) -> None:
    (tmp_path / "s.toml").write_bytes(b"\xff\xfeid")
    check_one_line(main("run", "s.toml"), ("s.toml", "UTF-8"))


@pytest.mark.parametrize("kind", ["somebody's folder", "a file", "below a file"])
def test_a_run_never_replaces_what_is_not_a_run(main: Callable[..., Any], tmp_path: Path, kind: str) -> None:
    out = tmp_path / "precious"
    if kind == "somebody's folder":
        out.mkdir()
        (out / "summary.json").write_text("{}", "utf-8")
        (out / "thesis.tex").write_text("years of work", "utf-8")
    else:
        out.write_text("years of work", "utf-8")
    before = {path: path.read_bytes() for path in tmp_path.rglob("*") if path.is_file()}
    given = out / "run" if kind == "below a file" else out
    check_one_line(main("run", "rtri_test_line", "--out", str(given)), (f"--out is '{given}'", "a run"))
    assert {path: path.read_bytes() for path in tmp_path.rglob("*") if path.is_file()} == before


def test_as_a_process_it_is_the_same_line_without_a_traceback(
    branchline: Callable[..., Any], tmp_path: Path
) -> None:
    check_one_line(branchline("run", "no_such_scenario", "--json", cwd=tmp_path), ("no_such_scenario",))
    assert list(tmp_path.iterdir()) == []
