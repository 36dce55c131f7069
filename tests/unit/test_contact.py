"""Contact: action and reaction, objectivity, friction anchors, corners carried by the grid, corner search."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from hybrid.body.attitude import exp_so3
from hybrid.body.closest import closest
from hybrid.body.surface import build_surface
from hybrid.build import build
from hybrid.contact import assembly, friction
from hybrid.contact.corners import SIGNS, Corners, find_corners
from hybrid.contact.meeting import meeting_points
from hybrid.scene import Axis, Body, Faces, Grid, Material, Scene, Soil, Stage, Time
from hybrid.soil.grid import FACES, make_grid, uniform_nodes
from hybrid.state import ContactHistory
from hybrid.system.cache import Systems
from hybrid.system.equations import Step, Unknowns

MU, RATIO = 0.3, 0.5
RIGHT_HAND = exp_so3(np.array([0.3, -1.1, 0.6]))


def box(cells=1, half=(1.0, 0.8, 0.5)):
    """ContactSurface of a box with `cells` x `cells` squares, two triangles each, on each side."""
    grid = np.linspace(-1.0, 1.0, cells + 1)
    index, triangles = {}, []
    for axis in range(3):
        for side in (-1.0, 1.0):
            for i in range(cells):
                for j in range(cells):
                    square = []
                    for u, v in ((0, 0), (1, 0), (1, 1), (0, 1)):
                        corner = np.empty(3)
                        corner[axis] = side
                        corner[(axis + 1) % 3], corner[(axis + 2) % 3] = grid[i + u], grid[j + v]
                        square.append(index.setdefault(tuple(corner + 0.0), len(index)))
                    square = square if side > 0 else square[::-1]
                    triangles += [square[:3], [square[0], square[2], square[3]]]
    return build_surface(np.array(list(index)) * half, np.array(triangles))


def ball(radius=0.25, rings=24):
    """ContactSurface of a sphere with vertices on circles of latitude."""
    polar = np.linspace(0, np.pi, rings + 1)[1:-1]
    turn = np.linspace(0, 2 * np.pi, 2 * rings, endpoint=False)
    points = [[0, 0, radius]]
    for a in polar:
        points += [[radius * np.sin(a) * c for c in (np.cos(b), np.sin(b), 1 / np.tan(a))] for b in turn]
    points.append([0, 0, -radius])
    n, triangles = len(turn), []
    for j in range(n):
        k = (j + 1) % n
        triangles.append([0, 1 + j, 1 + k])
        for i in range(len(polar) - 1):
            a, b = 1 + i * n, 1 + (i + 1) * n
            triangles += [[a + j, b + j, b + k], [a + j, b + k, a + k]]
        triangles.append([len(points) - 1, 1 + (len(polar) - 1) * n + k, 1 + (len(polar) - 1) * n + j])
    return build_surface(np.array(points, float), np.array(triangles))


def body_at(position=(0.0, 0.0, 0.0), rotation=np.eye(3)):
    return SimpleNamespace(position=np.array(position, float), rotation=rotation)


def corners_in(surface, y, anchor, pose=(np.zeros(3), np.eye(3)), touching=True):
    """Corners at places y (m, 3) of the body frame."""
    y = np.atleast_2d(np.array(y, float))
    m = len(y)
    return Corners(
        np.arange(m), pose[0] + y @ pose[1].T, y, np.zeros((m, 8), np.int64), np.full((m, 8), 0.125),
        np.full(m, 2e4), np.full(m, touching), np.array(np.broadcast_to(anchor, (m, 3)), float),
        np.zeros((m, 3)), np.zeros(m))


def touch_of(corners, surface, pose=(np.zeros(3), np.eye(3)), place=None, mu=MU):
    return friction.evaluate(
        corners, corners.position if place is None else place, *pose, surface, mu, RATIO)


def bed(cells=(8, 8, 2), size=0.1, per_axis=2):
    """Grid about z = 0, and positions and half-widths of the points that tile its lower half."""
    axes = [uniform_nodes(0.0, n * size, size) for n in cells[:2]]
    axes.append(uniform_nodes(-cells[2] * size / 2, cells[2] * size / 2, size))
    grid = make_grid(axes, np.array([(a[0], a[-1]) for a in axes]), dict.fromkeys(FACES, "free"))
    step = size / per_axis
    centres = [np.arange(a[0] + step / 2, end, step) for a, end in zip(axes, (axes[0][-1], axes[1][-1], 0.0))]
    position = np.stack([c.ravel() for c in np.meshgrid(*centres, indexing="ij")], axis=1)
    return grid, position, np.full_like(position, step / 2)


def found_in_bed(surface, body, history=None, active=None, reach=0.08, seed=1, pose=None, displacement=None):
    grid, position, half = bed()
    position = position + 0.01 * np.random.default_rng(seed).standard_normal(position.shape)
    active = np.ones(grid.node_count, bool) if active is None else active
    history = history or ContactHistory.empty()
    expected = displacement, pose or (body.position, body.rotation)
    return grid, find_corners(
        position, half, grid, active, body, surface, reach, np.full(len(position), 8e4), history, expected)


# ---------------------------------------------------------------- action and reaction, objectivity


def test_force_and_moment_cancel_to_round_off():
    surface, body = ball(), body_at((0.41, 0.38, 0.21), RIGHT_HAND)
    grid, corners = found_in_bed(surface, body)
    nodes = np.stack([a.ravel() for a in np.meshgrid(*grid.axes, indexing="ij")], axis=1)
    move = 0.004 * np.random.default_rng(2).standard_normal(nodes.shape)
    pose = body.position + (0.003, 0.001, -0.004), exp_so3(np.array([0.02, 0.05, -0.03])) @ body.rotation
    touch = touch_of(corners, surface, pose, corners.moved(move))
    assert len(touch) > 20 and 0 < touch.slip.sum() < len(touch)
    force = np.zeros_like(nodes)
    on_body = assembly.add_residual(touch, corners, force)
    scale = np.abs(touch.force).sum()
    np.testing.assert_allclose(force.sum(axis=0) + on_body[:3], 0.0, atol=1e-13 * scale)
    moment = np.cross(nodes + move - pose[0], force).sum(axis=0) + on_body[3:]
    np.testing.assert_allclose(moment, 0.0, atol=1e-13 * scale)


def test_tangent_of_a_rigid_motion_of_everything_vanishes_in_translation():
    """Moving corners and body together changes no force: D and Q cancel."""
    surface, body = ball(), body_at((0.41, 0.38, 0.21), RIGHT_HAND)
    _, corners = found_in_bed(surface, body)
    touch = touch_of(corners, surface, (body.position - (0, 0, 0.01), body.rotation))
    ww, Q = assembly.body_tangent(touch)
    np.testing.assert_allclose(touch.tangent + Q[:, :, :3], 0.0, atol=1e-12 * np.abs(Q).max())
    np.testing.assert_allclose(ww[:3, :3], touch.tangent.sum(axis=0), atol=1e-12 * np.abs(ww).max())


def test_law_is_objective():
    surface, rng = ball(), np.random.default_rng(3)
    pose = np.array([0.2, 0.1, -0.3]), RIGHT_HAND
    y = rng.standard_normal((40, 3))
    y *= (rng.uniform(0.22, 0.249, 40) / np.linalg.norm(y, axis=1))[:, None]
    corners = corners_in(surface, y, y + 0.002 * rng.standard_normal(y.shape), pose)
    touch = touch_of(corners, surface, pose)
    Q, shift = exp_so3(np.array([-0.8, 0.5, 2.0])), np.array([3.0, -1.0, 2.0])
    turned_pose = Q @ pose[0] + shift, Q @ pose[1]
    turned = touch_of(corners, surface, turned_pose, corners.position @ Q.T + shift)
    assert 0 < touch.slip.sum() < len(touch)
    np.testing.assert_array_equal(turned.slip, touch.slip)
    np.testing.assert_allclose(turned.gap, touch.gap, rtol=1e-11)
    np.testing.assert_allclose(turned.anchor, touch.anchor, atol=1e-14)
    np.testing.assert_allclose(turned.force, touch.force @ Q.T, atol=1e-11 * np.abs(touch.force).max())
    expected = Q @ touch.tangent @ Q.T
    np.testing.assert_allclose(turned.tangent, expected, atol=1e-10 * np.abs(expected).max())
    assert turned.energy == pytest.approx(touch.energy, rel=1e-11)


# ---------------------------------------------------------------- anchors


def test_anchor_without_expected_motion_is_the_place_at_the_start():
    surface, body = ball(), body_at((0.4, 0.4, 0.27), RIGHT_HAND)
    _, corners = found_in_bed(surface, body)
    assert len(corners) and not corners.touching.any()
    np.testing.assert_allclose(corners.anchor, corners.start, atol=1e-15)


def test_anchor_is_where_the_expected_path_meets_the_surface():
    surface, body = box(), body_at((0.0, 0.0, 0.51))        # 10 mm above the bed z = 0
    start = np.array([[0.1, 0.2, 0.0], [0.3, -0.1, -0.012]])
    pose = np.array([0.04, 0.0, 0.49]), np.eye(3)           # 20 mm down, 40 mm along x
    anchor, side = meeting_points(start, start, body, pose, surface)
    np.testing.assert_array_equal(side, [[0.0, 0.0, -1.0], [0.0, 0.0, 0.0]])
    np.testing.assert_allclose(anchor[0], [0.08, 0.2, -0.5], atol=2e-5)     # half way
    np.testing.assert_allclose(anchor[1], [0.26, -0.1, -0.502], atol=1e-12)  # not met: the end of the path


def test_rolling_without_sliding_winds_up_no_friction():
    """From where it touches, a corner under a rolling ball hardly moves along the surface; from where it
    stood at the start of the step it moves a³/(3r²)."""
    surface, r, way, depth = ball(rings=90), 0.25, 0.04, 0.0002
    lowest = -surface.vertices[:, 2].min()
    body = body_at((0.0, 0.0, lowest - depth))
    pose = np.array([way, 0.0, lowest - depth]), exp_so3(np.array([0.0, way / r, 0.0]))
    corner = np.array([[way + 0.002, 0.0, 0.0]])
    start = (corner - body.position) @ body.rotation
    anchor, _ = meeting_points(corner, corner, body, pose, surface)
    end = (corner - pose[0]) @ pose[1]
    normal = end / np.linalg.norm(end)

    def along(anchor):
        z = (end - anchor)[0]
        return np.linalg.norm(z - normal[0] * (z @ normal[0]))

    a = way + 0.002
    assert along(start) == pytest.approx(a**3 / (3 * r**2), rel=0.15)
    assert along(anchor) < 0.05 * along(start)
    assert abs(closest(anchor[0], np.inf, surface.tree)[4]) < 2e-5


@pytest.mark.parametrize("touching", [True, False])
def test_slip_moves_the_anchor_to_the_friction_limit(touching):
    surface = box()
    corners = corners_in(surface, [[0.2, 0.1, -0.49]], [0.21, 0.12, -0.495], touching=touching)
    touch = touch_of(corners, surface)
    pressure = 2e4 * 0.01
    assert touch.slip.all()
    z = corners.start[0] - touch.anchor[0]
    assert RATIO * 2e4 * np.hypot(z[0], z[1]) == pytest.approx(MU * pressure, rel=1e-12)
    assert np.hypot(*touch.force[0, :2]) == pytest.approx(MU * pressure, rel=1e-12)
    assert touch.force[0] @ (0.01, 0.02, 0.0) < 0.0         # against the way from the anchor
    history = friction.commit(corners, corners.position, touch)
    again = touch_of(replace(corners, touching=history.touching, anchor=history.anchor), surface)
    np.testing.assert_allclose(again.force, touch.force, rtol=1e-12)
    assert again.dissipated == pytest.approx(0.0, abs=1e-12)


def test_stick_leaves_the_anchor():
    surface = box()
    corners = corners_in(surface, [[0.2, 0.1, -0.49]], [0.201, 0.1, -0.495])
    touch = touch_of(corners, surface)
    assert not touch.slip.any() and touch.dissipated == 0.0
    np.testing.assert_array_equal(touch.anchor, corners.anchor)
    np.testing.assert_allclose(touch.force[0, :2], (-RATIO * 2e4 * 0.001, 0.0), atol=1e-9)


def slide(surface, mu=MU, steps=30):
    """Forces on a corner that slides and turns back under a box, with history from step to step."""
    corners = corners_in(surface, [[-0.6, -0.31, -0.49]], [-0.6, -0.31, -0.49])
    forces, work = [], 0.0
    for angle in np.linspace(0, 3.0, steps):
        y = np.array([[-0.6 + 0.9 * np.sin(angle), -0.31 + 0.2 * angle, -0.49]])
        touch = touch_of(corners, surface, place=y, mu=mu)
        history = friction.commit(corners, y, touch)
        corners = replace(corners, position=y, start=y, touching=history.touching, anchor=history.anchor)
        forces.append(touch.force[0])
        work += touch.dissipated
    return np.array(forces), work


def test_history_survives_hopping_between_triangles():
    coarse, fine = slide(box(1)), slide(box(9))
    np.testing.assert_allclose(fine[0], coarse[0], atol=1e-9)
    assert fine[1] == pytest.approx(coarse[1], rel=1e-12)


def test_friction_work_is_force_times_way():
    forces, work = slide(box(1), steps=300)
    angle = np.linspace(0, 3.0, 300)
    way = np.diff(np.stack([0.9 * np.sin(angle), 0.2 * angle], axis=1), axis=0)
    assert work == pytest.approx(np.sum(forces[1:, :2] * way), rel=5e-3)
    assert work > 0


def test_without_friction_the_force_is_normal():
    touch = touch_of(corners_in(box(), [[0.2, 0.1, -0.49]], [0.5, 0.5, -0.4]), box(), mu=0.0)
    np.testing.assert_allclose(touch.force, [[0.0, 0.0, 200.0]], atol=1e-9)
    assert not touch.slip.any()


# ---------------------------------------------------------------- corners


def pressed(geometry, steps=4):
    """Simulation of a sphere pressed into a soft block, frictionless, after a few steps."""
    axis = Axis(start=0.0, end=0.8, size=0.2)
    described = Scene(
        name="block", grid=Grid(axis, axis, Axis(start=-0.6, end=0.2, size=0.2), Faces(z_min="fixed")),
        soil=Soil(Material(law="hencky", young=2e5, poisson=0.2, density=1800.0), top=0.0, geostatic=False),
        bodies=(Body(
            geometry=geometry / "sphere.geo", density=3000.0, parameters={"radius": 0.25, "size": 0.12},
            position=(0.43, 0.37, 0.25), velocity=(0.3, 0.0, -1.5)),),
        gravity=(0.0, 0.0, 0.0), time=Time(step=0.01), stages=(Stage("press", steps),))
    simulation = build(described)
    simulation.run()
    return simulation


def contact_energy_at_rest(simulation, state):
    step = Step(simulation.model, state, 0.01, False, Systems(simulation.model))
    rest = Unknowns(np.zeros((simulation.model.soil.grid.node_count, 3)),
                    tuple((b.position, b.rotation) for b in state.bodies))
    return step.evaluate(rest).contacts[0].energy


def test_contact_energy_does_not_jump_between_steps(geometry):
    """Corners are carried as material points. Placed anew at x_p ± l they would jump, and energy too."""
    simulation = pressed(geometry)
    committed = simulation.evaluation.contacts[0].corners
    assert len(committed) >= 4 and committed.energy > 0.0
    state = simulation.state
    assert contact_energy_at_rest(simulation, state) == pytest.approx(committed.energy, rel=1e-10)
    anew = replace(state, contacts=[ContactHistory.empty()])
    assert abs(contact_energy_at_rest(simulation, anew) / committed.energy - 1) > 0.02


def test_weights_of_nodes_without_mass_go_to_the_others():
    surface, body = ball(), body_at((0.4, 0.4, 0.2))
    grid, everywhere = found_in_bed(surface, body)
    upper = np.broadcast_to(grid.axes[2] > 1e-9, grid.shape).ravel()
    _, corners = found_in_bed(surface, body, active=~upper)
    full = {id: both for id, *both in zip(everywhere.id, everywhere.node, everywhere.weight)}
    moved = 0
    for id, node, weight in zip(corners.id, corners.node, corners.weight):
        node_full, weight_full = full[id]
        np.testing.assert_array_equal(node, node_full)
        assert weight.sum() == pytest.approx(1.0, rel=1e-14)
        assert not weight[upper[node]].any()
        kept = ~upper[node]
        np.testing.assert_allclose(weight[kept], weight_full[kept] / weight_full[kept].sum(), rtol=1e-13)
        moved += weight_full[~kept].sum() > 1e-3
    assert moved > 3
    assert len(found_in_bed(surface, body, active=np.zeros(grid.node_count, bool))[1]) == 0


def brute_force(position, half, body, surface, reach):
    """Numbers of all corners within reach, one by one."""
    place = position[:, None] + SIGNS * half[:, None]
    y = (place.reshape(-1, 3) - body.position) @ body.rotation
    gaps = np.array([closest(tuple(point), np.inf, surface.tree)[4] for point in y])
    return np.flatnonzero(np.abs(gaps) < reach)


@pytest.mark.parametrize("surface, position", [
    (ball(), (0.4, 0.35, 0.2)), (box(2, (0.2, 0.15, 0.1)), (0.5, 0.3, 0.08)),
    (box(1, (0.2, 0.15, 0.1)), (0.9, 0.9, 0.3))])
@pytest.mark.parametrize("reach", [0.02, 0.1])
def test_corner_search_equals_brute_force(surface, position, reach):
    _, points, half = bed()
    points = points + 0.01 * np.random.default_rng(1).standard_normal(points.shape)
    body = body_at(position, RIGHT_HAND)
    _, corners = found_in_bed(surface, body, reach=reach)
    np.testing.assert_array_equal(corners.id, brute_force(points, half, body, surface, reach))
    np.testing.assert_allclose(
        corners.position, points[corners.id // 8] + SIGNS[corners.id % 8] * half[corners.id // 8], atol=1e-15)
    np.testing.assert_allclose(corners.stiffness, 2e4)


def test_history_is_followed_until_it_leaves_the_reach():
    surface, body = ball(), body_at((0.4, 0.4, 0.24))
    _, first = found_in_bed(surface, body)
    touch = touch_of(first, surface, (body.position - (0, 0, 0.01), body.rotation))
    shifted = first.position + 0.003
    history = friction.commit(first, shifted, touch)
    _, second = found_in_bed(surface, body, history)
    common = np.isin(second.id, first.id)
    at = np.searchsorted(first.id, second.id[common])
    np.testing.assert_array_equal(second.position[common], shifted[at])
    np.testing.assert_array_equal(second.touching[common], history.touching[at])
    carried = history.touching[at]
    assert carried.any()
    np.testing.assert_array_equal(second.anchor[common][carried], history.anchor[at][carried])
    _, far = found_in_bed(surface, body_at((0.4, 0.4, 2.0)), history)
    assert len(far) == 0
