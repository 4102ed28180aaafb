"""What is worked out beside a run's own books: running times and margins, and second opinions on energy."""
