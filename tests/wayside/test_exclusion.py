"""Trains, block manager and air together, on the bytes: whatever is lost, late, repeated or restarted, in
any order, no two trains believe to hold the same section.

The trains here keep the duties listed in `radio.messages` and nothing more. Of the persons, Mori stands beside
the trains and is truthful: enters by hand all that a train believes to hold, and confirms as outside only
trains that hold nothing. Sato, the controller, enters anything about anything, and accepts any picture.
"""

from __future__ import annotations

import random
from collections import Counter
from collections.abc import Callable
from itertools import pairwise

import msgspec
import pytest
from hypothesis import settings
from hypothesis import strategies as st
from hypothesis.stateful import RuleBasedStateMachine, initialize, invariant, rule

from host.device import DeviceHost
from host.store import MemoryStore
from radio.envelope import AGE_MAX_S, Endpoint, Received
from radio.keys import key_ring
from radio.messages import (
    AnyMessage,
    Claim,
    ClaimQuery,
    HoldingConfirmed,
    HoldingReport,
    RouteGranted,
    RouteRefused,
    RouteRequest,
    SignOff,
    SignOffAccepted,
    SignOffRefused,
    SignOn,
    SignOnAccepted,
)
from radio.noted import Noted, TelegramDropped
from wayside.config import (
    MANAGER_ID,
    DeviceConfig,
    ManagerConfig,
    ReentryMode,
    RouteEntry,
    SectionEntry,
    TerminalConfig,
)
from wayside.register import Stage
from wayside.said import (
    Accepted,
    AcceptPicture,
    ConfirmedByHand,
    ConfirmHolding,
    ConfirmOutside,
    Contradicted,
    EnterSection,
    Freed,
    Granted,
    Input,
    Note,
    Outside,
    PictureChanged,
    Started,
    WordTaken,
)

MASTER = b"m" * 32
UNITS = ("u1", "u2", "u3")
ROUTES = {
    "in": RouteEntry("in", "P0", ("A", "B")),
    "over": RouteEntry("over", "B", ("C", "D", "E")),
    "back": RouteEntry("back", "E", ("D", "C", "B")),
    "out": RouteEntry("out", "B", ("A", "P0")),
    "over 2": RouteEntry("over 2", "B", ("C", "D", "E2")),
    "back 2": RouteEntry("back 2", "E2", ("D", "C", "B")),
}
CONFIG = ManagerConfig(
    "line",
    MANAGER_ID,
    UNITS,
    (
        SectionEntry("P0", portal=True),
        SectionEntry("A", terminal_ids=("tA",)),
        SectionEntry("B"),
        SectionEntry("C"),
        SectionEntry("D", terminal_ids=("tD",)),
        SectionEntry("E"),
        SectionEntry("E2"),
    ),
    tuple(ROUTES.values()),
)
SECTIONS = tuple(section.section_id for section in CONFIG.sections)


class Train:
    """An on-board unit's memory of what it holds. `held` None: started again and does not know."""

    def __init__(self, unit_id: str) -> None:
        self.unit_id = unit_id
        self.epoch = 0
        self.physical: frozenset[str] = frozenset()  # where it stands, known to nobody but the person
        self.boot(held=())

    def boot(self, held: tuple[str, ...] | None = None) -> None:
        self.epoch += 1
        self.endpoint = Endpoint(key_ring(MASTER, self.unit_id, [MANAGER_ID]), self.epoch)
        self.held = held
        self.located = False  # a tag has told where it stands
        self.token = 0
        self.correlation = 0
        self.request: tuple[int, RouteRequest] | None = None
        self.sign_on: tuple[int, SignOn] | None = None
        self.leaving = 0  # correlation of the sign-off outstanding; the train itself has gone by then

    @property
    def believed(self) -> frozenset[str]:
        if self.leaving:
            return frozenset()
        return frozenset(self.held) if self.held is not None else self.physical

    @property
    def place(self) -> tuple[str, ...]:
        return tuple(sorted(self.physical))

    def next_correlation(self) -> int:
        self.correlation += 1
        return self.correlation

    def hold(self, sections: tuple[str, ...]) -> None:
        self.held, self.located = sections, False
        self.physical = frozenset(sections) if len(sections) < 2 else frozenset(sections[-1:])

    def take(self, got: Received) -> AnyMessage | None:
        match got.message:
            case ClaimQuery():
                return Claim(() if self.leaving else self.place if self.located else self.held, self.token)
            case SignOffAccepted() if self.leaving == got.correlation > 0:
                self.leaving = 0
                self.hold(())
            case SignOffRefused() if self.leaving and self.held:
                return HoldingReport(self.held, self.token)
            case RouteGranted() as granted:
                if self.request and got.correlation == self.request[0] and granted.token > self.token:
                    assert self.held is not None
                    self.hold(tuple(dict.fromkeys((*self.held, *granted.section_ids))))
                    self.token, self.request = granted.token, None
            case RouteRefused() if self.request and got.correlation == self.request[0]:
                self.request = None
            case SignOnAccepted() as accepted:
                self._signed_on(accepted, got.correlation)
            case HoldingConfirmed() as confirmed if self.held is not None:
                self._take_token(confirmed.token)
            case _:
                pass
        return None

    def _signed_on(self, accepted: SignOnAccepted, correlation: int) -> None:
        entering = self.sign_on is not None and correlation == self.sign_on[0]
        if self.held is None or (entering and accepted.section_ids):
            assert self.held in (None, ())
            self.hold(accepted.section_ids)
            self.sign_on = None
        self._take_token(accepted.token)

    def _take_token(self, token: int) -> None:
        if token > self.token:
            self.token, self.request = token, None


class World:
    """Telegrams live in `flying` until the age limit and are delivered any number of times, in any order."""

    def __init__(self, mode: ReentryMode = ReentryMode.ASSISTED) -> None:
        """A day under way: u1 stands in B, u2 in E, u3 is off the line."""
        self.mode = mode
        self.now_s = 0.0
        self.store = MemoryStore()
        self.units = {unit_id: Train(unit_id) for unit_id in UNITS}
        self.flying: list[tuple[str, bytes, float]] = []
        self.silent: set[str] = set()  # no telegram comes from or to these
        self.notes: list[Note] = []
        self.host: DeviceHost
        self.boot_manager()
        self.manage(inputs=[ConfirmHolding("u2", ("E",), "Sato")])
        for unit_id in ("u1", "u3"):
            self.manage(inputs=[ConfirmOutside(unit_id, "Sato")])
        self.units["u2"].boot(held=None)
        self.units["u2"].physical = frozenset({"E"})
        for unit_id in ("u2", "u1"):
            self.sign_on(unit_id)
            self.flush()
        self.normal_run("u1", "in")
        assert (self.units["u1"].held, self.units["u2"].held) == (("B",), ("E",))

    def manage(self, telegrams: list[bytes] | None = None, inputs: list[Input] | None = None) -> None:
        advance = self.host.advance(self.now_s, telegrams or [], inputs or [])
        self.flying += [
            (destination, data, self.now_s)
            for destination, data in advance.telegrams
            if destination not in self.silent
        ]
        self.judge(advance.notes)

    def judge(self, notes: tuple[Note, ...]) -> None:
        """Judged by the journal alone: nothing granted while undefined, tokens grow."""
        for note in notes:
            if isinstance(note, Started):
                self.known: set[str] = set()
                self.restoring = note.epoch > 1
            if isinstance(note, PictureChanged):
                self.restoring = note.stage != Stage.DEFINED.value
            if isinstance(note, Accepted | Outside | ConfirmedByHand):
                self.known.add(note.unit_id)
            if isinstance(note, Granted):
                assert self.known == set(UNITS)
                assert not self.restoring
        self.notes += notes

    def send(self, train: Train, message: AnyMessage, correlation: int) -> None:
        data = train.endpoint.seal(MANAGER_ID, message, self.now_s, correlation)
        if train.unit_id not in self.silent:
            self.flying.append((MANAGER_ID, data, self.now_s))

    def flush(self) -> None:
        """The air at its best: everything arrives, answers too."""
        while self.flying:
            self.deliver_one(0, keep=False)

    def normal_run(self, unit_id: str, route: str) -> None:
        self.flush()
        self.request(unit_id, route)
        self.flush()
        self.run_and_report(unit_id, drop=4)
        self.flush()

    def boot_manager(self) -> None:
        config: DeviceConfig = msgspec.structs.replace(CONFIG, reentry=self.mode)
        assert not isinstance(config, TerminalConfig)
        ring = key_ring(MASTER, MANAGER_ID, UNITS, ["tA", "tD"])
        self.host = DeviceHost(config, ring, self.store)
        self.manage()

    def restart_train(self, unit_id: str) -> None:
        train = self.units[unit_id]
        # Off the line there is nothing to forget; on it, it no longer knows.
        train.boot(held=None if train.physical else ())

    def sign_on(self, unit_id: str) -> None:
        train = self.units[unit_id]
        if train.held == () and train.sign_on is None:
            train.sign_on = (train.next_correlation(), SignOn(unit_id, ("P0",)))
        if train.held is None and train.sign_on is None:
            place = train.place if train.located else None
            train.sign_on = (train.next_correlation(), SignOn(unit_id, place))
        if train.sign_on is not None:
            self.send(train, train.sign_on[1], train.sign_on[0])

    def request(self, unit_id: str, route: str) -> None:
        train = self.units[unit_id]
        if train.leaving:
            return
        if train.held and train.request is None:
            message = RouteRequest(unit_id, route, ROUTES[route].section_ids)
            train.request = (train.next_correlation(), message)
        if train.held and train.request is not None:
            self.send(train, train.request[1], train.request[0])

    def run_and_report(self, unit_id: str, drop: int) -> None:
        train = self.units[unit_id]
        if train.held and not train.leaving:
            train.hold(train.held[min(drop, len(train.held) - 1) :])
            self.send(train, HoldingReport(train.held, train.token), train.next_correlation())

    def sign_off(self, unit_id: str) -> None:
        train = self.units[unit_id]
        if train.held == ("P0",):
            train.physical, train.request = frozenset(), None
            train.leaving = train.leaving or train.next_correlation()
            self.send(train, SignOff(unit_id, train.token), train.leaving)

    def deliver_in_order(self, count: int) -> None:
        for _ in range(min(count, len(self.flying))):
            self.deliver_one(0, keep=False)

    def deliver_one(self, index: int, *, keep: bool) -> None:
        destination, data, _ = self.flying[index] if keep else self.flying.pop(index)
        if destination == MANAGER_ID:
            self.manage([data])
            return
        train = self.units[destination]
        got = train.endpoint.open(data, self.now_s)
        if isinstance(got, Received) and (answer := train.take(got)) is not None:
            self.send(train, answer, got.correlation)

    def wait(self, pause_s: float) -> None:
        self.now_s = round(self.now_s + pause_s, 1)
        self.flying = [flight for flight in self.flying if self.now_s - flight[2] <= AGE_MAX_S + 1.0]
        self.manage()

    def lose_everything_in_the_air(self, unit_id: str) -> None:
        self.flying = [flight for flight in self.flying if flight[0] != unit_id]

    def locate(self, unit_id: str) -> None:
        """A train that has started again reads a tag: it claims where it stands."""
        train = self.units[unit_id]
        if train.held is None and train.physical and not train.located:
            train.located, train.sign_on = True, None
            self.sign_on(unit_id)

    def confirm_by_hand(self, unit_id: str, person: str = "Mori") -> None:
        """A true word about one train."""
        believed = tuple(sorted(self.units[unit_id].believed))
        entry: Input = (
            ConfirmHolding(unit_id, believed, person) if believed else ConfirmOutside(unit_id, person)
        )
        self.manage(inputs=[entry])

    def enter_every_section(self) -> None:
        """Sato corrects everything that was entered wrongly: a true word about every section."""
        holder = {section: train.unit_id for train in self.units.values() for section in train.believed}
        self.manage(inputs=[EnterSection(section, holder.get(section), "Sato") for section in SECTIONS])

    def hush(self, unit_id: str) -> None:
        """The radio of a train fails, or works again."""
        self.silent ^= {unit_id}

    def restore(self) -> None:
        """What a careful controller and the staff do together."""
        self.enter_every_section()
        for unit_id, train in self.units.items():
            if train.held is None or unit_id in self.silent:
                self.confirm_by_hand(unit_id)
                self.confirm_by_hand(unit_id, "Sato")
        self.manage(inputs=[AcceptPicture("Sato")])

    def heal(self) -> None:
        """Faults end, telegrams arrive, and the persons enter what the trains cannot say."""
        self.silent.clear()
        for _ in range(3):
            self.wait(6.0)
            self.flush()
            self.restore()
            for unit_id in UNITS:
                self.confirm_by_hand(unit_id)
                self.confirm_by_hand(unit_id, "Sato")
            for unit_id, train in self.units.items():
                if train.held is None:
                    self.sign_on(unit_id)
                elif train.leaving:
                    self.sign_off(unit_id)
                elif train.held:
                    self.run_and_report(unit_id, drop=4)
                else:
                    self.sign_on(unit_id)
                self.flush()
                self.check()

    def can_run(self, unit_id: str) -> bool:
        """Whether the train gets a route from where it stands."""
        train = self.units[unit_id]
        before = train.held
        for key, route in ROUTES.items():
            on_the_way = (route.from_section, *route.section_ids[:-1])
            if before and before[-1] in on_the_way and train.held == before:
                train.request = None
                self.request(unit_id, key)
                self.flush()
                self.check()
        return train.held != before

    def check(self) -> None:
        held = [section for train in self.units.values() for section in train.believed]
        assert len(held) == len(set(held)), "two trains believe to hold the same section"
        tokens = [note.token for note in self.notes if isinstance(note, Granted)]
        assert all(one < other for one, other in pairwise(tokens)), "tokens must grow"


units = st.sampled_from(UNITS)
routes = st.sampled_from(sorted(ROUTES))
sections = st.sampled_from(SECTIONS)
wrong_entries = st.one_of(
    st.builds(EnterSection, sections, st.none() | units, st.just("Sato")),
    st.builds(ConfirmHolding, units, st.lists(sections, min_size=1, unique=True).map(tuple), st.just("Sato")),
    st.builds(ConfirmOutside, units, st.just("Sato")),
    st.just(AcceptPicture("Sato")),
)
seldom = st.sampled_from([False, False, True])


class Exclusion(RuleBasedStateMachine):
    """Hypothesis chooses what happens, and shrinks what it finds."""

    def __init__(self) -> None:
        super().__init__()
        self.world = World()

    @initialize(mode=st.sampled_from(ReentryMode))
    def begin(self, mode: ReentryMode) -> None:
        self.world = World(mode)

    @rule(unit_id=units, route=routes)
    def normal_run(self, unit_id: str, route: str) -> None:
        self.world.normal_run(unit_id, route)

    @rule(unit_id=units, route=routes)
    def request(self, unit_id: str, route: str) -> None:
        self.world.request(unit_id, route)

    @rule(unit_id=units, drop=st.integers(0, 4))
    def run_and_report(self, unit_id: str, drop: int) -> None:
        self.world.run_and_report(unit_id, drop)

    @rule(unit_id=units)
    def sign_on(self, unit_id: str) -> None:
        self.world.sign_on(unit_id)

    @rule(unit_id=units)
    def sign_off(self, unit_id: str) -> None:
        self.world.sign_off(unit_id)

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
    def enter_anything(self, entry: Input) -> None:
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
TestExclusion.settings = settings(max_examples=60, stateful_step_count=60, deadline=None)


class Walker:
    """A long day at random, busier than hypothesis' examples: what happens often happens often."""

    def __init__(self, seed: int, mode: ReentryMode) -> None:
        self.chance = random.Random(seed)
        self.world = World(mode)

    def step(self) -> None:
        world, chance = self.world, self.chance
        unit_id = chance.choice(UNITS)
        held = world.units[unit_id].held
        routes = [key for key, route in ROUTES.items() if held and route.from_section == held[-1]] or ["in"]
        deeds: list[tuple[float, Callable[[], None]]] = [
            (6.0, lambda: world.request(unit_id, chance.choice(routes))),
            (4.0, lambda: world.run_and_report(unit_id, chance.choice([0, 1, 2, 4]))),
            (8.0, lambda: world.deliver_in_order(chance.randint(1, 4))),
            (4.0, self.deliver_any),
            (4.0, lambda: world.wait(chance.choice([0.1, 0.1, 1.0, 5.5]))),
            (2.0, lambda: world.normal_run(unit_id, chance.choice(routes))),
            (2.0, lambda: world.sign_on(unit_id)),
            (1.0, lambda: world.sign_off(unit_id)),
            (0.5, lambda: world.confirm_by_hand(unit_id)),
            (0.5, lambda: world.manage(inputs=[self.anything()])),
            (0.2, lambda: world.manage(inputs=[AcceptPicture("Sato")])),
            (0.4, world.restore),
            (0.3, lambda: world.locate(unit_id)),
            (0.3, lambda: world.lose_everything_in_the_air(unit_id)),
            (0.25, world.boot_manager),
            (0.25, lambda: world.restart_train(unit_id)),
        ]
        self.do(deeds)

    def step_of_recovery(self) -> None:
        """Mostly after a restart, with trains out of reach or without memory, and Sato hard at work."""
        world, chance = self.world, self.chance
        unit_id = chance.choice(UNITS)
        held = world.units[unit_id].held
        routes = [key for key, route in ROUTES.items() if held and route.from_section == held[-1]] or ["in"]
        self.do(
            [
                (4.0, lambda: world.normal_run(unit_id, chance.choice(routes))),
                (1.5, lambda: world.request(unit_id, chance.choice(routes))),
                (2.0, lambda: world.wait(chance.choice([0.1, 5.5]))),
                (2.0, lambda: world.sign_on(unit_id)),
                (0.5, lambda: world.sign_off(unit_id)),
                (1.0, lambda: world.confirm_by_hand(unit_id)),
                (3.0, lambda: world.manage(inputs=[self.anything()])),
                (2.0, lambda: world.manage(inputs=[AcceptPicture("Sato")])),
                (0.7, world.restore),
                (0.3, world.enter_every_section),
                (0.7, world.flush),
                (0.5, lambda: world.locate(unit_id)),
                (0.7, lambda: world.hush(unit_id)),
                (0.7, world.boot_manager),
                (0.3, lambda: world.restart_train(unit_id)),
            ]
        )

    def do(self, deeds: list[tuple[float, Callable[[], None]]]) -> None:
        (deed,) = self.chance.choices([deed for _, deed in deeds], [weight for weight, _ in deeds])
        deed()
        self.world.check()

    def anything(self) -> Input:
        """What Sato enters: mostly wrong."""
        chance = self.chance
        unit_id = chance.choice(UNITS)
        some = tuple(chance.sample(SECTIONS, chance.randint(1, 3)))
        wrong: list[Input] = [
            EnterSection(some[0], chance.choice([None, unit_id]), "Sato"),
            ConfirmHolding(unit_id, some, "Sato"),
            ConfirmOutside(unit_id, "Sato"),
        ]
        return chance.choice(wrong)

    def deliver_any(self) -> None:
        if self.world.flying:
            index = self.chance.randrange(len(self.world.flying))
            self.world.deliver_one(index, keep=self.chance.random() < 0.5)


@pytest.mark.parametrize("mode", ReentryMode)
@pytest.mark.parametrize("seed", range(30))
def test_walks_and_after_them_everyone_can_run_again(seed: int, mode: ReentryMode) -> None:
    walker = Walker(seed, mode)
    for _ in range(400):
        walker.step()
    world = walker.world
    world.heal()
    for unit_id, train in world.units.items():
        assert train.held is not None, unit_id
    assert any(world.can_run(unit_id) for unit_id in UNITS)


@pytest.mark.parametrize("mode", ReentryMode)
@pytest.mark.parametrize("seed", range(30))
def test_recoveries_and_after_them_everyone_can_run_again(seed: int, mode: ReentryMode) -> None:
    walker = Walker(seed, mode)
    for _ in range(400):
        walker.step_of_recovery()
    world = walker.world
    world.heal()
    for unit_id, train in world.units.items():
        assert train.held is not None, unit_id
    assert any(world.can_run(unit_id) for unit_id in UNITS)


@pytest.mark.parametrize("mode", ReentryMode)
def test_walks_grant_and_disturb_enough(mode: ReentryMode) -> None:
    kinds: Counter[type[Noted]] = Counter()
    granted_again = 0
    for seed in range(10):
        walker = Walker(seed, mode)
        for _ in range(300):
            walker.step()
            walker.step_of_recovery()
        notes = walker.world.notes
        kinds.update(type(note) for note in notes)
        granted_again += sum(isinstance(note, Granted) and note.token >> 32 > 1 for note in notes)
    assert kinds[Granted] > 40
    assert granted_again > 20
    enough = (
        Freed,
        TelegramDropped,
        Started,
        ConfirmedByHand,
        WordTaken,
        Contradicted,
    )
    assert min(kinds[kind] for kind in enough) > 20


def test_a_wish_to_enter_a_portal_where_a_silent_train_stands() -> None:
    """Found by a walk: u3 wishes to enter at P0, where u1 stands and has forgotten what it holds."""
    world = World()
    world.normal_run("u1", "out")
    assert world.units["u1"].held == ("P0",)
    world.restart_train("u1")
    world.boot_manager()
    world.flush()
    world.sign_on("u3")
    world.flush()
    world.sign_on("u3")
    world.flush()
    assert world.units["u3"].held == ()
    world.check()
