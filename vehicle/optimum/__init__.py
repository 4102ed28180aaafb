"""The run of least energy for a running time (省エネ運転), on real gradients and limits, and a proven bound below it."""

from vehicle.optimum.course import Course, NotFound, Optimum, Profile, TooShort
from vehicle.optimum.solve import least_energy, least_time

__all__ = ["Course", "NotFound", "Optimum", "Profile", "TooShort", "least_energy", "least_time"]
