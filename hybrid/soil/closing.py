"""Soil that has opened closes before it carries pressure again: FORMULATION (17a).

The return to the apex of a cone makes tensile volume strain plastic. Without a memory of it, a point that is pressed
again resists at the volume that it has then, and sand that falls, splashes or is shaken stays swollen. So a point keeps
the volume strain o by which it has opened, and a trial strain ε meets the law as

    ε + o/3 1      where that carries pressure: closed, o <- 0
    ε + c/3 1      else, c = min(o, <-tr ε>), without dilation: o <- o - c + (volume strain returned to the apex)

Soil that is sheared while it is open does not dilate. The tangent C becomes C (I - 1⊗1/3) where tr ε <= 0. A cohesive
point unloads from its tensile strength before it closes, so that a crack gains no energy. After Tampubolon et al., ACM
Trans. Graph. 36 (2017) 105.

Only with inertia: without it nothing resists soil that closes, and its displacement is not determined.
"""

import numpy as np


def respond(law, strain, points, opens=True):
    """(Response of a law, volume strain (n,) by which points are open after it, None where none is).

    strain: (n, 3) trial principal strains, changed in place where points close; points: Points at the start of the step;
    opens: whether soil remembers that it opens, as it does with inertia.
    """
    plastic_strain, opened = points.plastic_strain, points.opened
    if opened is None or not opens:
        response = law.respond(strain, plastic_strain)
        return response, _any(response.opened) if opens else opened
    trial, trace = strain.copy(), strain[:, 0] + strain[:, 1] + strain[:, 2]
    strain += opened[:, None] / 3
    response = law.respond(strain, plastic_strain)
    after = response.opened
    some = np.flatnonzero((opened > 0.0) & (response.stress.sum(axis=1) >= 0.0))
    if len(some):
        closed = np.minimum(np.maximum(-trace[some], 0.0), opened[some])
        strain[some] = trial[some] + closed[:, None] / 3
        still = law.without_dilation(some).respond(strain[some], plastic_strain[some])
        flat = trace[some] <= 0.0
        still.tangent[flat] -= still.tangent[flat].mean(axis=2, keepdims=True)
        for whole, part in ((response.stress, still.stress), (response.elastic, still.elastic),
                            (response.tangent, still.tangent)):
            whole[some] = part
        after[some] = opened[some] - closed + still.opened
    return response, _any(after)


def _any(opened):
    return opened if opened is not None and opened.any() else None
