"""What fails, heals and is done by people."""
