"""A section or station that is worked by substitute working: by which table, with which trains, whose each step is.

A post (`simulation.procedure.Post`) is a role at a place: `dispatcher`, `operator OGN`, `pilot OGN-KRS`, `driver V1`.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, replace

from simulation.procedure import (
    POST_OF,
    PROCEDURES,
    WITHIN_STATION,
    ActingRole,
    Part,
    Post,
    ProcedureRow,
    rows_of_train,
)
from simulation.substitute.book import BlockBook
from simulation.substitute.hops import Hop
from simulation.substitute_settings import Substitute


@dataclass(slots=True)
class Work:
    """One section or station: by which table it is worked, and its book. `due_step`: when the row under way is done;
    `taken_as_over`: ways of trains that people take as over though nobody has said so; `aside`: what persons have done
    for trains that are not in the book.
    """

    name: str
    block: bool
    ends: tuple[str, ...]
    table: tuple[ProcedureRow, ...]
    hops: list[Hop] = field(default_factory=list)
    book: BlockBook = field(default_factory=BlockBook)
    row: ProcedureRow | None = None
    due_step: int = 0
    gone_s: float = 0.0
    taken_as_over: set[Hop] = field(default_factory=set[Hop])
    aside: dict[Hop, BlockBook] = field(default_factory=dict[Hop, BlockBook])
    over: bool = False
    home: str = ""  # where its pilot begins

    @property
    def rows(self) -> tuple[ProcedureRow, ...]:
        """The table as it is for the train in the book."""
        return self.rows_of(self.book)

    def rows_of(self, book: BlockBook) -> tuple[ProcedureRow, ...]:
        """The table as it is for the train in a book."""
        return rows_of_train(self.table, ticket=book.ticket)

    def book_of(self, hop: Hop | None) -> BlockBook:
        """The book, or what stands beside it of a train that is not in it."""
        return self.book if hop in (None, self.book.hop) else self.aside.get(hop, BlockBook(hop=hop))

    def keep(self, hop: Hop | None, book: BlockBook) -> None:
        """What `book_of` gives has changed."""
        if hop is None or hop == self.book.hop:
            self.book = book
        else:
            self.aside[hop] = book

    def take_up(self, hop: Hop, *, ticket: bool) -> None:
        """A train comes into the book, with what has been done for it already."""
        before = self.aside.pop(hop, None)
        self.book = self.book.takes(hop, ticket=ticket if before is None else before.ticket)
        if before is not None:
            left_out = self.book.left_out | before.left_out
            self.book = replace(self.book, of_train=before.of_train, left_out=left_out)

    def posts(self, row: ProcedureRow, hop: Hop | None) -> tuple[str, ...]:
        """Whose step it is, for the train whose way `hop` is: any of these does it."""
        post = POST_OF[row.who]
        match row.who:
            case ActingRole.DISPATCHER:
                return (post.value,)
            case ActingRole.PILOT:
                places: tuple[str, ...] = (self.name,)
            case ActingRole.DRIVER:
                places = () if hop is None else (hop.stock_id,)
            case ActingRole.SENDING if hop is not None:
                places = (hop.origin or self.name,)
            case ActingRole.RECEIVING if hop is not None:
                places = (hop.destination or self.name,)
            case ActingRole.SENDING | ActingRole.RECEIVING if row.part is Part.TRAIN:
                places = ()  # whose it is depends on the train
            case _:
                places = self.ends
        return tuple(f"{post.value} {place}" for place in places)


def works_of(hops: Iterable[Hop], settings: Substitute) -> list[Work]:
    """The sections and stations of these ways, nothing done yet."""
    works: dict[str, Work] = {}
    for hop in hops:
        ends = tuple(dict.fromkeys((hop.origin, hop.destination))) if hop.block else (hop.work,)
        rows = PROCEDURES[settings.regime_of(hop.block)] if hop.block else WITHIN_STATION
        work = works.setdefault(hop.work, Work(hop.work, bool(hop.block), tuple(sorted(ends)), rows))
        work.hops.append(hop)
    return list(works.values())


def steps_by_post(hops: Iterable[Hop], settings: Substitute) -> Mapping[tuple[str, str], tuple[str, ...]]:
    """By post and section or station, the steps that are its; a post that has none is none."""
    found: dict[tuple[str, str], dict[str, None]] = {}
    for work in works_of(hops, settings):
        for row in work.table:
            ways = work.hops if row.part is Part.TRAIN else [None]
            for post in dict.fromkeys(post for hop in ways for post in work.posts(row, hop)):
                found.setdefault((post, work.name), {})[row.step.value] = None
    return {key: tuple(steps) for key, steps in found.items()}


def is_post(post: str, *kinds: Post) -> bool:
    """Whether a post is of one of these kinds."""
    return post.partition(" ")[0] in kinds


def place_of(post: str) -> str:
    """Where a post is: a station, a section, a unit; empty of the one that there is once."""
    return post.partition(" ")[2]
