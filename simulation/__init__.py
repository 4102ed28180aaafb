"""The world in time: clock, carriers, sensors, checkers, journal and the loop that joins all parties."""
