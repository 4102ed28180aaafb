"""A line worked by line signals: a machine of signals, the people at it, drivers who go by what they see."""
