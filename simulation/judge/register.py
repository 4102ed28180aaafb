"""What the block manager (閉そく管理装置) has given to whom, as its own journal entries tell it."""

from __future__ import annotations

from collections.abc import Collection, Iterable

from simulation.judge.log import Checker, Log


class RegisterWatch:
    """Follows the register and checks `no-double-grant`, `undefined-grants-nothing` and `tokens-grow`.

    After a restart the register is undefined until every unit that was registered is heard of. Until then the
    last known holding of such a unit still stands as what it was given, but not against others' claims. So it is of one
    about which persons take their word back.
    """

    def __init__(self, log: Log) -> None:
        self._log = log
        self._held: dict[str, dict[str, int]] = {}  # unit: section: token of the grant, 0 if not by a grant
        self._unheard: set[str] = set()
        self._restoring = False
        self._token_max = -1

    def knows(self, unit_id: str) -> bool:
        """Whether the manager has the unit on the line."""
        return unit_id in self._held

    def holds(self, unit_id: str, section_id: str) -> bool:
        """Whether the manager says, or said last, that the unit holds a section."""
        return section_id in self._held.get(unit_id, ())

    def token_of(self, unit_id: str, section_id: str) -> int:
        """Token of the grant under which a unit holds a section; 0 if it does not or holds it by a claim."""
        return self._held.get(unit_id, {}).get(section_id, 0)

    def granted(self, t_s: float, unit_id: str, route: str, section_ids: Collection[str], token: int) -> None:
        """A route was granted."""
        if self._unheard:
            unheard = ", ".join(sorted(self._unheard))
            text = (
                f"route {route} granted to {unit_id} while undefined: of {unheard} nobody knows what it holds"
            )
            self._log.note(t_s, Checker.UNDEFINED_GRANTS_NOTHING, unit_id, text)
        if token <= self._token_max:
            text = f"route {route} granted to {unit_id} with token {token}, not above {self._token_max}"
            self._log.note(t_s, Checker.TOKENS_GROW, unit_id, text)
        self._token_max = max(self._token_max, token)
        self._check_single(t_s, unit_id, section_ids)
        mine = self._held.setdefault(unit_id, {})
        for section_id in section_ids:
            mine.setdefault(section_id, token)

    def accepted(self, t_s: float, unit_id: str, section_ids: Collection[str]) -> None:
        """The manager took a sign-on, a claim or an entry by hand: the unit holds exactly these."""
        self._unheard.discard(unit_id)
        self._check_single(t_s, unit_id, section_ids)
        before = self._held.get(unit_id, {})
        self._held[unit_id] = {section_id: before.get(section_id, 0) for section_id in section_ids}

    def freed(self, unit_id: str, section_ids: Iterable[str]) -> None:
        """The manager freed sections of a unit."""
        mine = self._held.get(unit_id, {})
        for section_id in section_ids:
            mine.pop(section_id, None)

    def outside(self, unit_id: str) -> None:
        """The manager has a unit as off the line."""
        self._unheard.discard(unit_id)
        self._held.pop(unit_id, None)

    def restarted(self, registered: Iterable[str], epoch: int) -> None:
        """The manager started and knows nothing. A unit it forgot to ask counts as unheard all the same."""
        self._unheard, self._restoring = {*registered, *self._held}, epoch > 1

    def barred(self, unit_id: str) -> None:
        """Persons barred a unit: while the line is restored nothing that it has said is left in the register."""
        if self._restoring:
            self._unheard.add(unit_id)

    def taken_back(self, unit_id: str) -> None:
        """Persons were wrong about a unit: on a running line nobody knows where it is until it is heard of again."""
        if not self._restoring:
            self._unheard.add(unit_id)

    def defined(self) -> None:
        """The line is restored."""
        self._restoring = False

    def _check_single(self, t_s: float, unit_id: str, section_ids: Collection[str]) -> None:
        for other, sections in self._held.items():
            if other == unit_id or other in self._unheard:
                continue
            for section_id in section_ids:
                if section_id in sections:
                    text = f"section {section_id} given to {unit_id} while {other} holds it"
                    self._log.note(t_s, Checker.NO_DOUBLE_GRANT, section_id, text)
