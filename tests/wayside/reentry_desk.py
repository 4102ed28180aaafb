"""The manager a minute after its restart: a line after figure 3 of the paper, with three trains out on it.

P0 (portal), A (points), B (track), C (between), D (points), E (track), P9 (portal). When the manager loses its power u1
holds A and B (and stands in B), u2 holds E, u3 holds P9, u4 is off the line.
"""

from collections.abc import Iterable, Mapping

from msgspec.structs import replace

from radio.messages import AnyMessage, Claim, Contested, RouteGranted, RouteRequest, SignOnAccepted
from radio.noted import Noted
from tests.wayside.manager_desk import CONFIG, KEYS
from wayside.actions import Send, Show
from wayside.acts import Act
from wayside.block_manager import AskUnits, Heard, step
from wayside.config import ManagerConfig, ReentryMode, RouteEntry
from wayside.register import Register, start
from wayside.said import AcceptPicture, Contradicted, EnterSection, Note, Refused

SECTIONS = ("P0", "A", "B", "C", "D", "E", "P9")
ROUTES = (*CONFIG.routes, RouteEntry("up", "P9", ("E",)), RouteEntry("out", "B", ("A", "P0")))
HELD = {"u1": ("A", "B"), "u2": ("E",), "u3": ("P9",)}


def config_of(mode: ReentryMode) -> ManagerConfig:
    return replace(CONFIG, unit_ids=(*CONFIG.unit_ids, "u4"), routes=ROUTES, reentry=mode)


class Desk:
    """The manager a minute after its restart, the persons at it, and the trains out on the line."""

    def __init__(
        self, mode: ReentryMode = ReentryMode.ASSISTED, ledger: Iterable[str] | None = tuple(HELD)
    ) -> None:
        self.mode = mode
        self.register: Register = start(config_of(mode), 2, KEYS, ledger)
        self.notes: list[Note] = []
        self.contested: list[tuple[str, tuple[str, ...]]] = []
        self.now_s = 60.0
        self.register, _ = step(self.register, AskUnits(), 0.0)

    def act(self, act: Act) -> list[type[Noted]]:
        self.register, actions = step(self.register, act, self.now_s)
        self.notes = [action.note for action in actions if isinstance(action, Show)]
        return [type(note) for note in self.notes]

    def hear(self, unit_id: str, message: AnyMessage, epoch: int = 1) -> AnyMessage:
        self.register, actions = step(self.register, Heard(unit_id, epoch, True, 1, message), self.now_s)
        self.notes = [action.note for action in actions if isinstance(action, Show)]
        sends = [action for action in actions if isinstance(action, Send)]
        told = [(s.destination, s.message) for s in sends if isinstance(s.message, Contested)]
        self.contested = [(destination, message.section_ids) for destination, message in told]
        return [send.message for send in sends if not isinstance(send.message, Contested)][-1]

    def claim(self, *unit_ids: str) -> None:
        for unit_id in unit_ids:
            assert isinstance(self.hear(unit_id, Claim(HELD.get(unit_id, ()), 7)), SignOnAccepted)

    def enter(self, wrong: Mapping[str, str | None] | None = None, person: str = "Sato") -> None:
        """Every section by hand, as it is but for what is wrong."""
        right = {section: unit_id for unit_id, held in HELD.items() for section in held}
        for section in SECTIONS:
            unit_id = (wrong or {}).get(section, right.get(section))
            self.act(EnterSection(section, unit_id, person))

    def accept(self) -> list[type[Noted]]:
        return self.act(AcceptPicture("Sato"))

    def define(self) -> None:
        """The picture is accepted, and complete."""
        self.accept()
        assert self.register.defined

    @property
    def why(self) -> str:
        """What the last notes say."""
        return "; ".join(note.why for note in self.notes if isinstance(note, Refused | Contradicted))

    def check_no_grant_takes_what_a_train_holds(self) -> int:
        """Any unit asks for any route; returns how many are granted."""
        granted = 0
        for unit_id in HELD:
            for route in ROUTES:
                request = RouteRequest(unit_id, route.route_id, route.section_ids)
                event: Heard[AnyMessage] = Heard(unit_id, 1, True, 99, request)
                _, actions = step(self.register, event, self.now_s)
                for action in actions:
                    if isinstance(action, Send) and isinstance(action.message, RouteGranted):
                        granted += 1
                        for other in HELD.keys() - {unit_id}:
                            assert not set(HELD[other]) & set(action.message.section_ids)
        return granted
