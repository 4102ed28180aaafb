"""Whole files made from little: a line file from a list of its stations."""
