"""The headline: what a planner looks for first, in English and in Japanese; and what was broken."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Final

import polars as pl

from network.raw import is_table
from simulation.tolerance import OFF_MARK_M
from study.record.energy import PARTS, TrainEnergy
from study.record.figure import figures_of
from study.record.journal_rows import TelegramsOfWay
from study.record.marks import DrillShown
from study.record.parts import Fact, signed_number
from study.report.data import ReportedRun, place_said
from study.report.style import clock
from study.wording.catalogue import phrase
from study.wording.outcome import EXPECTED, OUTSIDE_LINE, ending_text
from study.wording.phrase import NOTHING, Phrase, joined_phrases
from vehicle.train_file import RegenerationReceiver

_NOT_RECORDED: Final = phrase("not recorded")
_DIGESTS: Final = {
    "seed": phrase("Seed"),
    "digest": phrase("Journal digest"),
    "motion_digest": phrase("Motion digest"),
}


def headline(run: ReportedRun, facts: Mapping[str, Any], drill: DrillShown | None = None) -> tuple[Fact, ...]:
    """The figures of the run, each with its name, in both languages."""
    planned, arrived = facts["trains_planned"], facts["trains_arrived"]
    telegrams = facts["telegrams"]
    counts = [
        phrase("{count} {what}").fill(count=f"{telegrams[name]:,}", what=said.name)
        for name, said in figures_of(TelegramsOfWay).items()
        if name in telegrams
    ]
    parties = ", ".join(str(party) for party in facts.get("parties", ()))
    arrived_said = phrase("{arrived} of {planned} planned").fill(arrived=arrived, planned=planned)
    return (
        *(() if drill is None else (Fact(phrase("Drill"), drill.verdict(), not drill.passed),)),
        Fact(phrase("Trains arrived"), arrived_said, arrived < planned),
        *_cut(facts),
        _invariants(facts),
        *_ending(facts),
        *_lateness(run, facts),
        *_margin(run, facts),
        _stops(run, facts),
        energy_fact(facts, run.tables.energy),
        parts_fact(facts),
        Fact(phrase("Telegrams"), joined_phrases(counts)),
        Fact(phrase("Parties"), Phrase(parties) if parties else _NOT_RECORDED),
        *(
            Fact(name, Phrase(str(facts[key])) if key in facts else _NOT_RECORDED)
            for key, name in _DIGESTS.items()
        ),
    )


def _cut(facts: Mapping[str, Any]) -> tuple[Fact, ...]:
    """How many trains the dispatcher left out; nothing where he left out none."""
    whole, part = facts.get("trains_cancelled", 0), facts.get("trains_shortened", 0)
    if not whole and not part:
        return ()
    said = phrase("{whole} whole, {part} in part").fill(whole=whole, part=part)
    return (Fact(phrase("Cancelled by the dispatcher"), said, True),)


def _lateness(run: ReportedRun, facts: Mapping[str, Any]) -> tuple[Fact, ...]:
    """The latest arrival or departure and the earliest departure, each with its place in the table of delays."""

    def where(at: Mapping[str, Any] | None) -> Phrase:
        if at is None:
            return NOTHING
        place = place_said(run, at["station"])
        return phrase(", {what} of {train} at {place}").fill(
            what=phrase(at["what"]), train=at["train"], place=place
        )

    late_s, early_s = facts["late_s_max"], facts["early_departure_s_max"]
    missing = facts["trains_planned"] - facts["trains_arrived"]
    if late_s is None:
        latest = phrase("no train arrived")
    else:
        at = where(facts.get("late_at"))
        latest = (
            phrase("{late_s:.0f} s{where}").fill(late_s=late_s, where=at)
            if late_s > 0.0
            else phrase("none late")
        )
        if missing:
            one = phrase("; {count} train did not arrive")
            latest = joined_phrases(
                (latest, (one if missing == 1 else _SOME_MISSING).fill(count=missing)), "", ""
            )
    at = where(facts.get("early_at"))
    early = phrase("no train departed") if early_s is None else phrase("none before plan")
    if early_s:
        early = phrase("{early_s:.0f} s before plan{where}").fill(early_s=early_s, where=at)
    return (
        Fact(phrase("Worst lateness"), latest, late_s is None or missing > 0),
        Fact(phrase("Earliest departure"), early, (early_s or 0.0) >= 1),
    )


_SOME_MISSING: Final = phrase("; {count} trains did not arrive")


def _invariants(facts: Mapping[str, Any]) -> Fact:
    """How many rules were broken; that a train has not arrived is one, and named apart."""
    named = len(facts.get("violations", ()))
    all_of_them = max(int(facts.get("invariants_broken", named)), named)
    missing = all_of_them - named
    broken = phrase("{count}, {missing} of them that a train has not arrived" if missing else "{count}")
    text = broken.fill(count=all_of_them, missing=missing) if all_of_them else phrase("none")
    return Fact(phrase("Invariants broken"), text, all_of_them > 0)


def _ending(facts: Mapping[str, Any]) -> tuple[Fact, ...]:
    """Why the run ended, and that something was missing then."""
    if "ended_because" not in facts:
        return ()
    why = ending_text(str(facts["ended_because"]))
    return (Fact(phrase("Ended because"), why, bool(facts.get("unfinished"))),)


def _margin(run: ReportedRun, facts: Mapping[str, Any]) -> tuple[Fact, ...]:
    """The smallest margins in one line, red where the plan cannot be kept; nothing where no hop has times."""
    margins = facts["margins"]
    if not margins:
        return ()
    least = margins["smallest_margin_s"]
    text = _hop_named(run, least)
    tightest = margins.get("smallest_margin_percent", least)
    if _hop(tightest) != _hop(least):
        text = phrase("{least}; in percent {tightest}").fill(least=text, tightest=_hop_named(run, tightest))
    return (Fact(phrase("Smallest margin"), text, least["margin_s"] < 0.0),)


def _hop(row: Mapping[str, Any]) -> tuple[str, str, str]:
    return row["train"], row["from_station"], row["to_station"]


def _hop_named(run: ReportedRun, row: Mapping[str, Any]) -> Phrase:
    percent = row["margin_percent"]
    return phrase("{seconds} s{share}, {train} {here} – {there}").fill(
        seconds=signed_number(row["margin_s"]),
        share="" if percent is None else f" ({signed_number(percent, 0, '%')})",
        train=row["train"],
        here=place_said(run, row["from_station"]),
        there=place_said(run, row["to_station"]),
    )


def _stops(run: ReportedRun, facts: Mapping[str, Any]) -> Fact:
    mean_m, sigma_m, worst_m = (facts[f"stop_error_m_{name}"] for name in ("mean", "sigma", "max_abs"))
    if mean_m is None:
        return Fact(phrase("Stops"), phrase("none measured"))
    sigma = "" if sigma_m is None else f", σ {sigma_m:.3f} m"
    at, more = facts["stop_off_at"], NOTHING
    if at is not None:
        more = phrase("; {count} more than {off_m:g} m off, the worst {train} at {place}").fill(
            count=facts["stops_off"],
            off_m=OFF_MARK_M,
            train=at["train"],
            place=place_said(run, at["station"]),
        )
    said = phrase("{count}: mean {mean}{sigma}, worst {worst_m:.3f} m from the mark{more}").fill(
        count=facts["stops"], mean=signed_number(mean_m, 3, "m"), sigma=sigma, worst_m=worst_m, more=more
    )
    return Fact(phrase("Stops"), said, at is not None)


def energy_fact(facts: Mapping[str, Any], energy_table: pl.DataFrame) -> Fact:
    """Net energy of the day in one line."""
    energy = facts["energy"]
    text = phrase(
        "{net:,.1f} kWh net {at}: traction {traction:,.1f}, auxiliary {auxiliary:,.1f},"
        " regenerated {regenerated:,.1f}"
    ).fill(at=drawn_at(energy_table), **energy["all"])
    return Fact(phrase("Energy"), joined_phrases((text, net_by_distance(energy)), "; ", "；"))


# Parts that say what of the others is lost, or that nothing is.
_NO_PARTS: Final = ("rejected_kwh", "residual_kwh")


def parts_fact(facts: Mapping[str, Any]) -> Fact:
    """Where the day's net energy went, in one line; what is nothing is not named."""
    energy = facts["energy"]
    parts, auxiliary = energy["parts"], energy["all"]["auxiliary"]
    of = figures_of(TrainEnergy)
    largest = [(of[name].name, parts[name.removesuffix("_kwh")]) for name in PARTS if name not in _NO_PARTS]
    largest = [(text, kwh) for text, kwh in sorted(largest, key=lambda row: -row[1]) if abs(kwh) >= 0.05]
    largest.insert(0, (of["auxiliary_kwh"].name, auxiliary))
    text = joined_phrases(phrase("{what} {kwh:,.1f}").fill(what=what, kwh=kwh) for what, kwh in largest)
    text = phrase("{parts} kWh").fill(parts=text)
    if parts["rejected"] >= 0.05:
        lost = phrase("{kwh:,.1f} kWh could have come back and was not taken").fill(kwh=parts["rejected"])
        text = joined_phrases((text, lost), "; ", "；")
    return Fact(phrase("Where it went"), text)


def net_by_distance(energy: Mapping[str, Any]) -> Phrase:
    """Net energy by distance, of the trains and with their layovers; empty where none moved."""
    per_km, per_car = energy["net_kwh_per_train_km"], energy["net_kwh_per_car_km"]
    if per_km["all"] is None:
        return NOTHING
    return phrase(
        "{trains:.2f} kWh/train-km ({car_trains:.2f} per car-km), {all:.2f} ({car_all:.2f}) with layovers"
    ).fill(trains=per_km["trains"], car_trains=per_car["trains"], all=per_km["all"], car_all=per_car["all"])


def drawn_at(energy: pl.DataFrame) -> Phrase:
    """Where energy is counted: at the wire, or at the battery of trains that charge their own."""
    receivers = set(energy["regenerated_to"])
    if receivers == {RegenerationReceiver.BATTERY.value}:
        return phrase("at the battery")
    if RegenerationReceiver.BATTERY.value in receivers:
        return phrase("at the wire or battery")
    return phrase("at the wire")


def broken_lines(facts: Mapping[str, Any]) -> tuple[Phrase, ...]:
    """Broken invariants, what else failed, what happened outside the design, unmet expectations, as lines of text."""
    return (
        *(_violation(item) for item in facts.get("violations", ())),
        *(phrase_of(text) for text in facts.get("broken", ())),
        *(OUTSIDE_LINE.fill(what=phrase_of(text)) for text in facts.get("outside_design", ())),
        *(EXPECTED.fill(what=phrase_of(text)) for text in facts.get("broken_expectations", ())),
    )


def _violation(item: object) -> Phrase:
    if not is_table(item):
        return phrase_of(item)
    at = f"{clock(item['t_s'], seconds=True)} " if item.get("t_s") is not None else ""
    text = f"{at}{item.get('checker', '')}: {item.get('text', '')}"
    return Phrase(text, f"{at}{item['ja']}" if item.get("ja") else "")


def phrase_of(text: object) -> Phrase:
    """A text, which may be in both languages."""
    return text if isinstance(text, Phrase) else Phrase(str(text))
