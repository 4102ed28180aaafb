"""What would be better: orders of trains found by a model, with a bound on what could be better still."""
