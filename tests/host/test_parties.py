"""Parties in this process and over Zenoh: the same bytes, power cuts and boots."""

from collections.abc import Callable
from pathlib import Path

import pytest

from host.devices import DeviceAdvance, Devices, device_specs
from host.local import LocalParties
from host.over_zenoh import ZenohParties
from host.parties import Parties, PartyError
from host.party import PartySpec
from network.errors import InputError
from network.model import Position
from radio.envelope import Endpoint, Received
from radio.keys import key_ring
from radio.messages import PointsCommand, RouteGranted, RouteRequest, SignOn
from simulation.world import point_machine
from simulation.world.point_machine import PointMachine
from tests.host.one_unit import MANAGER, MASTER, TERMINAL
from wayside.config import MANAGER_ID
from wayside.said import ConfirmOutside, PointsDetected, Started, StartThrow


def specs() -> tuple[PartySpec, ...]:
    return device_specs(MANAGER, [TERMINAL], MASTER)


def local(_directory: Path) -> Parties:
    return LocalParties(specs())


def zenoh(directory: Path) -> Parties:
    return ZenohParties("line", specs(), directory)


links = pytest.mark.parametrize("make", [local, zenoh])


class Script:
    """One train and one machine against the devices; `log` has every answer."""

    def __init__(self, parties: Parties) -> None:
        self.parties = parties
        self.devices = Devices(parties)
        self.train = Endpoint(key_ring(MASTER, "u1", [MANAGER_ID, "t"]), 1)
        self.machine = PointMachine("p", 0.5, Position.NORMAL)
        self.log: list[tuple[str, DeviceAdvance]] = []
        self.grant: RouteGranted | None = None

    def ask(
        self, device: str, now_s: float, *telegrams: bytes, inputs: tuple[ConfirmOutside, ...] = ()
    ) -> None:
        given = [point_machine.detection(self.machine)] if device == "t" else list(inputs)
        advance = self.devices.advance(device, now_s, telegrams, given)
        self.log.append((device, advance))
        for _, data in advance.telegrams:
            opened = self.train.open(data, now_s)
            assert isinstance(opened, Received)
            if isinstance(opened.message, RouteGranted):
                self.grant = opened.message
        for output in advance.outputs:
            self.machine = point_machine.step(self.machine, output, now_s)

    def run(self) -> list[tuple[str, DeviceAdvance]]:
        train = self.train
        self.ask(MANAGER_ID, 0.0, inputs=(ConfirmOutside("u1", "Sato"),))
        for now_s in (0.1, 0.2):
            self.ask(MANAGER_ID, now_s, train.seal(MANAGER_ID, SignOn("u1", ("P",)), now_s, 1), b"noise")
        for now_s in (0.3, 0.4):
            request = RouteRequest("u1", "R", ("S", "T"))
            self.ask(MANAGER_ID, now_s, train.seal(MANAGER_ID, request, now_s, 2))
        assert self.grant is not None
        (capability,) = self.grant.capabilities
        command = PointsCommand("p", Position.REVERSE, "S", self.grant.token, capability.mac)
        self.ask("t", 0.5, train.seal("t", command, 0.5, 3))
        self.machine = point_machine.advance(self.machine, 1.0)
        self.ask("t", 1.0)
        for device in (MANAGER_ID, "t"):
            self.parties.kill(device)
            assert not self.parties.alive(device)
            self.parties.restart(device)
            assert self.parties.alive(device)
            self.ask(device, 2.0)
        return self.log


def test_both_links_give_the_same_bytes(tmp_path: Path) -> None:
    with local(tmp_path) as one:
        expected = Script(one).run()
    with zenoh(tmp_path) as other:
        found = Script(other).run()
    assert found == expected
    assert sum(len(advance.telegrams) for _, advance in found) >= 6
    assert any(isinstance(output, StartThrow) for _, advance in found for output in advance.outputs)


@links
@pytest.mark.parametrize("device_id", [MANAGER_ID, "t"])
def test_a_killed_party_is_down_and_comes_back_with_a_new_boot(
    tmp_path: Path, make: Callable[[Path], Parties], device_id: str
) -> None:
    with make(tmp_path) as parties:
        devices = Devices(parties)
        (note, *_) = devices.advance(device_id, 0.0, []).notes
        assert note == Started(epoch=1)
        with pytest.raises(PartyError, match="runs already"):
            parties.restart(device_id)
        for boot in (2, 3):
            parties.kill(device_id)
            parties.kill(device_id)
            with pytest.raises(PartyError, match=f"party {device_id} is down"):
                devices.advance(device_id, 0.1, [])
            parties.restart(device_id)
            (note, *_) = devices.advance(device_id, 0.2, []).notes
            assert note == Started(epoch=boot)


@links
def test_a_killed_terminal_sees_its_points_only_when_it_is_told_anew(
    tmp_path: Path, make: Callable[[Path], Parties]
) -> None:
    with make(tmp_path) as parties:
        devices = Devices(parties)
        devices.advance("t", 0.0, [], [PointsDetected("p", Position.NORMAL, True)])
        parties.kill("t")
        parties.restart("t")
        (note,) = devices.advance("t", 0.2, [], [PointsDetected("p", Position.NORMAL, True)]).notes
        assert note == Started(epoch=2)


@links
def test_what_another_role_is_told_is_refused(tmp_path: Path, make: Callable[[Path], Parties]) -> None:
    with make(tmp_path) as parties, pytest.raises((InputError, PartyError), match="a record of this role"):
        parties.advance("t", 0.0, [], b"\xc1")
