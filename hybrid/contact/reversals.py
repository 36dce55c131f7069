"""Contact points that an update of Newton's method carries from slip in one direction to slip in the other.

The shear of a point that slips does not depend on how far. An update from there cannot see that the point would stick on
its way back, in a range μp/ε_T narrow beside any other length, and carries it past that range; the next one carries it back.
Such a point is therefore held in stick for the next update, if the residual has not fallen by half: it has the shear
and the tangent of stick, whatever their size,

    f_t = ε_T g_t        where it slipped before and after an update, and f_t before · f_t after < 0

Then it is judged anew: within the range it sticks, beyond it slips. That is the choice of an active set by the
multiplier, and not by the displacement (Alart and Curnier, Comput. Methods Appl. Mech. Eng. 92 (1991) 353-375; Hüeber,
Stadler and Wohlmuth, SIAM J. Sci. Comput. 30 (2008) 572-596). The residual that has to vanish stays that of the law.
FORMULATION (42b).
"""

import numpy as np

NONE = np.zeros(0, int)


def reversed_slip(before, after, held=NONE):
    """Index of the contact points that slip in two PointContacts of a step, `before` and `after` an update, against
    one another.

    held: index of those that were held in stick in that update: they have been given their way.
    """
    points, i, j = np.intersect1d(before.active, after.active, assume_unique=True, return_indices=True)
    back = before.slip[i] & after.slip[j] & (np.einsum("ci,ci->c", before.shear[i], after.shear[j]) < 0.0)
    return np.setdiff1d(points[back], held, assume_unique=True)
