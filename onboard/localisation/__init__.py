"""Where the train is, and within what bounds."""
