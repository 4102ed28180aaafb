"""A line after figure 3 of the paper, and its manager: P0 (portal), A (points), B (track), C (between), D (points),
E (track), P9 (portal).
"""

from radio.keys import capability_key
from radio.messages import AnyMessage, Claim, RouteRequest, SignOnAccepted
from radio.noted import Noted
from wayside.actions import Send, Show
from wayside.acts import Act
from wayside.block_manager import AskUnits, Heard, step
from wayside.config import ManagerConfig, RouteEntry, SectionEntry
from wayside.register import Register, UnitStanding, start
from wayside.said import ConfirmOutside

MASTER = b"m" * 32
KEYS = {terminal: capability_key(MASTER, terminal) for terminal in ("tA", "tD")}
CONFIG = ManagerConfig(
    "line",
    "block-manager",
    ("u1", "u2", "u3"),
    (
        SectionEntry("P0", portal=True),
        SectionEntry("A", terminal_ids=("tA",)),
        SectionEntry("B"),
        SectionEntry("C", open_line=True),
        SectionEntry("D", terminal_ids=("tD",)),
        SectionEntry("E"),
        SectionEntry("P9", portal=True),
    ),
    (
        RouteEntry("in", "P0", ("A", "B")),
        RouteEntry("over", "B", ("C", "D", "E")),
        RouteEntry("back", "E", ("D", "C", "B")),
    ),
)
IN = RouteRequest("u1", "in", ("A", "B"))


class Desk:
    """A register and what it did last, so that tests read as a conversation."""

    def __init__(self, epoch: int = 1) -> None:
        self.register: Register = start(CONFIG, epoch, KEYS)
        self.kinds: list[type[Noted]] = []
        self.unasked: list[tuple[str, AnyMessage]] = []
        self.now_s = 0.0

    def hear(
        self, unit_id: str, message: AnyMessage, epoch: int = 1, fresh: bool = True, correlation: int = 1
    ) -> AnyMessage:
        """The last answer to a telegram, to its sender with its correlation; what is said besides is `unasked`."""
        event = Heard(unit_id, epoch, fresh, correlation, message)
        self.register, actions = step(self.register, event, self.now_s)
        sends = [action for action in actions if isinstance(action, Send)]
        answers = [s.message for s in sends if (s.destination, s.correlation) == (unit_id, correlation)]
        self.unasked = [(s.destination, s.message) for s in sends if s.correlation != correlation]
        assert len(answers) + len(self.unasked) == len(sends)
        self.kinds = [type(action.note) for action in actions if isinstance(action, Show)]
        return answers[-1]

    def ask(self, now_s: float) -> list[tuple[str, AnyMessage]]:
        """Time passes; what is said to whom."""
        self.now_s = now_s
        self.register, actions = step(self.register, AskUnits(), now_s)
        return [(action.destination, action.message) for action in actions if isinstance(action, Send)]

    def act(self, act: Act) -> list[type[Noted]]:
        self.register, actions = step(self.register, act, self.now_s)
        return [type(action.note) for action in actions if isinstance(action, Show)]

    def standing(self, unit_id: str) -> UnitStanding:
        return self.register.unit(unit_id).standing

    def enter(self, unit_id: str, *sections: str) -> int:
        """Claim sections that nobody else holds; returns the token."""
        accepted = self.hear(unit_id, Claim(sections, 0))
        assert isinstance(accepted, SignOnAccepted)
        assert accepted.section_ids == sections
        return accepted.token


def defined(**holdings: tuple[str, ...]) -> Desk:
    """A desk with every unit outside but those named, who have claimed what they hold."""
    desk = Desk()
    for unit_id in CONFIG.unit_ids:
        if unit_id in holdings:
            desk.enter(unit_id, *holdings[unit_id])
        else:
            desk.act(ConfirmOutside(unit_id, "Sato"))
    return desk
