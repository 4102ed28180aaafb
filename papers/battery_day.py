"""The Karasuyama weekday on batteries: does every set come home, and which assumption decides it?

What is public of the EV-E301's battery is its voltage and energy, that it charges by a rigid bar at Karasuyama,
normally at Hoshakuji and under the wire of the main line, and one visitor's ten minutes of charging that took a set
home. All else is assumed, and each assumption is tried here at both ends of what could be, one at a time.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from functools import partial
from typing import Any, Final

import numpy as np
import polars as pl

from network.clock import clock
from papers.parameter_sets import LINE
from papers.reproduction import CaseRow, NullMethod, Options, Parameter, UnjudgedFigure
from papers.specification import Findings, Specification
from scenario.battery_choice import heated_trains
from scenario.scenario import Scenario, load_scenario
from simulation.setup import Setup
from study.record.wait import Cause
from study.runner.run import CarrierKind, FinishedRun, PartyLink, execute
from vehicle.train_file import TrainType

SCENARIO: Final = "karasuyama_battery"
ARRIVE: Final = "trains that arrive"
UNBALANCED_PERCENT_MAX: Final = 0.1
HOME_KM: Final = 32.1  # Karasuyama to Utsunomiya, of which 20.4 on this line
LINE_KM: Final = 20.4
TOLD_MIN: Final = 10.0  # one visitor's minutes of charging that took a set home
REGENERATION: Final = "battery.regeneration_max_w"
REFUSED_KWH: Final = (
    10.0  # a day: about a hundredth of what comes back, beyond what the taper of a full one refuses
)
CAPACITY: Final = "capacity_share"
CAPACITY_SHARE: Final = 0.9  # of new, as assumed
# of the battery: key, unit, what makes that of the key's own, and the ends of what could be
ASSUMED: Final = (
    ("resistance_ohm", "ohm", 1.0, (0.01, 0.1)),
    (CAPACITY, "of new", 1.0, (0.7, 1.0)),
    ("soc_low", "of full", 1.0, (0.05, 0.3)),
    ("soc_high", "of full", 1.0, (0.85, 1.0)),
    ("taper_from_soc", "of full", 1.0, (0.5, 0.88)),
    ("charge_max_w", "kW", 1e-3, (200e3, 600e3)),
    ("regeneration_max_w", "kW", 1e-3, (100e3,)),
    ("discharge_max_w", "kW", 1e-3, (350e3,)),
)

Change = Callable[[Setup], Setup]


@dataclass(frozen=True, slots=True)
class TriedAssumption:
    """One assumption at one other value."""

    what: str
    assumed: str
    value: str
    change: Change


def _run(scenario: Scenario, change: Change) -> FinishedRun:
    return execute(
        replace(scenario, setup=change(scenario.setup)), PartyLink.SIMULATED, carrier=CarrierKind.PLAIN
    )


# what is judged ---------------------------------------------------------------------------------------------


def _rows(day: FinishedRun) -> Iterator[CaseRow]:
    for unit, figures in day.summary["battery"].items():
        at = f"{clock(round(figures['lowest_at_s']))[:5]}, {figures['lowest_train']}"
        ours = f"{100.0 * figures['soc_lowest']:.1f} % at {at}; {figures['margin_kwh']:.1f} kWh above the reserve"
        good = figures["margin_kwh"] > 0.0 and figures["missing_kwh"] == 0.0
        yield CaseRow(f"{unit}: lowest charge of the day", None, ours, good, "above what is to be kept back")
    worst = max(abs(figures["unbalanced_percent"]) for figures in day.summary["battery"].values())
    yield CaseRow(
        "energy in the battery against in, out and lost",
        None,
        f"{worst:.4f} %",
        worst <= UNBALANCED_PERCENT_MAX,
        f"within {UNBALANCED_PERCENT_MAX} %",
    )
    yield arrival_row(day)


def arrival_row(day: FinishedRun) -> CaseRow:
    """Whether every set comes home."""
    arrived, planned = day.summary["trains_arrived"], day.summary["trains_planned"]
    whole = arrived == planned and not day.broken
    return CaseRow(ARRIVE, planned, arrived, whole, "all, and nothing broken")


def _limited_row(day: FinishedRun, tried: TriedAssumption, limited: FinishedRun) -> CaseRow:
    """The limit on what motors give back does something where it can: as assumed they never reach it."""
    refused, free = _refused_kwh(limited), _refused_kwh(day)
    return CaseRow(
        f"could have come back and was not taken, with {tried.value} from the motors, kWh",
        None,
        f"{refused:.1f}; with {tried.assumed} {free:.1f}",
        refused >= free + REFUSED_KWH,
        f"at least {REFUSED_KWH:g} kWh more: no motor reaches {tried.assumed}",
    )


def _refused_kwh(run: FinishedRun) -> float:
    return float(run.tables.energy["rejected_kwh"].sum())


def _home(day: FinishedRun) -> UnjudgedFigure:
    """Ten minutes at Karasuyama against what the way home takes, at this day's energy a kilometre up the line.

    Not judged: the power that the battery takes was chosen by this story, so that it cannot check it.
    """
    charges = day.tables.charges.filter(pl.col("station") == "KRS")
    needs_kwh = _up_kwh(day)
    kwh_per_km = needs_kwh / LINE_KM
    longer = charges.filter(pl.col("minutes") > TOLD_MIN, pl.col("soc_from") < pl.col("soc_to") - 0.05)
    first = longer.sort("from_s").row(0, named=True)
    ten_kwh = _gain_kwh(day, first["unit"], first["from_s"])
    home_kwh = kwh_per_km * HOME_KM
    verdict = "enough" if ten_kwh >= home_kwh else f"{home_kwh - ten_kwh:.0f} kWh too little"
    text = (
        f"{ten_kwh:.0f} kWh, by {first['train']}'s set; all {HOME_KM} km on the battery take {home_kwh:.0f} kWh at the"
        f" {kwh_per_km:.2f} kWh/km of this line: {verdict}"
    )
    return UnjudgedFigure(
        "ten minutes' charging, and the way home",
        text,
        "one visitor saw it suffice; no independent check, since charge_max_kw of the train was chosen by that",
    )


def _up_kwh(day: FinishedRun) -> float:
    """What a train takes from Karasuyama to Hoshakuji, mean over those of the day."""
    legs = day.tables.energy_legs
    ups = legs.filter(pl.col("from_station") == "KRS")["train"].unique().to_list()
    own = legs.filter(pl.col("train").is_in(ups), ~pl.col("to_station").str.contains(".", literal=True))
    return float(own["net_kwh"].sum()) / len(ups)


def _gain_kwh(day: FinishedRun, unit: str, from_s: float) -> float:
    """What the battery gains in the first ten minutes of a charge."""
    rows = day.tables.battery.filter(pl.col("unit") == unit)
    at_s, kwh = rows["t_s"].to_numpy(), rows["stored_kwh"].to_numpy()
    both = np.interp((from_s, from_s + 60.0 * TOLD_MIN), at_s, kwh)
    return float(both[1] - both[0])


# what is tried ----------------------------------------------------------------------------------------------


def _tried(base: Setup) -> Iterator[TriedAssumption]:
    """Every assumption at the ends of what could be."""
    settings = base.battery
    assert settings is not None
    for key, unit, scale, values in ASSUMED:
        for value in values:
            change = partial(_battery, key=key, value=value)
            yield TriedAssumption(
                f"battery.{key}", _now(base, key, scale, unit), f"{value * scale:g} {unit}", change
            )
    for heating_kw in (15.0, 40.0):
        yield TriedAssumption(
            "heating", "0 kW", f"{heating_kw:g} kW", partial(_heated, heating_kw=heating_kw)
        )
    for station, power_kw in (("KRS", 150.0), ("KRS", 800.0), ("HSK", 50.0), ("HSK", 400.0)):
        assumed = f"{base.line.chargers[station].power_w / 1e3:g} kW"
        yield TriedAssumption(
            f"charger of {station}",
            assumed,
            f"{power_kw:g} kW",
            partial(_charger, station=station, power_kw=power_kw),
        )
    beyond = settings.beyond
    yield TriedAssumption(
        "charging off the line", f"{beyond.charge_min:g} min", "0 min", partial(_beyond, charge_min=0.0)
    )
    yield TriedAssumption(
        "off the line",
        "from the wire",
        "2 kWh/km from the battery",
        partial(_beyond, consumption_kwh_per_km=2.0),
    )
    yield TriedAssumption(
        "charge as the day begins", "100 % of the window", "40 %", partial(_settings, start_share=0.4)
    )


def _now(base: Setup, key: str, scale: float, unit: str) -> str:
    battery = _first(base)
    if key == CAPACITY:
        return f"{CAPACITY_SHARE:g} of new"
    return f"{float(battery['pack'][key][0]) * scale:g} {unit}"


def _first(setup: Setup) -> Any:  # noqa: ANN401
    return next(kind.battery for kind in setup.trains.values() if kind.battery is not None)


def _battery(setup: Setup, key: str, value: float) -> Setup:
    return replace(setup, trains={s: _with(kind, key, value) for s, kind in setup.trains.items()})


def _with(kind: TrainType, key: str, value: float) -> TrainType:
    if kind.battery is None:
        return kind
    row = kind.battery.copy()
    if key == CAPACITY:
        row["full_c"] *= value / CAPACITY_SHARE
    else:
        row["pack"][key] = value
    if key == "charge_max_w":  # a battery that takes more has the current for it
        row["pack"]["charge_max_a"] = max(float(row["pack"]["charge_max_a"][0]), value / 500.0)
    return replace(kind, battery=row)


def _heated(setup: Setup, heating_kw: float) -> Setup:
    changed = _settings(setup, heating_kw=heating_kw)
    assert changed.battery is not None
    return replace(changed, trains=heated_trains(setup.trains, changed.battery))


def _no_chargers(setup: Setup) -> Setup:
    return replace(setup, line=replace(setup.line, chargers={}))


def _charger(setup: Setup, station: str, power_kw: float) -> Setup:
    chargers = dict(setup.line.chargers)
    chargers[station] = replace(chargers[station], power_w=power_kw * 1e3)
    return replace(setup, line=replace(setup.line, chargers=chargers))


def _beyond(setup: Setup, **values: float) -> Setup:
    assert setup.battery is not None
    return _settings(setup, beyond=setup.battery.beyond.model_copy(update=values))


def _settings(setup: Setup, **values: object) -> Setup:
    assert setup.battery is not None
    return replace(setup, battery=setup.battery.model_copy(update=values))


def _margin_kwh(run: FinishedRun) -> float:
    return min(float(figures["margin_kwh"]) for figures in run.summary["battery"].values())


def _figure(tried: TriedAssumption, run: FinishedRun) -> tuple[float, UnjudgedFigure]:
    """The lowest margin of any set with an assumption changed, and what became of the day."""
    margins = {unit: figures["margin_kwh"] for unit, figures in run.summary["battery"].items()}
    unit = min(margins, key=lambda name: margins[name])
    at = run.summary["battery"][unit]
    text = "; ".join((f"{margins[unit]:.1f} kWh ({unit}, {at['lowest_train']})", *_became(run)))
    name = f"{tried.what}: {tried.value} instead of {tried.assumed}"
    return margins[unit], UnjudgedFigure(name, text, "lowest margin of a set above the reserve")


def _became(run: FinishedRun) -> Iterator[str]:
    """What became of a day: trains and lateness, sets that waited for their charge, and who did not arrive and why."""
    summary, late_s = run.summary, run.summary["late_s_max"]
    late = "none" if late_s is None else f"{late_s:.0f} s"
    yield f"{summary['trains_arrived']} of {summary['trains_planned']} trains, {late} late at most"
    waits = run.tables.waits.filter(pl.col("cause") == Cause.UNABLE.value)
    if not waits.is_empty():
        trains = ", ".join(sorted(waits["train"].unique()))
        minutes = float((waits["to_s"] - waits["from_s"]).sum()) / 60.0
        yield f"{trains} waited for charge, {minutes:.0f} min in all"
    missing_kwh = sum(figures["missing_kwh"] for figures in summary["battery"].values())
    if missing_kwh > 0.05:
        yield f"{missing_kwh:.1f} kWh asked of batteries and not to be had"
    yield from (f"{w.number} did not arrive: {w.waits_for}" for w in run.result.waiting)


def _ranking(figures: list[tuple[float, UnjudgedFigure]], base_kwh: float) -> str:
    """Which assumption costs most."""
    lowest = sorted(figures, key=lambda pair: pair[0])[:3]
    named = "; ".join(f"{figure.name} ({kwh - base_kwh:+.1f} kWh)" for kwh, figure in lowest)
    return f"As assumed the lowest margin is {base_kwh:.1f} kWh. What takes most of it: {named}."


def _parameters(setup: Setup) -> Iterator[Parameter]:
    battery, settings = _first(setup), setup.battery
    assert settings is not None
    yield Parameter("energy of the battery when new", 190.0, "kWh", "published: 2 x 95 kWh at 630 V")
    for key, unit, scale, _ in ASSUMED:
        if key != CAPACITY:
            value = float(battery["pack"][key][0]) * scale
            yield Parameter(
                key.removesuffix("_w"), value, unit, "assumed: vehicle/trains/ev_e301_losses.toml"
            )
    for charger in setup.line.chargers.values():
        name = f"charger of {charger.station_id}"
        yield Parameter(name, charger.power_w / 1e3, "kW", "assumed: network/lines/karasuyama.toml")
    yield Parameter("reserve", settings.reserve_share, "of the window", "assumed: a tenth")
    yield Parameter("charging off the line", settings.beyond.charge_min, "min", "assumed: under the wire")


def experiment(options: Options) -> Findings:
    """Run the day as assumed, then with each assumption at the ends of its range."""
    scenario = load_scenario(SCENARIO, options.seed)
    day = _run(scenario, lambda setup: setup)
    tried = tuple(_tried(scenario.setup))
    if options.quick:
        tried = (*tried[:2], *(one for one in tried if one.what == REGENERATION))
    figures: list[tuple[float, UnjudgedFigure]] = []
    limited: list[CaseRow] = []
    for one in tried:  # a run holds a day's tables: not all of them at once
        run = _run(scenario, one.change)
        figures.append(_figure(one, run))
        limited += [_limited_row(day, one, run)] if one.what == REGENERATION else []
    return Findings(
        (*_rows(day), *limited),
        _parameters(scenario.setup),
        REMARKS if options.quick else (*REMARKS, _ranking(figures, _margin_kwh(day))),
        (_home(day), *(figure for _, figure in figures)),
    )


def uncharged(options: Options) -> Iterator[CaseRow]:
    """The day on what the batteries have as it begins."""
    yield arrival_row(_run(load_scenario(SCENARIO, options.seed), _no_chargers))


REMARKS: Final = (
    "Assumptions are changed one at a time; a set that has too little waits for its charge, so that a bad"
    " assumption shows as lateness or as trains that do not arrive before it shows as a lower margin.",
    "A set that has waited runs late and at the limits, and takes more than it reckoned with for a run on time: so"
    " its margin may be below 0 kWh, which is what the reserve is for.",
    "A power that moves nothing is not what binds: beside it stand the battery's own limit or the charger's, and"
    " stays at Karasuyama that fill the battery in any case.",
)
reproduce: Final = Specification(
    "battery-day",
    "A Karasuyama weekday on batteries",
    experiment,
    NullMethod("no charger on the line", (ARRIVE,), uncharged),
    LINE,
    "quick: three of the assumptions alone are tried",
)
