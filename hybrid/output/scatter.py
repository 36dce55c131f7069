"""Errors of many random runs, each a dot, with the band that they are meant to stay in."""

from dataclasses import dataclass

import numpy as np

from hybrid.output.panels import panels, stamp_corner

LIMIT = 10.0    # dots beyond this many aims are drawn at the edge as triangles


@dataclass(frozen=True)
class Cloud:
    """A panel: title, names of the axes; abscissa, error and colour of each run; abscissae of the runs that failed;
    aim: half-width of the band of right errors."""

    title: str
    across: str
    error: str
    x: list
    y: list
    colour: list
    failed: list
    aim: float


def scatter(path, clouds, colour, mark):
    """Panels two abreast, the colour bar named `colour`; `mark` in the corner. Returns the path."""
    with panels(path, [cloud.title for cloud in clouds], height=2.1, room=0.3, size=8) as (drawing, places):
        stamp_corner(drawing, mark)
        for cloud, axes in zip(clouds, places):
            axes.set_xlabel(cloud.across, fontsize=7)
            axes.set_ylabel(cloud.error, fontsize=7)
            axes.tick_params(labelsize=6)
            dots = _draw(axes, cloud)
        drawing.colorbar(dots, ax=drawing.axes, shrink=0.6, aspect=40, pad=0.01).set_label(colour, fontsize=7)
    return path


def _draw(axes, cloud):
    """Draw a cloud; returns its dots, which the colour bar explains."""
    x, y, colour = (np.array(values, float) for values in (cloud.x, cloud.y, cloud.colour))
    edge = min(LIMIT * cloud.aim, max(1.5 * cloud.aim, 1.1 * np.abs(y).max(initial=0.0)))
    axes.axhspan(-cloud.aim, cloud.aim, color="#cfe8d5", zorder=0)
    out, look = np.abs(y) > edge, {"cmap": "viridis", "vmin": 0.0, "vmax": 1.0, "linewidths": 0.3, "edgecolors": "black"}
    dots = axes.scatter(x[~out], y[~out], 12, colour[~out], zorder=3, **look)
    for side, marker in ((1, "^"), (-1, "v")):
        beyond = out & (side * y > 0)
        axes.scatter(x[beyond], np.full(beyond.sum(), 0.97 * side * edge), 14, colour[beyond], marker=marker, zorder=3,
                     **look)
    axes.plot(cloud.failed, np.zeros(len(cloud.failed)), "x", color="#9c2a1c", markersize=5, zorder=4)
    axes.set_ylim(-edge, edge)
    return dots
