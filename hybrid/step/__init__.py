"""One increment of time: its equations, their solution, and how long it may be."""
