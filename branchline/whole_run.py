"""A scenario run into its run directory, as `branchline run` and `branchline.run` do it."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from contextlib import nullcontext
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from branchline.ending import crashes_into, stopped_at_once
from branchline.extras import needing_extra
from branchline.progress import print_aside, progress_of
from host.over_tls import check_endpoint
from network.errors import COMMAND_LINE, InputError
from scenario.scenario import Scenario
from simulation.carriers.sumo_api import STEP_DELAY_MS
from study.feasibility.check import refuse
from study.record.directory import reserved
from study.runner.run import (
    NO_MORE,
    CarrierKind,
    FinishedRun,
    PartyLink,
    carrier_of,
    end_room_bytes,
    execute,
    fill_run,
    link_of,
    units_at,
)

if TYPE_CHECKING:  # only who compares needs what draws both graphs, and who listens what reads certificates
    from host.elsewhere import Elsewhere
    from study.compare.against import RunAgainst
    from study.compare.side import ComparedRun


@dataclass(frozen=True, slots=True)
class RunAsked:
    """How a scenario is to be run. `against`: the directory of a run to compare it with, by times over `over_s`.

    InputError where it cannot be asked so.
    """

    link: str = "simulated"
    units: str = "simulator"
    carrier: str = CarrierKind.SUMO.value
    against: Path | None = None
    over_s: float = 1.0
    anyway: bool = False
    gui: bool = False
    gui_delay_ms: int = STEP_DELAY_MS
    elsewhere: Elsewhere | None = None

    def __post_init__(self) -> None:
        units_at(self.units, link_of(self.link))
        if carrier_of(self.carrier) is not CarrierKind.SUMO and self.gui:
            raise InputError(COMMAND_LINE, "--gui", None, "--carrier sumo, which alone has a window")


@dataclass(frozen=True, slots=True)
class WholeRun:
    """A run in its directory, with its report, and what changed from another one."""

    done: FinishedRun
    report: Path
    compared: RunAgainst | None


def run_whole(
    scenario: Scenario,
    directory: Path,
    asked: RunAsked,
    *,
    progress: bool,
    stop: Callable[[], bool] | None = None,
) -> WholeRun:
    """Run and write all of it or nothing, or what there is when `stop` says so; its progress stands on stderr.

    Raises InputError where plan or directory do not allow it, CutShortError where it was cut short, Crashed for a bug.
    """
    days = scenario.setup.tuning.days
    if asked.elsewhere is not None and days > 1:
        raise InputError(scenario.called, "tuning.days", days, "1 with --listen: parties join for one day")
    plan = refuse(scenario.called, scenario.setup, anyway=asked.anyway)
    if progress and not plan.on_time:
        print_aside(f"{plan.verdict}; branchline check {scenario.called} shows all")
    base = None if asked.against is None else _base_of(asked.against, scenario)
    link = link_of(asked.link)
    with reserved(directory) as place:
        place.hold_room(end_room_bytes(scenario.setup))
        shown = progress_of(scenario.id) if progress else nullcontext()
        with crashes_into(directory), shown as told:
            done = execute(
                scenario,
                link,
                units=units_at(asked.units, link),
                carrier=CarrierKind.SUMO_GUI if asked.gui else carrier_of(asked.carrier),
                progress=told,
                journal=place.journal,
                delay_ms=asked.gui_delay_ms,
                stop=stop,
                say=print_aside if progress else None,
                elsewhere=asked.elsewhere,
            )
        if progress:
            print_aside("writing the report")
        compared = None if base is None else _compared(done, base, asked.over_s)
        report = fill_run(done, place, more=NO_MORE if compared is None else compared.more)
    return WholeRun(done, report, compared)


def elsewhere_of(
    link: str, listen: str | None, certificates: Path | None, party_ids: Sequence[str]
) -> Elsewhere | None:
    """The parties on other machines, as options name them; InputError where they do not go together."""
    if listen is None:
        return None
    if link_of(link) is not PartyLink.ZENOH:
        raise InputError(COMMAND_LINE, "--listen", listen, "--link zenoh, which processes need")
    check_endpoint("--listen", listen)
    if certificates is None:
        expected = "--certificates, without which nobody would be let in (branchline certificates makes them)"
        raise InputError(COMMAND_LINE, "--listen", listen, expected)
    with needing_extra("tls", "run --listen"):
        from host.elsewhere import Elsewhere
    return Elsewhere(listen, certificates.resolve(), tuple(party_ids), stopped_at_once)


def _base_of(directory: Path, scenario: Scenario) -> ComparedRun:
    """The run to compare with; read before the new one, which may be bound for its place."""
    from study.compare.against import base_of

    return base_of(directory, scenario.setup.line)


def _compared(done: FinishedRun, base: ComparedRun, over_s: float) -> RunAgainst:
    """What changed since."""
    from study.compare.against import changes_from_base

    return changes_from_base(done, base, over_s)
