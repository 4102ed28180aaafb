"""Who goes first: trains that are late, the tracks that they could take, and the order that costs least."""
