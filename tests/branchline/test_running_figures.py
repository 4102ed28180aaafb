"""The figures that `branchline run` prints are those of the report, in its words, and say what they are of."""

from typing import Any

import polars as pl
import pytest

from branchline.running import _errors, _margin, _net, _off_the_mark  # pyright: ignore[reportPrivateUsage]
from study.report.facts import energy_fact

BY = ("traction", "regenerated", "auxiliary", "net")
ENERGY: dict[str, Any] = {
    "all": dict(zip(BY, (2000.0, 336.3, 700.0, 2363.7), strict=True)),
    "regenerated_to": {},
    "net_kwh_per_train_km": {"trains": 2.88, "all": 3.52},
    "net_kwh_per_car_km": {"trains": 1.44, "all": 1.76},
}


def test_energy_by_distance_is_that_of_the_report() -> None:
    net, distance = _net(ENERGY).split("; ")
    assert net == "2,363.7 kWh"
    assert distance == "2.88 kWh/train-km (1.44 per car-km), 3.52 (1.76) with layovers"
    frame = pl.DataFrame({"regenerated_to": ["other_trains"]})
    assert energy_fact({"energy": ENERGY}, frame).value.en.endswith(f"; {distance}")
    nobody: dict[str, Any] = {"trains": None, "all": None}
    assert _net(ENERGY | {"net_kwh_per_train_km": nobody, "net_kwh_per_car_km": nobody}) == "2,363.7 kWh"


def test_the_smallest_margin_says_what_was_planned_and_what_was_left() -> None:
    planned = {"train": "1", "from_station": "AOK", "to_station": "SAW", "margin_s": 18.2}
    left = {"train": "21", "from_station": "HMN", "to_station": "KTR", "left_s": 5.9, "run_s": 99.0}
    margins = {"smallest_margin_s": planned, "smallest_left_s": left}
    assert _margin(margins) == "planned 18 s (1, AOK to SAW); least left as run 6 s (21, HMN to KTR)"
    assert _margin({**margins, "smallest_left_s": {**left, "run_s": None}}).endswith(
        "KTR), where it did not run"
    )
    assert _margin({"smallest_margin_s": planned}) == "planned 18 s (1, AOK to SAW)"
    assert _margin(None) == "-"


def test_stops_off_their_marks_are_warned_of() -> None:
    at = {"train": "7", "station": "JNY", "error_m": -8.91}
    assert _off_the_mark({"stops": 1370, "stops_off": 22, "stop_off_at": at}) == (
        "warning: 22 of 1370 stops more than 0.35 m off their marks, -8.91 m the worst (7 at JNY)"
    )
    assert _off_the_mark({"stops": 1370, "stops_off": 0, "stop_off_at": None}) is None


@pytest.mark.parametrize(
    ("sigma_m", "says"),
    [
        (0.05, "error mean 0.016 m, sigma 0.050 m, largest 0.211 m"),
        (None, "error mean 0.016 m, largest 0.211 m"),  # of one stop
    ],
)
def test_what_a_single_stop_has_not_is_not_named(sigma_m: float | None, says: str) -> None:
    figures = {"stop_error_m_mean": 0.016, "stop_error_m_sigma": sigma_m, "stop_error_m_max_abs": 0.211}
    assert _errors(figures) == says
