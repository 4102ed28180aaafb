"""Fencing tokens counted anew: of a token only matters which others are the same, greater or less.

Tokens in use anywhere on the line are bits of one number, fifteen to each boot of the manager; counted anew, those of
each boot are 1, 2, 3 ... in their order, and the manager's counter is the greatest, so that its next token is new to
all. Codes of capabilities follow their tokens.
"""

from __future__ import annotations

from collections.abc import Iterable
from functools import cache
from typing import Final

from msgspec.structs import replace

from onboard.authority.letters import CommandedPoints
from radio.keys import capability_mac
from radio.messages import AnyMessage, Capability, PointsCommand, RouteGranted, SignOnAccepted
from verify.explored_line import BOOTS, CAPABILITY_KEYS, UNITS
from verify.manager import ManagerState
from verify.manager import plain as plain_register
from verify.on_air import InAir
from verify.terminal import TerminalState
from verify.terminal import plain as plain_terminal
from verify.train import TrainState
from wayside.point_terminal import TerminalMemory

A_BOOT: Final = 15  # tokens that one boot of the manager may have in use
_SECTION: Final = "X"  # the only one with points
_BOOT: Final = (1 << A_BOOT) - 1


def bits_of(tokens: Iterable[int]) -> int:
    """Tokens as bits; OverflowError where the model holds no more."""
    bits = 0
    for token in tokens:
        if token:
            epoch, counter = token >> 32, token & 0xFFFFFFFF
            if counter > A_BOOT or epoch > BOOTS:
                raise OverflowError(f"token {counter} of boot {epoch}: the model holds {A_BOOT} of {BOOTS}")
            # The token that a boot begins with, before it has given any, is none.
            bits |= 1 << (epoch - 1) * A_BOOT + counter - 1 if counter else 0
    return bits


def of_boot(bits: int, epoch: int) -> int:
    """The bits of one boot."""
    return bits >> (epoch - 1) * A_BOOT & _BOOT


def in_order(bits: int, epoch: int, counter: int) -> bool:
    """Whether nothing is to be counted anew; `counter`: of the manager's boot `epoch`, negative without power."""
    parts = [of_boot(bits, boot) for boot in range(1, BOOTS + 1)]
    return all(part & part + 1 == 0 for part in parts) and counter in (-1, parts[epoch - 1].bit_count())


def anew(token: int, bits: int) -> int:
    """A token counted anew among those in use: how many of its boot are not greater."""
    epoch, counter = token >> 32, token & 0xFFFFFFFF
    return (epoch << 32) + (of_boot(bits, epoch) & (1 << counter) - 1).bit_count() if token else 0


@cache
def _codes() -> dict[bytes, tuple[str, str, int]]:
    """What each code of a capability stands for: terminal, unit and token."""
    return {
        capability_mac(key, terminal, _SECTION, unit, token): (terminal, unit, token)
        for terminal, key in CAPABILITY_KEYS.items()
        for unit in UNITS
        for epoch in range(1, BOOTS + 1)
        for token in range((epoch << 32), (epoch << 32) + A_BOOT + 1)
    }


def _code(mac: bytes, bits: int) -> bytes:
    known = _codes().get(mac)
    if known is None:
        return mac
    terminal, unit, token = known
    return capability_mac(CAPABILITY_KEYS[terminal], terminal, _SECTION, unit, anew(token, bits))


def of_train(train: TrainState) -> int:
    """Tokens that a unit knows, as bits."""
    numbers = train.numbers
    of_sections = (token for _, token in numbers.tokens)
    return bits_of((numbers.token, *of_sections, *(known.token for _, known in numbers.commanded)))


def train_anew(train: TrainState, bits: int) -> TrainState:
    """A unit with its tokens counted anew."""
    numbers = train.numbers
    return train._replace(
        numbers=numbers._replace(
            token=anew(numbers.token, bits),
            tokens=tuple((section, anew(token, bits)) for section, token in numbers.tokens),
            macs=tuple((key, _code(mac, bits)) for key, mac in numbers.macs),
            commanded=tuple(
                (points, CommandedPoints(anew(c.token, bits), _code(c.mac, bits), c.correlation))
                for points, c in numbers.commanded
            ),
        )
    )


def of_telegram(telegram: InAir) -> int:
    """The token of a telegram, as a bit."""
    return bits_of((getattr(telegram.message, "token", 0),))


def telegram_anew(telegram: InAir, bits: int) -> InAir:
    """A telegram with its token counted anew."""
    message: AnyMessage = telegram.message
    changes: dict[str, object] = {"token": anew(getattr(message, "token", 0), bits)}
    if isinstance(message, RouteGranted | SignOnAccepted):
        changes["capabilities"] = tuple(
            Capability(c.terminal_id, c.section_id, _code(c.mac, bits)) for c in message.capabilities
        )
    if isinstance(message, PointsCommand):
        changes["mac"] = _code(message.mac, bits)
    return telegram._replace(message=replace(message, **changes))


def of_manager(manager: ManagerState) -> int:
    """Tokens that the register has for units, as bits; its counter is not one."""
    return bits_of(unit.token for unit in manager.kept.register.units.values())


def manager_anew(manager: ManagerState, bits: int) -> ManagerState:
    """The manager with its tokens counted anew."""
    register = manager.kept.register
    units = {u: replace(known, token=anew(known.token, bits)) for u, known in register.units.items()}
    counter = of_boot(bits, manager.epoch).bit_count() if manager.power else 0
    return manager._replace(kept=plain_register(replace(register, units=units, counter=counter)))


def of_terminal(terminal: TerminalState) -> int:
    """Tokens that a terminal remembers, as bits."""
    memory = terminal.kept.terminal.memory
    return bits_of((*memory.tokens.values(), *(held.token for held in memory.commitments.values())))


def terminal_anew(terminal: TerminalState, bits: int) -> TerminalState:
    """A terminal with its tokens counted anew."""
    known = terminal.kept.terminal
    memory = TerminalMemory(
        {section: anew(token, bits) for section, token in known.memory.tokens.items()},
        {
            points: replace(held, token=anew(held.token, bits))
            for points, held in known.memory.commitments.items()
        },
        known.memory.bars,
    )
    return terminal._replace(kept=plain_terminal(replace(known, memory=memory)))
