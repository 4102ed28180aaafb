"""What changed between runs of one line: inputs, times, meets and figures, for a person, as data and as pictures."""
