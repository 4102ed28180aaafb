"""A person who works a line by substitute working as the page says: each step of the own roles once it is next."""

from collections.abc import Iterable
from dataclasses import replace
from typing import Any

from console.books import works_shown
from console.desk import Desk
from console.protocol import DeskAnswer, DoAct, StepState
from console.seats import Seat
from console.session import Session
from scenario.scenario import Scenario, load_scenario
from simulation.procedure import PROCEDURES, WITHIN_STATION, Part, Regime
from simulation.result import RunResult
from study.drilling.drill import find_drill

TRAIN_STEPS = {
    row.step.value
    for rows in (*PROCEDURES.values(), WITHIN_STATION)
    for row in rows
    if row.part is Part.TRAIN
}


def drill_of(name: str, **changes: Any) -> Scenario:  # noqa: ANN401 - of the settings
    """A drill with other settings of `[substitute]`."""
    scenario = load_scenario(find_drill(name))
    setup = scenario.setup
    assert setup.substitute is not None
    return replace(scenario, setup=replace(setup, substitute=setup.substitute.model_copy(update=changes)))


def of_regime(name: str, regime: Regime) -> Scenario:
    """A drill worked by another regime."""
    return drill_of(name, regime=regime)


class AtPosts:
    """Whoever has these roles in a session, from the instructor's seat, which may have all."""

    def __init__(self, session: Session, posts: Iterable[str] = ()) -> None:
        self.session, self.desk = session, Desk(session)
        self.posts: set[str] = set()
        for post in posts:
            self.take(post)

    def act(self, kind: str, post: str, **keys: str) -> DeskAnswer:
        table = {"kind": kind, "target": post, **keys}
        return self.desk.ask(Seat.INSTRUCTOR, DoAct(act=table), 0.0)

    def take(self, post: str) -> None:
        assert self.act("take_role", post).good
        self.posts.add(post)
        self.session.run_to(self.session.step + 2)

    def hand_back(self, post: str) -> None:
        assert self.act("hand_back_role", post).good
        self.posts.discard(post)
        self.session.run_to(self.session.step + 2)

    def do(self, post: str, step: str, block: str, train: str = "", kind: str = "do_step") -> None:
        keys = {"train": train} if train else {}
        answer = self.act(kind, post, step=step, block=block, **keys)
        assert answer.good, answer.why
        self.session.run_to(self.session.step + 2)

    def steps(self, *states: StepState) -> list[tuple[str, str, str, str]]:
        """Own steps in these states: role, step, block, train."""
        return [
            (own, shown.step, work.block, work.train if shown.step in TRAIN_STEPS else "")
            for work in works_shown(self.session)
            for shown in work.steps
            for own in [post for post in shown.posts if post in self.posts][:1]
            if shown.state in states
        ]

    def follow(self) -> None:
        """All that is next now."""
        while self.session.ended is None and (steps := self.steps(StepState.NEXT)):
            self.do(*steps[0])

    def run(self, until_s: float = float("inf")) -> None:
        """Follow until a time, or to the end."""
        session = self.session
        while session.ended is None and session.now_s < until_s:
            self.follow()
            session.next_event()

    def result(self) -> RunResult:
        self.run()
        return self.session.result
