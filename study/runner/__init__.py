"""Scenarios executed: the world built, run, collected, judged and put on disk."""
