"""Drills judged expectation by expectation, and moved to every instant and every telegram."""
