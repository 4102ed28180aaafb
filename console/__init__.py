"""The desk: a running line, and the seats of those who work it."""
