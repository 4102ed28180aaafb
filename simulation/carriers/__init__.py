"""What carries the trains: SUMO, or plain track."""
