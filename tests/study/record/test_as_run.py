"""The day as it was run: true times in whole seconds, and only as far as trains came."""

from dataclasses import replace

from exchange.oudia.nodes import parse_oudia
from exchange.oudia.route import route_of
from exchange.oudia.writer import AS_RUN, oudia_of
from network.files.line_file import load_line
from network.files.shipped import shipped_line, shipped_timetable
from network.timetable import CallKind, Stabled, load_timetable
from study.record.as_run import trains_as_run
from study.record.tables import make_table

LINE = load_line(shipped_line("karasuyama"))
PLAN = load_timetable(shipped_timetable("karasuyama_weekday"), LINE)


def _stops(*rows: tuple[str, str, str, float | None, float | None]) -> object:
    columns: dict[str, list[object]] = {name: [] for name in make_table("stops").columns}
    for number, station, kind, arrival_s, departure_s in rows:
        row = {
            "unit": "V1",
            "train": number,
            "revenue": True,
            "station": station,
            "track": "1",
            "kind": kind,
            "arrival_s": arrival_s,
            "departure_s": departure_s,
        }
        for name, column in columns.items():
            column.append(row.get(name))
    return make_table("stops", columns)


def test_trains_have_their_true_times_as_far_as_they_came() -> None:
    table = _stops(
        ("321M", "HSK", "stop", None, 20_221.4),
        ("321M", "SHN", "pass", None, 20_500.6),
        ("321M", "OGN", "operational", 21_400.2, None),
        ("321M", "KRS", "stop", None, None),
        ("322M", "KRS", "stop", None, None),
    )
    (train,) = trains_as_run(PLAN, table)  # type: ignore[arg-type]
    assert train.number == "321M"
    assert [(call.station_id, call.arrival_s, call.departure_s) for call in train.calls] == [
        ("HSK", None, 20_221),
        ("SHN", None, 20_501),
        ("OGN", 21_400, None),
    ]
    assert [call.kind for call in train.calls] == [CallKind.STOP, CallKind.PASS, CallKind.OPERATIONAL]
    assert (train.begins, train.ends) == (PLAN.trains["321M"].begins, Stabled())


def test_the_day_as_run_is_a_dia_beside_the_plan() -> None:
    late = [
        replace(
            train,
            calls=tuple(
                replace(
                    call,
                    arrival_s=None if call.arrival_s is None else call.arrival_s + 7,
                    departure_s=None if call.departure_s is None else call.departure_s + 7,
                )
                for call in train.calls
            ),
        )
        for train in PLAN.trains.values()
    ]
    data = oudia_of(LINE, PLAN, late).encoded()
    route = route_of(parse_oudia(data, "day.oud2"), "day.oud2")
    plan, run = route.dia(PLAN.head.name), route.dia(AS_RUN)
    assert [train.number for train in plan.trains] == [train.number for train in run.trains]
    for planned, ran in zip(plan.trains, run.trains, strict=True):
        for ours, true in zip(planned.cells, ran.cells, strict=True):
            assert (ours.how, ours.track) == (true.how, true.track)
            assert true.departure_s == (None if ours.departure_s is None else ours.departure_s + 7)
        assert ran.kind.endswith("（実績）")
