"""One material point along a path of principal strains and stresses, axes fixed: a law in a test apparatus."""

from dataclasses import dataclass

import numpy as np

from hybrid.laws import plastic_increment


@dataclass
class Path:
    """Histories of a path, a row per increment: total strain, Kirchhoff stress, elastic strain, each (m, 3), α (m,)."""

    strain: np.ndarray
    stress: np.ndarray
    elastic: np.ndarray
    plastic: np.ndarray
    iterations: int


def drive(law, start, strain=(None, None, None), steps=50):
    """Path of a law of one point from principal stress `start` (3,) [Pa].

    strain: logarithmic strain to which each axis is taken in equal steps; None keeps the axis at its stress.
    """
    start = np.array(start, float)
    held = np.array([s is None for s in strain])
    step = np.array([0.0 if s is None else s / steps for s in strain])
    elastic, total, alpha = law.strain(start[None])[0], np.zeros(3), 0.0
    rows, most = [(total, start, elastic, alpha)], 0
    for _ in range(steps):
        increment = step.copy()
        for iteration in range(50):
            trial = (elastic + increment)[None]
            response = law.respond(trial, np.array([alpha]))
            miss = np.where(held, response.stress[0] - start, 0.0)
            if np.abs(miss).max() <= 1e-11 * law.young[0] * 1e-2:
                break
            tangent = np.where(held[:, None], response.tangent[0], np.eye(3) * law.young[0])
            increment = increment - np.linalg.solve(tangent, miss)
        else:
            raise AssertionError(f"no equilibrium: {miss}")
        most = max(most, iteration)
        total, alpha = total + increment, alpha + plastic_increment(trial, response.elastic)[0]
        elastic = response.elastic[0].copy()
        rows.append((total, response.stress[0].copy(), elastic, alpha))
    return Path(*(np.array(column) for column in zip(*rows)), most)
