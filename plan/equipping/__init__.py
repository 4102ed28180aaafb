"""The cheapest equipment with which a line takes so many trains an hour: every choice, each with its proof."""
