"""From a Scene to a Simulation: `build` reads the scene and calls one module each for grid, bodies, soil and its laws.

Besides it, limits and reports read what a scene says of its bodies, soil and stages.
"""
