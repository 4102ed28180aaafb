"""Whatever tags say within what units are told to expect, the truth stays inside the bounds."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from itertools import accumulate

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from network.model import TagPurpose
from onboard.localisation.tags import TagDoubt, TagOutcome, Wheels
from onboard.localisation.wheel_scale import LEARNED_OVER_M, WheelScale, front_interval
from onboard.mission import PathTag
from onboard.records import UNIT
from onboard.unit_records import UnitParameters

PARAMETERS = UnitParameters()
TRUSTING = PARAMETERS.model_copy(update={"tags_wrong_together": 0})
START_M = 100.0
READ_WITHIN_M = 0.2


@dataclass
class Ride:
    """A train that truly is at `true_m`, on a wheel worth `worn` metres a metre counted, and its unit."""

    tags: tuple[PathTag, ...]
    worn: float = 1.0
    parameters: UnitParameters = PARAMETERS
    true_m: float = START_M
    heard: list[TagOutcome] = field(default_factory=list)

    def __post_init__(self) -> None:
        self.row = np.zeros(1, dtype=UNIT).view(np.recarray)[0]
        self.row.position_known, self.row.odometer_scale = 1, 1.0
        self.row.position_m = self.true_m
        self.row.bound_ahead_m = self.row.bound_behind_m = self.parameters.tag_accuracy_m
        self.doubt = TagDoubt(self.row, self.parameters)
        self.doubt.position_told()
        self.doubt.new_path(self.tags)

    @property
    def out_m(self) -> float:
        """By how much the truth is out of the bounds; not positive where it is inside, or nothing is stated."""
        if not self.row.position_known:
            return -np.inf
        beyond_m = self.true_m - self.row.position_m
        return float(max(beyond_m - self.row.bound_ahead_m, -beyond_m - self.row.bound_behind_m))

    def run_to(self, true_m: float, changes: float = 0.0) -> None:
        """Run, each metre counted being worth that much more than the wheel is."""
        counted_m = (true_m - self.true_m) / (self.worn + changes)
        row = self.row
        row.odometer_m += counted_m
        row.position_m += counted_m * row.odometer_scale
        row.bound_ahead_m += counted_m * row.bound_growth
        row.bound_behind_m += counted_m * row.bound_growth
        self.true_m = true_m

    def read_all(self, *tags: PathTag) -> None:
        """Run to where each lies and read it."""
        for tag in tags:
            self.run_to(tag.position_m)
            self.read(tag)

    def read(self, tag: PathTag, error_m: float = 0.0) -> TagOutcome:
        """The reader reads what calls itself `tag`; what the driving part makes of it."""
        heard, _ = self.doubt.tag_read(tag, float(self.row.odometer_m) + error_m)
        if heard is TagOutcome.OUT:
            self.doubt.begin_doubt()
            self.row.position_known = 0
        self.heard.append(heard)
        return heard


def tags_at(*positions_m: float) -> tuple[PathTag, ...]:
    return tuple(PathTag(number, at_m, TagPurpose.POSITION) for number, at_m in enumerate(positions_m))


@dataclass(frozen=True)
class Laid:
    """A tag of a drawn line: how far behind the one before it, and what is wrong with it."""

    gap_m: float
    ill: str
    by_m: float
    changes: float
    error_m: float


worn = st.floats(1.0 - PARAMETERS.wheel_scale_limit, 1.0 + PARAMETERS.wheel_scale_limit)
changes = st.floats(-0.0049, 0.0049)
lies = st.floats(-60.0, 60.0)
laid = st.builds(
    Laid,
    gap_m=st.one_of(st.floats(8.0, 60.0), st.floats(60.0, 3000.0)),
    ill=st.sampled_from(["none", "none", "none", "missed", "moved", "wrong", "swapped"]),
    by_m=lies,
    changes=changes,
    error_m=st.floats(-READ_WITHIN_M, READ_WITHIN_M),
)


def ills_of(line: Sequence[Laid]) -> list[str]:
    """What is wrong with each tag; the one after a tag that was swapped is the other one of the two."""
    ills: list[str] = []
    for index, one in enumerate(line):
        if index and ills[-1] == "swapped":
            ills.append("swapped with")
        else:
            last = index + 1 == len(line)
            ills.append("none" if last and one.ill in ("wrong", "swapped") else one.ill)
    return ills


def ride_along(line: Sequence[Laid], worn: float, parameters: UnitParameters, together: int) -> Ride:
    """Run along the line and read its tags; AssertionError where the truth leaves the bounds.

    One that would be one too many that lie together is not read, nor is one passed before the one before it.
    """
    tags = tags_at(*(START_M + at_m for at_m in accumulate(one.gap_m for one in line)))
    ride = Ride(tags, worn, parameters)
    lying, swapped = 0, False
    for index, (one, ill) in enumerate(zip(line, ills_of(line), strict=True)):
        at_m = tags[index].position_m + (one.by_m if ill == "moved" else 0.0)
        lies = ill != "none"
        unread = ill == "missed" or at_m <= ride.true_m or (ill == "swapped with" and not swapped)
        too_many = lies and lying >= together and ill != "swapped with"
        swapped = ill == "swapped" and not unread and not too_many
        if unread or too_many:
            continue
        lying = lying + 1 if lies else 0
        says = {"wrong": index + 1, "swapped": index + 1, "swapped with": index - 1}.get(ill, index)
        ride.run_to(at_m, one.changes)
        assert ride.out_m <= 1e-9, (index, ill)
        ride.read(tags[says], one.error_m)
        assert ride.out_m <= 1e-9, (index, ill, ride.heard)
    return ride


@given(st.lists(laid, min_size=2, max_size=25), worn)
def test_the_truth_stays_inside_whatever_tags_say(line: list[Laid], worn: float) -> None:
    ride_along(line, worn, PARAMETERS, 1)


@given(st.lists(laid, min_size=2, max_size=25), worn)
def test_two_that_lie_together_need_the_bounds_to_span_three(line: list[Laid], worn: float) -> None:
    ride_along(line, worn, PARAMETERS.model_copy(update={"tags_wrong_together": 2}), 2)


MOVED = [Laid(2000.0, "none", 0.0, 0.0, 0.0), Laid(2000.0, "moved", 25.0, 0.0, 0.0)]


def test_trusted_a_moved_tag_moves_the_bounds_off_the_truth() -> None:
    ride_along(MOVED, 1.0, PARAMETERS, 1)
    with pytest.raises(AssertionError, match="moved"):
        ride_along(MOVED, 1.0, TRUSTING, 1)


def test_where_more_tags_lie_than_units_expect_bounds_may_be_broken() -> None:
    line = [*MOVED, Laid(200.0, "moved", 25.0, 0.0, 0.0)]
    with pytest.raises(AssertionError, match="moved"):
        ride_along(line, 1.0, PARAMETERS, 2)


def test_a_tag_that_deviates_from_what_the_wheels_are_known_to_be_worth_is_doubted() -> None:
    """And does not move the estimate; the next one tells that it was wrong."""
    ride = Ride(tags_at(*(START_M + 1000.0 * n for n in range(1, 8))))
    for tag in ride.tags[:5]:
        ride.run_to(tag.position_m)
        assert ride.read(tag) is TagOutcome.BELIEVED
    assert ride.row.bound_growth < 0.6 * PARAMETERS.wheel_error_share
    ride.run_to(ride.tags[5].position_m - 18.0)
    before_m = float(ride.row.position_m)
    assert ride.read(ride.tags[5]) is TagOutcome.DOUBTED
    assert float(ride.row.position_m) == before_m
    assert ride.out_m <= 0.0
    ride.run_to(ride.tags[6].position_m)
    assert ride.read(ride.tags[6]) is TagOutcome.BELIEVED
    assert ride.out_m <= 0.0


def test_a_worn_wheel_is_not_taken_for_wrong_tags() -> None:
    ride = Ride(
        tags_at(*(START_M + 1000.0 * n for n in range(1, 8))), worn=1.0 - PARAMETERS.wheel_scale_limit
    )
    ride.read_all(*ride.tags)
    assert set(ride.heard) == {TagOutcome.BELIEVED}


def test_after_a_fault_told_by_a_tag_the_bounds_before_it_are_spanned_too() -> None:
    """The tag that fixes the position again lies: trusted, it would be a false position."""
    ride = Ride(tags_at(400.0, 800.0, 1500.0))
    ride.run_to(400.0)
    assert ride.read(ride.tags[2]) is TagOutcome.OUT
    ride.run_to(810.0)  # moved by 10 m
    assert ride.read(ride.tags[1]) is TagOutcome.BELIEVED
    assert ride.out_m <= 0.0
    assert ride.row.bound_ahead_m > 10.0


def lose_to_a_tag_of_another_path(ride: Ride) -> None:
    ride.doubt.begin_doubt(Wheels.SOUND)
    ride.row.position_known = 0


def test_wheels_are_not_doubted_for_a_tag_that_lies_on_another_path() -> None:
    """No count of theirs explains it: bounds grow as before it, and hold what the next tag may lie by."""
    ride = Ride(tags_at(400.0, 800.0, 1500.0))
    ride.run_to(400.0)
    ride.read(ride.tags[0])
    growth = ride.row.bound_growth
    lose_to_a_tag_of_another_path(ride)
    assert ride.row.bound_growth == growth
    ride.run_to(810.0)  # moved by 10 m
    assert ride.read(ride.tags[1]) is TagOutcome.BELIEVED
    assert ride.out_m <= 0.0
    assert ride.row.bound_ahead_m > 10.0


def test_of_two_faults_one_after_the_other_the_tag_between_is_spanned() -> None:
    """Read in doubt, and right: the fault after it says nothing against it, and the next tag may lie."""
    ride = Ride(tags_at(400.0, 425.0, 460.0, 800.0, 1500.0))
    ride.run_to(350.0)
    ride.doubt.begin_doubt()
    ride.row.position_known = 0
    ride.run_to(425.0)
    assert ride.read(ride.tags[1]) is TagOutcome.DOUBTED
    lose_to_a_tag_of_another_path(ride)
    ride.run_to(810.0)
    assert ride.read(ride.tags[3]) is TagOutcome.BELIEVED
    assert ride.out_m <= 0.0


def measured(*further_m: float) -> Ride:
    """Five tags have told what wheels are worth, then one said that it is another one, far away."""
    ride = Ride(tags_at(*(START_M + 1000.0 * n for n in range(1, 6)), *further_m, 20_000.0))
    ride.read_all(*ride.tags[:5])
    ride.run_to(ride.true_m + 300.0)
    assert ride.read(ride.tags[-1]) is TagOutcome.OUT
    assert ride.row.bound_growth == PARAMETERS.doubt_error_share
    return ride


def test_the_first_tag_that_answers_the_one_before_the_fault_shows_that_wheels_are_sound() -> None:
    """Of three tags only the middle one does not fit what wheels are known to be worth: it was the tag that lied."""
    ride = measured(6_000.0)
    ride.run_to(6_000.0)
    assert ride.read(ride.tags[5]) is TagOutcome.BELIEVED
    assert ride.row.bound_growth < 0.6 * PARAMETERS.wheel_error_share
    assert ride.out_m <= 0.0


def test_wheels_that_are_worth_something_else_since_stay_in_doubt() -> None:
    ride = measured(6_000.0)
    ride.run_to(6_000.0, changes=0.1)
    assert ride.read(ride.tags[5]) is TagOutcome.BELIEVED
    assert ride.row.bound_growth == PARAMETERS.doubt_error_share


def test_nor_does_what_was_known_come_back_where_the_tachometer_shows_what_no_slide_explains() -> None:
    ride = measured(6_000.0)
    ride.doubt.begin_doubt(Wheels.FALSE)
    ride.run_to(6_000.0)
    assert ride.read(ride.tags[5]) is TagOutcome.BELIEVED
    assert ride.row.bound_growth == PARAMETERS.doubt_error_share


def fix_within(ride: Ride, half_m: float) -> None:
    """An absolute sensor has the front where it is."""
    ride.row.fix_low_m, ride.row.fix_high_m = ride.true_m - half_m, ride.true_m + half_m
    ride.row.fix_odometer_m = ride.row.odometer_m
    ride.doubt.fix_came()


@pytest.mark.parametrize(("half_m", "sound"), [(0.5, True), (20.0, False)])
def test_so_does_a_fix_that_tells_it_as_finely_as_wheels_are_stated(half_m: float, sound: bool) -> None:
    ride = measured(6_000.0)
    ride.run_to(ride.true_m + 500.0)
    fix_within(ride, half_m)
    assert bool(ride.row.bound_growth < PARAMETERS.wheel_error_share) is sound


def test_fixes_measure_the_wheels_of_a_train_that_reads_tags() -> None:
    ride = Ride(tags_at(400.0), worn=1.01)
    fix_within(ride, 0.5)
    ride.run_to(START_M + 1000.0)
    fix_within(ride, 0.5)
    assert ride.row.bound_growth < 0.6 * PARAMETERS.wheel_error_share
    assert ride.row.odometer_scale == pytest.approx(1.01, abs=0.006)


@pytest.mark.parametrize(("off_m", "wheels"), [(8.0, Wheels.DOUBTED), (60.0, Wheels.SOUND)])
def test_wheels_are_doubted_for_what_they_could_err_by_since_a_fix(off_m: float, wheels: Wheels) -> None:
    ride = Ride(tags_at(400.0, 800.0 + off_m))
    ride.row.fix_at_m = -np.inf
    ride.run_to(400.0)
    ride.read(ride.tags[0])
    ride.run_to(770.0)
    assert ride.doubt.wheels_by_tag(ride.tags[1], float(ride.row.odometer_m)) is Wheels.DOUBTED
    ride.row.fix_at_m, ride.row.fix_odometer_m = 770.0, ride.row.odometer_m
    ride.row.fix_low_m, ride.row.fix_high_m = 766.0, 774.0
    ride.run_to(800.0)
    assert ride.doubt.wheels_by_tag(ride.tags[1], float(ride.row.odometer_m)) is wheels
    assert ride.doubt.wheels_by_overdue(780.0) is Wheels.SOUND
    assert ride.doubt.wheels_by_overdue(799.0) is Wheels.DOUBTED


def test_wheels_that_are_out_of_order_say_nothing_of_where_it_is() -> None:
    ride = Ride(tags_at(150.0, 400.0))
    ride.run_to(160.0)
    ride.doubt.begin_doubt(Wheels.FALSE)
    ride.row.position_known = 0
    ride.run_to(400.0)
    assert ride.read(ride.tags[1]) is TagOutcome.BELIEVED
    assert ride.row.bound_ahead_m == pytest.approx(PARAMETERS.tag_accuracy_m)


@pytest.mark.parametrize("turned", [False, True])
def test_on_another_path_what_tags_said_is_kept(turned: bool) -> None:
    ride = Ride(tags_at(200.0, 300.0))
    ride.read_all(*ride.tags)
    ride.run_to(310.0)
    kept = ride.doubt.leave_path(turned=turned)
    ride.row.position_m = 5000.0
    ride.doubt.new_path(ride.tags, kept)
    again = ride.doubt.leave_path(turned=turned)  # mirrored twice, or never
    ride.row.position_m = 310.0
    ride.doubt.new_path(ride.tags, again)
    ends_m = [(one.low_m, one.high_m) for one in ride.doubt.leave_path(turned=False)]
    assert ends_m[-1] == pytest.approx((-0.7, 0.7))
    assert ends_m[0] == pytest.approx((-0.5 - 2.2, 0.5 + 2.2))
    assert kept[-1].high_m - kept[-1].low_m == pytest.approx(1.4)


# what the wheels are worth -------------------------------------------------------------------------------------------


@given(
    worn, st.lists(st.tuples(st.floats(50.0, 2000.0), changes, st.floats(0.0, 3.0)), min_size=1, max_size=12)
)
def test_the_wheels_worth_stays_within_what_is_learned(
    worn: float, way: list[tuple[float, float, float]]
) -> None:
    ride = Ride(())
    wheel = WheelScale(ride.row, PARAMETERS)
    wheel.learn(front_interval(ride.row, ride.true_m - 1.0, ride.true_m + 1.0))
    ride.worn = worn
    for run_m, more, half_m in way:
        ride.run_to(ride.true_m + run_m, more)
        wheel.learn(front_interval(ride.row, ride.true_m - half_m, ride.true_m + half_m))
        low, high = wheel.scales
        assert low <= worn - 0.0049 or low <= worn
        assert low + 0.005 <= worn + 1e-9
        assert high - 0.005 >= worn - 1e-9
        wheel.apply(float(ride.row.odometer_scale))
        assert ride.row.bound_growth <= PARAMETERS.wheel_error_share + 1e-12


def test_what_contradicts_the_wheels_makes_it_begin_anew() -> None:
    ride = Ride(())
    wheel = WheelScale(ride.row, PARAMETERS)
    stated = wheel.scales
    wheel.learn(front_interval(ride.row, 99.0, 101.0))
    ride.run_to(100.0 + 10.0 * LEARNED_OVER_M)
    wheel.learn(front_interval(ride.row, 1099.0, 1101.0))
    assert wheel.scales.high - wheel.scales.low < stated.high - stated.low
    ride.run_to(1100.0 + 10.0 * LEARNED_OVER_M)
    wheel.learn(front_interval(ride.row, 2199.0, 2201.0))
    assert wheel.scales == stated


def test_fixes_that_are_wide_measure_the_wheels_from_the_first_of_a_path_on() -> None:
    """40 m wide and 300 m apart: over six of them nothing is learned, over 20 km 0.2 % either way."""
    ride = Ride(())
    wheels = [WheelScale(ride.row, PARAMETERS, keeps_first=first) for first in (True, False)]
    for place in range(67):
        for wheel in wheels:
            wheel.learn(front_interval(ride.row, ride.true_m - 20.0, ride.true_m + 20.0))
        if place < 66:
            ride.run_to(ride.true_m + 300.0)
    kept, forgotten = ((wheel.worth.high - wheel.worth.low) / 2.0 for wheel in wheels)
    varies = PARAMETERS.wheel_varies_share
    assert kept == pytest.approx(varies + 40.0 / (66 * 300.0), abs=1e-6)
    assert forgotten == pytest.approx(PARAMETERS.wheel_scale_limit)
