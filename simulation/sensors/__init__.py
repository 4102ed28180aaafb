"""What sensors make of the truth."""
