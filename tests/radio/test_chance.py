"""Generators by name: the same for the same name, unrelated for others."""

import numpy as np

from radio.chance import generator


def test_same_seed_and_names_same_draws() -> None:
    assert (
        generator(1, "air", "a", "b").random(8).tolist() == generator(1, "air", "a", "b").random(8).tolist()
    )


def test_names_and_seed_all_matter_and_do_not_run_together() -> None:
    names = [("air", "a", "b"), ("air", "b", "a"), ("air", "ab"), ("aira", "b")]
    draws = {generator(seed, *name).random() for seed in (1, 2) for name in names}
    assert len(draws) == 8


def test_draws_of_neighbouring_seeds_are_uncorrelated() -> None:
    one, other = generator(1, "x").random(20_000), generator(2, "x").random(20_000)
    # The correlation of independent draws has a standard deviation of 1/sqrt(n); five of them.
    assert abs(np.corrcoef(one, other)[0, 1]) < 5 / np.sqrt(20_000)
