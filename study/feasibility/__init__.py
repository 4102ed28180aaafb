"""Whether a plan can work, said before it runs: one check for `branchline check` and `branchline run`."""
