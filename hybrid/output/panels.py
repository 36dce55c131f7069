"""A page of lettered panels two abreast, with the mark of its record in the corner."""

from contextlib import contextmanager

import numpy as np

from hybrid.output.figures import PAGE, figure


@contextmanager
def panels(path, titles, height, room, size):
    """(figure, axes of each of the `titles`), saved to `path` when the block ends.

    height [in]: of a row; room [in]: for what else is on the page; size [pt]: of the titles.
    """
    rows = (len(titles) + 1) // 2
    with figure(path, PAGE, height * rows + room) as drawing:
        places = np.ravel(drawing.subplots(rows, 2, squeeze=False))
        for letter, title, axes in zip("abcdefghijkl", titles, places):
            axes.set_title(f"({letter}) {title}", loc="left", fontsize=size)
        for axes in places[len(titles):]:
            axes.set_axis_off()
        yield drawing, places[:len(titles)]


def stamp_corner(drawing, mark):
    """Write `mark`, which names the record that a figure is drawn from, in its lower right corner."""
    drawing.supxlabel(mark, fontsize=5, x=0.99, ha="right", color="#777777")
