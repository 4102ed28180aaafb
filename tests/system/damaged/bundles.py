"""Whole input of a command, every file of it valid and every table of every schema in it: what is damaged."""

import json
import math
import tomllib
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from datetime import date
from pathlib import Path
from typing import Any, Final

from network.files.line_schema import LineFile
from network.files.shipped import shipped_line, shipped_timetable
from network.files.timetable_schema import TimetableFile
from onboard.driving.laws.settings import LawTables
from onboard.driving.planner.wish import Planning
from onboard.driving.tuning import DEAD_TIMES, OFFSETS
from onboard.driving_settings import Driving
from onboard.unit_records import UnitParameters
from radio.air import AirParameters
from scenario.scenario_file import ScenarioFile
from scenario.sweep_file import SweepFile
from simulation.battery_settings import BatterySettings
from simulation.gnss_settings import Gnss
from simulation.people import People
from simulation.sensor_settings import Beacons, Curvature, Lidar
from simulation.settings import Dispatch, Interlocking, Limits, Operation, Sensors
from vehicle.train_file import TrainFile, shipped_train

Data = dict[str, Any]


@dataclass(frozen=True, slots=True)
class Bundle:
    """Files of a command by name, as data; `out` is what it writes if all is well, `models` what a TOML file is."""

    name: str
    arguments: tuple[str, ...]
    files: Mapping[str, Any]
    models: Mapping[str, type] = field(default_factory=dict[str, type])
    out: str | None = None

    def written(self) -> dict[str, bytes]:
        """Every file as it is written."""
        return {name: text_of(name, data).encode() for name, data in self.files.items()}


def text_of(name: str, data: object) -> str:
    """A file's text: JSON, or TOML with everything in one line a key."""
    if name.endswith(".json"):
        return json.dumps(data, ensure_ascii=False)
    if not isinstance(data, Mapping):
        return f"a = {toml_value(data)}\n"
    return "".join(f"{_key(key)} = {toml_value(value)}\n" for key, value in data.items())


def toml_value(value: object) -> str:
    """A value as TOML writes it."""
    if isinstance(value, Mapping):
        return "{ " + ", ".join(f"{_key(key)} = {toml_value(v)}" for key, v in value.items()) + " }"
    if isinstance(value, list | tuple):
        return "[" + ", ".join(map(toml_value, value)) + "]"
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, float):
        text = repr(value)
        return text if math.isfinite(value) else text.replace("Infinity", "inf")
    if isinstance(value, date):
        return value.isoformat()
    if isinstance(value, int):
        return hex(value) if abs(value) > 10**300 else str(value)
    return json.dumps(value, ensure_ascii=False).replace("\x7f", "\\u007f")


def _key(key: object) -> str:
    text = str(key)
    plain = text.isascii() and text.replace("_", "").replace("-", "").isalnum()
    return text if plain else toml_value(text)


def _toml(path: Path) -> Data:
    return tomllib.loads(path.read_text("utf-8"))


def _line() -> Data:
    data = _toml(shipped_line("rtri_test_line"))
    axis = data["alignments"][0]
    axis["curves"] = [
        {"from_km": 0.55, "to_km": 0.85, "radius_m": 400.0, "transition_m": 40.0, "cant_mm": 60.0}
    ]
    axis["limits"] = [{"from_km": 0.55, "to_km": 0.85, "speed_kmh": 40.0, "directions": ["down"]}]
    data["points"][0]["offset_m"] = 0.0
    next(section for section in data["sections"] if section["kind"] == "between")["virtual_blocks"] = 1
    road = {"lanes": 1, "vehicles_per_h": [60.0], "approach_m": 200.0, "stop_line_m": 4.0, "stall_s": 60.0}
    data["crossings"] = [{"id": "C1", "section": "6", "km": 0.7, "width_m": 6.0, "road": road}]
    data["chargers"] = [
        {
            "station": "B",
            "tracks": ["1"],
            "power_kw": 400.0,
            "voltage_v": 1500.0,
            "current_max_a": 300.0,
            "connect_s": 20.0,
            "disconnect_s": 10.0,
            "origin": "assumed",
        }
    ]
    return data


def _train() -> Data:
    data = _toml(shipped_train("ev_e301_losses"))
    data["traction"] |= {
        "weak_field_speed_kmh": 60.0,
        "notch_speed_cap_kmh": [20.0, 40.0, 60.0, 80.0, 0.0],
        "curve_speed_kmh": [0.0, 50.0, 100.0],
        "curve_force_kn": [48.0, 20.0, 8.0],
    }
    return data


SCRIPT: Final[Data] = {
    "fault": [
        {"kind": "clock", "target": "K1", "start": "10:00", "offset_s": 0.1, "drift_ppm": 1.0, "duration_s": 5.0},
        {"kind": "loss", "target": "K1 <-> block-manager", "start": "10:00", "p": 0.1, "duration_s": 5.0},
        {"kind": "delay", "target": "* <-> *", "start": "10:00:30", "seconds": 0.2, "duration_s": 5.0},
        {"kind": "reorder", "target": "* -> B-W", "start": "10:00", "p": 0.1, "seconds": 0.2, "duration_s": 5.0},
        {"kind": "flip", "target": "* -> B-W", "start": "10:00", "p": 0.1, "duration_s": 5.0},
        {"kind": "duplicate", "target": "* -> B-W", "start": "10:00", "p": 0.1, "duration_s": 5.0},
        {"kind": "slow", "target": "P7", "start": "10:00", "factor": 1.5, "duration_s": 5.0},
        {"kind": "scale", "target": "K1", "start": "09:59", "factor": 1.0, "duration_s": 5.0},
        {"kind": "slippery", "target": "K1", "start": "train T1 departs A", "factor": 0.9, "duration_s": 5.0},
        {"kind": "brake", "target": "K1", "start": "10:00", "reserve": 0.9, "duration_s": 5.0},
        {"kind": "gnss_reflections", "target": "K1", "start": "10:00", "bias_m": 30.0, "over_m": 50.0},
        {"kind": "gnss_time_tag", "target": "K1", "start": "10:00", "late_s": 0.5, "duration_s": 5.0},
        {"kind": "gyro_bias", "target": "K1", "start": "10:00", "jump_degps": 0.1, "duration_s": 5.0},
        {"kind": "gyro_noise", "target": "K1", "start": "10:00", "factor": 2.0, "duration_s": 5.0},
        {"kind": "wrong_id", "target": "603", "start": "09:00", "id": 602, "after_s": 1.0, "duration_s": 5.0},
    ],
    "act": [
        {"kind": "give_back", "target": "K1", "start": "10:10", "hold_s": 5.0, "after_s": 1.0},
        {"kind": "accept_picture", "start": {"who": "K1", "what": "mission_done"}, "pace_s": 1.0},
        {"kind": "drive", "start": {"who": "K1", "what": "mission_done"}, "target": "K1", "notch": 0},
    ],
    "expect": [
        {"text": "it moves", "event": {"who": "K1", "what": "moving"}, "after": "train T1 departs A", "within_s": 60.0},
        {"text": "slow", "property": "speed_at_most", "unit": "K1", "kmh": 80.0, "until": "train T1 arrives B"},
    ],
}  # fmt: skip


def _scenario() -> Data:
    return {
        "id": "damaged",
        "name": "All that a scenario may say",
        "line": "l.toml",
        "timetable": "t.toml",
        "seed": 1,
        "assumed": ["everything"],
        "trains": {
            "default": "v.toml",
            "load_share_mean": 0.2,
            "load_share_spread": 0.1,
            "stock": {"K1": "v.toml"},
        },
        **{
            name: table.model_dump(mode="json")
            for name, table in {
                "air": AirParameters(),
                "unit": UnitParameters(),
                "driving": Driving(),
                "law": LawTables(),
                "planning": Planning(),
                "sensors": Sensors(),
                "gnss": Gnss(),
                "beacons": Beacons(),
                "curvature": Curvature(),
                "lidar": Lidar(),
                "limits": Limits(),
                "operation": Operation(interlocking=Interlocking.CENTRAL, centre="B"),
                "dispatch": Dispatch(),
                "people": People(),
                "battery": BatterySettings(start_of={"K1": 0.9}),
            }.items()
        },
        "tuning": {"days": 1, "learn": True, "learned": "learned.json"},
        "vision": {"stations": ["B"], "rate_hz": 5.0},
        "scatter": {
            "brake_sigma": 0.01,
            "brake_leg_sigma": 0.01,
            "dead_time_spread_s": 0.1,
            "lag_spread_s": 0.1,
            "weather": [{"from": "09:00", "to": "11:00", "adhesion_low": 0.9, "adhesion_high": 1.0}],
            "stock": {
                "K1": {
                    "brake_factor": 1.0,
                    "wheel_factor": 1.0,
                    "dead_time_offset_s": 0.1,
                    "lag_offset_s": 0.1,
                }
            },
        },
        "late": _late(),
        "belief": {"trains": {"K1": "v.toml"}},
        "patch": {
            "line": {
                "set": {"points.P7.throw_time_s": 7.0},
                "times": {"points.P5.throw_time_s": 1.1},
                "remove_tags": {"purpose": "position", "near_marks_m": 20.0},
            },
            "timetable": {
                "scale": [{"from": "09:00", "to": "11:00", "times": 1.1}],
                "like": [{"number": "T9", "train": "T1", "later_s": 7200, "stock": "K9"}],
                "set": {"trains.T9.calls.A.track": "2", "trains.T9.calls.B.track": "2"},
            },
            "train": {"v.toml": {"set": {"mass_empty_t": 78.0}}},
            "law": {"set": {"predictive_fuzzy.estimates": False}},
            "planning": {"set": {"style": "coast"}},
            "battery": {"set": {"departure": "leave"}},
            "late": {"set": {"dwell.people.share": 0.9}},
        },
        **SCRIPT,
    }


def _late() -> Data:
    exponential = {"distribution": "exponential", "mean_s": 60.0, "max_s": 600.0}
    return {
        "entry": {"all": {"portals": [], "share": 0.5, "seconds": exponential, "source": "assumed"}},
        "dwell": {
            "people": {
                "share": 0.9,
                "seconds": {"distribution": "weibull", "mean_s": 10.0, "shape": 1.4},
                "stations": {"B": 1.5},
                "peaks": [{"from": "09:00", "to": "11:00", "times": 2.0}],
                "source": "assumed",
            }
        },
        "doors": {
            "again": {
                "share": 0.1,
                "seconds": {"distribution": "lognormal", "mean_s": 15.0, "sigma": 0.6},
                "source": "assumed",
            }
        },
        "dead_zones": {
            "mast": {
                "per_day": 0.1,
                "length_low_m": 10.0,
                "length_high_m": 100.0,
                "seconds": {"distribution": "uniform", "low_s": 1.0, "high_s": 60.0},
                "source": "assumed",
            }
        },
        "failures": {
            "motors": {
                "kind": "motors",
                "cut_out": 1,
                "mtbf_km": 1e5,
                "seconds": {"distribution": "fixed", "mean_s": 60.0},
                "source": "assumed",
            },
            "unit": {
                "kind": "power_off",
                "targets": ["K1"],
                "mtbf_h": 1e4,
                "seconds": {"distribution": "fixed", "mean_s": 60.0},
                "source": "assumed",
            },
            "points": {
                "kind": "stuck",
                "mtbf_operations": 1e4,
                "seconds": {"distribution": "gamma", "mean_s": 60.0, "shape": 2.0},
                "source": "assumed",
            },
        },
    }


def _learned() -> Data:
    counts = [0] * DEAD_TIMES, [0] * OFFSETS
    counts[0][5] = counts[1][10] = 3
    return {
        "K1": {
            "train_id": "K1",
            "design_dead_time_s": 0.5,
            "dead_time_counts": counts[0],
            "offset_counts": counts[1],
            "left_out": 1,
            "last": [5, 10],
        }
    }


def _polyline() -> Data:
    bend = [[140.0 + 0.0004 * i, 36.7 + 0.00002 * max(0, i - 12) ** 2] for i in range(26)]
    return {"features": [{"geometry": {"type": "LineString", "coordinates": bend}}]}


def _stations() -> Data:
    places = _polyline()["features"][0]["geometry"]["coordinates"]
    rows = [
        {"original_name": f"駅{i}", "lng": places[at][0], "lat": places[at][1]}
        for i, at in enumerate((1, 24))
    ]
    return {"name": "試験線", "station_list": rows}


def _mini_tokyo() -> list[Data]:
    line = "JR-East.Karasuyama."

    def row(number: str, direction: str, ends: Iterable[tuple[str, str, str]], beyond: str) -> Data:
        calls = [{"s": f"{line}{name}", key: time} for name, key, time in ends]
        return {
            "id": f"{line}{number}.Weekday",
            "n": number,
            "d": direction,
            "tt": calls,
            beyond: ["JR-East.Tohoku.X"],
        }

    down = row("1M", "Outbound", (("Hoshakuji", "d", "06:00"), ("Karasuyama", "a", "06:40")), "os")
    up = row("2M", "Inbound", (("Karasuyama", "d", "07:00"), ("Hoshakuji", "a", "07:40")), "ds")
    late = row("3M", "Outbound", (("Hoshakuji", "d", "21:00"), ("Karasuyama", "a", "21:40")), "os")
    return [down, up, late]


SCENARIO: Final = Bundle(
    "scenario",
    ("check", "s.toml", "--json"),
    {
        "s.toml": _scenario(),
        "l.toml": _line(),
        "t.toml": _toml(shipped_timetable("rtri_test_line")),
        "v.toml": _train(),
        "learned.json": _learned(),
    },
    {"s.toml": ScenarioFile, "l.toml": LineFile, "t.toml": TimetableFile, "v.toml": TrainFile},
)
GEOMETRY: Final = Bundle(
    "geometry",
    ("import", "geometry", "polyline.json", "stations.json", "out.toml"),
    {"polyline.json": _polyline(), "stations.json": _stations()},
    out="out.toml",
)
TIMETABLE: Final = Bundle(
    "mini-tokyo",
    ("import", "mini-tokyo", "source.json", "out.toml", "--line", "karasuyama"),
    {"source.json": _mini_tokyo()},
    out="out.toml",
)
SWEEP: Final = Bundle(
    "sweep",
    ("sweep", "w.toml", "--check", "--json"),
    {
        "w.toml": {
            "id": "damaged",
            "name": "All that a sweep may say",
            "scenario": "rtri_test_line",
            "carrier": "plain",
            "assumed": ["everything"],
            "watch": ["mean_late_s"],
            "confidence": 0.9,
            "keep": ["journal"],
            "seeds": {"first": 1, "days": 3},
            "axis": [
                {"name": "radio", "key": "air.delay_mean_s", "values": [0.1, 0.2], "labels": ["a", "b"]},
                {"name": "two", "point": [{"label": "no"}, {"label": "yes", "set": {"timetable": "rtri_two_trains"}}]},
            ],
            "draw": [
                {"name": "stop", "key": "unit.dwell_min_s", "distribution": "uniform", "low": 20.0, "high": 21.0},
                {"name": "kind", "key": "trains.default", "distribution": "choice", "values": ["ev_e301"]}
                | {"weights": [1.0]},
            ],
            "stop": {"figure": "mean_late_s", "narrower_than": 1.0, "least_days": 2},
        }
    },
    {"w.toml": SweepFile},
)  # fmt: skip
RANGED: Final = (SCENARIO, SWEEP)  # between them every kind of figure there is
# A file is taken as often as it says here; the fit of a geometry takes longest.
WEIGHTS: Final = (
    (SCENARIO, "s.toml", 28),
    (SCENARIO, "l.toml", 26),
    (SCENARIO, "t.toml", 12),
    (SCENARIO, "v.toml", 20),
    (SCENARIO, "learned.json", 4),
    (GEOMETRY, "polyline.json", 2),
    (GEOMETRY, "stations.json", 2),
    (TIMETABLE, "source.json", 6),
    (SWEEP, "w.toml", 4),
)
