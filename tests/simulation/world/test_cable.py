"""Who is reached over a cut cable, and that nobody is the worse for it where the interlocking is on board."""

from typing import Final

import pytest
from hypothesis import given
from hypothesis import strategies as st

from network.files.line_file import load_line
from network.files.shipped import shipped_line
from network.model import Line
from simulation.faults.cable import WHOLE, CableCut, CutCable, stretches_of
from simulation.faults.fault import folded_value
from simulation.settings import Interlocking, Operation
from simulation.world.cable import Cable, centre_of
from wayside.config import MANAGER_ID

LINE: Final[Line] = load_line(shipped_line("karasuyama"))
CENTRAL: Final = Operation(interlocking=Interlocking.CENTRAL)
places_m: Final = st.floats(-1000.0, 20_304.0)
shares: Final = st.floats(0.0, 1.0)
stretches: Final = st.sampled_from(stretches_of(LINE))


def cable_of(*cuts: CableCut, centre: str | None = None) -> Cable:
    cable = Cable(LINE, CENTRAL.model_copy(update={"centre": centre}))
    cable.cut(cuts)
    return cable


def test_stretches_join_neighbours_along_the_line() -> None:
    assert stretches_of(LINE)[:2] == ("HSK - SHN", "SHN - NIT")
    assert stretches_of(LINE)[-1] == "TAK - KRS"
    assert len(stretches_of(LINE)) == len(LINE.stations) - 1


def test_the_centre_is_at_the_first_station_or_where_it_is_said_to_be() -> None:
    assert centre_of(LINE, CENTRAL) == "HSK"
    assert centre_of(LINE, CENTRAL.model_copy(update={"centre": "KRS"})) == "KRS"


@pytest.mark.parametrize(
    ("centre", "unit_m", "device", "carried"),
    [
        (None, 3_000.0, MANAGER_ID, True),  # between the centre at Hoshakuji and the cut at km 13.8
        (None, 13_000.0, "OGN-E", True),
        (None, 14_000.0, MANAGER_ID, False),
        (None, 14_000.0, "OGN-E", False),  # however near: by way of the centre
        ("KRS", 14_000.0, MANAGER_ID, True),
        ("KRS", 20_000.0, "OGN-E", False),
        ("KRS", 12_600.0, MANAGER_ID, False),
        ("OGN", 20_000.0, MANAGER_ID, False),
        ("OGN", 0.0, "HSK-S", True),
    ],
)
def test_beyond_a_cut_nobody_is_reached(
    centre: str | None, unit_m: float, device: str, carried: bool
) -> None:
    assert cable_of(CableCut("OGN - KBN", 0.5), centre=centre).carries(unit_m, device) is carried


@given(stretches, shares, places_m, places_m)
def test_who_is_nearer_to_the_centre_is_never_worse_off(
    stretch: str, along: float, one_m: float, other_m: float
) -> None:
    cable = cable_of(CableCut(stretch, along))
    nearer_m, further_m = sorted((max(one_m, 0.0), max(other_m, 0.0)))
    assert cable.carries(nearer_m, MANAGER_ID) or not cable.carries(further_m, MANAGER_ID)


@given(places_m, st.sampled_from(sorted(p.terminal_id for p in LINE.points.values())))
def test_a_cut_of_the_whole_cable_reaches_everybody(unit_m: float, device: str) -> None:
    cable = cable_of(CableCut(WHOLE, 0.5))
    assert not cable.carries(unit_m, device)
    assert not cable.carries(unit_m, MANAGER_ID)


@given(places_m, stretches, shares)
def test_on_board_a_cut_takes_nothing_away(unit_m: float, stretch: str, along: float) -> None:
    cable = Cable(LINE, Operation())
    cable.cut((CableCut(stretch, along), CableCut(WHOLE, 0.5)))
    assert not cable.severed
    assert cable.carries(unit_m, MANAGER_ID)


@given(st.lists(st.tuples(stretches, shares), max_size=4), places_m)
def test_cuts_that_overlap_are_one_quantity(given_cuts: list[tuple[str, float]], unit_m: float) -> None:
    """Each takes away what it takes alone, and one that ends leaves the others."""
    faults = [CutCable(target=stretch, along_share=along) for stretch, along in given_cuts]
    assert len({fault.place for fault in faults}) <= 1
    cuts: tuple[CableCut, ...] = folded_value((), faults)
    alone = [cable_of(cut).carries(unit_m, MANAGER_ID) for cut in cuts]
    assert cable_of(*cuts).carries(unit_m, MANAGER_ID) is all(alone)


def test_staff_work_relay_interlockings_an_hour_after_the_cut_and_agree_on_each_train_by_telephone() -> None:
    relay = Cable(
        LINE, Operation(interlocking=Interlocking.RELAY, staff_reach_s=3600.0, telephone_block_s=180.0)
    )
    relay.cut((CableCut(WHOLE, 0.5),), 1000.0)
    assert not relay.carries(0.0, MANAGER_ID)
    assert not relay.worked_locally(4599.9, "K1", asks_route=False)
    assert relay.worked_locally(4600.0, "K1", asks_route=False)
    # asked every 2 s from 4600 s on, and once more for another route after a minute in which it asked for nothing
    heard = [t_s for t_s in range(4600, 4800, 2) if relay.worked_locally(float(t_s), "K1", asks_route=True)]
    assert heard[0] == 4780
    assert not relay.worked_locally(4860.0, "K1", asks_route=True)
    relay.cut((), 5000.0)
    relay.cut((CableCut(WHOLE, 0.5),), 6000.0)
    assert not relay.worked_locally(6001.0, "K1", asks_route=False)


@pytest.mark.parametrize("interlocking", [Interlocking.CENTRAL, Interlocking.ONBOARD])
def test_nobody_works_stations_that_have_no_interlocking_of_their_own(interlocking: Interlocking) -> None:
    cable = Cable(LINE, Operation(interlocking=interlocking))
    cable.cut((CableCut(WHOLE, 0.5),), 0.0)
    assert not cable.worked_locally(1e6, "K1", asks_route=False)
