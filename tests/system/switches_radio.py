"""What the envelope refuses, let pass."""

from collections.abc import Callable, Sequence
from itertools import repeat

import msgspec
import pytest

from onboard.authority.letters import Letters
from onboard.unit import OnboardUnit, Report, Telegram, UnitAnswer
from radio import envelope as env
from radio.envelope import DropReason, Envelope, Peer, header_of, kind_of
from radio.keys import MAC_BYTES
from radio.messages import HoldingReport
from simulation.world import radio as world_radio
from tests.system.switchboard import switch

# envelope -----------------------------------------------------------------------------------------------------


def anywhere(_receiver: str) -> bool:
    return True


def on_board(receiver: str) -> bool:
    return receiver.startswith("K")


def at_the_ground(receiver: str) -> bool:
    return not on_board(receiver)


def lets_pass(patch: pytest.MonkeyPatch, *let: DropReason, where: Callable[[str], bool] = anywhere) -> None:
    check = env.check

    def lax(
        peer: Peer, envelope: Envelope, own_epoch: int, now_s: float, age_max_s: float
    ) -> tuple[Peer, DropReason | None]:
        heard, reason = check(peer, envelope, own_epoch, now_s, age_max_s)
        return (peer, None) if reason in let and where(envelope.destination) else (heard, reason)

    patch.setattr(env, "check", lax)


@switch
def accepts_telegrams_twice(patch: pytest.MonkeyPatch) -> None:
    lets_pass(patch, DropReason.REPEATED)


@switch
def ground_accepts_telegrams_twice(patch: pytest.MonkeyPatch) -> None:
    """Manager and terminals alone."""
    lets_pass(patch, DropReason.REPEATED, where=at_the_ground)


@switch
def units_accept_telegrams_twice(patch: pytest.MonkeyPatch) -> None:
    lets_pass(patch, DropReason.REPEATED, where=on_board)


@switch
def obeys_an_earlier_boot(patch: pytest.MonkeyPatch) -> None:
    lets_pass(patch, DropReason.OLD_EPOCH)


@switch
def obeys_whenever(patch: pytest.MonkeyPatch) -> None:
    """Units take telegrams however late, and each for the answer to what is outstanding."""
    lets_pass(patch, DropReason.STALE, DropReason.OUT_OF_ORDER, where=on_board)
    patch.setattr(Letters, "_answers", lambda *_: True)


def kind_of_data(data: bytes) -> str | None:
    """Kind of the message in a telegram that is sound."""
    envelope = header_of(data)
    return None if envelope is None else kind_of(envelope)


@switch
def forges_a_report(patch: pytest.MonkeyPatch) -> None:
    """Given: with each request of K2 goes a report in the name of K1, code and all made up: 'I hold 3 alone'."""
    advance, token, sent = OnboardUnit.advance, [0], [1000]

    def forging(self: OnboardUnit, now_s: float, telegrams: Sequence[bytes], sensed: Report) -> UnitAnswer:
        answer = advance(self, now_s, telegrams, sensed)
        if self.unit_id == "K1":
            token[0] = self._letters.token
            return answer
        requests = [
            telegram for telegram in answer.telegrams if kind_of_data(telegram.data) == "RouteRequest"
        ]
        return msgspec.structs.replace(
            answer, telegrams=(*map(forged, requests, repeat(now_s)), *answer.telegrams)
        )

    def forged(request: Telegram, now_s: float) -> Telegram:
        sent[0] += 1
        report = msgspec.Raw(msgspec.msgpack.encode(HoldingReport(("3",), token[0])))
        false = Envelope("K1", request.destination, 1, 1, sent[0], now_s, None, 0, report)
        data = msgspec.msgpack.encode(false) + bytes(MAC_BYTES)
        return Telegram(request.destination, data)

    patch.setattr(OnboardUnit, "advance", forging)


@switch
def believes_any_code(patch: pytest.MonkeyPatch) -> None:
    patch.setattr(env, "mac_equal", lambda *_: True)


@switch
def hears_the_first_network_alone(patch: pytest.MonkeyPatch) -> None:
    patch.setattr(world_radio, "combined", lambda first, _second, _sent: first)


@switch
def takes_what_both_networks_bring(patch: pytest.MonkeyPatch) -> None:
    """A telegram that comes over two networks comes twice, and the envelope lets it."""
    patch.setattr(world_radio, "combined", lambda first, second, _sent: (*first, *second))
    accepts_telegrams_twice(patch)
