"""Driving laws: what a train asks of its machinery between stations, one file each, listed in `table`."""
