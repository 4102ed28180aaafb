"""A proven lower bound of the energy."""

from __future__ import annotations

from vehicle.optimum.course import Course, Optimum


def lower_bound_j(course: Course, optimum: Optimum, time_s: float) -> float:
    """No run of the course within `time_s` needs less at the wire, J."""
    raise NotImplementedError
