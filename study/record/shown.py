"""What a run directory needs besides tables, summary and inputs so that its report can be made anew from it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass, field
from itertools import zip_longest
from pathlib import Path
from typing import Any

import msgspec
import numpy as np

from network.files.json_input import read_json
from onboard.driving.tuning import Learned, StopDecelerations
from scenario.inputs import Inputs
from simulation.judge.checkers import Checker
from simulation.result import RunResult
from study.record.marks import DrillShown
from study.record.parts import PagePart
from study.wording.outcome import rule_text
from study.wording.phrase import Phrase


@dataclass(frozen=True, slots=True)
class RuleBroken:
    """A broken invariant: when, which, and how, in words; `ja`: all of it in Japanese."""

    t_s: float
    checker: str
    text: str
    ja: str = ""


@dataclass(frozen=True, slots=True)
class Waves:
    """The last stop that a train counted; see `onboard.driving.tuning.StopRecord`."""

    designed_mps2: tuple[float, ...]
    actual_mps2: tuple[float, ...]
    slid: bool
    load_share: float


@dataclass(frozen=True, slots=True)
class LearnedTrain:
    """What a train has learned, and the waves of the last stop that it counted."""

    learned: Learned
    stop: StopDecelerations


@dataclass(frozen=True, slots=True)
class Shown:
    """Parties by name, rules broken, what else failed (texts), last stops of trains that learn by unit, the drill,
    and the `parts` that come before all others.

    `tables` are the digests of the tables' files: a damaged one must not come before a decoder that trusts it.
    """

    parties: tuple[str, ...] = ()
    violations: tuple[RuleBroken, ...] = ()
    broken: tuple[str, ...] = ()
    waves: dict[str, Waves] = field(default_factory=dict[str, Waves])
    drill: DrillShown | None = None
    tables: dict[str, str] = field(default_factory=dict[str, str])
    parts: tuple[PagePart, ...] = ()
    broken_ja: tuple[str, ...] = ()  # the same in Japanese, where they are known in it

    def as_json(self) -> bytes:
        """The file's text."""
        return msgspec.json.encode(self) + b"\n"

    def facts(self, summary: Mapping[str, Any], inputs: Inputs) -> dict[str, Any]:
        """What `study.report.report.write_report` takes as the summary."""
        return {
            **summary,
            "scenario": inputs.scenario["name"],
            "parties": list(self.parties),
            "violations": [asdict(rule) for rule in self.violations],
            "broken": [
                Phrase(text, ja) for text, ja in zip_longest(self.broken, self.broken_ja, fillvalue="")
            ],
            "broken_expectations": [] if self.drill is None else list(self.drill.unmet()),
            "assumed": list(inputs.assumed),
        }

    def tuned(self, learned: Mapping[str, Learned]) -> dict[str, LearnedTrain]:
        """What each train that learns has learned, with its last stop, by unit."""
        return {
            unit: LearnedTrain(known, _record(self.waves[unit]))
            for unit, known in learned.items()
            if unit in self.waves
        }


def shown_of(
    result: RunResult,
    broken: tuple[Phrase, ...],
    terminals: tuple[str, ...],
    drill: DrillShown | None,
    tables: dict[str, str],
) -> Shown:
    """What the report shows of a run; trains that did not arrive are named once."""
    rules = [v for v in result.violations if v.checker != Checker.EVERYONE_ARRIVES]
    rule_texts = {rule_text(v).en for v in rules}
    apart = [sentence for sentence in broken if sentence.en not in rule_texts]
    return Shown(
        parties=(*result.stock_ids, "block-manager", *terminals),
        violations=tuple(RuleBroken(v.t_s, str(v.checker), v.text, rule_text(v).in_("ja")) for v in rules),
        broken=tuple(sentence.en for sentence in apart),
        broken_ja=tuple(sentence.in_("ja") for sentence in apart),
        waves={unit: _waves(stop) for unit, stop in result.learned_from.items()},
        drill=drill,
        tables=tables,
    )


def read_shown(path: Path) -> Shown:
    """What `Shown.as_json` wrote. Raises InputError for anything else."""
    return read_json(path, Shown)


def _waves(stop: StopDecelerations) -> Waves:
    return Waves(
        tuple(stop.designed_mps2.tolist()), tuple(stop.actual_mps2.tolist()), stop.slid, stop.load_share
    )


def _record(waves: Waves) -> StopDecelerations:
    return StopDecelerations(
        np.array(waves.designed_mps2, dtype=np.float64),
        np.array(waves.actual_mps2, dtype=np.float64),
        waves.slid,
        waves.load_share,
    )
