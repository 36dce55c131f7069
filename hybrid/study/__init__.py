"""Studies of the method: speed against accuracy (precision), and the known ways in which runs fail (failure)."""
