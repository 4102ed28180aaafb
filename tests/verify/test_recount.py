"""The checker takes a certificate that holds, and refuses one that does not."""

from collections.abc import Callable
from pathlib import Path
from typing import Any, Final

import numpy as np
import pytest
from msgspec.structs import replace
from numpy.typing import NDArray

from network.errors import InputError
from onboard.duty import duty_step
from verify.certificate import Certificate, read, sources_digest, write
from verify.expansion import Expansion
from verify.explore import certificate_of, explored
from verify.explored_line import BIT, Budgets, ExploredLine
from verify.halves import Halves
from verify.parties import ExploredParties, StepKind
from verify.recount import ELSEWHERE, NO_ROOM, NOT_IN_TABLES, recount
from verify.restored import restored
from verify.search import search

WIDTH: Final = 8


@pytest.fixture(scope="module")
def certificate() -> Certificate:
    return certificate_of(explored(ExploredLine(budgets=Budgets())))


def without(certificate: Certificate, index: int) -> Certificate:
    states, ranks = certificate.states, certificate.ranks
    return replace(
        certificate,
        states=states[: WIDTH * index] + states[WIDTH * (index + 1) :],
        ranks=ranks[: 2 * index] + ranks[2 * (index + 1) :],
    )


def test_it_holds_whatever_way_it_came(certificate: Certificate, tmp_path: Path) -> None:
    file = tmp_path / "a.cert"
    write(file, certificate)
    found = recount(read(file))
    assert found.refused == ""
    assert found.states == len(certificate.states) // WIDTH
    assert found.finished > 0


def test_it_names_those_parts_alone_that_a_state_has(certificate: Certificate) -> None:
    """Most cells of a train only come between two states, and would leave states no room in 64 bits."""
    states = np.frombuffer(certificate.states, ">u8").astype(np.int64)
    for bits, cells in zip(reversed(certificate.bits[1:]), reversed(certificate.cells), strict=True):
        assert np.array_equal(np.unique(states & (1 << bits) - 1), np.arange(len(cells)))
        states = states >> bits


@pytest.mark.parametrize(("trains", "budgets"), [(2, Budgets(1)), (3, Budgets(1)), (1, Budgets(0, 1, 0, 1))])
def test_it_finds_by_halves_as_many_successors_as_the_search(trains: int, budgets: Budgets) -> None:
    parties = ExploredParties(ExploredLine(trains=trains, budgets=budgets))
    expansion = Expansion(parties)
    keys = search(expansion, 3_000, lambda _: None, expansion.broken).states
    source, _, trouble = expansion.following(keys)
    grounds = [(key[:-1], expansion.lefts.things[key[-1]]) for key in expansion.ground_keys.things]
    halves = Halves(parties, grounds, [cells.named() for cells in expansion.cells])
    parts, numbers = list[NDArray[np.int64]](), keys.astype(np.int64)
    for bits in reversed(expansion.bits):
        parts.append(numbers & (1 << bits) - 1)
        numbers = numbers >> bits
    *cells, ground = parts
    found = list(halves.following(ground, cells[::-1]))
    of_search, of_halves = source << 3 | trouble, np.concatenate([f.source << 3 | f.trouble for f in found])
    assert np.array_equal(np.sort(of_halves), np.sort(of_search))
    for known, cells in zip(halves.cells, expansion.cells, strict=True):
        assert set(cells.named()) <= set(known) <= set(cells.keys.things)


@pytest.mark.parametrize("share", [0.0, 0.3, 0.7])
def test_one_state_removed_is_refused(certificate: Certificate, share: float) -> None:
    count = len(certificate.states) // WIDTH
    found = recount(without(certificate, int(share * count)))
    assert "leads out of the set" in found.refused or found.refused == "the start is not in it"


def test_an_unsafe_state_put_in_is_refused(certificate: Certificate) -> None:
    """Both trains in the portal: a cell of each in which it stands there, on the first ground."""
    parties = ExploredParties(certificate.line)
    for kind, *of in certificate.made:
        parties.make(StepKind(kind), *of)
    one, other = (
        next(
            index
            for index, cell in enumerate(certificate.cells[unit])
            if parties.train_models[unit].occupied(parties.trains[unit].things[cell[0]]) == BIT["P"]
        )
        for unit in (0, 1)
    )
    key = (one << certificate.bits[2]) | other
    states = sorted(
        [certificate.states[i : i + WIDTH] for i in range(0, len(certificate.states), WIDTH)]
        + [key.to_bytes(WIDTH)]
    )
    at = states.index(key.to_bytes(WIDTH))
    ranks = certificate.ranks[: 2 * at] + b"\0\1" + certificate.ranks[2 * at :]
    found = recount(replace(certificate, states=b"".join(states), ranks=ranks))
    assert "is not safe: two trains in one section" in found.refused


@pytest.mark.parametrize(("cells", "states"), [(2, (0, 1)), (1, (2**64 - 1,))])
def test_few_states_that_pass_for_all_others_are_refused(
    certificate: Certificate, cells: int, states: tuple[int, ...]
) -> None:
    """All trains have left before any came. The start has the number of such a state, as its cells have no room in it,
    or, where its cells are in no table, the number of what is in none.
    """
    parties = ExploredParties(certificate.line)
    for kind, *of in certificate.made:
        parties.make(StepKind(kind), *of)
    of_cells = Halves(parties, certificate.grounds, certificate.cells).of_cells
    gone = [
        next(c for c, done in zip(known, of.column("finished"), strict=True) if done and not any(c[1]))
        for known, of in zip(certificate.cells, of_cells, strict=True)
    ]
    parts, left = certificate.grounds[0]
    forged = replace(
        certificate,
        bits=(62, 0, 0),
        grounds=((parts, left), (parts, (7, *left[1:]))),
        cells=tuple((last, (0, last[1], 0))[:cells] for last in gone),
        states=b"".join(state.to_bytes(WIDTH) for state in states),
        ranks=bytes(2 * len(states)),
    )
    assert recount(forged).refused in (NO_ROOM, NOT_IN_TABLES)


def test_a_step_that_has_changed_is_refused(
    certificate: Certificate, monkeypatch: pytest.MonkeyPatch
) -> None:
    """By the local states, even where the digest of the sources is not looked at."""

    def none_cleared(*_: object) -> tuple[str, ...]:
        return ()

    monkeypatch.setattr(duty_step, "cleared_sections", none_cleared)
    found = recount(certificate, sources=sources_digest())
    assert ELSEWHERE in found.refused


def test_other_sources_are_refused(certificate: Certificate) -> None:
    assert "another digest" in recount(certificate, sources="0" * 32).refused


def test_a_rank_that_nothing_lowers_is_refused(certificate: Certificate) -> None:
    ranks = bytearray(certificate.ranks)
    at = next(i for i in range(0, len(ranks), 2) if int.from_bytes(ranks[i : i + 2]) > 3)
    ranks[at : at + 2] = (1).to_bytes(2)
    assert "no event that leads to a rank below" in recount(replace(certificate, ranks=bytes(ranks))).refused


def test_a_file_that_is_damaged_or_none_is_bad_input(certificate: Certificate, tmp_path: Path) -> None:
    file = tmp_path / "a.cert"
    write(file, certificate)
    data = bytearray(file.read_bytes())
    data[len(data) // 2] ^= 1
    file.write_bytes(data)
    with pytest.raises(InputError, match="whole"):
        read(file)


def test_no_certificate_of_what_does_not_hold() -> None:
    with restored("sign-off-frees"):
        found = explored(ExploredLine(budgets=Budgets(loss=1)))
    with pytest.raises(ValueError, match="safe and alive"):
        certificate_of(found)


@pytest.mark.parametrize(
    "options",
    [
        ("--crossing", "barriers", "--restore", "sign-off-frees"),
        ("--crossing", "barriers", "--out", "a.cert"),
        ("--restore", "sign-off-frees", "--out", "a.cert"),
        ("--collisions", "--out", "a.cert"),
    ],
)
def test_what_would_not_be_done_is_refused(
    main: Callable[..., Any], tmp_path: Path, options: tuple[str, ...]
) -> None:
    assert main("verify", "explore", "0", *options).code == 2
    assert not list(tmp_path.iterdir())


def test_collisions_alone_are_not_called_safe(main: Callable[..., Any]) -> None:
    told = main("verify", "explore", "0", "--collisions")
    assert told.code == 0
    assert "no other rule was looked at" in told.out
