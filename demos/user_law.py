"""A law of one's own: clay that hardens along a hyperbola, pressed in an oedometer by a rigid platen.

    y(α) = y0 + (y1 - y0) α / (α + a)        q_trial - 3G Δα = y(α + Δα)        quadratic in Δα

y0, y1: first and last yield stress, a: plastic strain at half of the way, q = √(3/2 s:s). With the axial strain ε the
oedometer has q = y(α) = 3G (2/3 ε - α) and τ = K ε + 2/3 y(α), so the platen's force is F = A τ(ε) exp(ε): 153.634 kN
after 20 steps, by the run and by the closed form.

    .venv/bin/python demos/user_law.py          a few seconds
"""

from pathlib import Path

import numpy as np
from scipy.optimize import brentq

import hybrid
from hybrid import Axis, Body, Faces, Grid, Material, Output, Scene, Soil, Solver, Stage, Time
from hybrid.laws import Response
from hybrid.laws.hencky import Hencky
from hybrid.setup.build import build

YOUNG, POISSON, FIRST, LAST, HALF, SIDE = 2e6, 0.3, 20e3, 80e3, 0.02, 0.8
BOX = Path(__file__).parents[1] / "geometry" / "box.geo"


class HyperbolicClay(Hencky):
    """Von Mises with hyperbolic hardening; elasticity, energy and the start are Hencky's."""

    plastic = True

    def respond(self, strain, plastic_strain):
        K, G = self.parameters.T
        mean = strain.mean(axis=1, keepdims=True)
        deviator = strain - mean
        norm = np.maximum(np.linalg.norm(deviator, axis=1), 1e-300)
        q, growth, reach = np.sqrt(6) * G * norm, LAST - FIRST, plastic_strain + HALF
        b, c = q - FIRST - 3 * G * reach - growth, np.maximum((q - FIRST) * reach - growth * plastic_strain, 0.0)
        flow = 2 * c / (np.sqrt(b**2 + 12 * G * c) - b)                     # 3G Δα² - b Δα - c = 0
        left = (1 - 3 * G * flow / np.maximum(q, 1e-300))[:, None]
        elastic = mean + left * deviator
        stress = 3 * K[:, None] * mean + 2 * G[:, None] * left * deviator
        n, slope = deviator / norm[:, None], growth * HALF / (reach + flow) ** 2
        along = np.where(c > 0, 2 * G * (1 - left[:, 0]) - 6 * G**2 / (3 * G + slope), 0.0)
        tangent = (2 * G * left[:, 0])[:, None, None] * (np.eye(3) - 1 / 3) + K[:, None, None] + (
            along[:, None, None] * n[:, :, None] * n[:, None, :])
        return Response(stress, elastic, tangent)


def clay(points, stress):
    """The law of all points, as `build` asks for it."""
    return HyperbolicClay(np.full(len(points), YOUNG), POISSON)


def oedometer(steps=20):
    """Scene of a cube of clay between rollers, pressed by 0.08 m, quasi-static."""
    axis = Axis(start=0.0, end=SIDE, size=0.4)
    platen = Body(geometry=BOX, density=8000.0, parameters={"length": 1.2, "width": 1.2, "height": 0.4, "size": 10.0},
                  position=(0.4, 0.4, 0.0), rest_on=SIDE, velocity=(0.0, 0.0, -0.08 / steps), driven=("z",),
                  held=("x", "y", "rx", "ry", "rz"), penalty=1000.0)
    return Scene(name="oedometer", grid=Grid(axis, axis, axis, Faces()), bodies=(platen,), gravity=(0.0, 0.0, 0.0),
                 soil=Soil(Material(law="user", density=1700.0), geostatic=False),
                 time=Time(step=1.0, inertia=False), stages=(Stage("press", steps),),
                 solver=Solver(tolerance=1e-8, linear="direct"), output=Output(every=0, checkpoint=0))


def closed_form(strain):
    """Force [N] at an axial logarithmic strain, compression positive."""
    K, G = YOUNG / (3 * (1 - 2 * POISSON)), YOUNG / (2 * (1 + POISSON))
    def miss(alpha):
        return 3 * G * (2 / 3 * strain - alpha) - FIRST - (LAST - FIRST) * alpha / (alpha + HALF)
    alpha = brentq(miss, 0.0, strain, xtol=1e-15)
    return SIDE**2 * np.exp(strain) * (K * strain + 2 * G * (2 / 3 * strain - alpha))


def check():
    """Largest relative error of the tangent at random strains and histories."""
    rng = np.random.default_rng(1)
    return hybrid.check_law(HyperbolicClay(np.full(300, YOUNG), POISSON), 0.03 * rng.standard_normal((300, 3)),
                            rng.uniform(0.0, 0.1, 300))


if __name__ == "__main__":
    print(f"tangent against finite differences: {check():.0e}")
    simulation = build(oedometer(), law=clay)
    *_, last = simulation.steps()
    strain = -np.log(simulation.state.points.deformation[:, 2, 2]).mean()
    found, exact = last.bodies[0].contact_force[2], closed_form(strain)
    print(f"force at {strain:.4f} of axial strain: {found / 1e3:.3f} kN, closed form {exact / 1e3:.3f} kN, "
          f"{100 * (found / exact - 1):+.3f} %")
    assert abs(found / exact - 1) < 1e-3
