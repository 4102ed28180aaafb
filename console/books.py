"""Substitute working at the desk: its tables once, and the books of its sections as often as they are asked for."""

from __future__ import annotations

from console.line_drawn import PostDrawn, StepDrawn, WorkDrawn
from console.protocol import StepShown, StepState, WorkShown
from console.seats import Seat, may_be
from console.session import Session
from simulation.procedure import POST_OF, Part, ProcedureRow
from simulation.setup import Setup
from simulation.substitute.hops import hops_of
from simulation.substitute.players import SubstitutePlayers
from simulation.substitute.work import Work, place_of, works_of
from simulation.world.roster import drawn_up
from study.wording.parties import party
from study.wording.procedure import role_name, says_text, step_name, waits_text

THE_TRAIN = "{train}"  # in what is said, where its number stands


def works_drawn(setup: Setup) -> tuple[WorkDrawn, ...]:
    """The sections and stations of a scenario that has substitute working, with their tables."""
    if setup.substitute is None:
        return ()
    return tuple(
        WorkDrawn(
            block=work.name,
            regime=setup.substitute.regime_of(work.name).value if work.block else "",
            rows=tuple(_drawn(work.name, row) for row in work.table),
            trains=tuple(dict.fromkeys(hop.train for hop in work.hops)),
        )
        for work in works_of(hops_of(drawn_up(setup, setup.line)), setup.substitute)
    )


def posts_drawn(session: Session, seat: Seat) -> tuple[PostDrawn, ...]:
    """The roles that the holder of a seat may take; of drivers only one has the unit."""
    return tuple(
        PostDrawn(post=post, name_ja=party(post).in_("ja"))
        for post in session.names.posts
        if may_be(seat, post, place_of(post))
    )


def _drawn(block: str, row: ProcedureRow) -> StepDrawn:
    who, to = role_name(row.who.value), role_name(row.to.value)
    says, waits = says_text(row.step.value, block, THE_TRAIN), waits_text(row)
    return StepDrawn(
        step=row.step.value,
        post=POST_OF[row.who].value,
        name_ja=step_name(row.step.value).in_("ja"),
        part=row.part.name.lower(),
        who=who.en,
        who_ja=who.in_("ja"),
        to=to.en,
        to_ja=to.in_("ja"),
        says=says.en,
        says_ja=says.in_("ja"),
        needs=tuple(step.value for step in row.needs),
        waits=waits.en,
        waits_ja=waits.in_("ja"),
    )


def players_of(session: Session) -> SubstitutePlayers | None:
    """Those who work the line of a session by substitute working; None where there are none."""
    people = session.simulation.by_people
    return people if isinstance(people, SubstitutePlayers) else None


def roles_taken(session: Session) -> tuple[str, ...]:
    """The roles that persons have."""
    players = players_of(session)
    return () if players is None else tuple(sorted(players.persons.taken))


def works_shown(session: Session) -> tuple[WorkShown, ...]:
    """Every book, while substitute working is in force."""
    players = players_of(session)
    if players is None:
        return ()
    return tuple(_shown(session, players, work) for work in players.works if not work.over)


def _shown(session: Session, players: SubstitutePlayers, work: Work) -> WorkShown:
    hop = work.book.hop
    due = {row.step for row in work.book.due_rows(work.rows, ending=players.is_ending(work))}
    under_way = {begun.row.step for begun in players.persons.begun if begun.work is work}
    if work.row is not None:
        under_way.add(work.row.step)
    return WorkShown(
        block=work.name,
        train="" if hop is None else hop.train,
        pilot=work.book.pilot,
        steps=tuple(
            StepShown(
                step=row.step.value,
                state=StepState.UNDER_WAY
                if row.step in under_way
                else _state(session, players, work, row, is_due=row.step in due),
                posts=work.posts(row, hop if row.part is Part.TRAIN else None),
            )
            for row in work.table
        ),
    )


def _state(
    session: Session, players: SubstitutePlayers, work: Work, row: ProcedureRow, *, is_due: bool
) -> StepState:
    book = work.book
    if row.step in book.left_out:
        return StepState.LEFT_OUT
    if row.step in book.steps:
        return StepState.DONE
    if not is_due:
        return StepState.LATER
    lets = players.sight.lets(work, row, book.hop, session.step)
    return StepState.NEXT if lets else StepState.WAITS
