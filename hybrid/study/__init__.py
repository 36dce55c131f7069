"""Studies of the method: error against time (precision), known ways of failing (failure), problems not tuned to (random)."""
