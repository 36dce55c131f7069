"""What stays the same during a stage: soil, bodies, integration rule, loads."""

from dataclasses import dataclass, replace

import numpy as np

from hybrid.body import rigid
from hybrid.body.rigid import FREEDOMS, RigidBody, engage_guides, release_guides
from hybrid.scheme import Scheme
from hybrid.soil.model import Soil
from hybrid.step.loads import Loads


@dataclass(frozen=True)
class Model:
    """Frozen for a stage; linear "krylov" | "direct" and its relative tolerance."""

    soil: Soil
    bodies: tuple[RigidBody, ...]
    scheme: Scheme
    loads: Loads
    linear: str = "krylov"
    linear_tolerance: float = 1e-3

    @property
    def gravity(self):
        """All of it, (3,) [m/s²]."""
        return self.loads.gravity

    @property
    def body_free(self):
        """(bodies, 6) bool mask of the bodies' unknowns."""
        return np.array([b.free for b in self.bodies], bool).reshape(-1, 6)

    def on(self, soil):
        """The same model with other soil."""
        young, volume = soil.law.young, soil.constants.volume
        return replace(self, soil=soil, bodies=tuple(rigid.with_stiffness(body, young, volume) for body in self.bodies))

    def for_stage(self, held=(), beta=None, gamma=None, loads=None):
        """The same model with more components ("x" ... "rz") of every body held and, if given, Newmark's rule or other
        loads."""
        held = np.isin(FREEDOMS, held)
        bodies = tuple(replace(b, free=b.free & ~held, drive=b.drive * ~held) for b in self.bodies)
        return replace(self, scheme=self.scheme.with_pair(beta, gamma), bodies=bodies, loads=loads or self.loads)

    def begin(self, state):
        """`state` at the start of a stage of this model: guides let go of bodies, or take hold of them, and the jolt is
        their work."""
        bodies = [release_guides(b, s) for b, s in zip(self.bodies, state.bodies)] if self.scheme.inertia else state.bodies
        gravity = self.loads.on_bodies(state.time)
        taken = [engage_guides(b, s, gravity, self.scheme) for b, s in zip(self.bodies, bodies)]
        jolt, work = sum(jolt for _, jolt in taken), dict(state.work)
        if jolt:
            work["drive"] = work.get("drive", 0.0) + jolt
        return replace(state, bodies=[motion for motion, _ in taken], work=work)
