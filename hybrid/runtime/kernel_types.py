"""The types of a kernel's arguments are found once, not in every call.

Numba knows the type of an array at once. For a tuple it writes a fingerprint of what is in it, and looks that up. In numba
0.56 a fingerprint has room for 40 characters; those of longer tuples, three arrays with names or more, are read from
memory that was never written and are found in no table, so that each call finds the types anew, in 0.06 to 0.1 ms. Here
tuples of arrays are looked up by what decides their type: 100 steps of demos/rolling_sphere.toml take 0.6 of the time.
"""

import numpy as np
from numba.core import dispatcher

PLAIN = {float, bool, np.float64, np.bool_, type(None)}     # their values do not matter to the type


def _key(value):
    """What decides the type of a tuple of arrays and such values; None for any other value."""
    kind = type(value)
    if kind is np.ndarray:
        return value.dtype, value.ndim, value.flags.num
    if isinstance(value, tuple):
        parts = tuple(map(_key, value))
        return None if None in parts else (kind, parts)
    return kind if kind in PLAIN else None


def typeof(value, *purpose):
    """As numba's function of this name."""
    key = _key(value) if isinstance(value, tuple) else None
    if key is None:
        return _numba_typeof(value, *purpose)
    found = _known.get((key, purpose))
    if found is None:
        found = _known[key, purpose] = _numba_typeof(value, *purpose)
    return found


if dispatcher.typeof.__module__ != __name__:
    _numba_typeof, _known = dispatcher.typeof, {}
    dispatcher.typeof = typeof
