"""The carrier is gone. A module of its own, so that who names the error loads no model of a line."""

from __future__ import annotations


class CarrierLostError(RuntimeError):
    """What carries the trains is gone: the run cannot go on."""
