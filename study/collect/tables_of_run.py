"""From what a run leaves behind to its tables: trajectories, stops, blocks, telegrams, energy, events."""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

import numpy as np
import polars as pl
from numpy.typing import NDArray

from network.model import Line
from radio.noted import TelegramDropped
from simulation.result import RunResult, TraceSpan
from simulation.setup import STEPS_PER_S
from simulation.world.roster import Duty
from study.capacity.blocking_table import blocking_table, blocks_table
from study.capacity.observed import occupations_run
from study.collect.crossings import crossing_tables
from study.collect.energy import StockMake, energy_tables
from study.collect.energy_hours import energy_hours_of
from study.collect.margins import margins_of
from study.collect.stops import stops_table, with_passings
from study.measures.register_holds import SectionHold
from study.measures.running_times import PlannedLeg
from study.record.calls import TracePoint
from study.record.figure import schema_of
from study.record.journal_rows import EventInWords, TelegramsOfWay
from study.record.spans import rows_by_span
from study.record.tables import RunTables, make_table
from study.wording.events import event_text, wording_of
from study.wording.phrase import Names, names_of


def tables_of(
    result: RunResult,
    line: Line,
    fleet: Mapping[str, StockMake],
    holds: Sequence[SectionHold],
    legs: Sequence[PlannedLeg] = (),
    duties: Iterable[Duty] = (),
    end_s: float = -math.inf,
) -> RunTables:
    """All tables of a run but those of `execute`; `fleet` says what stock is, `holds` who had which section when,
    the rest what was planned, and when the run ends whatever happens, s.
    """
    spans = [(span, rows) for span, rows in rows_by_span(result) if rows.size]
    stops = stops_table(with_passings(result.stops, duties, spans))
    return RunTables.with_tables(
        trajectory=_trajectory(result, spans),
        stops=stops,
        blocks=blocks_table(holds),
        blocking=blocking_table(occupations_run(result, line, holds)),
        telegrams=_telegrams(result),
        **energy_tables(result.energy, fleet),
        energy_hours=energy_hours_of(result.energy, fleet),
        margins=margins_of(legs, stops, end_s),
        **crossing_tables(result, line),
        events=_events(result, names_of(line)),
    )


def _trajectory(result: RunResult, spans: list[tuple[TraceSpan, NDArray[np.void]]]) -> pl.DataFrame:
    frames: list[dict[str, Any]] = []
    for span, rows in spans:
        starts = np.asarray(span.starts_m)
        step_index = np.clip(np.searchsorted(starts, rows["position_m"], side="right") - 1, 0, None)
        entries = np.asarray(span.entries_m)[step_index]
        kilometrage = entries + span.direction * (rows["position_m"] - starts[step_index])
        frames.append(
            {
                **{name: rows[name] for name in schema_of(TracePoint) if name in (rows.dtype.names or ())},
                "t_s": rows["step"] / STEPS_PER_S,
                "unit": np.full(rows.size, result.stock_ids[span.slot]),
                "train": np.full(rows.size, span.number),
                "direction": np.full(rows.size, span.direction, dtype=np.int8),
                "kilometrage_m": kilometrage,
                "piece": np.asarray(span.piece_ids)[step_index],
                "intervention": rows["intervention"].astype(np.int8),
            }
        )
    if not frames:
        return make_table("trajectory")
    columns = {name: np.concatenate([frame[name] for frame in frames]) for name in frames[0]}
    return make_table("trajectory", columns)


def _telegrams(result: RunResult) -> pl.DataFrame:
    dropped: dict[tuple[str, str, str], int] = defaultdict(int)
    for entry in result.journal.entries:
        match entry.event:  # what was not proven to be of its source and kind is in no row
            case TelegramDropped(source=str(source), receiver=receiver, kind=str(kind)):
                dropped[source, receiver, kind] += 1
            case _:
                pass
    return make_table(
        "telegrams",
        [
            TelegramsOfWay(
                source,
                destination,
                kind,
                count["sent"],
                count["delivered"],
                count["lost"],
                dropped[source, destination, kind],
                count["bytes"],
            )
            for (source, destination, kind), count in sorted(result.telegrams.items())
        ],
    )


def _events(result: RunResult, names: Names) -> pl.DataFrame:
    rows: list[EventInWords] = []
    for entry in result.journal.entries:
        wording = wording_of(entry.event)
        if wording is not None:
            text = event_text(entry.event, names)
            rows.append(EventInWords(entry.t_s, entry.who, wording.kind, text.en, text.in_("ja")))
    return make_table("events", rows)
