"""On-board units, block manager and air together, on the bytes: whatever is lost, late, repeated or restarted, in
any order, no two trains believe to hold the same section, and no two stand in one.

The units are the very machine that runs (`onboard.unit`), the manager its very host; made up are a line without
points, the places of the trains in joints and what their crews do.
"""

import random
from collections import Counter
from collections.abc import Callable
from typing import Final

import msgspec
import pytest
from hypothesis import settings
from hypothesis import strategies as st
from hypothesis.stateful import RuleBasedStateMachine, initialize, invariant, rule

from onboard.authority.letters import _READERS, Letters
from onboard.authority.records import Authority, Event
from onboard.duty import duty_step
from onboard.duty.stop_limit import cleared_sections
from onboard.duty_parameters import ReleaseRule
from onboard.notes import Agreed, GaveBack, Mismatch, Resumed, RouteHeld, UnitRestarted
from onboard.notes import SignedOff as UnitSignedOff
from onboard.plan import DutyPlan
from radio.envelope import Received
from radio.messages import SignOnAccepted
from radio.noted import Noted, TelegramDropped
from tests.host.exclusion_bench import World
from tests.host.exclusion_trains import SECTIONS, UNITS, Where
from tests.nightly import others_nightly
from tests.system.switches_wayside import grants_what_another_holds
from wayside import said
from wayside.config import ReentryMode

SEEDS: Final = 16
SLICE: Final = 2  # of them in every run

units = st.sampled_from(UNITS)
goals = st.sampled_from(["E", "E2"])
sections = st.sampled_from(SECTIONS)
wrong_entries = st.one_of(
    st.builds(said.EnterSection, sections, st.none() | units, st.just("Sato")),
    st.builds(
        said.ConfirmHolding, units, st.lists(sections, min_size=1, unique=True).map(tuple), st.just("Sato")
    ),
    st.builds(said.ConfirmOutside, units, st.just("Sato"), st.sampled_from(("", "P0", "P9"))),
    st.builds(said.TakeBack, units, st.just("Sato")),
    st.just(said.AcceptPicture("Sato")),
)
seldom = st.sampled_from([False, False, True])


class Exclusion(RuleBasedStateMachine):
    """Hypothesis chooses what happens, and shrinks what it finds."""

    def __init__(self) -> None:
        super().__init__()
        self.world = World()

    @initialize(mode=st.sampled_from(ReentryMode), release=st.sampled_from(ReleaseRule))
    def begin(self, mode: ReentryMode, release: ReleaseRule) -> None:
        self.world = World(mode, release)

    @rule(unit_id=units)
    def normal_run(self, unit_id: str) -> None:
        self.world.normal_run(unit_id)

    @rule(unit_id=units)
    def go(self, unit_id: str) -> None:
        self.world.go(unit_id)

    @rule(unit_id=units, to=goals)
    def next_train(self, unit_id: str, to: str) -> None:
        self.world.next_train(unit_id, to)

    @rule(unit_id=units)
    def set_back(self, unit_id: str) -> None:
        self.world.set_back(unit_id)

    @rule(unit_id=units, really=seldom)
    def lose_position(self, unit_id: str, really: bool) -> None:
        if really:
            self.world.lose_position(unit_id)

    @rule(data=st.data(), keep=st.booleans())
    def deliver(self, data: st.DataObject, keep: bool) -> None:
        if self.world.flying:
            self.world.deliver_one(data.draw(st.integers(0, len(self.world.flying) - 1)), keep=keep)

    @rule()
    def deliver_everything(self) -> None:
        self.world.flush()

    @rule(unit_id=units)
    def lose(self, unit_id: str) -> None:
        self.world.lose_everything_in_the_air(unit_id)

    @rule(pause_s=st.sampled_from([0.1, 1.0, 5.5]))
    def wait(self, pause_s: float) -> None:
        self.world.wait(pause_s)

    @rule(really=seldom)
    def restart_manager(self, really: bool) -> None:
        if really:
            self.world.boot_manager()

    @rule(unit_id=units, really=seldom)
    def restart_train(self, unit_id: str, really: bool) -> None:
        if really:
            self.world.restart_train(unit_id)

    @rule(unit_id=units)
    def confirm_by_hand(self, unit_id: str) -> None:
        self.world.confirm_by_hand(unit_id)

    @rule(entry=wrong_entries)
    def enter_anything(self, entry: said.Input) -> None:
        self.world.manage(inputs=[entry])

    @rule(unit_id=units)
    def locate(self, unit_id: str) -> None:
        self.world.locate(unit_id)

    @rule()
    def restore(self) -> None:
        self.world.restore()

    @rule(unit_id=units, really=seldom)
    def hush(self, unit_id: str, really: bool) -> None:
        if really:
            self.world.hush(unit_id)

    @invariant()
    def check(self) -> None:
        self.world.check()


TestExclusion = Exclusion.TestCase
TestExclusion.settings = settings(stateful_step_count=60)


class Walker:
    """A long day at random, busier than hypothesis' examples: what happens often happens often."""

    def __init__(self, seed: int, mode: ReentryMode, release: ReleaseRule = ReleaseRule.ROUTE) -> None:
        self.chance = random.Random(seed)
        self.world = World(mode, release, contact=seed % 2 == 0)

    def step(self) -> None:
        world, chance = self.world, self.chance
        unit_id = chance.choice(UNITS)
        self.do(
            [
                (8.0, lambda: world.go(unit_id)),
                (8.0, lambda: world.deliver_in_order(chance.randint(1, 4))),
                (4.0, self.deliver_any),
                (6.0, lambda: world.wait(chance.choice([0.1, 1.0, 1.0, 5.5]))),
                (2.0, lambda: world.normal_run(unit_id)),
                (3.0, lambda: world.next_train(unit_id, chance.choice(["E", "E2"]))),
                (0.5, lambda: world.set_back(unit_id)),
                (0.5, lambda: world.confirm_by_hand(unit_id)),
                (0.5, lambda: world.manage(inputs=[self.anything()])),
                (0.2, lambda: world.manage(inputs=[said.AcceptPicture("Sato")])),
                (0.4, world.restore),
                (0.6, lambda: world.locate(unit_id)),
                (0.2, lambda: world.lose_position(unit_id)),
                (0.3, lambda: world.lose_everything_in_the_air(unit_id)),
                (0.25, world.boot_manager),
                (0.25, lambda: world.restart_train(unit_id)),
            ]
        )

    def step_of_recovery(self) -> None:
        """Mostly after a restart, with trains out of reach or without memory, and Sato hard at work."""
        world, chance = self.world, self.chance
        unit_id = chance.choice(UNITS)
        self.do(
            [
                (4.0, lambda: world.normal_run(unit_id)),
                (3.0, lambda: world.go(unit_id)),
                (2.0, lambda: world.wait(chance.choice([0.1, 5.5]))),
                (2.0, lambda: world.next_train(unit_id, chance.choice(["E", "E2"]))),
                (0.3, lambda: world.set_back(unit_id)),
                (1.0, lambda: world.confirm_by_hand(unit_id)),
                (3.0, lambda: world.manage(inputs=[self.anything()])),
                (2.0, lambda: world.manage(inputs=[said.AcceptPicture("Sato")])),
                (0.7, world.restore),
                (0.3, world.enter_every_section),
                (0.7, world.flush),
                (0.7, lambda: world.locate(unit_id)),
                (0.7, lambda: world.hush(unit_id)),
                (0.7, world.boot_manager),
                (0.3, lambda: world.restart_train(unit_id)),
            ]
        )

    def do(self, deeds: list[tuple[float, Callable[[], None]]]) -> None:
        (deed,) = self.chance.choices([deed for _, deed in deeds], [weight for weight, _ in deeds])
        deed()
        self.world.check()

    def anything(self) -> said.Input:
        """What Sato enters: mostly wrong."""
        chance = self.chance
        unit_id = chance.choice(UNITS)
        some = tuple(chance.sample(SECTIONS, chance.randint(1, 3)))
        wrong: list[said.Input] = [
            said.EnterSection(some[0], chance.choice([None, unit_id]), "Sato"),
            said.ConfirmHolding(unit_id, some, "Sato"),
            said.ConfirmOutside(unit_id, "Sato", chance.choice(["", "P0", "P9"])),
            said.TakeBack(unit_id, "Sato"),
        ]
        return chance.choice(wrong)

    def deliver_any(self) -> None:
        if self.world.flying:
            index = self.chance.randrange(len(self.world.flying))
            self.world.deliver_one(index, keep=self.chance.random() < 0.5)


@pytest.mark.parametrize("mode", ReentryMode)
@pytest.mark.parametrize("release", ReleaseRule)
@pytest.mark.parametrize("recovering", [False, True], ids=["walk", "recovery"])
@pytest.mark.parametrize("seed", others_nightly(range(SEEDS), range(SLICE)))
def test_walks_and_after_them_all_goes_on(
    seed: int, recovering: bool, release: ReleaseRule, mode: ReentryMode
) -> None:
    walker = Walker(seed, mode, release)
    for _ in range(300):
        walker.step_of_recovery() if recovering else walker.step()
    walker.world.heal()
    walker.world.check_that_all_goes_on()


@pytest.mark.parametrize("mode", ReentryMode)
def test_walks_grant_run_and_disturb_enough(mode: ReentryMode) -> None:
    kinds: Counter[type[Noted]] = Counter()
    granted_again = 0
    for seed in range(8):
        walker = Walker(seed, mode)
        for _ in range(250):
            walker.step()
            walker.step_of_recovery()
        notes = walker.world.notes
        kinds.update(type(note) for note in notes)
        kinds.update(type(note) for train in walker.world.units.values() for note in train.notes)
        granted_again += sum(isinstance(note, said.Granted) and note.token >> 32 > 1 for note in notes)
    enough = {
        **dict.fromkeys((said.Granted, said.Freed, TelegramDropped, said.Started, RouteHeld), 20),
        **dict.fromkeys((said.ConfirmedByHand, said.WordTaken, said.Contradicted), 20),
        **dict.fromkeys((UnitRestarted, GaveBack, Resumed, UnitSignedOff), 5),
        **dict.fromkeys((said.TakenBack, said.ToBeSwept, said.Swept, Mismatch, Agreed), 5),
    }
    assert granted_again > 10
    assert {kind: kinds[kind] for kind, count in enough.items() if kinds[kind] < count} == {}


def enters_on_any_acceptance(patch: pytest.MonkeyPatch) -> None:
    """Takes whatever is accepted for the portal that it wishes to enter."""
    sign_on = Letters._signed_on

    def any_sign_on(self: Letters, heard: Received, message: SignOnAccepted) -> Event:
        wished = msgspec.structs.replace(message, section_ids=(*message.section_ids, "P0"))
        return sign_on(self, heard, message if message.section_ids else wished)

    patch.setattr(Letters, "_signed_on", any_sign_on)
    patch.setitem(_READERS, SignOnAccepted, any_sign_on)


def releases_where_it_stands(patch: pytest.MonkeyPatch) -> None:
    """Gives back one section too many behind the rear."""

    def too_many(way: DutyPlan, state: Authority, clear: int) -> tuple[str, ...]:
        return cleared_sections(way, state, clear + 1)

    patch.setattr(duty_step, "cleared_sections", too_many)


@pytest.mark.parametrize(
    "off", [grants_what_another_holds, enters_on_any_acceptance, releases_where_it_stands]
)
def test_walks_see_what_is_switched_off(
    off: Callable[[pytest.MonkeyPatch], None], monkeypatch: pytest.MonkeyPatch
) -> None:
    off(monkeypatch)
    with pytest.raises(AssertionError, match=r"two trains|holds nothing"):
        for seed in range(2 * SEEDS):
            walker = Walker(seed, ReentryMode.ASSISTED)
            for _ in range(300):
                walker.step()


def test_a_wish_to_enter_a_portal_where_a_silent_train_stands() -> None:
    """Found by a walk: u2 wishes to enter at P0, where u3 stands and has forgotten what it holds."""
    world = World()
    u2, u3 = world.units["u2"], world.units["u3"]
    world.run_to("u2", "P9")
    while u2.where is not Where.OUTSIDE:
        world.next_train("u2", "E")
        world.normal_run("u2")
    world.next_train("u3", "E")
    world.flush()
    assert u3.physical == {"P0"}
    world.hush("u3")
    world.restart_train("u3")
    world.boot_manager()
    world.next_train("u2", "E")
    for _ in range(4):
        world.flush()
        world.wait(5.0)
    assert u2.where is Where.WAITING
    assert u2.believed == frozenset()
    assert u3.physical == {"P0"}
    world.check()


def test_a_claim_of_nothing_accepted_opens_no_portal() -> None:
    """Found by a walk: asked on its sign-on, u3 claims nothing; the acceptance of that is no leave to enter."""
    world = World()
    u3 = world.units["u3"]
    world.boot_manager()
    world.next_train("u3", "E")
    world.flush()
    assert any(isinstance(note, said.Outside) and note.unit_id == "u3" for note in world.notes)
    assert u3.where is Where.WAITING
    for _ in range(3):
        world.restore()
        world.wait(6.0)
        world.flush()
    world.run_to("u3", "P0")
    world.check()
