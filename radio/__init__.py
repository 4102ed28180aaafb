"""What is said: telegrams, their envelope and keys, the air they pass, the fleets of wayside devices."""
