"""Contact points: found close to a body, moved with the grid, and kept while they stay close."""

from dataclasses import replace

import numpy as np
import pytest
from contact_bed import PLACES, RIGHT_HAND, ball, bed, body_at, box, contact_of, found_in_bed, id_of

from hybrid.body.attitude import exp_so3
from hybrid.body.closest import closest
from hybrid.contact import soil_to_body
from hybrid.contact.search import Domains
from hybrid.scene import Axis, Body, Faces, Grid, Material, Scene, Soil, Stage, Time
from hybrid.setup.build import build
from hybrid.state import ContactHistory
from hybrid.step.equations import begin
from hybrid.step.evaluation import Unknowns
from hybrid.step.workspace import Workspace


def pressed(geometry, steps=4, **body):
    """Simulation of a sphere pressed into a soft block, frictionless, after a few steps."""
    axis = Axis(start=0.0, end=0.8, size=0.2)
    described = Scene(
        name="block", grid=Grid(axis, axis, Axis(start=-0.6, end=0.2, size=0.2), Faces(z_min="fixed")),
        soil=Soil(Material(law="hencky", young=2e5, poisson=0.2, density=1800.0), top=0.0, geostatic=False),
        bodies=(Body(
            geometry=geometry / "sphere.geo", density=3000.0, parameters={"radius": 0.25, "size": 0.12},
            position=(0.43, 0.37, 0.25), velocity=(0.3, 0.0, -1.5), **body),),
        gravity=(0.0, 0.0, 0.0), time=Time(step=0.01), stages=(Stage("press", steps),))
    simulation = build(described)
    simulation.run()
    return simulation


def contact_energy_at_rest(simulation, state):
    step = begin(simulation.model, state, 0.01, False, Workspace(simulation.model))
    rest = Unknowns(np.zeros((simulation.model.soil.grid.node_count, 3)),
                    tuple((b.position, b.rotation) for b in state.bodies))
    return step.evaluate(rest).contacts[0].energy


@pytest.mark.parametrize("contact, jump", [("corners", 1e-10), ("faces", 0.015)])
def test_contact_energy_does_not_jump_between_steps(geometry, contact, jump):
    """Contact points are carried as material points. Placed anew on the domains they would jump, and energy too. The
    area of a face and its projection are those at the start of a step, so the energy on faces changes a little."""
    simulation = pressed(geometry, contact=contact, penalty=50.0)
    committed = simulation.evaluation.contacts[0]
    assert len(committed) >= 4 and committed.energy > 0.0
    state = simulation.state
    assert contact_energy_at_rest(simulation, state) == pytest.approx(committed.energy, rel=jump)
    anew = replace(state, contacts=[ContactHistory.empty()])
    assert abs(contact_energy_at_rest(simulation, anew) / committed.energy - 1) > 0.02


def test_weights_of_nodes_without_mass_go_to_the_others():
    surface, body = ball(), body_at((0.4, 0.4, 0.2))
    grid, everywhere = found_in_bed(surface, body)
    upper = np.broadcast_to(grid.axes[2] > 1e-9, grid.shape).ravel()
    _, corners = found_in_bed(surface, body, active=~upper)
    full = {id: both for id, *both in zip(id_of(everywhere), everywhere.node, everywhere.weight)}
    moved = 0
    for id, node, weight in zip(id_of(corners), corners.node, corners.weight):
        node_full, weight_full = full[id]
        np.testing.assert_array_equal(node, node_full)
        assert weight.sum() == pytest.approx(1.0, rel=1e-14)
        assert not weight[upper[node]].any()
        kept = ~upper[node]
        np.testing.assert_allclose(weight[kept], weight_full[kept] / weight_full[kept].sum(), rtol=1e-13)
        moved += weight_full[~kept].sum() > 1e-3
    assert moved > 3
    assert len(found_in_bed(surface, body, active=np.zeros(grid.node_count, bool))[1]) == 0


def brute_force(position, half, body, surface, reach, places):
    """Numbers of all places within reach that look at the body, one by one."""
    found = []
    for point in range(len(position)):
        for place, offset in enumerate(places.flat):
            y = (position[point] + offset * half[point] - body.position) @ body.rotation
            triangle, feature, _, _, gap = closest(tuple(y), np.inf, surface.tree)
            normal = body.rotation @ surface.tree.normals[triangle, feature]
            if abs(gap) < reach and places.projected_share(np.array([place]), normal[None])[0] > 0.0:
                found.append(1000 * point + place)
    return found


@pytest.mark.parametrize("surface, position", [
    (ball(), (0.4, 0.35, 0.2)), (box(2, (0.2, 0.15, 0.1)), (0.5, 0.3, 0.08)),
    (box(1, (0.2, 0.15, 0.1)), (0.9, 0.9, 0.3))])
@pytest.mark.parametrize("reach", [0.02, 0.1])
@pytest.mark.parametrize("name", PLACES)
def test_search_equals_brute_force(surface, position, reach, name):
    _, points, half = bed()
    points = points + 0.01 * np.random.default_rng(1).standard_normal(points.shape)
    body = body_at(position, RIGHT_HAND)
    places = PLACES[name]
    _, corners = found_in_bed(surface, body, reach=reach, places=places)
    wanted = brute_force(points, half, body, surface, reach, places)
    assert set(id_of(corners)) <= set(wanted)
    missed = np.setdiff1d(wanted, id_of(corners))       # in blocks that look away from the body, beside a sharp edge
    assert len(missed) <= (0.02 * len(wanted) if name == "faces" and len(surface.triangles) == 48 else 0)
    offset = places.flat[corners.place] * half[corners.point]
    np.testing.assert_allclose(corners.position, points[corners.point] + offset, atol=1e-15)
    if name == "corners":
        np.testing.assert_allclose(corners.stiffness, 2e4)


@pytest.mark.parametrize("name", PLACES)
def test_history_is_followed_until_it_leaves_the_reach(name):
    surface, body, places = ball(), body_at((0.4, 0.4, 0.24)), PLACES[name]
    _, first = found_in_bed(surface, body, places=places)
    contact = contact_of(first, surface, (body.position - (0, 0, 0.01), body.rotation))
    shifted = first.position + 0.002     # less than a tenth of a half-width
    history = soil_to_body.commit(first, shifted, contact)
    _, second = found_in_bed(surface, body, history, places=places)
    common = np.isin(id_of(second), id_of(first))
    at = np.searchsorted(id_of(first), id_of(second)[common])
    np.testing.assert_array_equal(second.position[common], shifted[at])
    np.testing.assert_array_equal(second.touching[common], history.touching[at])
    carried = history.touching[at]
    assert carried.any()
    np.testing.assert_array_equal(second.anchor[common][carried], history.anchor[at][carried])
    _, far = found_in_bed(surface, body_at((0.4, 0.4, 2.0)), history, places=places)
    assert len(far) == history.touching.sum() and far.touching.all()      # those that leave contact in this step


@pytest.mark.parametrize("sunk, turned, afresh", [(0.05, True, False), (0.2, True, True), (0.2, False, False)])
def test_an_open_point_far_behind_its_face_is_placed_afresh(sunk, turned, afresh, monkeypatch):
    """In half-widths of its domain, in soil that has turned; one that touches stays where the grid has carried it."""
    monkeypatch.setattr(Domains, "turned", lambda self, point: np.full(len(point), turned))
    surface, body, places = ball(), body_at((0.4, 0.4, 0.24)), PLACES["faces"]
    _, first = found_in_bed(surface, body, places=places)
    contact = contact_of(first, surface, (body.position - (0, 0, 0.01), body.rotation))
    _, _, half = bed()
    normal = places.normal[first.place // places.offset.shape[1]]
    carried = first.position - sunk * half[first.point] * normal
    history = soil_to_body.commit(first, carried, contact)
    _, second = found_in_bed(surface, body, history, places=places)
    common = np.isin(id_of(second), id_of(first))
    at = np.searchsorted(id_of(first), id_of(second)[common])
    touching = history.touching[at]
    expected = np.where(touching[:, None] | (not afresh), carried[at], first.position[at])
    assert touching.any() and not touching.all()
    np.testing.assert_allclose(second.position[common], expected, atol=1e-12)


def test_inactive_points_have_no_corners():
    surface, body = ball(), body_at((0.4, 0.4, 0.24))
    _, first = found_in_bed(surface, body)
    history = soil_to_body.commit(first, first.position, contact_of(first, surface, (body.position, body.rotation)))
    point = first.point[0]
    stays = np.arange(len(bed()[1])) != point
    _, second = found_in_bed(surface, body, history, included=stays)
    np.testing.assert_array_equal(id_of(second), id_of(first)[first.point != point])


def test_soil_has_turned_by_the_rotation_of_its_deformation_gradient():
    """A block turned by 40 and 50°, stretched, and sheared by γ, which turns by tan = γ/2."""
    stretch = np.diag([1.5, 0.8, 1.0])
    shear = [np.eye(3) + gamma * np.outer((1.0, 0.0, 0.0), (0.0, 0.0, 1.0)) for gamma in (1.9, 2.1)]
    turned = [exp_so3(np.radians([0.0, angle, 0.0])) @ stretch for angle in (40.0, 50.0)]
    found = Domains(*np.zeros((4, 5, 3)), deformation=np.array([stretch, *shear, *turned])).turned(np.arange(5))
    assert found.tolist() == [False, False, True, False, True]
