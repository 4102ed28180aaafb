"""The nearest workable plan to published times: arrivals, meets, tracks and sets, and what of the print has to move."""
