"""Scenarios in the forms of other programs."""
