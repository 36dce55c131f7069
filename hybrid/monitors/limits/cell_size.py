"""What the limits of the size of cells share: from which error on they report, and their remedy."""

EXCESS = 0.1    # of a load, above which it is reported
ON_LINE = 0.15  # cells between an edge and a line of the grid: contact sees the edge there as on it


def smaller_cells(size, where=""):
    """Remedy for a load that is wrong by more than EXCESS in cells larger than `size` [m]; where: they are, as " at it"."""
    return f"Use cells of at most {size:.2g} m{where}, or extrapolate two sizes of cells to none"
