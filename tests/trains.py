"""Timetables of tests, a line for each train: its number, direction and ends, and where it calls when.

`"4B up, stabled to portal:HSK.MD: KRS -/07:30; OGN 2 07:55/08:05; HSK 08:27/-"` runs from Karasuyama to a portal;
`NIT pass 07:07:20` runs through, and a stop with ` operational` behind it is for nobody.
"""

import re
from typing import Final

TRAIN: Final = re.compile(r"(\w+) (up|down), (\S+) to (\S+): (.+)")
CALL: Final = re.compile(r"(\w+) (?:(\w+) )?([\d:]+|-)/([\d:]+|-)( operational)?")
PASSING: Final = re.compile(r"(\w+) pass ([\d:]+)")


def day_of(*trains: str, **stock: str) -> str:
    """The tables of trains, and of the stock that works them: `SA="A B"`."""
    worked = {name: ", ".join(f'"{number}"' for number in numbers.split()) for name, numbers in stock.items()}
    diagrams = (f'[[diagrams]]\nstock = "{name}"\ntrains = [{numbers}]\n' for name, numbers in worked.items())
    return "".join((*map(_train, trains), *diagrams))


def timetable_of(name: str, line: str, *trains: str, dwell_min_s: int | None = None, **stock: str) -> str:
    """A timetable file of a line."""
    dwell = "" if dwell_min_s is None else f"dwell_min_s = {dwell_min_s}\n"
    return f'[timetable]\nid = "{name}"\nline = "{line}"\n{dwell}{day_of(*trains, **stock)}'


def _train(text: str) -> str:
    found = TRAIN.fullmatch(text)
    assert found, text
    number, direction, begins, ends, calls = found.groups()
    rows = ", ".join(map(_call, calls.split("; ")))
    return (
        f'[[trains]]\nnumber = "{number}"\ndirection = "{direction}"\nbegins = "{begins}"\nends = "{ends}"\n'
        f"calls = [{rows}]\n"
    )


def _call(text: str) -> str:
    if passing := PASSING.fullmatch(text):
        return f'{{ station = "{passing[1]}", pass = "{passing[2]}" }}'
    found = CALL.fullmatch(text)
    assert found, text
    keys = dict(zip(("station", "track", "arrival", "departure"), found.groups(), strict=False))
    given = [f'{key} = "{value}"' for key, value in keys.items() if value not in (None, "-")]
    return f"{{ {', '.join([*given, 'operational = true'] if found[5] else given)} }}"
