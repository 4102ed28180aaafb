"""What a planner adds to a published day."""

from pathlib import Path

import pytest

from exchange.additions import read_additions, shipped_additions
from network.errors import InputError
from network.files.line_file import load_line
from network.files.shipped import shipped_line
from network.model import Direction
from network.timetable import CallKind

LINE = load_line(shipped_line("karasuyama"))


def additions(tmp_path: Path, calls: str) -> Path:
    path = tmp_path / "more.toml"
    path.write_text(f'[[trains]]\nnumber = "E1"\ndirection = "up"\ncalls = [{calls}]\n', encoding="utf-8")
    return path


def test_the_shipped_empty_working() -> None:
    got = read_additions(shipped_additions("karasuyama"), LINE)
    (train,) = got.trains
    assert (train.number, train.direction, train.revenue, train.to_beyond) == (
        "E346M",
        Direction.UP,
        False,
        True,
    )
    assert train.calls[0].departure_s == 22 * 3600 + 15 * 60
    assert got.stock == ("V1", "V2", "V3", "V4")


def test_passing_and_operational_calls(tmp_path: Path) -> None:
    calls = (
        '{station="KRS", departure="23:50"}, {station="TAK", pass="23:55"},'
        ' {station="OGN", arrival="00:05", departure="00:06", operational=true}, {station="HSK", arrival="00:30"}'
    )
    (train,) = read_additions(additions(tmp_path, calls), LINE).trains
    kinds = [call.kind for call in train.calls]
    assert kinds == [CallKind.STOP, CallKind.PASS, CallKind.OPERATIONAL, CallKind.STOP]
    assert train.calls[-1].arrival_s == 86_400 + 1800


@pytest.mark.parametrize(
    ("calls", "message"),
    [
        (
            '{station="KRX", departure="22:00"}, {station="HSK", arrival="22:30"}',
            r"calls\[0\].station is 'KRX'",
        ),
        ('{station="KRS", departure="22:00"}, {station="HSK"}', r"calls\[1\].departure"),
        (
            '{station="KRS", departure="22:00"}, {station="HSK", arrival="21:00"}',
            "a time not before 22:00:00",
        ),
        ('{station="KRS", departure="22:00"}', "calls"),
    ],
)
def test_faulty_additions_are_named(tmp_path: Path, calls: str, message: str) -> None:
    with pytest.raises(InputError, match=message):
        read_additions(additions(tmp_path, calls), LINE)
