"""A unit that only waits outside its portal, and the real block manager that has lost its register.

u1 stands in the portal P0 and is silent; u3 waits outside to enter there. Asked, u3 must claim nothing: its wish is no
fact, and the train that stands there must be able to say so.
"""

from dataclasses import dataclass, field

from onboard.authority import machine as authority
from onboard.authority.letters import Letters
from onboard.authority.records import (
    Authority,
    BeginOnLine,
    Commit,
    Event,
    Renew,
    SendClaim,
    SendRequest,
    Take,
)
from radio.envelope import Received
from radio.messages import AnyMessage, Claim, RefusalReason, SignOn, SignOnAccepted, SignOnRefused
from wayside import actions, block_manager
from wayside.config import ManagerConfig, RouteEntry, SectionEntry
from wayside.register import Register, UnitStanding, start

CONFIG = ManagerConfig(
    "line",
    "block-manager",
    ("u1", "u3"),
    (SectionEntry("P0", portal=True), SectionEntry("A"), SectionEntry("B")),
    (RouteEntry("in", "P0", ("A", "B")),),
)


@dataclass
class Radio:
    """The manager after its restart, u3's authority, and the air between them, which loses nothing."""

    register: Register = field(default_factory=lambda: start(CONFIG, 2, {}, None))
    state: Authority = field(default_factory=Authority)
    letters: Letters = field(default_factory=lambda: Letters("u3", "block-manager"))
    said: list[AnyMessage] = field(default_factory=list)
    now_s: float = 0.0

    def put(self, event: Event) -> None:
        """To u3; what it says goes to the manager, and the answers back, until nobody has more to say."""
        self.state, done = authority.step(self.state, event, covered=True)
        for action in done:
            if isinstance(action, Renew | Commit | Take):
                self.letters.keep(action)
            elif isinstance(action, SendRequest | SendClaim):
                letter = self.letters.write(action)
                self.said.append(letter.message)
                for answer in self.tell_manager("u3", letter.message, letter.correlation):
                    heard = Received(
                        "block-manager", 2, 0, True, answer.correlation, 0.0, None, 0, answer.message
                    )
                    meant = self.letters.read(heard)
                    assert meant is not None
                    self.put(meant)

    def tell_manager(self, unit_id: str, message: AnyMessage, correlation: int) -> list[actions.Send]:
        self.now_s += 1.0
        heard = block_manager.Heard(unit_id, 1, True, correlation, message)
        self.register, done = block_manager.step(self.register, heard, self.now_s)
        return [a for a in done if isinstance(a, actions.Send) and a.destination == unit_id]

    def ask_all(self) -> None:
        """The manager asks whoever blocks the line."""
        self.now_s += 10.0
        self.register, done = block_manager.step(self.register, block_manager.AskUnits(), self.now_s)
        for action in done:
            if isinstance(action, actions.Send) and action.destination == "u3":
                heard = Received(
                    "block-manager", 2, 0, True, action.correlation, 0.0, None, 0, action.message
                )
                meant = self.letters.read(heard)
                assert meant is not None
                self.put(meant)


def waits_outside(radio: Radio, enters: bool) -> None:
    radio.put(BeginOnLine(("P0",), enters=enters))
    radio.ask_all()


def test_who_waits_to_enter_holds_nothing() -> None:
    radio = Radio()
    waits_outside(radio, enters=True)
    assert radio.said[0] == SignOn("u3", ("P0",))
    assert Claim((), 0) in radio.said
    assert not any(isinstance(message, Claim) and message.section_ids for message in radio.said)
    assert radio.state.held == ()
    assert radio.register.holders == {}
    assert radio.register.unit("u3").standing is UnitStanding.OUTSIDE


def test_the_train_that_stands_there_is_then_accepted() -> None:
    radio = Radio()
    waits_outside(radio, enters=True)
    (answer,) = radio.tell_manager("u1", Claim(("P0",), 0), 9)
    assert isinstance(answer.message, SignOnAccepted)
    assert answer.message.section_ids == ("P0",)
    assert radio.register.holders == {"P0": "u1"}
    assert radio.register.unit("u1").standing is UnitStanding.REPORTED


def test_a_wish_told_as_a_fact_shuts_it_out() -> None:
    """The switch: a unit that claims where it only wants to be."""
    radio = Radio()
    waits_outside(radio, enters=False)
    assert Claim(("P0",), 0) in radio.said
    (answer,) = radio.tell_manager("u1", Claim(("P0",), 0), 9)
    assert answer.message == SignOnRefused(RefusalReason.HELD, "P0", "u3")
    assert radio.register.unit("u1").standing is UnitStanding.DISPUTED
