"""`[line_signals]` of a scenario, checked against its line, its day and its other tables."""

from __future__ import annotations

from collections.abc import Collection

from network.errors import InputError
from network.files.toml_input import one_of
from network.model import SectionKind
from simulation.line_signals_settings import LineSignals, SignalDeed
from simulation.setup import Setup
from simulation.world.roster import drawn_up

_AT_LEVERS = (SignalDeed.LEVER, SignalDeed.RELEASE_LEVER)


def check_line_signals(file: str, setup: Setup) -> None:
    """Places and names exist, and nothing else works the line, or InputError."""
    settings = setup.line_signals
    if settings is None:
        return
    for key, other in (("substitute", setup.substitute), ("battery", setup.battery)):
        if other is not None:
            raise InputError(file, key, None, "no such table with [line_signals], where trains have no units")
    for duties in drawn_up(setup, setup.line).values():
        for duty in duties:
            if duty.enters or duty.leaves:
                expected = (
                    f"no portal: train {duty.train.number} would come or go by one, which no signal is at"
                )
                raise InputError(file, "line_signals", None, expected)
    _check_places(file, setup, settings)
    _check_names(file, settings)


def _check_places(file: str, setup: Setup, settings: LineSignals) -> None:
    sections = setup.line.sections.values()
    blocks = sorted(s.id for s in sections if s.kind is SectionKind.BETWEEN)
    halts = [station.id for station in setup.line.stations.values() if station.is_halt]
    places = sorted((*(s.id for s in sections if s.kind is SectionKind.TRACK), *halts))
    for i, signal in enumerate(settings.signal):
        key = f"line_signals.signal[{i}]"
        _known(file, f"{key}.at", signal.at, places)
        _known(file, f"{key}.block", signal.block, blocks)
    for i, lever in enumerate(settings.lever):
        for j, block in enumerate(lever.blocks):
            _known(file, f"line_signals.lever[{i}].blocks[{j}]", block, blocks)


def _check_names(file: str, settings: LineSignals) -> None:
    signals = _once(file, "line_signals.signal", [signal.id for signal in settings.signal])
    levers = _once(file, "line_signals.lever", [lever.id for lever in settings.lever])
    for i, detector in enumerate(settings.detector):
        _known(file, f"line_signals.detector[{i}].signal", detector.signal, signals)
        for j, held in enumerate(detector.holds):
            _known(file, f"line_signals.detector[{i}].holds[{j}]", held, signals)
    for i, act in enumerate(settings.act):
        names = levers if act.does in _AT_LEVERS else signals
        _known(file, f"line_signals.act[{i}].target", act.target, names)


def _once(file: str, key: str, ids: list[str]) -> list[str]:
    for i, name in enumerate(ids):
        if name in ids[:i]:
            raise InputError(file, f"{key}[{i}].id", name, "each name once")
    return ids


def _known(file: str, key: str, value: str, known: Collection[str]) -> None:
    if value not in known:
        raise InputError(file, key, value, one_of(known, value) if known else "nothing: there are none")
