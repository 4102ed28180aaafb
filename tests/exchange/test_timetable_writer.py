"""What is written is read back the same, whatever it holds."""

import string

import pytest
from hypothesis import given
from hypothesis import strategies as st

from exchange.planned import TrainOnLine, Workings
from exchange.timetable_writer import file_of_timetable, file_of_trains, timetable_toml
from network.errors import InputError
from network.files.line_file import load_line
from network.files.shipped import shipped_line, shipped_names, shipped_timetable
from network.files.timetable_schema import CallTable, DiagramTable, HeadTable, TimetableFile, TrainTable
from network.files.toml_input import parse_toml, read_text
from network.model import Direction
from network.timetable import Call, parse_timetable, time_text, timetable_of

LINES = {name: load_line(shipped_line(name)) for name in shipped_names("lines")}

identifiers = st.text(string.ascii_letters + string.digits, min_size=1, max_size=8).map(
    lambda text: f"x{text}"
)
UNSEEN = ("Cs", "Cc", "Cf", "Zl", "Zp")  # what no title has, by Unicode's category
any_text = st.text(st.characters(exclude_categories=UNSEEN, include_characters="\u200c\u200d"), max_size=30)
raw_text = st.text(st.characters(exclude_categories=("Cs",)) | st.sampled_from('\x7f\x00\r"'), max_size=12)
prose = st.text(st.characters(exclude_categories=UNSEEN, include_characters="\n\t"), max_size=30)
times = st.integers(0, 30 * 3600 - 1).map(time_text)
calls = st.builds(
    CallTable.model_construct,
    station=raw_text,
    track=st.none() | raw_text,
    arrival=st.none() | times,
    departure=st.none() | times,
    passes=st.none() | times,
    operational=st.booleans(),
    inferred=st.booleans(),
)
trains = st.builds(
    TrainTable.model_construct,
    number=identifiers,
    direction=st.sampled_from(["down", "up"]),
    revenue=st.booleans(),
    calls=st.lists(calls, min_size=1, max_size=4),
    begins=raw_text,
    ends=raw_text,
)
heads = st.builds(
    HeadTable.model_construct,
    id=identifiers,
    name=any_text,
    line=any_text,
    dwell_min_s=st.floats(0, 3600) | st.integers(0, 3600).map(float),
    sources=st.lists(prose, max_size=3),
    assumed=st.lists(prose, max_size=3),
)
files = st.builds(
    TimetableFile.model_construct,
    timetable=heads,
    trains=st.lists(trains, min_size=1, max_size=3),
    diagrams=st.lists(
        st.builds(
            DiagramTable.model_construct, stock=identifiers, trains=st.lists(any_text, min_size=1, max_size=3)
        ),
        max_size=2,
    ),
)


@given(files)
def test_a_file_of_any_content_is_read_back_the_same(file: TimetableFile) -> None:
    assert parse_toml(timetable_toml(file), "written", TimetableFile) == file


def test_more_trains_than_a_file_may_have_are_one_message() -> None:
    numbers = [f"{i}" for i in range(2001)]
    calls = (Call("HSK", None, None, 0), Call("KRS", None, 3600, None))
    trains = [TrainOnLine(number, Direction.DOWN, calls) for number in numbers]
    stabled = dict.fromkeys(numbers, "stabled")
    with pytest.raises(InputError, match=r"^many: trains; expected at most 2000 entries, not 2001$"):
        file_of_trains(HeadTable(id="many", line="karasuyama"), trains, Workings(stabled, stabled, ()), ())


@given(st.integers(0, 30 * 3600 - 1))
def test_times_are_read_back_the_same(time_s: int) -> None:
    from network.timetable import seconds_of

    assert seconds_of("file", "key", time_text(time_s), None) == time_s


@pytest.mark.parametrize("name", shipped_names("timetables"))
def test_shipped_timetables_are_written_and_read_back_the_same(name: str) -> None:
    path = shipped_timetable(name)
    text = read_text(path)
    tables = parse_toml(text, str(path), TimetableFile)
    line = LINES[tables.timetable.line]
    timetable = parse_timetable(text, str(path), line)
    written = timetable_toml(file_of_timetable(timetable))
    assert parse_timetable(written, "written", line) == timetable
    assert (
        timetable_of(parse_toml(timetable_toml(tables), "written", TimetableFile), "written", line)
        == timetable
    )


@pytest.mark.parametrize("name", ["karasuyama_weekday", "karasuyama_holiday"])
def test_files_look_as_those_that_were_written_before(name: str) -> None:
    path = shipped_timetable(name)
    text = read_text(path)
    assert timetable_toml(parse_toml(text, str(path), TimetableFile)) == text


def test_an_hour_past_the_last_that_files_write_is_that_of_the_day_after() -> None:
    assert [time_text(s) for s in (0, 59, 107_999, 108_000)] == ["00:00", "00:00:59", "29:59:59", "06:00"]
