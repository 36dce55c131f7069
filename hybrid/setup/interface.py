"""Friction and interface of a body as a scene describes them."""

import numpy as np

from hybrid.contact.interface import Interface


def friction_of(described, mixed=False):
    """Coefficient of friction, inf where adhesion alone limits the shear; 0 where either of them is none. mixed: whether
    some of the soil is no clay, which has friction whatever the adhesion."""
    if described.adhesion == 0.0 and not mixed:
        return 0.0
    return described.friction if described.friction is not None else 0.0 if described.adhesion is None else np.inf


def interface_of(described, mixed=False):
    """Interface of a body, None where its contact is that of friction alone. mixed: as in `friction_of`."""
    tension = {None: 0.0, "full": np.inf}.get(described.tension, described.tension)
    adheres = described.adhesion is not None and (described.adhesion > 0.0 or mixed)
    if not adheres and not tension:
        return None
    adhesion = described.adhesion if adheres else None
    return Interface(adhesion, tension, frictional=bool(adhesion and described.friction),
                     elsewhere=0.0 if described.friction is None else np.inf)
