"""From a Scene to a Simulation: `build` reads the scene and calls one module each for grid, bodies, soil and its laws.

No other package reads a scene, apart from what observers print.
"""
