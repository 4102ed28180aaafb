"""Make the Kururi and Isumi lines with their days: from station lists, published geometry and published times.

Nobody has had a hand in the files that this writes. `python -m documents.real_lines DATA` writes lines, timetables and
scenarios; DATA holds `geometry/` (Seo-4d696b75/station_database, CC BY-SA 4.0) and `timetables/mini_tokyo_3d/`
(nagix/mini-tokyo-3d, data from ODPT), neither of which is kept here. The same by hand, for one line and day:

    branchline new line documents/station_lists/kururi.toml network/lines/kururi.toml \
        --polyline DATA/geometry/polyline_11330.json --stations-geometry DATA/geometry/line_11330.json
    branchline import mini-tokyo DATA/timetables/mini_tokyo_3d/jreast-kururi.json \
        network/timetables/kururi_weekday.toml --line network/lines/kururi.toml

Then `python -m sumo_cfg.build` makes the nets.
"""

from __future__ import annotations

import sys
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Final

from exchange.import_timetable import ImportOrder, import_timetable
from exchange.mini_tokyo import SOURCE, read_mini_tokyo
from exchange.new_line import NewLine, NewLineOptions, make_line
from exchange.timetable_writer import timetable_toml
from network.model import Line

ROOT: Final = Path(__file__).resolve().parents[1]


@dataclass(frozen=True, slots=True)
class RealLine:
    """A line: names of its files in the sources, and what its scenarios say."""

    id: str
    name: str
    operator: str
    geometry: int  # the source's code of the line
    timetable: str
    trains_there: str  # for which the stand-in stands
    block: str  # how trains are kept apart in truth

    @property
    def station_list(self) -> Path:
        """The list that the line is made from."""
        return ROOT / f"documents/station_lists/{self.id}.toml"


@dataclass(frozen=True, slots=True)
class CalendarDay:
    """A day of the timetables."""

    id: str
    calendar: str
    name: str


LINES: Final = (
    RealLine(
        "kururi",
        "Kururi Line",
        "JR",
        11330,
        "jreast-kururi",
        trains_there="KiHa E130-100 railcars of 20 m",
        block="special automatic block with track circuits at stations",
    ),
    RealLine(
        "isumi",
        "Isumi Line",
        "Isumi Railway's",
        99308,
        "isumi-isumi",
        trains_there="Isumi 300 railcars of 18 m",
        block="special automatic block with electronic codes",
    ),
)
DAYS: Final = (
    CalendarDay("weekday", "Weekday", "weekdays"),
    CalendarDay("holiday", "SaturdayHoliday", "weekends and holidays"),
)


def new_line(real: RealLine, data: Path) -> NewLine:
    """The line as `branchline new line` makes it."""
    geometry = data / "geometry"
    asked = NewLineOptions(
        polyline=geometry / f"polyline_{real.geometry}.json",
        stations_geometry=geometry / f"line_{real.geometry}.json",
    )
    return make_line(real.station_list, real.id, asked)


def timetable_text(real: RealLine, day: CalendarDay, line: Line, data: Path) -> str:
    """The timetable file as `branchline import mini-tokyo` makes it."""
    source = data / f"timetables/mini_tokyo_3d/{real.timetable}.json"
    order = ImportOrder(id=f"{real.id}_{day.id}", credit=SOURCE)
    return timetable_toml(import_timetable(read_mini_tokyo(source, day.calendar), line, order).file)


def scenario_text(real: RealLine, day: CalendarDay) -> str:
    """The scenario file."""
    sentences = "\n".join(f'  "{text}",' for text in _assumed(real))
    what = "a weekday" if day.id == "weekday" else "a day of a weekend or holiday"
    return f"""# Made by documents.real_lines; change that and run it again.
id = "{real.id}_{day.id}"
name = "{real.operator} {real.name}, {what}"
line = "{real.id}"
timetable = "{real.id}_{day.id}"
seed = 1
assumed = [
{sentences}
]

[trains]
default = "br642"

[air]
delay_min_s = 0.1
delay_mean_s = 0.2
loss_good_p = 0.01
"""


def _assumed(real: RealLine) -> Iterator[str]:
    yield (
        f"train: BR 642 as a stand-in for the {real.trains_there}, because their traction and resistance are not "
        "published; one set of two parts, 41.7 m, for each train"
    )
    yield (
        "line: how many tracks, their sides and lengths, gradients, limits of curves, coverage and tags, as the line "
        "file says"
    )
    yield f"equipment: nothing of what is simulated here is on the line, which has a {real.block}"
    yield "sets: which set runs which train, where and on which track sets stand, as the timetable file says"
    yield (
        "air: telegrams take 0.1 s at least and 0.2 s on average, 1 % are lost, because the paper gives no figures "
        "for its radio"
    )
    yield "load: a fifth of capacity, scattered by train"


def scenarios() -> dict[Path, str]:
    """Scenario files, which need no data."""
    return {
        ROOT / f"study/scenarios/{real.id}_{day.id}.toml": scenario_text(real, day)
        for real in LINES
        for day in DAYS
    }


def files(data: Path) -> Iterator[tuple[Path, str]]:
    """Every file with its text, lines first."""
    for real in LINES:
        made = new_line(real, data)
        yield ROOT / f"network/lines/{real.id}.toml", made.text
        for day in DAYS:
            text = timetable_text(real, day, made.line, data)
            yield ROOT / f"network/timetables/{real.id}_{day.id}.toml", text
    yield from scenarios().items()


def main(arguments: list[str]) -> int:
    """Write the files; their nets are `python -m sumo_cfg.build`'s."""
    if len(arguments) != 1:
        sys.stderr.write("usage: python -m documents.real_lines DATA\n")
        return 2
    for path, text in files(Path(arguments[0])):
        path.write_text(text, "utf-8")
        sys.stdout.write(f"{path.relative_to(ROOT)}\n")
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
