"""A new scenario and a new drill, on a scenario that there is: they run as they stand, and say what may be added."""

from __future__ import annotations

from pathlib import Path
from typing import Final

from network.clock import clock
from network.files.toml_text import text_toml
from scenario.scenario import Scenario, load_scenario
from simulation.setup import Setup
from study.making.place import checked_new, named_from, write_new

FAULT_BEFORE_S: Final = 90  # the first departure: its route is not asked for yet, so that the train waits
POWER_OFF_S: Final = 60
ENTRY_AFTER_S: Final = 120  # from the fault: the manager is on again, and a person restores the picture


def new_scenario(extends: str, out: Path) -> Scenario:
    """Write a scenario that changes nothing yet, and read it again. InputError."""
    stem = checked_new(out)
    base = load_scenario(extends)
    write_new(out, scenario_text(stem, named_from(out, extends), base))
    return load_scenario(str(out))


def new_drill(scenario: str, out: Path) -> Scenario:
    """Write a drill with a fault, an act and an expectation, and read it again. InputError."""
    stem = checked_new(out)
    base = load_scenario(scenario)
    write_new(out, drill_text(stem, named_from(out, scenario), base))
    return load_scenario(str(out))


def scenario_text(stem: str, extends: str, base: Scenario) -> str:
    """The scenario's file; what stands behind `#` is valid as it is on this line and timetable."""
    setup = base.setup
    return f"""# A what-if on {base.name}: run it with `branchline run {stem}.toml`, and compare it with
# `branchline run {stem}.toml --against RUN`, RUN being a run directory of {base.id}.
# What is not said here is as in the scenario that it extends; docs/files.md has every key of every file.

extends = {text_toml(extends)}
id = {text_toml(stem)}
name = {text_toml(f"{base.name}: {stem}")}

# seed = 2                          # another draw of every chance in the run
# assumed = ["what nobody has published, in sentences for the report"]

# What differs from the files that are named, by id, by share, by hours: take away a `#` and run it again.
# Put `*` in place of an id for all of them.

{_line_examples(setup)}
{_timetable_examples(setup)}
# [patch.train.{_train_file(base)}.times]
# "body.mass_empty_{_mass_unit(base)}" = 1.1             # a tenth heavier

# [patch.air.times]
# delay_mean_s = 2.0                # telegrams take twice as long

# [patch.unit.set]
# request_lead_s = 60.0             # a route is asked for a minute before the departure
"""


def _line_examples(setup: Setup) -> str:
    line = setup.line
    alignment = next(iter(line.alignments.values()))
    at_m = alignment.from_m + 0.4 * (alignment.to_m - alignment.from_m)
    rows = ["# [patch.line.set]"]
    for points in list(line.points.values())[:1]:
        rows.append(f'# "points.{points.id}.throw_time_s" = 20.0   # slower points')
    rows += [
        '# "line.max_speed_kmh" = 50.0',
        "",
        "# [patch.line.add]                  # a restriction of 25 km/h over 400 m",
        f"# limits = [{{ from_km = {at_m / 1000.0:.3f}, to_km = {at_m / 1000.0 + 0.4:.3f}, speed_kmh = 25,"
        ' directions = ["down", "up"] }]',
        "",
    ]
    return "\n".join(rows)


def _timetable_examples(setup: Setup) -> str:
    train = next(iter(setup.timetable.trains.values()))
    call = train.calls[0]
    later = clock((call.departure_s or 0) + 60)
    hour = min(call.last_s // 3600, 21)
    return f"""# [patch.timetable.set]
# "trains.{train.number}.calls.{call.station_id}.departure" = "{later}"

# [[patch.timetable.scale]]         # running times of some hours 5 % longer
# from = "{hour:02d}:00"
# to = "{hour + 2:02d}:00"
# times = 1.05
"""


def _train_file(base: Scenario) -> str:
    return next(iter(base.inputs.stock.values()))


def _mass_unit(base: Scenario) -> str:
    body = base.inputs.trains[_train_file(base)]["body"]
    return next(str(key).rpartition("_")[2] for key in body if str(key).startswith("mass_empty_"))


def drill_text(stem: str, scenario: str, base: Scenario) -> str:
    """The drill's file."""
    first_s = min(train.calls[0].last_s for train in base.setup.timetable.trains.values())
    fault_s = max(first_s - FAULT_BEFORE_S, 0)
    return f"""# A drill on {base.name}: run it with `branchline drill {stem}.toml`.
# Faults and their keys are in docs/faults.md, acts, expectations and what they may wait for in docs/files.md;
# events and their data in docs/journal.md.

extends = {text_toml(scenario)}
id = {text_toml(stem)}
name = "The block manager loses its power for a minute"

# What fails. `after = {{ who = ..., what = ... }}` in place of `start` waits for an event of the journal.
[[fault]]
kind = "power_off"
target = "block-manager"
start = "{clock(fault_s)}"
duration_s = {POWER_OFF_S:.1f}

# What people do: here the controller restores the block state, asking every train for what it holds.
[[act]]
kind = "reenter_assisted"
start = "{clock(fault_s + ENTRY_AFTER_S)}"
pace_s = 10.0 # assumed: to ask, look and type

# What must be so. That nothing unsafe happens and that everyone arrives is expected of every drill.
[[expect]]
text = "the manager restarts"
event = {{ who = "block-manager", what = "started" }}
after = {{ who = "world", what = "fault_over" }}

[[expect]]
text = "nothing is granted before the block state is restored"
event = {{ who = "block-manager", what = "granted" }}
absent = true
after = {{ who = "world", what = "fault" }}
until = {{ who = "controller", what = "act" }}

[[expect]]
text = "then routes are granted again"
event = {{ who = "block-manager", what = "granted" }}
after = {{ who = "controller", what = "act" }}
"""
