"""The command line of branchline."""
