"""Studies of the methods over problems with known answers: speed against accuracy."""
