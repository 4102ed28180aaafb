"""Plans for laws that follow one: what the unit works out at a departure, and the planner's wishes about it."""
