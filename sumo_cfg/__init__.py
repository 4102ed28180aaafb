"""The line as SUMO sees it: plain XML, netconvert, the shipped nets, SUMO's options, the map of the truth."""
