"""How the train drives: supervision, patterns, notches, stopping at the mark."""
