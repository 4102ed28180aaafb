"""`branchline capacity`: how full each part of a line is (UIC 406), how many more trains fit, what equipment buys."""

from __future__ import annotations

import math
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from branchline.ending import print_json
from branchline.headways import ByTheory, Source
from branchline.options import Json
from branchline.progress import print_aside

if TYPE_CHECKING:
    from scenario.scenario import Scenario
    from study.capacity.equipment import EquipmentFigures, LeverWorth
    from study.capacity.line_capacity import Period, Rate
    from study.capacity.more import AddedTrains
    from study.record.read_back import RunRead

ALL = "all"


def capacity(
    source: Source,
    cut: Annotated[
        str, typer.Option("--cut", help="How the line is cut: whole, crossing, interval, section, or all.")
    ] = ALL,
    from_time: Annotated[
        str | None,
        typer.Option("--from", help="From this time, HH:MM, instead of the whole day and the peak."),
    ] = None,
    to_time: Annotated[str | None, typer.Option("--to", help="Until this time, HH:MM.")] = None,
    traffic: Annotated[
        str,
        typer.Option(
            "--traffic", help="Kind of traffic whose limits are shown: mixed, suburban, high-speed."
        ),
    ] = "mixed",
    stops: Annotated[
        str, typer.Option("--stops", help="Stops as planned (kept), or as short as possible (least).")
    ] = "kept",
    buffer_s: Annotated[
        float,
        typer.Option(
            "--buffer", min=0.0, max=3600.0, help="Time kept between an added train and the others, s."
        ),
    ] = 0.0,
    theory: ByTheory = False,
    equipment: Annotated[
        bool,
        typer.Option(
            "--equipment", help="Also show what tags, radio, points and bounds are worth, by theory."
        ),
    ] = False,
    out: Annotated[
        Path | None,
        typer.Option(
            "--out",
            help="Directory for occupation.csv and the pictures as PNG and SVG; or FILE.toml for a scenario with the"
            " trains that fit.",
        ),
    ] = None,
    as_json: Json = False,
) -> None:
    """Show how full each part of a line is (compression, UIC 406), and how many more trains fit."""
    from branchline.questions import CapacityAsked, capacity_of
    from branchline.sources import loaded_source, setup_of_source
    from study.capacity.equipment import worth_of
    from study.plot.choice import time_of
    from study.record.directory import asked_folder
    from study.report.capacity import FILES, write_occupation

    between_s = time_of("--from", from_time), time_of("--to", to_time)
    asked = CapacityAsked(cut, between_s, traffic, stops, buffer_s, theory)
    loaded = loaded_source(source)
    extended = None
    if out is not None and out.suffix == ".toml":
        extended = _extended(out, source, loaded)
    with asked_folder(None if extended else out, FILES.__contains__, "capacity") as folder:
        found = capacity_of(loaded, asked, progress=True)
        by_cut, cuts, more, periods = found.by_cut, found.cuts, found.more, found.periods
        worth = worth_of(setup_of_source(loaded)) if equipment else None
        if folder is not None:
            write_occupation(folder, by_cut, worth)
    if out is not None and extended is not None:
        _write_more(out, *extended, found.more)
    elif out is not None:
        print_aside(f"wrote {', '.join(sorted(p.name for p in out.iterdir()))} in {out}")
    if as_json:
        print_json(
            {"conclusion": found.conclusion}
            | _as_dict(by_cut, {one.name: one.how for one in cuts}, more, periods, worth, theory=theory)
        )
        return
    for one in cuts:
        _print(one.name, one.how, by_cut[one.name])
    _print_more(more, periods)
    if worth is not None:
        _print_worth(worth)
    sys.stdout.write(f"\n{found.conclusion}\n")


def _extended(out: Path, source: str, loaded: Scenario | RunRead) -> tuple[str, Scenario]:
    """The scenario to which trains are added, and how a file at `out` names it. InputError where it cannot be."""
    from network.errors import COMMAND_LINE, InputError
    from scenario.scenario import Scenario
    from study.making.place import extended_by

    if not isinstance(loaded, Scenario):
        raise InputError(COMMAND_LINE, "SOURCE", source, "a scenario, which the one with more trains extends")
    return extended_by(out, source, "--out"), loaded


def _write_more(out: Path, base: str, scenario: Scenario, more: AddedTrains) -> None:
    from network.files.json_input import write_aside
    from network.files.toml_text import toml_of
    from study.capacity.more import patch_with

    if not more.sets:
        print_aside(f"no more trains fit, so {out} is not written")
        return
    kinds = {one.stock_id: scenario.inputs.stock[path.kind_of_stock] for one, path in more.sets}
    stock = {"trains": {"stock": kinds}} if len(set(scenario.inputs.stock.values())) > 1 else {}
    head = {"extends": base, "id": out.stem, "name": f"{more.trains} more trains"}
    write_aside(out, toml_of({**head, **stock, **patch_with(scenario.setup, more)}))
    print_aside(f"wrote {out}, {base} with {more.trains} more trains")


def _as_dict(
    by_cut: Mapping[str, Sequence[Rate]],
    how: Mapping[str, str],
    more: AddedTrains,
    periods: Sequence[Period],
    worth: Sequence[LeverWorth] | None,
    *,
    theory: bool,
) -> dict[str, Any]:
    cuts = [
        {"cut": name, "how": how[name], "parts": [rate.as_dict() for rate in rates]}
        for name, rates in by_cut.items()
    ]
    room = {
        "paths": [path.as_dict() for path in more.paths],
        "kinds": list(more.names),
        "trains": {period.name: more.trains_in(period) for period in periods},
        "dropped": list(more.dropped),
        "wait_s_max": more.search.wait_s_max,
        "buffer_s": more.search.buffer_s,
    }
    found = {"of": "theory" if theory else "run", "cuts": cuts, "room": room}
    return found if worth is None else found | {"equipment": [one.as_dict() for one in worth]}


def _print(name: str, how: str, rates: Sequence[Rate]) -> None:
    """A block a way of cutting, a row a part and period."""
    from rich.cells import cell_len, set_cell_size

    wide = max((cell_len(rate.part.name) for rate in rates), default=0)
    heads = ("kind", "period", "trains", "occupied min", "rate %", "limit %", "with added %", "below limit")
    rows = [f"cut: {name} - {how}", f"{'':{wide}}" + "".join(f"{head:>13}" for head in heads) + "  critical"]
    for rate in rates:
        if not rate.trains:
            continue
        cells = (
            rate.part.kind.value,
            rate.period.name,
            str(rate.trains),
            f"{rate.compressed.occupied_s / 60.0:.1f}",
            f"{100.0 * rate.occupied_share:.1f}",
            f"{100.0 * rate.limit_share:.0f}",
            f"{100.0 * rate.consumed_share:.1f}",
            str(rate.trains_below_limit),
        )
        note = f" (stops not kept: {', '.join(rate.contradiction)})" if rate.contradiction else ""
        row = set_cell_size(rate.part.name, wide) + "".join(f"{cell:>13}" for cell in cells)
        rows.append(f"{row}  {rate.compressed.section_id}{note}")
    sys.stdout.write("\n".join((*rows, "", "")))


def _print_more(more: AddedTrains, periods: Sequence[Period]) -> None:
    """How many more trains, and where."""
    if not more.names:
        sys.stdout.write("room: no train of the plan comes from a portal, so no further set could come\n")
        return
    counts = ", ".join(f"{more.trains_in(period)} in the {period.name}" for period in periods)
    sys.stdout.write(
        f"room between the trains: {counts}; each checked in the plan, standing {more.search.wait_s_max / 60.0:.0f} min"
        f" at most at a place, {more.search.buffer_s:.0f} s from others\n"
    )
    for path in more.paths:
        row = path.as_dict()
        sys.stdout.write(
            f"  {row['path']}: {row['departs']} - {row['arrives']}, waits {path.waits_s / 60.0:.0f} min\n"
        )
    if more.dropped:
        sys.stdout.write(f"  taken out again, as impossible: {', '.join(more.dropped)}\n")


def _print_worth(worth: Sequence[LeverWorth]) -> None:
    """What each parameter is worth from its low to its high end."""
    sys.stdout.write(
        "\nwhat equipment gains: headway of a following train with routes held whole, and with five virtual blocks,"
        " longest time from an arrival to the opposing departure, s; occupancy of the fullest part, %\n"
    )
    for one in worth:
        cells = [
            f"{word:>16}"
            + "".join(f"{'-' if math.isnan(value) else f'{value:.1f}':>9}" for value in _figures(end))
            for word, end in ((one.low, one.low_end), (one.high, one.high_end))
        ]
        sys.stdout.write(f"  {one.name:24}{'  '.join(cells)}\n")


def _figures(end: EquipmentFigures) -> tuple[float, ...]:
    return end.headway_s, end.block_headway_s, end.meet_s, 100.0 * end.occupied_share
