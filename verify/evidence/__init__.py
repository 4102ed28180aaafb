"""What runs are held against: the explored states, intruders, bounds; it runs scenarios, which the rest must not."""
