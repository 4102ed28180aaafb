"""What the train is: traction, brakes, resistance, adhesion, energy, and the files that describe trains."""
