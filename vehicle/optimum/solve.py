"""Least time and least energy."""

from __future__ import annotations

from vehicle.optimum.course import Course, Optimum, Profile


def least_time(course: Course) -> Profile:
    """The fastest run; ValueError where the train cannot get there."""
    raise NotImplementedError


def least_energy(course: Course, time_s: float, points: int = 300, warm: Optimum | None = None) -> Optimum:
    """The run of least energy in at most `time_s`; TooShort, with the least time, where there is none."""
    raise NotImplementedError
