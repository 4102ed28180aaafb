"""Scenario files read and made into a setup."""
