"""Does a sphere roll and slide down a rough slope according to Coulomb's law? Fig. 2a of Bird et al. (UKACM 2024).

         O ->        r = 0.25 m on a slope of θ = 45°, friction μ = 0 to 1, one second from rest.
      =========      The slope is held: points' domains under penalty contact.

    slides, tan θ > 3.5 μ:   d = ½ g t² (sin θ - μ cos θ)     ω = 5 μ g cos θ t / (2 r)
    rolls:                   d = 5/14 g t² sin θ              ω = 5/7 g sin θ t / r

Six unknowns, 3 200 points, 820 triangles, 100 steps of 0.01 s: some seconds for each μ, plus the start.

Nothing is set but the physics: contact on the faces of the domains. As published, at the corners of the domains, the
slope is a lattice, s = r/2 apart: a ride over bumps of s²/(4r) = 16 mm, in the air for 5 to 9 steps, with a penalty and
a damping that have to be chosen (p_f E in Pa/m, rms errors in % over μ = 0, 0.2, 0.4 and five starts; spin at μ = 0
relative to rolling):

    p_f E         5e5    1e6    2e6    3e6    5e6    1e7
    distance      1.9    1.6    1.6    2.4    3.2    6.1
    spin          6.7    3.1    2.5    2.5    3.0    3.5

Errors on corners fall as spacing and facets are refined together (and the penalty grows as s⁻³; only the track of the
sphere is then modelled), largest over the five μ:

    spacing s     0.125 m   0.0625 m   0.03125 m
    distance        1.2 %      0.5 %       0.1 %
    spin            3.3 %      1.7 %       1.2 %

    .venv/bin/python demos/rolling_sphere.py           faces, and corners at the paper's resolution
    .venv/bin/python demos/rolling_sphere.py 1 2 4     and corners at half and a quarter of its spacing
"""

import sys
from pathlib import Path

import numpy as np

import hybrid
from hybrid.output.figures import Curve, comparison
from hybrid.output.history import read_history
from hybrid.study.precision.problems.sphere import corners, law, missed, overrides

SCENE, OUT = Path(__file__).with_suffix(".toml"), Path("out/rolling_sphere")
FRICTION = (0.0, 0.1, 0.2, 0.4, 1.0)
LIMITS = {1: (2.3, 6.5), 2: (0.7, 2.5), 4: (0.5, 1.5)}  # [%] of distance and spin on corners, by refinement
FACES = 1.0, 2.0    # [%] the same on faces


def motion(folder):
    """Time [s], distance [m] and spin about y [rad/s], in space, of a run; from its history.csv."""
    h = {key.removeprefix("sphere_"): values for key, values in read_history(folder).items()}
    w, x, y, z = h["qw"], h["qx"], h["qy"], h["qz"]
    spin = (2 * (x * y + w * z) * h["spin_x_rad_per_s"] + (1 - 2 * (x * x + z * z)) * h["spin_y_rad_per_s"]
            + 2 * (y * z - w * x) * h["spin_z_rad_per_s"])
    return h["time_s"], h["x_m"] - 0.6, spin


def errors(mu, time, distance, spin):
    """Errors [%] of distance and spin at the end."""
    return tuple(100 * error for error in missed(mu, time[-1], distance[-1], spin[-1]))


def rides(name, refinement, changes, limits):
    """Run all μ, print and check their errors, draw them."""
    curves = []
    for mu in FRICTION:
        folder = OUT / f"{name}_mu_{mu}"
        hybrid.run(SCENE, folder, overrides(mu, refinement) + changes)
        time, *found = motion(folder)
        curves.append(Curve(f"$\\mu$ = {mu}", time, found, law(mu, time)))
        percent = errors(mu, time, *found)
        print(f"{name:10}  mu = {mu}  distance {found[0][-1]:.4f} m ({percent[0]:+.2f} %)  "
              f"spin {found[1][-1]:.3f} rad/s ({percent[1]:+.2f} %)")
        assert np.all(np.abs(percent) < limits), "too far from the law"
    print(comparison(OUT / f"{name}.png", curves))


if __name__ == "__main__":
    rides("faces", 1, [], FACES)
    for fine in [int(n) for n in sys.argv[1:]] or [1]:
        rides(f"corners_{fine}", fine, corners(fine), LIMITS.get(fine, LIMITS[4]))
