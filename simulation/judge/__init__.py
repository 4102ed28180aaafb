"""Independent checkers: they see the carrier's truth and the journal, nothing else."""
