"""Runs and drills: executed, collected into tables, judged."""
