"""What the train is to do: its mission and its times."""
