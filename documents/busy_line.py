"""Write the busy line: 33 km of single track, six two-track stations, 96 trains in 12 h.

A line made up to measure what a busy day costs, so every figure of it is assumed. `python -m documents.busy_line`
writes line, timetable and scenario; a test holds the committed files against it. The rule of the timetable:
trains leave each end every 15 min, opposing trains so shifted that they pass at every station.

    station k of a down train that leaves at t:  arrives t + 450 k - 75 s, leaves t + 450 k s
    of an up train that leaves at t + 450 s:     the same counted from the other end, so both stand there together
    a set turns back in 975 s: 2 (2175 s + 975 s) are seven intervals, so seven sets run the day
"""

from __future__ import annotations

import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Final

from network.clock import clock
from network.files.line_file import parse_line
from network.tag_layout import lay_tags, tags_toml

LINE_ID: Final = "busy_line"
ROOT: Final = Path(__file__).resolve().parents[1]
STATIONS: Final = (
    ("ASA", "Asahi"),
    ("IZU", "Izumi"),
    ("USU", "Usui"),
    ("EDO", "Edogawa"),
    ("OKA", "Oka"),
    ("KAS", "Kasumi"),
)
SPAN_KM: Final = 6.6
TRAINS_EACH_WAY: Final = 48
MORNING_ID: Final = "busy_morning"  # for studies of many days run whole
MORNING_EACH_WAY: Final = 16
INTERVAL_S: Final = 900
STEP_S: Final = INTERVAL_S // 2  # from station to station, so that every station is a place to pass
DWELL_S: Final = 75
FIRST_S: Final = 6 * 3600
TURN_BACK_S: Final = INTERVAL_S + DWELL_S
_RUN_S: Final = (len(STATIONS) - 1) * STEP_S - DWELL_S  # from end to end
# A down train i becomes the up train i + 3, an up train j the down train j + 4.
DOWN_TO_UP: Final = (_RUN_S + TURN_BACK_S - STEP_S) // INTERVAL_S
UP_TO_DOWN: Final = (STEP_S + _RUN_S + TURN_BACK_S) // INTERVAL_S

_LINE: Final = f"""[line]
id = "{LINE_ID}"
name = "Busy line"
max_speed_kmh = 85
overlap_m = 0 # assumed: supervision guarantees the stop before the points, so opposing trains come in at once
assumed = [
  "the line: made up by documents.busy_line to measure a busy day; no figure of it has a source",
  "stations: six, 6.6 km apart, two tracks of 240 m, platforms of 80 m, marks that centre a train of 40 m",
  "maximum speed: 85 km/h, a common figure for branch lines of this class",
  "plan and profile: a curve of 800 m radius and a rise or fall of 8 permille between any two stations",
  "points: 6 s to throw, 45 km/h on the reverse leg, normal for left-hand running",
  "portals: a depot beyond each end, from which sets come in the morning and to which they go in the evening",
  "coverage: 1.5 km on either side of each station, as the paper covers only the surroundings of stations",
  "tags: by the rule of network.tag_layout",
]
"""

_STATION: Final = """
[[sections]]
id = "{id}.W"
kind = "points"

[[sections]]
id = "{id}.1"
kind = "track"
from_km = {track_from:.2f}
to_km = {track_to:.2f}
offset_m = -4.0

[[sections]]
id = "{id}.2"
kind = "track"
from_km = {track_from:.2f}
to_km = {track_to:.2f}
offset_m = 4.0

[[sections]]
id = "{id}.E"
kind = "points"

[[points]]
id = "{id}.11"
section = "{id}.W"
terminal = "{id}-W"
from_km = {west:.2f}
toe_km = {west_toe:.2f}
to_km = {track_from:.2f}
faces = "down"
stem = "{before}"
normal = "{id}.1"
reverse = "{id}.2"
throw_time_s = 6.0
diverging_limit_kmh = 45

[[points]]
id = "{id}.21"
section = "{id}.E"
terminal = "{id}-E"
from_km = {track_to:.2f}
toe_km = {east_toe:.2f}
to_km = {east:.2f}
faces = "up"
stem = "{after}"
normal = "{id}.2"
reverse = "{id}.1"
throw_time_s = 6.0
diverging_limit_kmh = 45

[[stations]]
id = "{id}"
name = "{name}"
km = {km:.1f}
"""


def line_toml() -> str:
    """The line file, tags included."""
    bare = _LINE + _alignment() + "".join(_stretches()) + "".join(_stations())
    tags = tags_toml(parsed := parse_line(bare, LINE_ID), lay_tags(parsed))
    return f"# Made by documents.busy_line; change that and run it again.\n\n{tags}\n{bare}"


def timetable_toml(timetable_id: str = LINE_ID, each_way: int = TRAINS_EACH_WAY) -> str:
    """The timetable file of a day with so many trains each way."""
    trains = [_train("down", i, each_way) + _train("up", i, each_way) for i in range(each_way)]
    head = f"""# Made by documents.busy_line; change that and run it again.

[timetable]
id = "{timetable_id}"
name = "Busy line, a train every 15 min each way for {each_way * INTERVAL_S // 3600} h"
line = "{LINE_ID}"
dwell_min_s = 30
assumed = [
  "all times: 7.5 min from station to station, 75 s of them standing, so that trains pass at every station",
  "turning back: 975 s at each end, on the track that the set before has left",
]
"""
    return head + "".join(trains) + "".join(_diagrams(each_way))


def scenario_toml() -> str:
    """The scenario file."""
    return f"""# Made by documents.busy_line; change that and run it again.
id = "{LINE_ID}"
name = "A busy line: 33 km, six two-track stations, 96 trains in 12 h"
line = "{LINE_ID}"
timetable = "{LINE_ID}"
seed = 1
assumed = [
  "air: telegrams take 0.1 s at least, 0.2 s on average, 1 % are lost; the paper gives no figures",
  "load: a fifth of capacity, scattered by train",
]

[trains]
default = "ev_e301"

[air]
delay_min_s = 0.1
delay_mean_s = 0.2
loss_good_p = 0.01
"""


def files() -> dict[Path, str]:
    """Text of each file by its path."""
    name = f"{LINE_ID}.toml"
    return {
        ROOT / "network/lines" / name: line_toml(),
        ROOT / "network/timetables" / name: timetable_toml(),
        ROOT / "study/scenarios" / name: scenario_toml(),
        ROOT / "docs/studies/order_of_trains/morning_times.toml": timetable_toml(
            MORNING_ID, MORNING_EACH_WAY
        ),
    }


def _km(index: int) -> float:
    return SPAN_KM * index


def _alignment() -> str:
    """One axis; level 0.6 km either side of a station, a hill or a dip and a curve between two."""
    end_km = _km(len(STATIONS) - 1)
    gradients = [(-1.0, 0.6, 0.0)]
    curves: list[tuple[float, float, int]] = []
    for i in range(len(STATIONS) - 1):
        low, middle, high = _km(i) + 0.6, _km(i) + SPAN_KM / 2, _km(i + 1) - 0.6
        rise = 8.0 if i % 2 == 0 else -8.0
        gradients += [(low, middle, rise), (middle, high, -rise), (high, min(high + 1.2, end_km + 1.0), 0.0)]
        curves.append((middle - 0.3, middle + 0.3, 800 if i % 2 == 0 else -800))
    gradients[-1] = (gradients[-1][0], end_km + 1.0, 0.0)
    rows = [f"  {{ from_km = {a:.1f}, to_km = {b:.1f}, permille = {p} }}," for a, b, p in gradients]
    bends = [
        f"  {{ from_km = {a:.1f}, to_km = {b:.1f}, radius_m = {r}, transition_m = 42.0, cant_mm = 70 }},"
        for a, b, r in curves
    ]
    covered = [
        f"  {{ from_km = {max(_km(i) - 1.5, -1.0):.1f}, to_km = {min(_km(i) + 1.5, end_km + 1.0):.1f} }},"
        for i in range(len(STATIONS))
    ]
    tables = [("gradients", rows), ("curves", bends), ("coverage", covered)]
    lists = "".join(f"{name} = [\n" + "\n".join(items) + "\n]\n" for name, items in tables)
    return f'\n[[alignments]]\nid = "main"\nfrom_km = -1.0\nto_km = {end_km + 1.0:.1f}\n{lists}'


def _stretches() -> Iterator[str]:
    """Portals and the sections between stations."""
    ids = [station_id for station_id, _ in STATIONS]
    for i in range(len(STATIONS) + 1):
        kind = "between" if 0 < i < len(STATIONS) else "portal"
        from_km = -1.0 if i == 0 else _km(i - 1) + 0.2
        to_km = _km(i) - 0.2 if i < len(STATIONS) else _km(i - 1) + 1.0
        yield (
            f'\n[[sections]]\nid = "{_stretch(ids, i)}"\nkind = "{kind}"\n'
            f"from_km = {from_km:.1f}\nto_km = {to_km:.1f}\n"
        )


def _stretch(ids: list[str], index: int) -> str:
    """Name of what lies before station `index`."""
    if index == 0:
        return f"{ids[0]}.P"
    return f"{ids[-1]}.P" if index == len(ids) else f"{ids[index - 1]}-{ids[index]}"


def _stations() -> Iterator[str]:
    ids = [station_id for station_id, _ in STATIONS]
    for i, (station_id, name) in enumerate(STATIONS):
        km = _km(i)
        yield _STATION.format(
            id=station_id,
            name=name,
            km=km,
            before=_stretch(ids, i),
            after=_stretch(ids, i + 1),
            west=km - 0.2,
            west_toe=km - 0.18,
            track_from=km - 0.12,
            track_to=km + 0.12,
            east_toe=km + 0.18,
            east=km + 0.2,
        )
        yield "tracks = [\n"
        for track, usual in (("1", "down"), ("2", "up")):
            directions = '["down", "up"]' if i in (0, len(STATIONS) - 1) else f'["{usual}"]'
            yield (
                f'  {{ name = "{track}", section = "{station_id}.{track}", platform_from_km = {km - 0.04:.2f}, '
                f"platform_to_km = {km + 0.04:.2f}, mark_down_km = {km + 0.02:.2f}, "
                f"mark_up_km = {km - 0.02:.2f}, directions = {directions} }},\n"
            )
        yield "]\n"


def _number(direction: str, index: int) -> str:
    """Odd numbers go down, even ones up, as in Japan."""
    return f"{2 * index + (1 if direction == 'down' else 2)}M"


def _train(direction: str, index: int, each_way: int) -> str:
    """One train: where its set comes from, its calls, what becomes of it."""
    if direction == "down":
        stops = [station_id for station_id, _ in STATIONS]
        before, after, leaves_s = index - UP_TO_DOWN, index + DOWN_TO_UP, FIRST_S
        other, usual = "up", "1"
    else:
        stops = [station_id for station_id, _ in reversed(STATIONS)]
        before, after, leaves_s = index - DOWN_TO_UP, index + UP_TO_DOWN, FIRST_S + STEP_S
        other, usual = "down", "2"
    leaves_s += INTERVAL_S * index
    begins = f"from:{_number(other, before)}" if before >= 0 else f"portal:{stops[0]}.P"
    ends = f"becomes:{_number(other, after)}" if after < each_way else f"portal:{stops[-1]}.P"
    first_track, last_track = "12"[index % 2], "12"[after % 2]
    calls: list[str] = []
    for k, station in enumerate(stops):
        track = first_track if k == 0 else last_track if k == len(stops) - 1 else usual
        arrival = f', arrival = "{clock(leaves_s + STEP_S * k - DWELL_S)}"' if k else ""
        goes_on = k < len(stops) - 1 or ends.startswith("portal")
        departure = f', departure = "{clock(leaves_s + STEP_S * k)}"' if goes_on else ""
        calls.append(f'  {{ station = "{station}", track = "{track}"{arrival}{departure} }},\n')
    return (
        f'\n[[trains]]\nnumber = "{_number(direction, index)}"\ndirection = "{direction}"\n'
        f'begins = "{begins}"\nends = "{ends}"\ncalls = [\n{"".join(calls)}]\n'
    )


def _diagrams(each_way: int) -> Iterator[str]:
    """Sets by their first train: those that no other train has become."""
    firsts = [("down", i) for i in range(UP_TO_DOWN)] + [("up", j) for j in range(DOWN_TO_UP)]
    for stock, first in enumerate(firsts, start=1):
        direction, index = first
        numbers: list[str] = []
        while index < each_way:
            numbers.append(f'"{_number(direction, index)}"')
            direction, index = (
                ("up", index + DOWN_TO_UP) if direction == "down" else ("down", index + UP_TO_DOWN)
            )
        yield f'\n[[diagrams]]\nstock = "B{stock}"\ntrains = [{", ".join(numbers)}]\n'


def main() -> None:
    """Write the files; their net is `python -m sumo_cfg.build`'s."""
    for path, text in files().items():
        path.write_text(text, "utf-8")
        sys.stdout.write(f"{path.relative_to(ROOT)}\n")


if __name__ == "__main__":
    main()
