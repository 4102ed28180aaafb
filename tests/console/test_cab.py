"""What the cab says in Japanese: no word of it is left in English."""

import re
from collections import deque

import pytest
from msgspec.structs import replace

from console.cab import wait_text
from onboard.duty.shown import waits_for
from onboard.duty.unable import NoCharge, TooSteep, Unable
from scenario.scenario import load_scenario
from study.wording.phrase import names_of
from verify.lone_unit import PLANS, ExploredRun, first, steps

ENGLISH = re.compile(r"[a-z]{3,}")
STATES = 1_500


def wait_ja(waits_for: str) -> str:
    return wait_text(waits_for, {}).in_("ja")


def states() -> set[ExploredRun]:
    """Of one unit, the nearest to the beginning of its day."""
    seen = set(first())
    queue = deque(seen)
    while queue and len(seen) < STATES:
        for after in (step.run for step in steps(queue.popleft())):
            if after not in seen:
                seen.add(after)
                queue.append(after)
    return seen


def test_whatever_a_unit_waits_for_is_said_in_japanese() -> None:
    said = {waits_for(PLANS[run.plan], run.state) for run in states()}
    assert len(said) > 15
    assert {text: wait_ja(text) for text in said if ENGLISH.search(wait_ja(text))} == {}


STEEP = {
    "station": "B",
    "piece_id": "A-B",
    "kilometrage_m": 1500.0,
    "gradient_permille": 25.0,
    "pull_n": 60e3,
    "needed_n": 80e3,
    "load_share": 0.5,
    "motors_share": 0.5,
}


@pytest.mark.parametrize(
    "unable",
    [
        TooSteep(**STEEP),
        TooSteep(**STEEP, adhesion_factor=0.3),
        *(
            NoCharge(station, 1e7, 2e7, charges, full=full, up=up)
            for station in ("B", "")
            for charges, full, up in (
                (False, False, True),
                (True, True, True),
                (True, False, True),
                (True, False, False),
            )
        ),
        NoCharge("B", 3e7, 2e7, charges=True, connected=True),
    ],
    ids=lambda unable: unable.words,
)
def test_so_is_what_keeps_a_train_from_its_next_stop(unable: Unable) -> None:
    assert ENGLISH.search(wait_ja(f"what takes it to B: {unable.words}")) is None


def test_so_is_what_ails_a_unit_that_shows_nothing_and_devices_that_have_lost_their_memory() -> None:
    lost = "it has lost its durable state, and people must commission it"
    said = [wait_ja(text) for text in (f"its unit: {lost}", f"route A>B: held; B-W: {lost}")]
    assert [ENGLISH.search(text) for text in said] == [None, None]
    assert "B-W" in said[1] and "A>B" in said[1]


def test_so_is_the_level_crossing_for_which_a_train_stands() -> None:
    at_road = {
        (run.plan, replace(run.state, place=replace(run.state.place, crossing="C7"))) for run in states()
    }
    said = {wait_ja(waits_for(PLANS[plan], state)) for plan, state in at_road}
    assert "踏切C7の遮断証明" in said


def test_stations_go_by_their_names_in_the_language_of_the_reader() -> None:
    """下野花岡 is SHN in the line's file, and B stands for a station of another line."""
    names = names_of(load_scenario("karasuyama_weekday").setup.line)
    said = wait_text("its run to SHN", names)
    assert (said.en, said.in_("ja")) == ("its run to Shimotsuke-Hanaoka", "下野花岡までの走行")
    needs = wait_text(f"what takes it to SHN: {NoCharge('OGN', 1e7, 2e7, True).words}", names)
    assert "下野花岡まで" in needs.in_("ja") and "大金" in needs.in_("ja")
    assert wait_text("its run to B", names).in_("ja") == "Bまでの走行"
