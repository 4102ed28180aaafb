"""Thousands of days: what is varied, who runs them, what they show together."""
