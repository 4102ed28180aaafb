"""What the train may occupy, and where it must stop."""
