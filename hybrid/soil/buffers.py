"""Memory that stays where the number of points changes, as it does in each of several processes in nearly every step: pages
of new arrays cost more than what is written into them."""

import numpy as np

SPARE = 8       # of so many rows one more is kept ready


def resized(buffer, n):
    """Array of n rows like those of a `buffer`, in its memory if that has room. Its contents are undefined."""
    whole = buffer if buffer.base is None else buffer.base
    if len(whole) < n:
        whole = np.empty((n + n // SPARE, *buffer.shape[1:]), buffer.dtype)
    return whole[:n]
