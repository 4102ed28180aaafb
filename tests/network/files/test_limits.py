"""What grows without bound in a file has an end: lists, routes, a day; and what is too short or too fast is none."""

from typing import Final

import pytest

from network.errors import InputError
from network.files.kinds import ROWS_MAX, TABLES_MAX, TEXTS_MAX
from network.files.line_file import parse_line
from network.files.shipped import shipped_line, shipped_timetable
from network.graph import TRAILS_MAX, routes_from
from network.model import Direction
from network.timetable import LAST_S_MAX, parse_timetable

LINE = shipped_line("rtri_test_line").read_text("utf-8")
TIMES = shipped_timetable("rtri_test_line").read_text("utf-8")


def refused_line(text: str) -> InputError:
    with pytest.raises(InputError) as error:
        parse_line(text, "l.toml")
    return error.value


def refused_times(text: str) -> InputError:
    with pytest.raises(InputError) as error:
        parse_timetable(text, "t.toml", parse_line(LINE, "l.toml"))
    return error.value


def ladder(rungs: int) -> str:
    """Tracks that part and meet again `rungs` times between two portals: two to the power of that many ways."""
    top_km = 0.2 + 0.2 * rungs
    text = f"""
[line]
id = "ladder"
name = "Ladder"
max_speed_kmh = 45
[[alignments]]
id = "main"
from_km = 0.0
to_km = {top_km:.3f}
gradients = [{{ from_km = 0.0, to_km = {top_km:.3f}, permille = 0.0 }}]
[[stations]]
id = "A"
name = "A"
km = 0.05
tracks = [{{ name = "1", section = "T", platform_from_km = 0.02, platform_to_km = 0.08, mark_down_km = 0.07 }}]
[[sections]]
id = "T"
kind = "track"
from_km = 0.0
to_km = 0.1
[[sections]]
id = "PE"
kind = "portal"
from_km = {top_km - 0.1:.3f}
to_km = {top_km:.3f}
"""
    for i in range(rungs):
        low = 0.1 + 0.2 * i
        before = "T" if i == 0 else f"P{i - 1}b.stem"
        after = "PE" if i == rungs - 1 else f"P{i + 1}a.stem"
        for end, section in (("a", f"W{i}"), ("b", f"E{i}")):
            text += f'[[sections]]\nid = "{section}"\nkind = "points"\n'
            at = low if end == "a" else low + 0.12
            toe = at + 0.02 if end == "a" else at + 0.06
            text += (
                f'[[points]]\nid = "P{i}{end}"\nsection = "{section}"\nterminal = "X"\nfrom_km = {at:.3f}\n'
                f'toe_km = {toe:.3f}\nto_km = {at + 0.08:.3f}\nfaces = "{"down" if end == "a" else "up"}"\n'
                f'stem = "{before if end == "a" else after}"\nnormal = "M{i}.1"\nreverse = "M{i}.2"\n'
                "throw_time_s = 5\ndiverging_limit_kmh = 25\n"
            )
        for track, offset in ((1, 0.0), (2, 4.0)):
            text += (
                f'[[sections]]\nid = "M{i}.{track}"\nkind = "between"\nfrom_km = {low + 0.08:.3f}\n'
                f"to_km = {low + 0.12:.3f}\noffset_m = {offset}\n"
            )
    return text


def test_a_line_with_more_ways_than_can_be_written_down_is_refused() -> None:
    line = parse_line(ladder(3), "l.toml")
    assert len(routes_from(line, "T", Direction.DOWN)) == 8
    error = refused_line(ladder(14))
    assert error.key.startswith("sections[") and error.value in ("T", "PE")
    assert "fewer ways" in error.expected


def test_it_is_the_cap_that_stops_it(monkeypatch: pytest.MonkeyPatch) -> None:
    parse_line(LINE, "l.toml")
    monkeypatch.setattr("network.graph.TRAILS_MAX", 1)
    assert "fewer ways" in refused_line(LINE).expected
    assert TRAILS_MAX > 1000


@pytest.mark.parametrize(
    ("text", "key", "most"),
    [
        (
            LINE.replace("limits = []", "limits = [" + "{}," * (ROWS_MAX + 1) + "]"),
            "alignments[0].limits",
            ROWS_MAX,
        ),
        (LINE.replace("assumed = [", "assumed = [" + '"a",' * (TEXTS_MAX + 1), 1), "line.assumed", TEXTS_MAX),
        (LINE + '[[joints]]\nlow = "a"\nhigh = "b"\n' * (TABLES_MAX + 1), "joints", TABLES_MAX),
    ],
    ids=["rows", "texts", "tables"],
)
def test_a_list_has_an_end(text: str, key: str, most: int) -> None:
    error = refused_line(text)
    assert (error.key, error.value) == (key, None)
    assert f"at most {most} entries, not " in error.expected


def test_a_list_that_is_too_short_is_said_in_plain_words() -> None:
    head, _, rest = TIMES.partition("[[trains]]")
    assert rest
    error = refused_times("trains = []\n" + head)
    assert (error.key, error.value, error.expected) == ("trains", None, "at least 1 entry, not 0")


def test_a_piece_of_track_is_there() -> None:
    error = refused_line(LINE.replace("to_km = 0.08\n", "to_km = 0.0005\n"))
    assert error.key == "sections[0].to_km" and "at least 1 m" in error.expected


def test_no_train_is_faster_than_the_fastest() -> None:
    error = refused_times(TIMES.replace('arrival = "10:02:00"', 'arrival = "10:00:02"'))
    assert error.key == "trains[0].calls[1].arrival" and "no train is faster" in error.expected
    slower = TIMES.replace('arrival = "10:02:00"', 'arrival = "10:00:05"')
    assert parse_timetable(slower, "t.toml", parse_line(LINE, "l.toml"))


HOURS: Final = (2, 23, 2, 13, 23, 10, 21, 8)  # each over 12 h before the last one ended is of the next day


def _nights(count: int) -> str:
    """A set that goes round at these hours."""
    head, _, rest = TIMES.partition("[[trains]]")
    train, _, diagram = rest.partition("[[diagrams]]")
    text = head
    for i in range(count):
        hour = f"{HOURS[i]:02d}"
        one = train.replace('"T1"', f'"D{i}"').replace("10:0", f"{hour}:0")
        one = one if i == 0 else one.replace('begins = "stabled"', 'begins = "portal:PW"')
        text += "[[trains]]" + one.replace('ends = "stabled"', 'ends = "portal:PE"')
    names = ", ".join(f'"D{i}"' for i in range(count))
    return text + "[[diagrams]]" + diagram.replace('["T1"]', f"[{names}]")


def test_a_day_has_an_end() -> None:
    """Trains of a set that go back in time are of the next day; many of them would be a run of weeks."""
    line = parse_line(LINE, "l.toml")
    assert parse_timetable(_nights(7), "t.toml", line).trains["D6"].calls[-1].last_s > 2 * 86_400
    error = refused_times(_nights(8))
    assert error.key == "diagrams[0].trains" and f"within {LAST_S_MAX // 3600} h" in error.expected
