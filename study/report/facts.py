"""The headline: what a planner looks for first, in English and in Japanese; and what was broken."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Final

import polars as pl

from network.files.raw import is_table
from study.measures.summary import NEVER_CAME, OFF_MARK_M
from study.record.energy import PARTS, TrainEnergy
from study.record.figure import figures_of
from study.record.marks import DrillShown
from study.record.parts import Fact, signed
from study.record.told import TelegramsOfWay
from study.report.data import ReportedRun, place_name
from study.report.style import clock
from study.wording.outcome import EXPECTED, OUTSIDE_LINE, ending_text
from study.wording.phrase import Phrase
from vehicle.train_file import RegenerationReceiver

_WHAT_JA: Final[Mapping[str, str]] = {"arrival": "着", "departure": "発", NEVER_CAME: "未着"}


def headline(run: ReportedRun, facts: Mapping[str, Any], drill: DrillShown | None = None) -> tuple[Fact, ...]:
    """The figures of the run, each with its name, in both languages."""
    planned, arrived = facts["trains_planned"], facts["trains_arrived"]
    telegrams = facts["telegrams"]
    counts = [
        (said.name, telegrams[name]) for name, said in figures_of(TelegramsOfWay).items() if name in telegrams
    ]
    parties = ", ".join(str(party) for party in facts.get("parties", ()))
    return (
        *_drill_fact(drill),
        Fact(
            "Trains arrived",
            f"{arrived} of {planned} planned",
            arrived < planned,
            "到着列車",
            f"計画 {planned} 本中 {arrived} 本",
        ),
        _invariants(facts),
        *_ending(facts),
        *_lateness(run, facts),
        *_margin(run, facts),
        _stops(run, facts),
        energy_fact(facts, run.tables.energy),
        parts_fact(facts),
        Fact(
            "Telegrams",
            ", ".join(f"{count:,} {said.en}" for said, count in counts),
            False,
            "電文",
            "、".join(f"{said.ja} {count:,}" for said, count in counts),
        ),
        Fact("Parties", parties or "not recorded", False, "装置", parties or "記録なし"),
        *(
            Fact(name, str(facts.get(key, "not recorded")), False, name_ja, str(facts.get(key, "記録なし")))
            for name, key, name_ja in (
                ("Seed", "seed", "乱数の種"),
                ("Journal digest", "digest", "記録の要約値"),
                ("Motion digest", "motion_digest", "走行の要約値"),
            )
        ),
    )


def _drill_fact(drill: DrillShown | None) -> tuple[Fact, ...]:
    if drill is None:
        return ()
    verdict = drill.verdict()
    return (Fact("Drill", verdict.en, not drill.passed, "訓練", verdict.in_("ja")),)


def _lateness(run: ReportedRun, facts: Mapping[str, Any]) -> tuple[Fact, ...]:
    """The latest arrival or departure and the earliest departure, each with its place in the table of delays."""

    def where(at: Mapping[str, Any] | None) -> str:
        return "" if at is None else f", {at['what']} of {at['train']} at {place_name(run, at['station'])}"

    def where_ja(at: Mapping[str, Any] | None) -> str:
        if at is None:
            return ""
        return f"（{at['train']} {place_name(run, at['station'], japanese=True)} {_WHAT_JA[at['what']]}）"

    late_s, early_s = facts["late_s_max"], float(facts["early_departure_s_max"])
    missing = facts["trains_planned"] - facts["trains_arrived"]
    if late_s is None:
        latest = Fact("Worst lateness", "no train arrived", True, "最大遅延", "到着列車なし")
    else:
        at = facts.get("late_at")
        text = f"{late_s:.0f} s{where(at)}" if late_s > 0.0 else "none late"
        text_ja = f"{late_s:.0f} 秒{where_ja(at)}" if late_s > 0.0 else "遅延なし"
        more = f"; {missing} train{'s' if missing > 1 else ''} did not arrive" if missing else ""
        more_ja = f"（{missing} 本未着）" if missing else ""
        latest = Fact("Worst lateness", text + more, missing > 0, "最大遅延", text_ja + more_ja)
    at = facts.get("early_at")
    before = f"{early_s:.0f} s before plan{where(at)}" if early_s else "none before plan"
    before_ja = f"計画より {early_s:.0f} 秒早発{where_ja(at)}" if early_s else "早発なし"
    return latest, Fact("Earliest departure", before, early_s >= 1, "最大早発", before_ja)


def _invariants(facts: Mapping[str, Any]) -> Fact:
    """How many rules were broken; that a train has not arrived is one, and said apart."""
    named = len(facts.get("violations", ()))
    all_of_them = max(int(facts.get("invariants_broken", named)), named)
    missing = all_of_them - named
    if not all_of_them:
        return Fact("Invariants broken", "none", False, "不変条件の違反", "なし")
    apart = f", {missing} of them that a train has not arrived" if missing else ""
    apart_ja = f"（うち未着 {missing}）" if missing else ""
    return Fact(
        "Invariants broken", f"{all_of_them}{apart}", True, "不変条件の違反", f"{all_of_them} 件{apart_ja}"
    )


def _ending(facts: Mapping[str, Any]) -> tuple[Fact, ...]:
    """Why the run ended, and that something was missing then."""
    if "ended_because" not in facts:
        return ()
    why = ending_text(str(facts["ended_because"]))
    return (Fact("Ended because", why.en, bool(facts.get("unfinished")), "終了理由", why.in_("ja")),)


def _margin(run: ReportedRun, facts: Mapping[str, Any]) -> tuple[Fact, ...]:
    """The smallest margins in one line, red where the plan cannot be kept; nothing where no hop has times."""
    margins = facts["margins"]
    if not margins:
        return ()
    least = margins["smallest_margin_s"]
    text, text_ja = (_hop_named(run, least, japanese=japanese) for japanese in (False, True))
    tightest = margins.get("smallest_margin_percent", least)
    if _hop(tightest) != _hop(least):
        text += f"; in percent {_hop_named(run, tightest)}"
        text_ja += f"、率では {_hop_named(run, tightest, japanese=True)}"
    return (Fact("Smallest margin", text, least["margin_s"] < 0.0, "最小余裕時分", text_ja),)


def _hop(row: Mapping[str, Any]) -> tuple[str, str, str]:
    return row["train"], row["from_station"], row["to_station"]


def _hop_named(run: ReportedRun, row: Mapping[str, Any], *, japanese: bool = False) -> str:
    percent = row["margin_percent"]
    share = "" if percent is None else f" ({signed(percent, 0, '%')})"
    here, there = (place_name(run, row[f"{end}_station"], japanese=japanese) for end in ("from", "to"))
    seconds = signed(row["margin_s"], 0, "秒" if japanese else "s")
    return f"{seconds}{share}, {row['train']} {here} – {there}"


def _stops(run: ReportedRun, facts: Mapping[str, Any]) -> Fact:
    mean_m, sigma_m, worst_m = (facts[f"stop_error_m_{name}"] for name in ("mean", "sigma", "max_abs"))
    if mean_m is None:
        return Fact("Stops", "none measured", False, "停止位置", "測定なし")
    sigma = "" if sigma_m is None else f", σ {sigma_m:.3f} m"
    mean = signed(mean_m, 3, "m")
    off, at = facts["stops_off"], facts["stop_off_at"]
    more = more_ja = ""
    if at is not None:
        place, place_ja = (place_name(run, at["station"], japanese=japanese) for japanese in (False, True))
        more = f"; {off} more than {OFF_MARK_M:g} m off, the worst {at['train']} at {place}"
        more_ja = f"、{OFF_MARK_M:g} m 超 {off} 回（最大は {at['train']} {place_ja}）"
    return Fact(
        "Stops",
        f"{facts['stops']}: mean {mean}{sigma}, worst {worst_m:.3f} m from the mark{more}",
        at is not None,
        "停止位置",
        f"{facts['stops']} 回、平均 {mean}{sigma}、最大誤差 {worst_m:.3f} m{more_ja}",
    )


def energy_fact(facts: Mapping[str, Any], energy_table: pl.DataFrame) -> Fact:
    """Net energy of the day in one line."""
    energy = facts["energy"]
    whole, per_km, per_car = energy["all"], energy["net_kwh_per_train_km"], energy["net_kwh_per_car_km"]
    distance = net_by_distance(energy)
    at, at_ja = drawn_at(energy_table)
    text = (
        f"{whole['net']:,.1f} kWh net {at}: traction {whole['traction']:,.1f},"
        f" auxiliary {whole['auxiliary']:,.1f}, regenerated {whole['regenerated']:,.1f}"
    )
    text_ja = (
        f"正味 {whole['net']:,.1f} kWh（{at_ja}）：力行 {whole['traction']:,.1f}、"
        f"補機 {whole['auxiliary']:,.1f}、回生 {whole['regenerated']:,.1f}"
    )
    if distance:
        text += f"; {distance}"
        text_ja += (
            f"；{per_km['trains']:.2f} kWh/列車キロ（{per_car['trains']:.2f} kWh/車両キロ）、"
            f"折返しを含め {per_km['all']:.2f}（{per_car['all']:.2f}）"
        )
    return Fact("Energy", text, False, "電力量", text_ja)


# Parts that say what of the others is lost, or that nothing is.
_NO_PARTS: Final = ("rejected_kwh", "residual_kwh")


def parts_fact(facts: Mapping[str, Any]) -> Fact:
    """Where the day's net energy went, in one line; what is nothing is not named."""
    energy = facts["energy"]
    parts, auxiliary = energy["parts"], energy["all"]["auxiliary"]
    of = figures_of(TrainEnergy)
    told = [(of[name].name, parts[name.removesuffix("_kwh")]) for name in PARTS if name not in _NO_PARTS]
    told = [(said, kwh) for said, kwh in sorted(told, key=lambda row: -row[1]) if abs(kwh) >= 0.05]
    told.insert(0, (of["auxiliary_kwh"].name, auxiliary))
    text = ", ".join(f"{said.en} {kwh:,.1f}" for said, kwh in told)
    text_ja = "、".join(f"{said.ja} {kwh:,.1f}" for said, kwh in told)
    if parts["rejected"] >= 0.05:
        text += f"; {parts['rejected']:,.1f} could have come back and was not taken"
        text_ja += f"；回生失効 {parts['rejected']:,.1f}"
    return Fact("Where it went", f"{text} kWh", False, "電力量の内訳", f"{text_ja} kWh")


def net_by_distance(energy: Mapping[str, Any]) -> str:
    """Net energy by distance, of the trains and with their layovers; empty where none moved."""
    per_km, per_car = energy["net_kwh_per_train_km"], energy["net_kwh_per_car_km"]
    if per_km["all"] is None:
        return ""
    return (
        f"{per_km['trains']:.2f} kWh/train-km ({per_car['trains']:.2f} per car-km),"
        f" {per_km['all']:.2f} ({per_car['all']:.2f}) with layovers"
    )


def drawn_at(energy: pl.DataFrame) -> tuple[str, str]:
    """Where energy is counted, in both languages: at the wire, or at the battery of trains that charge their own."""
    receivers = set(energy["regenerated_to"])
    if receivers == {RegenerationReceiver.BATTERY.value}:
        return "at the battery", "蓄電池端"
    if RegenerationReceiver.BATTERY.value in receivers:
        return "at the wire or battery", "架線または蓄電池端"
    return "at the wire", "架線端"


def broken_lines(facts: Mapping[str, Any]) -> tuple[Phrase, ...]:
    """Broken invariants, what else failed, what happened outside the design, unmet expectations, as lines of text."""
    return (
        *(_violation(item) for item in facts.get("violations", ())),
        *(phrase_of(text) for text in facts.get("broken", ())),
        *(OUTSIDE_LINE.of(what=phrase_of(text)) for text in facts.get("outside_design", ())),
        *(EXPECTED.of(what=phrase_of(text)) for text in facts.get("broken_expectations", ())),
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
