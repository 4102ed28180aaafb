"""Tags read bit by bit in a line run: by the reader's own rules, with the errors of table 7."""

import pytest

from network.units import mps
from papers.tag_scheme import Scheme, passage_failure
from papers.tag_trials import clopper_pearson
from radio.chance import generator
from simulation.sensors.tag_air import BIT_ERROR_RATES, channel_at, read_bits

TAG_ID = 0x2C9A


@pytest.mark.parametrize(("kmh", "row"), [(0.0, 40), (40.0, 40), (41.0, 60), (100.0, 100), (160.0, 130)])
def test_a_speed_reads_as_the_next_higher_one_of_table_7(kmh: float, row: int) -> None:
    assert channel_at(mps(kmh), 1.0).bit_error_rates == BIT_ERROR_RATES[row]


def test_without_bit_errors_a_tag_says_what_it_is() -> None:
    channel = channel_at(10.0, 0.0)
    assert {read_bits(generator(1, str(i)), TAG_ID, channel) for i in range(50)} == {TAG_ID}


def test_passages_fail_as_often_as_the_exact_figure_says() -> None:
    """Rates times 30 at 100 km/h: the exact probability lies in the interval of 2,000 passages."""
    channel = channel_at(mps(100.0), 30.0)
    count = 2000
    missed = sum(read_bits(generator(7, str(i)), TAG_ID, channel) is None for i in range(count))
    exact = passage_failure(Scheme("paper"), channel, TAG_ID).safe_side
    assert 0 < missed < count
    assert clopper_pearson(missed, count, 0.999).holds(exact)


def test_noise_alone_is_never_taken_for_an_id() -> None:
    channel = channel_at(10.0, 1000.0)
    assert {read_bits(generator(3, str(i)), TAG_ID, channel) for i in range(300)} == {None}
