"""Overlap of two bodies at the start: that of their smooth surfaces, not of their facets."""

import numpy as np
import pytest

from hybrid.contact.overlap import depth_of_overlap
from hybrid.runtime.data import GEOMETRY
from hybrid.scene import Body
from hybrid.setup.bodies import build_body, mesh_of

TUBE = """SetFactory("OpenCASCADE");
Mesh.MeshSizeMin = 0.1;
Mesh.MeshSizeMax = 0.1;
Cylinder(1) = {0, 0, -0.1, 0, 0, 0.2, 0.7};
Cylinder(2) = {0, 0, -0.2, 0, 0, 0.4, 0.6};
BooleanDifference(3) = { Volume{1}; Delete; }{ Volume{2}; Delete; };
Physical Volume("body") = {3};
Physical Surface("contact") = Abs(Boundary{ Volume{3}; });
"""


@pytest.fixture(scope="module")
def tube(tmp_path_factory):
    path = tmp_path_factory.mktemp("tube") / "tube.geo"
    path.write_text(TUBE)
    return placed(Body(path, 1000.0, name="tube", position=(0.0, 0.0, 0.0)))


def placed(described):
    return build_body(described, mesh_of(described), np.array([0.0, 0.0, -9.81]))


@pytest.mark.parametrize("angle", [0.0, 7.0, 30.0, 101.0])
@pytest.mark.parametrize("gap, expected", [(0.0, 0.0), (-0.01, 0.01)])
def test_a_roller_in_a_tube_overlaps_its_bore_and_not_the_facets_of_it(tube, angle, gap, expected):
    """Radii of 0.15 and 0.6 m; facets of 0.1 m are up to 2 mm inside the bore."""
    across = (0.6 - 0.15 - gap) * np.array([np.cos(np.radians(angle)), np.sin(np.radians(angle)), 0.0])
    roller = placed(Body(GEOMETRY / "cylinder.geo", 1000.0, name="roller", position=tuple(across),
                         parameters={"radius": 0.15, "height": 0.2, "size": 0.05}))
    depth = depth_of_overlap(tube, roller, np.zeros(3, bool))
    assert depth == pytest.approx(expected, abs=3e-4 if gap == 0.0 else 2e-3)
