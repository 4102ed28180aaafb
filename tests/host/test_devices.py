"""What starts the devices of a line, and their records as the parties carry them."""

import msgspec
import pytest

from host.boot import boot
from host.devices import CODEC, DeviceSaid, DeviceTold, device_specs
from host.party import Role
from host.store import MemoryStore, commission
from network.errors import InputError
from network.model import Position
from tests.host import one_unit
from tests.host.one_unit import MASTER
from wayside.config import MANAGER_ID, PointsEntry, SectionEntry, TerminalConfig, decode_config
from wayside.said import ConfirmOutside, PointsDetected, Started, StartThrow

STATION = SectionEntry("S", terminal_ids=("extra", "west"))
MANAGER = msgspec.structs.replace(
    one_unit.MANAGER,
    unit_ids=("u1", "u2"),
    sections=(SectionEntry("P", portal=True), STATION, SectionEntry("T")),
)
TERMINALS = [TerminalConfig("line", name, (PointsEntry("p", "S", 8.0),)) for name in ("extra", "west")]


def test_a_device_gets_no_keys_but_its_own() -> None:
    specs = device_specs(MANAGER, TERMINALS, MASTER)
    assert [(spec.party_id, spec.role, spec.line_id) for spec in specs] == [
        (MANAGER_ID, Role.BLOCK_MANAGER, "line"),
        ("extra", Role.POINT_TERMINAL, "line"),
        ("west", Role.POINT_TERMINAL, "line"),
    ]
    assert decode_config(specs[0].config) == MANAGER
    west = specs[2].keys
    assert (west.owner, set(west.pairs), set(west.capabilities)) == ("west", {"u1", "u2"}, {"west"})
    secrets = {spec.party_id: {*spec.keys.pairs.values()} for spec in specs}
    assert secrets["west"].isdisjoint(secrets["extra"] | secrets[MANAGER_ID])
    assert MASTER not in msgspec.json.encode(specs)


def test_records_survive_their_way() -> None:
    told = DeviceTold((ConfirmOutside("u", "x"), PointsDetected("p", None, False)))
    said = DeviceSaid((StartThrow("p", Position.REVERSE),), (Started(epoch=3),))
    assert CODEC.decode_told(CODEC.encode(told)) == told
    assert CODEC.decode_said(CODEC.encode(said)) == said


@pytest.mark.parametrize("data", [b"", b"\xc1", b"\x91\x01"])
def test_bytes_that_are_no_record_are_bad_input(data: bytes) -> None:
    with pytest.raises(InputError, match="a record of this role"):
        CODEC.decode_told(data)


@pytest.mark.parametrize(
    "change", [{"role": Role.BLOCK_MANAGER}, {"line_id": "other"}, {"party_id": "extra"}, {"config": b"{}"}]
)
def test_a_device_that_was_configured_for_something_else_does_not_start(change: dict[str, object]) -> None:
    (_, _, west) = device_specs(MANAGER, TERMINALS, MASTER)
    store, other = MemoryStore(), MemoryStore()
    commission(store)
    commission(other)
    assert boot(west, other).epoch == 1
    with pytest.raises(InputError, match=r"config\.json.*expected"):
        boot(msgspec.structs.replace(west, **change), store)
    assert store.load().epoch == 0
