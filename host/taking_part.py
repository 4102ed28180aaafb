"""A party of a run whose simulator is on another machine: as `host.serve`, over TLS, from a folder that people carried
here (`host.certificates`, and the invitation to one run).

The party is an object of this process. The simulator cuts its power and gives it back by word, so that its faults come
where they come on one machine.
"""

from __future__ import annotations

import os
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Final

import msgspec
import zenoh

from host.certificates import name_in
from host.elsewhere import INVITATION_FILE
from host.local import LocalParties
from host.lockstep import Answerer
from host.over_tls import (
    CERTIFICATE_FILE,
    FAR,
    PartyInvitation,
    PowerDeed,
    check_endpoint,
    tls_session_json5,
)
from host.parties import PartyError
from host.party import Advance, PartySpec
from host.process import WANTING_CODE
from host.serve import PartyServer
from network.errors import InputError


class FarParty:
    """`host.party.Party` that does what its machine is told: to it, with it or for it."""

    def __init__(self, spec: PartySpec) -> None:
        self._party_id: Final = spec.party_id
        self._parties = LocalParties([spec])
        self._parties.__enter__()
        self.over = False  # the run

    @property
    def epoch(self) -> int:
        """Number of its present boot; 0: it is down."""
        party = self._parties.running(self._party_id)
        return 0 if party is None else party.epoch

    def advance(self, now_s: float, telegrams: Sequence[bytes], told: bytes) -> Advance:
        """Act at `now_s`, or lose power, or what else it is told. Raises InputError, PartyError."""
        asked = FAR.decode_told(told)
        match asked.deed:
            case PowerDeed.ADVANCE:
                return self._parties.advance(self._party_id, now_s, telegrams, asked.told)
            case PowerDeed.KILL:
                self._parties.kill(self._party_id)
            case PowerDeed.RESTART:
                self._parties.restart(self._party_id)
            case PowerDeed.LOSE:
                self._parties.lose(self._party_id)
            case PowerDeed.COMMISSION:
                self._parties.commission(self._party_id, asked.number, asked.told)
            case PowerDeed.LEAVE:
                self.over = True
        return Advance((), b"", None)


def take_part(folder: Path, endpoint: str) -> None:
    """Host the party of a folder until its run is over. Raises InputError, and PartyError where it is not let in.

    The process ends with code 3 when the link is lost before the run is over.
    """
    check_endpoint("--connect", endpoint)
    name = name_in(folder)
    file = folder / INVITATION_FILE
    invitation = _invitation(file)
    spec = invitation.spec
    if name != spec.party_id:
        raise InputError(str(folder / CERTIFICATE_FILE), "name", name, f"{spec.party_id}, who is invited")
    party = FarParty(spec)
    config = tls_session_json5("connect", endpoint, folder, invitation.session_id)
    try:
        session = zenoh.open(zenoh.Config.from_json5(config))
    except zenoh.ZError as error:
        why = "nobody waits there, or one end does not believe the other's certificate"
        raise PartyError(f"{endpoint} does not let {spec.party_id} in: {why} ({error})") from error
    file.unlink(missing_ok=True)

    def ended(event: zenoh.TransportEvent) -> None:
        if event.kind == zenoh.SampleKind.DELETE and not party.over:
            sys.stderr.write(f"the link to {endpoint} is lost before the run of {spec.party_id} was over\n")
            sys.stderr.flush()
            os._exit(WANTING_CODE)

    with session:
        _listener = session.info.declare_transport_events_listener(ended, history=True)
        answerer = Answerer(spec.party_id, invitation.plane_key, party)
        PartyServer(session, answerer, spec.line_id, spec.party_id).run(lambda: party.over)


def _invitation(file: Path) -> PartyInvitation:
    try:
        return msgspec.json.decode(file.read_bytes(), type=PartyInvitation)
    except OSError as error:
        expected = f"what the simulator writes for this run while it waits ({error.strerror})"
        raise InputError(str(file), "", None, expected) from None
    except msgspec.MsgspecError as error:
        raise InputError(str(file), "", None, f"an invitation to a run ({error})") from None
