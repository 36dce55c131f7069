"""Mass, centre, inertia and gravity load against closed forms and an independent integration."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from hybrid.body.mass import assemble, condensation, condensed_mass
from hybrid.body.mesh import generate
from hybrid.body.smooth_mass import layers, mass_and_surface
from hybrid.runtime.errors import GeometryError

GEOMETRY = Path(__file__).parents[2] / "geometry"
STEEL = 7850.0
SIZES = np.array([0.2, 0.1, 0.05])


def inertia_from(second):
    """Inertia tensor from the second moments ∫ρ x x^T dV."""
    return np.trace(second) * np.eye(3) - second


def surface_moments(mesh, density):
    """Mass, centre and inertia about it of the polyhedron inside the surface triangles.

    Divergence theorem for homogeneous f of degree k: ∫f dV = 1/(3+k) ∫f x·n dA. On a flat triangle x·n is
    constant and the edge midpoints integrate second-degree f exactly. Neither tetrahedra nor shape functions
    enter.
    """
    triangles = np.vstack([mesh.contact, mesh.symmetry])
    origin = mesh.points.mean(axis=0)
    corners = mesh.points[triangles] - origin
    a, b, c = corners[:, 0], corners[:, 1], corners[:, 2]
    flux = np.einsum("ti,ti->t", np.cross(b - a, c - a), a) / 2.0  # x·n times the area
    middles = (corners + np.roll(corners, -1, axis=1)) / 2.0
    volume = flux.sum() / 3.0
    first = np.einsum("t,tki->i", flux / 3.0, middles) / 4.0
    second = np.einsum("t,tki,tkj->ij", flux / 3.0, middles, middles) / 5.0
    centre = first / volume
    second -= volume * np.outer(centre, centre)
    return density * volume, origin + centre, density * inertia_from(second)


def relative(value, reference):
    return np.linalg.norm(np.asarray(value) - reference) / np.linalg.norm(reference)


def slope(errors):
    return np.polyfit(np.log(SIZES), np.log(errors), 1)[0]


def smooth_sphere(radius, density):
    mass = density * 4.0 / 3.0 * np.pi * radius**3
    return mass, 0.4 * mass * radius**2 * np.eye(3)


def smooth_cylinder(radius, density, height=1.0):
    mass = density * np.pi * radius**2 * height
    across = mass * (3.0 * radius**2 + height**2) / 12.0
    return mass, np.diag([across, across, 0.5 * mass * radius**2])


SMOOTH = {"sphere": smooth_sphere, "cylinder": smooth_cylinder}


@pytest.fixture(scope="module")
def round_bodies():
    """Meshes and masses of sphere and cylinder of radius 0.5 m at three sizes."""
    bodies = {}
    for name in SMOOTH:
        meshes = [generate(GEOMETRY / f"{name}.geo", {"radius": 0.5}, size=h) for h in SIZES]
        bodies[name] = [(mesh, condensed_mass(mesh, STEEL)) for mesh in meshes]
    return bodies


@pytest.fixture(scope="module")
def anchor():
    return generate(GEOMETRY / "stockless_anchor.geo")


# ---- box: the mesh is the solid, so everything is exact ----------------------------------------------------


@pytest.mark.parametrize("shift", [(0.0, 0.0, 0.0), (40.0, -70.0, 20.0)])
def test_box_is_exact(shift):
    length, width, height, density = 2.0, 1.0, 0.5, 2500.0
    mesh = generate(GEOMETRY / "box.geo", {"length": length, "width": width, "height": height})
    body = condensed_mass(replace(mesh, points=mesh.points + shift), density)
    mass = density * length * width * height
    inertia = mass / 12.0 * np.diag([width**2 + height**2, length**2 + height**2, length**2 + width**2])
    assert body.mass == pytest.approx(mass, rel=1e-12)
    assert np.abs(body.centre - shift).max() < 1e-12 * max(1.0, np.abs(shift).max())
    assert relative(body.inertia, inertia) < 1e-12


# ---- sphere and cylinder: exact for the facets, second order for the smooth solid --------------------------


@pytest.mark.parametrize("name", SMOOTH)
def test_round_body_has_the_exact_moments_of_its_facets(round_bodies, name):
    for mesh, body in round_bodies[name]:
        mass, centre, inertia = surface_moments(mesh, STEEL)
        assert body.mass == pytest.approx(mass, rel=1e-12)
        assert np.abs(body.centre - centre).max() < 1e-12
        assert relative(body.inertia, inertia) < 1e-12


def orders(bodies, mass, inertia):
    """Observed orders of convergence of mass and inertia toward the given smooth values."""
    of_mass = slope([abs(body.mass - mass) / mass for _, body in bodies])
    of_inertia = slope([relative(body.inertia, inertia) for _, body in bodies])
    return np.array([of_mass, of_inertia])


@pytest.mark.parametrize("name", SMOOTH)
def test_round_body_converges_at_second_order(round_bodies, name):
    found = orders(round_bodies[name], *SMOOTH[name](0.5, STEEL))
    assert np.all((found > 1.8) & (found < 2.3)), found


@pytest.mark.parametrize("name", SMOOTH)
def test_order_is_lost_against_a_wrong_radius(round_bodies, name):
    found = orders(round_bodies[name], *SMOOTH[name](0.5 * 1.01, STEEL))
    assert np.all((found < 1.8) | (found > 2.3)), found


# ---- the smooth solid behind the facets -----------------------------------------------------------------------


@pytest.mark.parametrize("name", SMOOTH)
def test_the_smooth_solid_converges_at_fourth_order(round_bodies, name):
    """Layers between facets and smooth surface: 0.2 % of the mass is missed without, 1e-5 with them."""
    smooth = [(mesh, mass_and_surface(mesh, STEEL)[0]) for mesh, _ in round_bodies[name]]
    found = orders(smooth, *SMOOTH[name](0.5, STEEL))
    assert np.all((found > 3.5) & (found < 5.0)), found
    for (_, body), (_, facets) in zip(smooth, round_bodies[name]):
        exact, _ = SMOOTH[name](0.5, STEEL)
        assert abs(body.mass - exact) < 0.01 * abs(facets.mass - exact)
        assert np.abs(body.centre).max() < 1e-3 * 0.5


def test_a_box_has_no_layers():
    mesh = generate(GEOMETRY / "box.geo")
    plain, (smooth, _) = condensed_mass(mesh, STEEL), mass_and_surface(mesh, STEEL)
    assert smooth.mass == plain.mass and np.array_equal(smooth.inertia, plain.inertia)


def test_a_layer_has_the_moments_of_a_parabolic_cap():
    """z = u v a + v w b + w u c over the unit triangle: volume (a + b + c)/24, first moment of z half the square."""
    heights = np.array([0.3, 0.1, 0.2])
    nodes = np.zeros((1, 9, 3))
    nodes[0, 1, 0] = nodes[0, 2, 1] = 1.0
    nodes[0, 6:, 2] = -heights
    volume, first, second = layers(nodes)
    assert volume == pytest.approx(heights.sum() / 24, rel=1e-12)
    square = (heights**2).sum() / 180 + 2 * (heights.prod() / heights).sum() / 360
    assert first[2] == pytest.approx(0.5 * square, rel=1e-12)
    assert second == pytest.approx(second.T)


# ---- anchor ------------------------------------------------------------------------------------------------


def test_anchor_agrees_with_surface_integrals(anchor):
    body = condensed_mass(anchor, STEEL)
    mass, centre, inertia = surface_moments(anchor, STEEL)
    assert body.mass == pytest.approx(mass, rel=1e-10)
    assert np.abs(body.centre - centre).max() < 1e-10
    assert relative(body.inertia, inertia) < 1e-10
    off = ~np.eye(3, dtype=bool)
    assert relative(body.inertia[off], inertia[off]) < 1e-10, "products of inertia"
    assert np.abs(inertia[off]).min() > 10.0, "the half body has all of them"


def test_anchor_has_the_published_mass(anchor):
    assert condensed_mass(anchor, STEEL).mass == pytest.approx(3291.6 + 1058.4, rel=0.01)


def test_comparison_sees_a_lumped_mass_a_missing_cut_face_and_the_wrong_centre(anchor):
    mass, centre, inertia = surface_moments(anchor, STEEL)
    nodes, matrix, loads = assemble(anchor.points, anchor.tets, STEEL)
    lumped = np.einsum("v,vi,vj->ij", loads[::3, 0], nodes - centre, nodes - centre)
    assert relative(inertia_from(lumped), inertia) > 1e-3
    about_origin = condensation(nodes)
    assert relative((about_origin.T @ (matrix @ about_origin))[3:, 3:], inertia) > 1e-1
    # the cut face goes through the origin of y, so it carries no flux unless the body is moved off it
    moved = replace(anchor, points=anchor.points + [0.0, 1.0, 0.0])
    opened = replace(moved, symmetry=moved.symmetry[:0])
    assert abs(surface_moments(opened, STEEL)[0] - mass) > 1e-3 * mass


# ---- condensed matrix and load -----------------------------------------------------------------------------


def test_condensation_moves_nodes_rigidly():
    rng = np.random.default_rng(1)
    nodes = rng.normal(size=(7, 3))
    centre, shift, turn = rng.normal(size=(3, 3))
    moved = condensation(nodes, centre) @ np.concatenate([shift, turn])
    assert moved.reshape(-1, 3) == pytest.approx(shift + np.cross(turn, nodes - centre), abs=1e-14)


def test_condensed_matrix_is_block_diagonal(anchor):
    body = condensed_mass(anchor, STEEL)
    nodes, matrix, _ = assemble(anchor.points, anchor.tets, STEEL)
    c = condensation(nodes, body.centre)
    expected = np.zeros((6, 6))
    expected[:3, :3], expected[3:, 3:] = body.mass * np.eye(3), body.inertia
    assert np.abs(c.T @ (matrix @ c) - expected).max() < 1e-12 * np.abs(expected).max()
    assert np.array_equal(body.inertia, body.inertia.T)
    assert np.linalg.eigvalsh(body.inertia).min() > 0.0


def test_gravity_acts_at_the_centre(anchor):
    body = condensed_mass(anchor, STEEL)
    assert np.abs(body.gravity_load[:3] - body.mass * np.eye(3)).max() < 1e-12 * body.mass
    assert np.abs(body.gravity_load[3:]).max() < 1e-12 * body.mass


@pytest.mark.parametrize("density", [0.0, -1.0, np.nan, np.inf])
def test_impossible_density_is_refused(anchor, density):
    with pytest.raises(GeometryError, match="must be positive and finite"):
        condensed_mass(anchor, density)
