"""Which parties of a run are on other machines, and what stands ready for them in the folder of its certificates."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from contextlib import AbstractContextManager
from dataclasses import dataclass
from pathlib import Path
from typing import Final

import msgspec

from host.certificates import DENIED_FILE, PARTIES_FOLDER, denied_in, name_in
from host.over_tls import PartyInvitation, access_control, tls_session_json5
from host.process import write_private
from network.errors import COMMAND_LINE, InputError

INVITATION_FILE: Final = "invitation.json"


@dataclass(frozen=True, slots=True)
class Elsewhere:
    """Which parties of a run people start on other machines, and where the simulator waits for them.

    `party_ids`: empty for all that are processes. While it waits it is in the context that `waiting` makes of what is
    to be said. InputError where certificates are missing or have run out.
    """

    endpoint: str
    certificates: Path
    party_ids: tuple[str, ...]
    waiting: Callable[[str], AbstractContextManager[None]]

    def __post_init__(self) -> None:
        name_in(self.certificates)

    @property
    def folder(self) -> Path:
        """Where a folder for each party is."""
        return self.certificates / PARTIES_FOLDER

    def chosen(self, party_ids: Iterable[str]) -> frozenset[str]:
        """Those of these parties that are elsewhere. InputError for an unknown one, and for one that is denied."""
        known = frozenset(party_ids)
        chosen, denied = frozenset(self.party_ids) or known, denied_in(self.certificates)
        for party_id in sorted(chosen):
            if party_id not in known:
                names = ", ".join(sorted(known))
                raise InputError(COMMAND_LINE, "--elsewhere", party_id, f"a party that is a process: {names}")
            if party_id in denied:
                file = self.certificates / DENIED_FILE
                raise InputError(
                    str(file), "", party_id, "no party that is to take part: its certificate counts no more"
                )
            if not (folder := self.folder_of(party_id)).is_dir():
                raise InputError(str(folder), "", None, "its folder, as `branchline certificates` made it")
        return chosen

    def folder_of(self, party_id: str) -> Path:
        """What people carry to its machine."""
        return self.folder / party_id

    def invite(self, invitation: PartyInvitation) -> None:
        """Write what it needs besides its certificate."""
        file = self.folder_of(invitation.spec.party_id) / INVITATION_FILE
        write_private(file, msgspec.json.encode(invitation))

    def uninvite(self, party_id: str) -> None:
        """It has joined, or nobody waits for it any longer."""
        (self.folder_of(party_id) / INVITATION_FILE).unlink(missing_ok=True)

    def session_json5(self, line_id: str, party_ids: Iterable[str], session_id: str) -> str:
        """Zenoh configuration of the simulator's end."""
        access = access_control(line_id, party_ids)
        return tls_session_json5("listen", self.endpoint, self.certificates, session_id, access)
