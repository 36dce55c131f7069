"""Does a sphere roll and slide according to Coulomb's law on a slope that deforms? r = 1 m, m = 5000 kg, μ = 0 to 1.

The sphere of demos/rolling_sphere.py on an elastic slab of 1 GPa, with the same laws (see there): on the faces of
domains with cells of 0.1 m, and as published on their corners with cells of 0.025 m, which as coarse as that would be a
bumpy ride. What is left is the creep of the tangential springs while the contact rolls on.

    .venv/bin/python demos/rolling_slab.py 0.4          at that friction, both ways
    .venv/bin/python demos/rolling_slab.py              at five
"""

import sys
from pathlib import Path

import numpy as np
from rolling_sphere import FRICTION, law

import hybrid

SCENE, OUT, RADIUS = Path(__file__).with_suffix(".toml"), Path("out/rolling_slab"), 1.0
FINE = [*(f"grid.{axis}.size=0.025" for axis in "xyz"), "grid.y.fine=[0.75, 0.85]", "grid.z.fine=[-0.05, 0.0]",
        "body.0.contact=corners", "body.0.penalty=50"]
WAYS = {"faces, cells of 0.1 m": [], "corners, cells of 0.025 m": FINE}


def errors(mu, simulation, start):
    """Errors [%] of distance and spin of a finished run; of the spin relative to rolling when the law has none."""
    motion, time = simulation.state.bodies[0], simulation.scene.time.step * simulation.scene.stages[1].steps
    exact, rolling = law(mu, time, RADIUS), law(1.0, time, RADIUS)
    spin = (motion.rotation @ motion.spin)[1]
    return (100 * ((motion.position[0] - start) / exact[0] - 1), 100 * (spin - exact[1]) / (exact[1] or rolling[1]))


if __name__ == "__main__":
    for mu in [float(a) for a in sys.argv[1:]] or FRICTION:
        for way, changes in WAYS.items():
            folder = OUT / f"{way.split(',')[0]}_mu_{mu}"
            simulation = hybrid.run(SCENE, folder, [f"body.0.friction={mu}", *changes])
            missed = errors(mu, simulation, simulation.initial_bodies[0].position[0])
            print(f"{way}  mu = {mu}  distance {missed[0]:+.2f} %  spin {missed[1]:+.2f} %")
            assert np.all(np.abs(missed) < (0.35, 1.0)), "too far from the law"
