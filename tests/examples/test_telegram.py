"""The recipe "a telegram" of docs/make-a.md, followed: "hold at the next station", from manager to unit."""

import json
from pathlib import Path
from typing import Any

import pytest

from tests.examples.conftest import Clone, cloned, files_of

HERE = Path(__file__).parent / "telegram"
ASKED_FROM_S = 10 * 3600.0 - 45.0  # a route is asked for 45 s before the departure
RELEASED_S = 10 * 3600.0 + 300.0
MESSAGE = '''

class HoldAtStation(Message, frozen=True, array_like=True, tag=25):
    """Manager to unit: at your next stop stay, and ask for no route; or no more (発車抑止). It restricts alone."""

    hold: bool
'''
INPUT = '''

class HoldTrain(msgspec.Struct, frozen=True, array_like=True, tag=7):
    """Operator to manager: have this train held back at its next stop, or let it go."""

    unit_id: str
    person: str
    hold: bool


'''
ACT = '''def _hold_train(register: Register, event: HoldTrain) -> Step:
    """Told to the unit; the register stays as it is."""
    return register, (Send(event.unit_id, HoldAtStation(event.hold)),)


'''
EVENT = '''class HeldBack(msgspec.Struct, frozen=True, tag=True):
    """The manager has the train stay at its next stop, or no more."""

    hold: bool


'''


def with_telegram(clone: Clone) -> Clone:
    clone.write(
        "radio/messages.py",
        (
            'while the contradiction lasts.\n    """\n\n    section_ids: tuple[str, ...]\n',
            MESSAGE,
        ),
        ("    | Restarted\n", "    | HoldAtStation\n"),
    )
    clone.write(
        "wayside/said.py",
        ('has looked at the whole line as it is shown; it is right."""\n\n    person: str\n', INPUT),
        ("    | UnbarUnit\n", "    | HoldTrain\n"),
    )
    clone.write(
        "wayside/acts.py",
        ("from typing import Any, Final\n\n", "from radio.messages import HoldAtStation\n"),
        (
            "from wayside.actions import Show\n",
            "from wayside.actions import Send\nfrom wayside.said import HoldTrain\n",
        ),
        ("Act = ConfirmOutside | ConfirmHolding | EnterSection | AcceptPicture | TakeBack", " | HoldTrain"),
        ("_Handler = Callable[[Register, Any], Step]\n", "\n\n" + ACT),
        (
            "UNIT_ACTS: Final[Mapping[tuple[LineState, UnitStanding, type], _Handler]] = MappingProxyType(\n    {\n",
            "        **{(state, standing, HoldTrain): _hold_train\n"
            "           for state in LineState for standing in UnitStanding},\n",
        ),
    )
    clone.add(HERE / "hold.py", "onboard/authority/hold.py")
    clone.write(
        "onboard/authority/records.py",
        ("    unsaid: tuple[PointsNeeded, ...] = ()\n", "    held_back: bool = False  # at its next stop\n"),
        ('nothing that was sent before is known to have arrived."""\n\n\n', EVENT),
        ("    | PointsDenialHeard\n    | PeerRestarted\n", "    | HeldBack\n"),
    )
    clone.write(
        "onboard/authority/letters.py",
        (
            "    radio.Restarted: lambda _letters, _heard, _message: sym.PeerRestarted(),\n",
            "    radio.HoldAtStation: lambda _self, _heard, message: sym.HeldBack(message.hold),\n",
        ),
    )
    clone.write(
        "onboard/authority/machine.py",
        (
            "from onboard.authority import agreement, points, report, route, sign_on\n",
            "from onboard.authority import hold\n",
        ),
        ("        **report.TABLE,\n", "        **hold.TABLE,\n"),
    )
    clone.write(
        "onboard/duty/machine.py",
        (
            "            duty.actions.append(Finished(duty.plan.number))\n        return\n",
            "    if state.authority.held_back:\n        return\n",
        ),
    )
    return clone


def asked_s(figures: dict[str, Any]) -> list[float]:
    return [now_s for now_s, who, what in figures["said"] if (who, what) == ("K1", "RouteRequest")]


def test_held_back_a_train_asks_for_no_route_until_it_is_let_go(tmp_path: Path) -> None:
    made = with_telegram(cloned(tmp_path))
    assert made.touched == files_of("telegram")
    told = made.succeeds(str(HERE / "conversation.py"), "neither", "hold", "release")
    free, held, released = (json.loads(figures) for figures in told.splitlines())
    assert asked_s(free) == [ASKED_FROM_S]
    assert asked_s(held) == []
    assert asked_s(released)[0] == pytest.approx(RELEASED_S + 1.0)
    sent = [now_s for now_s, _, what in released["said"] if what == "HoldAtStation"]
    assert sent == [RELEASED_S - 600.0, RELEASED_S]
    assert held["held"] == ["3"]  # the track where it stands stays its own
    assert len(free["held"]) > 1
