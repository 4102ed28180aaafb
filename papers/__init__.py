"""Published experiments rebuilt."""
