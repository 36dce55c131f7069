"""A body inside the soil, between its corners, is reported once; one that has contact is not."""

import numpy as np
import pytest

from hybrid.monitors import missed_contact
from hybrid.scene import Time
from hybrid.setup.build import build
from hybrid.study.scenes import driven, soil_scene


def notes(place, height=0.3, **body):
    """Of a box driven on its edge, 10 mm a step, with the edge at x = `place`; corners lie 0.1 m apart."""
    centre = place + np.sin(np.pi / 4) * (height - 0.3) / 2     # the edge is below the centre where the box is a cube
    cube = driven(0.3, 0.3, height, velocity=(0.0, 0.0, -1.0), position=(centre, 0.4, 0.0), rest_on=0.0, size=0.05,
                  rotation=(0.0, 1.0, 0.0, 45.0), **{"contact": "corners", **body})
    records = build(soil_scene([cube], held=True, steps=4, time=Time(step=0.01))).steps()
    return [(record.step, note) for record in records for note in record.notes if "inside the soil" in note]


def test_an_edge_between_rows_of_corners():
    (step, text), = notes(0.45)
    assert step == 3 and "0.3 of a point domain's height below" in text and "limit 0.25" in text
    assert 'body.contact = "faces"' in text


@pytest.mark.parametrize("place, body", [(0.4, {}), (0.45, {"contact": "faces"})])
def test_an_edge_that_touches(place, body):
    assert not notes(place, **body)


def test_the_edge_of_a_large_body(monkeypatch):
    """30 mm are a small part of 2 m; without that rule they would be reported."""
    assert not notes(0.45, height=2.4)
    monkeypatch.setattr(missed_contact, "PART", 0.0)
    assert len(notes(0.45, height=2.4)) == 1
