"""What makes a day late: distributions, the tables of a scenario that name them, and the day drawn from them."""
