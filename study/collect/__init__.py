"""From a run that has ended to its tables."""
