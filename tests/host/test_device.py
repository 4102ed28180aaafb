"""The device host: order of work, durable state, boots; and the configurations it starts from."""

from pathlib import Path
from typing import Any

import msgspec
import pytest

from host.device import DeviceHost
from host.devices import DeviceAdvance
from host.store import Durable, FileStore, MemoryStore, PartyStore
from network.errors import InputError
from network.model import Position
from radio.envelope import Endpoint, Received
from radio.keys import key_ring
from radio.messages import (
    AnyMessage,
    Claim,
    ClaimQuery,
    HoldingReport,
    PointsCommand,
    PointsProof,
    Restarted,
    RouteGranted,
    RouteRequest,
    SignOff,
    SignOn,
    SignOnAccepted,
)
from radio.noted import TelegramDropped, TookEffect
from tests.host.one_unit import MANAGER, MASTER, TERMINAL
from wayside.config import (
    MANAGER_ID,
    CrossingConfig,
    ManagerConfig,
    TerminalConfig,
    decode_config,
    encode_config,
)
from wayside.level_crossing import CrossingDevice, CrossingMemory, CrossingState
from wayside.point_terminal import Commitment, TerminalMemory
from wayside.said import (
    BoundaryPassed,
    ConfirmHolding,
    ConfirmOutside,
    InputRefused,
    PointsCommanded,
    PointsDetected,
    Refused,
    Started,
    StartThrow,
    StopThrow,
)


def manager(store: PartyStore | None = None) -> DeviceHost:
    return DeviceHost(MANAGER, key_ring(MASTER, MANAGER_ID, ["u1"], ["t"]), store or MemoryStore())


def terminal(store: PartyStore | None = None) -> DeviceHost:
    return DeviceHost(TERMINAL, key_ring(MASTER, "t", ["u1"], ["t"]), store or MemoryStore())


def unit(epoch: int = 1) -> Endpoint:
    return Endpoint(key_ring(MASTER, "u1", [MANAGER_ID, "t"]), epoch)


def heard(train: Endpoint, advance: DeviceAdvance, now_s: float) -> list[AnyMessage]:
    messages = []
    for destination, data in advance.telegrams:
        assert destination == "u1"
        opened = train.open(data, now_s)
        assert isinstance(opened, Received), opened
        messages.append(opened.message)
    return messages


def granted(train: Endpoint) -> RouteGranted:
    """Sign on at the portal, ask for the route, get it."""
    host = manager()
    host.advance(0.0, [], [ConfirmOutside("u1", "Sato")])
    sign_on = SignOn("u1", ("P",))
    (accepted,) = heard(train, host.advance(0.2, [train.seal(MANAGER_ID, sign_on, 0.2)]), 0.2)
    assert isinstance(accepted, SignOnAccepted)
    request = train.seal(MANAGER_ID, RouteRequest("u1", "R", ("S", "T")), 0.3, 1)
    (answer,) = heard(train, host.advance(0.3, [request]), 0.3)
    assert isinstance(answer, RouteGranted)
    return answer


def command(grant: RouteGranted, position: Position = Position.REVERSE) -> PointsCommand:
    (capability,) = grant.capabilities
    return PointsCommand("p", position, "S", grant.token, capability.mac)


def test_from_sign_on_to_proof() -> None:
    train, host = unit(), terminal()
    host.advance(0.0, [], [PointsDetected("p", Position.NORMAL, True)])
    thrown = host.advance(1.0, [train.seal("t", command(granted(train)), 1.0, 2)])
    assert thrown.outputs == (StartThrow("p", Position.REVERSE),)
    assert thrown.telegrams == ()
    assert thrown.wake_at_s == 9.0
    proven = host.advance(7.0, [], [PointsDetected("p", Position.REVERSE, True)])
    (proof,) = heard(train, proven, 7.0)
    assert isinstance(proof, PointsProof)
    assert (proof.position, proof.locked, proof.detected) == (Position.REVERSE, True, True)
    assert proven.wake_at_s is None


@pytest.mark.parametrize("shows_s", [0.5, 1.0 - 3600.0])
def test_a_throw_has_its_time_though_the_clock_is_set_back(shows_s: float) -> None:
    train, host = unit(), terminal()
    host.advance(0.0, [], [PointsDetected("p", Position.NORMAL, True)])
    host.advance(1.0, [train.seal("t", command(granted(train)), 1.0, 2)])
    limit_s = host.advance(shows_s, []).wake_at_s  # no time has passed
    assert limit_s == pytest.approx(shows_s + 8.0)
    assert not host.advance(shows_s + 7.9, []).outputs
    assert host.advance(shows_s + 8.0, []).outputs == (StopThrow("p"),)


def test_every_boot_has_a_new_epoch_and_says_so() -> None:
    store = MemoryStore()
    for epoch in (1, 2, 3):
        host = manager(store)
        assert host.epoch == epoch
        (note, *_) = host.advance(0.0, []).notes
        assert note == Started(epoch=epoch)


def test_a_terminal_remembers_its_tokens_over_a_power_cut() -> None:
    train, store = unit(), MemoryStore()
    grant = granted(train)
    terminal(store).advance(1.0, [train.seal("t", command(grant), 1.0)])
    expected = TerminalMemory({"S": grant.token}, {"p": Commitment("u1", Position.REVERSE, grant.token)})
    assert msgspec.msgpack.decode(store.load().vital, type=TerminalMemory) == expected
    again = terminal(store)
    found = again.advance(2.0, [], [PointsDetected("p", Position.REVERSE, True)])
    assert isinstance(heard(train, found, 2.0)[0], PointsProof)


def test_a_telegram_for_the_boot_before_takes_no_effect_and_is_answered() -> None:
    train, store = unit(), MemoryStore()
    host = terminal(store)
    host.advance(0.0, [], [PointsDetected("p", Position.REVERSE, True)])
    grant = granted(train)
    heard(train, host.advance(1.0, [train.seal("t", command(grant), 1.0)]), 1.0)
    again = terminal(store)
    answer = again.advance(2.0, [train.seal("t", command(grant), 2.0)])
    assert [type(note) for note in answer.notes] == [Started, TelegramDropped]
    assert heard(train, answer, 2.0) == [Restarted()]
    # Now it knows the new boot; the command repeated counts.
    answer = again.advance(3.0, [train.seal("t", command(grant), 3.0)])
    assert PointsCommanded in [type(note) for note in answer.notes]


def test_what_answers_the_boot_before_of_a_unit_is_not_said_to_the_next_one() -> None:
    """Both are heard in one step: sealed for who was heard last, the first answer would count as one to the second."""
    before, host = unit(1), terminal()
    grant = granted(before)
    host.advance(0.0, [], [PointsDetected("p", Position.REVERSE, True)])
    after = unit(2)
    sent = [before.seal("t", command(grant), 1.0, 1), after.seal("t", command(grant), 1.0, 2)]
    opened = [after.open(data, 1.0) for _, data in host.advance(1.0, sent).telegrams]
    assert [one.correlation for one in opened if isinstance(one, Received)] == [2]


def test_noise_and_copies_change_nothing() -> None:
    train, host = unit(), manager()
    data = train.seal(MANAGER_ID, Claim((), 0), 0.0)
    notes = host.advance(0.0, [b"noise", data, data]).notes
    started, noise, heard_first, repeated = notes
    assert started == Started(epoch=1)
    unread = {"source": None, "epoch": None, "sequence": None, "kind": None, "correlation": None}
    assert noise == TelegramDropped(receiver=MANAGER_ID, why="corrupted", **unread)
    telegram = {
        "source": "u1",
        "receiver": MANAGER_ID,
        "epoch": 1,
        "sequence": 0,
        "kind": "Claim",
        "correlation": 0,
    }
    assert heard_first == TookEffect(**telegram)
    assert repeated == TelegramDropped(why="repeated", **telegram)


def test_inputs_and_messages_for_other_devices_are_refused() -> None:
    train = unit()
    notes = manager().advance(0.0, [], [PointsDetected("p", None, False)]).notes
    assert InputRefused(why="PointsDetected") in notes
    host = terminal()
    advance = host.advance(0.0, [train.seal("t", ClaimQuery(), 0.0)], [ConfirmOutside("u1", "Sato")])
    assert [type(note) for note in advance.notes] == [Started, InputRefused, TookEffect, Refused]
    assert advance.telegrams == ()


def test_keys_of_another_device_are_refused() -> None:
    with pytest.raises(InputError, match="the keys of t"):
        DeviceHost(TERMINAL, key_ring(MASTER, "other", ["u1"], ["t"]), MemoryStore())


def test_the_same_telegrams_give_the_same_bytes() -> None:
    def run() -> list[DeviceAdvance]:
        train, host = unit(), manager()
        return [
            host.advance(0.0, [], [ConfirmOutside("u1", "Sato")]),
            host.advance(0.1, [train.seal(MANAGER_ID, SignOn("u1", ("P",)), 0.1)]),
        ]

    assert run() == run()


def test_a_lost_ledger_stays_lost_until_a_device_has_a_new_one(tmp_path: Path) -> None:
    store = FileStore(tmp_path / "durable")
    store.save(Durable(1, spare=None))
    assert store.load().spare is None
    manager(store).advance(0.0, [])
    # Any unit may be on the line, and anywhere on it.
    assert store.load() == Durable(2, spare=msgspec.msgpack.encode((("u1",), ("S", "T"), {}, (), {}, {})))


def test_a_ledger_that_cannot_be_read_is_a_lost_one_and_a_memory_is_no_start() -> None:
    store = MemoryStore()
    store.save(Durable(1, spare=b"\xc1"))
    manager(store).advance(0.0, [])
    assert ledger(store) == ("u1",)
    assert unswept(store) == ("S", "T")
    store.save(Durable(1, vital=b"\xc1"))
    with pytest.raises(InputError, match="a terminal's memory"):
        terminal(store)


EMPTY = msgspec.msgpack.encode(CrossingMemory())


@pytest.mark.parametrize(
    ("boots", "vital", "contacts", "state"),
    [
        (0, b"", True, CrossingState.OPEN),  # it never ran
        (1, EMPTY, False, CrossingState.OPEN),
        (1, EMPTY, True, CrossingState.CLOSING),  # fronts may have passed in the dark
        (1, b"", False, CrossingState.CLOSING),
        (1, b"\xc1", False, CrossingState.CLOSING),
    ],
)
def test_a_crossing_that_may_have_forgotten_a_train_begins_closed(
    boots: int, vital: bytes, contacts: bool, state: CrossingState
) -> None:
    store, config = MemoryStore(), CrossingConfig("line", "C", True, 15.0, 20.0, contacts=contacts)
    store.save(Durable(boots, vital))
    crossing = DeviceHost(config, key_ring(MASTER, "C", ["u1"], ["t"]), store).state
    assert isinstance(crossing, CrossingDevice) and crossing.state is state


def remembered(store: PartyStore) -> tuple[tuple[str, ...], tuple[str, ...], dict[str, int], tuple[str, ...]]:
    kept = tuple[
        tuple[str, ...],
        tuple[str, ...],
        dict[str, int],
        tuple[str, ...],
        dict[str, dict[int, str]],
        dict[str, dict[int, str]],
    ]
    return msgspec.msgpack.decode(store.load().spare or b"\xc0", type=kept)[:4]


def ledger(store: PartyStore) -> tuple[str, ...]:
    return remembered(store)[0]


def unswept(store: PartyStore) -> tuple[str, ...]:
    return remembered(store)[1]


def test_what_must_be_swept_is_kept_over_a_power_cut_until_a_train_has_run_through_it() -> None:
    train, store = unit(), MemoryStore()
    host = manager(store)
    host.advance(0.0, [], [ConfirmHolding("u1", ("S", "T"), "Sato")])
    assert (ledger(store), unswept(store)) == (("u1",), ())
    host.advance(1.0, [], [ConfirmOutside("u1", person, "P") for person in ("Sato", "Mori")])
    assert (ledger(store), unswept(store)) == ((), ("S", "T"))
    again = manager(store)
    assert unswept(store) == ("S", "T")
    heard(train, again.advance(2.0, [train.seal(MANAGER_ID, Claim((), 0), 2.0)]), 2.0)
    for now_s, claimed in ((3.0, ()), (4.0, ("S", "T"))):
        data = train.seal(MANAGER_ID, Claim(claimed, 0), now_s)
        answer = heard(train, again.advance(now_s, [data]), now_s)[-1]
    assert isinstance(answer, SignOnAccepted)
    assert answer.on_sight == ("S", "T")
    swept = train.seal(MANAGER_ID, HoldingReport(("T",), answer.token, ("S",)), 5.0)
    again.advance(5.0, [swept])
    assert unswept(store) == ("T",)


def test_the_ledger_is_kept_before_the_unit_is_told_and_until_it_has_left() -> None:
    train, store = unit(), MemoryStore()
    host = manager(store)
    host.advance(0.0, [], [ConfirmOutside("u1", "Sato")])
    assert ledger(store) == ()
    entered = host.advance(0.2, [train.seal(MANAGER_ID, SignOn("u1", ("P",)), 0.2)])
    assert ledger(store) == ("u1",)
    (accepted,) = heard(train, entered, 0.2)
    assert isinstance(accepted, SignOnAccepted)
    again = manager(store)
    assert ledger(store) == ("u1",)
    (query,) = heard(train, again.advance(1.0, []), 1.0)
    assert query == ClaimQuery()
    heard(train, again.advance(1.2, [train.seal(MANAGER_ID, Claim(("P",), accepted.token), 1.2)]), 1.2)
    heard(train, again.advance(1.4, [train.seal(MANAGER_ID, SignOff("u1", accepted.token), 1.4)]), 1.4)
    assert ledger(store) == ("u1",)
    again.advance(1.6, [], [BoundaryPassed("P")])
    assert ledger(store) == ()


class Watched(MemoryStore):
    """Writes down when something was kept."""

    def __init__(self, order: list[str]) -> None:
        super().__init__()
        self.order = order

    def save(self, durable: Durable) -> None:
        super().save(durable)
        self.order.append("kept")


def test_what_changes_is_kept_before_a_telegram_of_it_is_made(monkeypatch: pytest.MonkeyPatch) -> None:
    """A boot before all else, a unit that comes onto the line, and what points are locked for."""
    order: list[str] = []
    seal = Endpoint.seal

    def sealed(self: Endpoint, *what: Any) -> bytes:  # noqa: ANN401 - as it is
        order.append(f"said by {self.owner}")
        return seal(self, *what)

    monkeypatch.setattr(Endpoint, "seal", sealed)
    train, grant = unit(), granted(unit(2))
    host = manager(Watched(order))
    host.advance(0.0, [], [ConfirmOutside("u1", "Sato")])
    data = train.seal(MANAGER_ID, SignOn("u1", ("P",)), 0.2)
    del order[:]
    host.advance(0.2, [data])
    assert order == ["kept", f"said by {MANAGER_ID}"]
    points = terminal(Watched(order))
    points.advance(0.0, [], [PointsDetected("p", Position.REVERSE, True)])
    data = train.seal("t", command(grant), 1.0)
    del order[:]
    points.advance(1.0, [data])
    assert order == ["kept", "said by t"]


def test_a_unit_on_the_line_cannot_be_struck_off_the_fleet_list() -> None:
    store = MemoryStore()
    store.save(Durable(1, spare=msgspec.msgpack.encode((("u9",), ()))))
    with pytest.raises(InputError, match=r"unit_ids.*expected a fleet list with u9"):
        manager(store)


@pytest.mark.parametrize("config", [MANAGER, TERMINAL])
def test_configurations_survive_their_file(config: ManagerConfig | TerminalConfig) -> None:
    assert decode_config(encode_config(config)) == config


@pytest.mark.parametrize("data", [b"", b"{}", b'{"type":"toaster"}', b'{"type":"point-terminal"}'])
def test_configurations_that_cannot_be_read(data: bytes) -> None:
    with pytest.raises(InputError, match=r"config\.json.*expected the configuration"):
        decode_config(data)
