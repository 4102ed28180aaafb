from itertools import pairwise

import pytest

from network.graph import all_routes
from network.model import SectionKind
from network.timetable import AtPortal, BecomesTrain
from simulation.setup import Setup
from simulation.world.roster import draw_up, first_section, portal_mark_m, stabled_at_start

LEAD_S = 210.0


def lengths(setup: Setup) -> dict[str, float]:
    return {d.stock_id: 40.0 for d in setup.timetable.diagrams}


def test_the_test_line_has_one_stabled_stock_with_one_train(rtri_setup: Setup) -> None:
    duties = draw_up(rtri_setup.line, rtri_setup.timetable, lengths(rtri_setup), LEAD_S)
    assert list(duties) == ["K1"]
    (duty,) = duties["K1"]
    assert stabled_at_start(duties["K1"])
    assert not stabled_at_start(())
    assert (duty.enters, duty.leaves, duty.becomes) == (False, False, None)
    assert duty.enter_s == 36_000.0  # 10:00:00, its departure
    assert first_section(rtri_setup.line, duty.train) == "3"


def test_every_train_of_a_day_is_somebodys_duty(karasuyama_setup: Setup) -> None:
    setup = karasuyama_setup
    duties = draw_up(setup.line, setup.timetable, lengths(setup), LEAD_S)
    numbers = [duty.train.number for of_stock in duties.values() for duty in of_stock]
    assert sorted(numbers) == sorted(setup.timetable.trains)
    for of_stock in duties.values():
        for duty in of_stock:
            spans = duty.mission.spans
            assert duty.enters == isinstance(duty.train.begins, AtPortal)
            assert duty.enters == (spans[0].kind is SectionKind.PORTAL)
            assert duty.leaves == (spans[-1].kind is SectionKind.PORTAL)
            if duty.enters:
                assert duty.enter_s == duty.train.calls[0].first_s - LEAD_S
        for before, after in pairwise(of_stock):
            if isinstance(before.train.ends, BecomesTrain):
                assert before.becomes == after.train.number
                assert before.mission.spans[-1].section_id == after.mission.spans[0].section_id


def test_a_train_enters_on_its_portal_tag(karasuyama_setup: Setup) -> None:
    setup = karasuyama_setup
    entering = next(t for t in setup.timetable.trains.values() if isinstance(t.begins, AtPortal))
    assert isinstance(entering.begins, AtPortal)
    portal = entering.begins.section_id
    piece = setup.line.pieces[setup.line.sections[portal].piece_ids[0]]
    mark_m = portal_mark_m(setup.line, entering, portal, 40.0)
    assert mark_m in {t.position_m for t in setup.line.tags.values() if t.piece_id == piece.id}
    assert piece.from_m < mark_m < piece.to_m


def test_routes_for_messages(rtri_setup: Setup) -> None:
    """Two tracks at A and B: each station can be left and reached by both, from either side."""
    routes = tuple(route.id for route in all_routes(rtri_setup.line))
    assert {"PW>3", "PW>4", "3>8", "3>9", "4>8", "4>9", "8>PE", "9>PE"} <= set(routes)
    assert len(routes) == len(set(routes)) == 16


def test_a_train_without_a_track_is_named(rtri_setup: Setup) -> None:
    from dataclasses import replace

    train = rtri_setup.timetable.trains["T1"]
    wrong = replace(train, calls=(replace(train.calls[0], track="9"), *train.calls[1:]))
    with pytest.raises(ValueError, match="train T1 has no track at A"):
        first_section(rtri_setup.line, wrong)
