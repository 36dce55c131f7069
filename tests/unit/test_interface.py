"""Interface of clay: who bears its area, what is bonded, and what is remembered of a bond that has broken."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from contact_bed import PRESSURE, ball, bed, body_at, box, domains_of, id_of

from hybrid.body.rounded import round_off
from hybrid.body.sharp_edges import find_edges
from hybrid.contact import contact_points, interface
from hybrid.contact import places as rules
from hybrid.contact.contact_pair import ContactPair
from hybrid.contact.contact_points import SoilSurface
from hybrid.contact.cover import Cover
from hybrid.contact.interface import Interface, PointLimits, place_limits
from hybrid.contact.search import Reach
from hybrid.laws.cone import merge
from hybrid.laws.drucker_prager import DruckerPrager
from hybrid.laws.hencky import Hencky
from hybrid.laws.mohr_coulomb import MohrCoulomb
from hybrid.laws.von_mises import VonMises
from hybrid.laws.willam_warnke import WillamWarnke
from hybrid.runtime.data import GEOMETRY
from hybrid.runtime.errors import SceneError
from hybrid.scene import Axis, Body, Faces, Grid, Layer, Material, Pull, Scene, Soil, Stage, Time
from hybrid.scene.file import validate
from hybrid.setup import contact
from hybrid.setup.build import build
from hybrid.setup.interface import friction_of, interface_of
from hybrid.state import ContactHistory

SHEAR = 2e3     # [Pa]


def pair_of(surface, height, history=None, tension=0.0, shear=SHEAR, sharp=None, begins=None):
    """Grid and ContactPair of a body whose centre is `height` above a flat bed of 0.8 m x 0.8 m; sharp: as in Interface;
    begins: whether the run does, left out: without history."""
    grid, position, half = bed()
    body = SimpleNamespace(surface=surface, friction=np.inf, tangential=0.5, places=rules.faces(4), free=np.ones(6, bool),
                           contact_pressure=np.full(len(position), PRESSURE), soft_edges=None)
    pose = np.array([0.4, 0.4, height]), np.eye(3)
    limits = PointLimits(np.full(len(position), shear), tension, sharp)
    soil = SoilSurface(domains_of(position, half), grid, np.ones(grid.node_count, bool))
    pair = ContactPair(soil, body, body_at(*pose), history or ContactHistory.empty(), Reach(0.05, 0.0),
                       (np.zeros((grid.node_count, 3)), pose), limits, begins=history is None if begins is None else begins)
    return grid, pair


def steps_of(surface, heights, tension):
    """Normal forces (k,) [N] on the bed, energies and dissipated work of a body that goes through heights; histories."""
    grid, pair = pair_of(surface, heights[0], tension=tension)
    still, out = np.zeros((grid.node_count, 3)), []
    for height in heights:
        found = pair.evaluate(still, (np.array([0.4, 0.4, height]), np.eye(3)))
        history = pair.commit(found, still)
        out.append((found.resultant[2], found.energy, found.dissipated, history))
        _, pair = pair_of(surface, height, history, tension)
    return out


PLATE = box(half=(0.2, 0.2, 0.1))       # 16 whole domains of 0.1 m x 0.1 m
STIFF = PRESSURE * 0.16                 # [N/m]


def test_points_that_touch_already_are_not_bonded_anew_when_the_run_begins():
    """Such as those with which the soil has settled: they keep the gap at which their springs have no force."""
    grid, pair = pair_of(PLATE, 0.101, tension=np.inf)
    still = np.zeros((grid.node_count, 3))
    history = pair.commit(pair.evaluate(still, (np.array([0.4, 0.4, 0.1005]), np.eye(3))), still)
    assert history.touching.any() and history.rest[history.touching] == pytest.approx(1e-3)
    _, pair = pair_of(PLATE, 0.1005, history, np.inf, begins=True)
    touching = pair.points.touching
    assert touching.sum() >= history.touching.sum() and pair.points.rest[touching].max() == pytest.approx(1e-3)
    known = np.isin(id_of(pair.points), id_of(history)[history.touching])
    assert pair.points.rest[known] == pytest.approx(1e-3)


def test_the_area_of_flat_contact_is_that_of_the_body():
    grid, pair = pair_of(PLATE, 0.099)
    found = pair.evaluate(np.zeros((grid.node_count, 3)), (np.array([0.4, 0.4, 0.099]), np.eye(3)))
    assert pair.points.limits.shear[found.active].sum() == pytest.approx(SHEAR * 0.16, rel=1e-9)


@pytest.mark.parametrize("measured, least, most", [(True, 0.159, 0.161), (False, 0.0, 0.15)])
def test_a_face_has_its_whole_area_although_its_edges_are_rounded_off(measured, least, most):
    """As far as half a cell beside each of them soil is away from the body; from that surface 0.148 of 0.16 m² are borne."""
    rounded = round_off(PLATE, find_edges(PLATE, 0.1))
    sharp, still = PLATE if measured else None, np.zeros((bed()[0].node_count, 3))
    _, first = pair_of(rounded, 0.099, sharp=sharp)
    found = first.evaluate(still, (np.array([0.4, 0.4, 0.099]), np.eye(3)))
    _, after = pair_of(rounded, 0.099, first.commit(found, still), sharp=sharp)
    assert least < after.points.limits.shear[after.points.touching].sum() / SHEAR < most


def test_the_thickness_of_a_slice_is_no_width_of_a_domain():
    """Faces 3 and 10 domains beside the one that touches: the first is borne, by a slice of 1 m as by any other."""
    half = np.array([0.025, 0.5, 0.025])
    position = np.array([[0.0, 0.0, -0.025], [0.15, 0.0, -0.025], [0.5, 0.0, -0.025]])
    places = rules.faces(4, (False, True, False))
    top = int(np.flatnonzero(places.flat[:, 2] == 1.0)[0])
    domains, upward, none = domains_of(position, np.tile(half, (3, 1))), np.tile([0.0, 0.0, -1.0], (3, 1)), np.zeros(3)
    found = {"point": np.arange(3), "place": np.full(3, top), "position": position + places.flat[top] * half,
             "normal": upward,
             "rest": none, "clearance": np.array([-1e-4, 1e-3, 1e-3]), "touching": np.arange(3) == 0, "opened": none > 0.0}
    area = places.area(found["place"], domains.half, domains.volume)
    body, surface = body_at((0.0, 0.0, 1.0)), box(half=(2.0, 0.5, 1.0))
    shear = place_limits(PointLimits(np.full(3, SHEAR), 0.0), found, area, domains, places, body, surface)[0].shear
    np.testing.assert_allclose(shear, SHEAR * area[0] * np.array([2.0, 0.0, 1.0]))


@pytest.mark.parametrize("collapsed", [False, True])
@pytest.mark.parametrize("opened", [False, True])
@pytest.mark.parametrize("tension", [0.0, 1e3])
def test_layers_of_clay_that_has_parted_bear_the_interface_of_one(collapsed, opened, tension):
    """A thin layer touches the plate; where it has parted from the next one, the upper faces of both lie before the
    plate. In space and in a slice, where a domain has the whole thickness."""
    across = np.arange(0.025, 0.8, 0.05)
    x, y = (axis.ravel() for axis in np.meshgrid(across, [0.4] if collapsed else across, indexing="ij"))
    gap, wide = 0.02 if opened else 0.0, 0.4 if collapsed else 0.025
    position, half = (np.concatenate([np.stack(np.broadcast_arrays(*row), axis=1) for row in rows]) for rows in (
        ((x, y, -0.006), (x, y, -0.032 - gap)), ((0.025 + 0 * x, wide, 0.006), (0.025 + 0 * x, wide, 0.02))))
    places = rules.faces(4, (False, collapsed, False))
    tops = np.flatnonzero(places.flat[:, 2] == 1.0)
    point, place = np.repeat(np.arange(len(position)), len(tops)), np.tile(tops, len(position))
    at = position[point] + places.flat[place] * half[point]
    depth, m, none = -at[:, 2], len(point), np.zeros(len(point))
    found = {"point": point, "place": place, "position": at, "normal": np.tile([0.0, 0.0, -1.0], (m, 1)), "rest": none,
             "clearance": np.where(depth < 1e-9, -1e-6, depth), "touching": depth < 1e-9, "opened": none > 0.0}
    under = (np.abs(at - 0.4)[:, :2] <= np.where([False, collapsed], np.inf, 0.3)).all(axis=1)
    found = {name: values[under] for name, values in found.items()}
    domains, body = domains_of(position, half), body_at((0.4, 0.4, 0.1))
    surface = box(half=(0.3, 0.4 if collapsed else 0.3, 0.1))
    area = places.area(found["place"], domains.half[found["point"]], domains.volume[found["point"]])
    plate, flat = 0.6 * (0.8 if collapsed else 0.6), np.array([[0.0, 1.0, 0.0]]) if collapsed else ()
    cover, strength = Cover.of(surface, 0.05, flat), np.full(len(position), SHEAR)
    counted, every = (place_limits(PointLimits(strength, tension, None, known), found, area, domains, places, body, surface)
                      for known in (cover, None))
    layers = 2.0 if opened else 1.0
    assert every[0].shear[found["touching"]].sum() / SHEAR == pytest.approx(layers * plate, rel=1e-9)
    sums = [counted[0].shear[found["touching"]].sum() / SHEAR]
    if tension:
        sums.append(counted[0].tension.sum() / tension)
    else:
        sums.append(counted[1](found["touching"], np.ones(len(area)))[found["touching"]].sum() / SHEAR)
    for borne in sums:
        # beside edges half of what is around is not there
        assert borne == pytest.approx(plate, rel=0.12 if opened else 1e-3)


def ball_in_a_bed(radius, height, tension=0.0):
    """ContactPair of a ball in a bed whose points inside it are removed, once it has touched: few contact points do."""
    grid, position, half = bed((16, 16, 8), 0.05)
    centre = np.array([0.4, 0.4, height])
    nearest_corner = np.maximum(np.abs(position - centre) - half, 0.0)
    inside = np.linalg.norm(nearest_corner, axis=1) < radius - 5e-3
    domains = domains_of(position, half, ~inside)
    body = SimpleNamespace(surface=ball(radius), friction=np.inf, tangential=0.5, places=rules.faces(8),
                           free=np.ones(6, bool),
                           contact_pressure=np.full(len(position), PRESSURE), soft_edges=None)
    limits = PointLimits(np.full(len(position), SHEAR), tension)

    def pair(history):
        return ContactPair(SoilSurface(domains, grid, np.ones(grid.node_count, bool)), body, body_at(centre), history,
                           Reach(0.03, 0.0), (np.zeros((grid.node_count, 3)), (centre, np.eye(3))), limits,
                           begins=not len(history.point))

    still = np.zeros((grid.node_count, 3)), (centre, np.eye(3))
    first = pair(ContactHistory.empty())
    return pair(first.commit(first.evaluate(*still), still[0]))


def test_contact_points_that_touch_bear_the_steps_around_them():
    """The interface of all of the cap."""
    radius, height = 0.25, 0.1
    after = ball_in_a_bed(radius, height)
    touching = after.points.touching
    area, own = after.points.limits.shear[touching].sum() / SHEAR, after.points.stiffness[touching].sum() / PRESSURE
    cap = 2 * np.pi * radius * (radius - height)
    assert area == pytest.approx(cap, rel=0.2) and own < 0.5 * cap      # of soil up to a domain away, so rather larger


@pytest.mark.parametrize("tension, least, most", [(0.0, 0.0, 0.02), (1.0, 0.2, 1.0)])
def test_points_that_are_hardly_pressed_bear_little_of_the_interface(tension, least, most):
    """They part from the body first, and would take with them what they bear: 27 % of all on those with less than a tenth of
    the mean force, where the nearest one bears. So it is with a bond, which holds whatever presses."""
    points = ball_in_a_bed(0.25, 0.1, tension).points
    touching = points.touching
    force = (points.stiffness * (points.rest - points.clearance))[touching]
    shear = points.limits.shear[touching]
    assert least < shear[force < 0.1 * force.mean()].sum() / shear.sum() < most


@pytest.mark.parametrize("law, cone", [("mohr-coulomb", None), ("willam-warnke", None),
                                       ("drucker-prager", "compression"), ("drucker-prager", "plane strain")])
def test_clay_may_be_written_as_soil_without_friction(law, cone):
    """Its interface bears the cohesion by default, as that of von Mises' law beside it does, whatever its section."""
    laws, young = {"mohr-coulomb": MohrCoulomb, "willam-warnke": WillamWarnke}, np.full(1, 1e7)
    build = laws.get(law) or (lambda *given: DruckerPrager(*given, cone))
    made = interface_of(Body("box.geo", 1.0, adhesion=0.5))
    both = merge([build(young, 0.3, 0.0, 0.0, 1e4), VonMises(young, 0.3, 2e4, "plane strain")], [[0], [1]])
    assert made.of_points(both, np.zeros(2)).shear == pytest.approx([5e3, 1e4], rel=1e-12)


def test_strength_is_that_of_the_law_softened_and_matched():
    """α s_u with s_u as given, whatever state the cone is matched to, and falling with plastic strain to the residual."""
    strength, alpha = 1e4, 0.5
    for cone in ("plane strain", "compression"):
        law = VonMises(np.full(3, 1e7), 0.49, strength, cone, -2e4, 4e3)
        limits = Interface(alpha, 0.0).of_points(law, np.array([0.0, 0.1, 1.0]))
        np.testing.assert_allclose(limits.shear, alpha * np.array([1e4, 8e3, 4e3]))


def test_without_a_bond_nothing_pulls():
    forces = [force for force, *_ in steps_of(PLATE, (0.099, 0.1005, 0.102), 0.0)]
    assert forces[0] == pytest.approx(STIFF * 1e-3, rel=1e-9) and forces[1:] == [0.0, 0.0]


def test_a_full_bond_pulls_as_it_presses():
    forces = [force for force, *_ in steps_of(PLATE, (0.099, 0.1005, 0.12, 0.099), np.inf)]
    np.testing.assert_allclose(forces, STIFF * np.array([1e-3, -5e-4, -2e-2, 1e-3]), rtol=1e-9)


def test_a_bond_breaks_at_its_limit_and_stays_broken():
    """Pulled to the limit it bears σ_t A in that step and nothing after it; pressed again, it does not bond again. What
    was put into it has been dissipated."""
    tension = 1e4
    limit, way = tension * 0.16, 0.6e-3
    found = steps_of(PLATE, (0.099, 0.1 + 0.5 * limit / STIFF, 0.1 + way, 0.1 + way, 0.0995, 0.1005), tension)
    np.testing.assert_allclose([force for force, *_ in found], [STIFF * 1e-3, -0.5 * limit, -limit, 0.0, STIFF * 5e-4, 0.0],
                               rtol=1e-9, atol=1e-9)
    dissipated = [lost for _, _, lost, _ in found]
    assert dissipated[2] == pytest.approx(limit * (way - 0.5 * limit / STIFF), rel=1e-9)
    assert sum(dissipated) == pytest.approx(dissipated[2])
    assert [history.opened.any() for *_, history in found] == [False, False, True, True, True, True]


def test_what_has_opened_is_followed_however_far_the_body_goes():
    found = steps_of(PLATE, (0.099, 0.12, 0.4, 0.0995), 1e4)
    opened = [set(id_of(history)[history.opened]) for *_, history in found]
    assert opened[1] and opened[1] == opened[2] == opened[3]
    assert found[3][0] == pytest.approx(STIFF * 5e-4, rel=1e-9)


@pytest.mark.parametrize("overlap", [0.0, 1e-12, -1e-12, 1e-4])
def test_soil_that_begins_at_the_body_is_bonded_whatever_the_round_off(overlap):
    grid, pair = pair_of(PLATE, 0.1 - overlap, tension=np.inf)
    assert (pair.points.limits.tension > 0.0).sum() * 0.05**2 / 16 == pytest.approx(0.16)
    assert pair.points.rest[pair.points.touching].max() == pytest.approx(max(0.0, -overlap), abs=1e-15)


def test_soil_that_begins_on_the_body_is_bonded_where_it_is():
    """0.1 half-widths, 2.5 mm, away: no force there, and pulled from there on. Farther away it is not bonded."""
    forces = [force for force, *_ in steps_of(PLATE, (0.102, 0.1025, 0.1018), np.inf)]
    np.testing.assert_allclose(forces, STIFF * np.array([0.0, -5e-4, 2e-4]), rtol=1e-8, atol=1e-6)
    assert [force for force, *_ in steps_of(PLATE, (0.103, 0.104), np.inf)] == [0.0, 0.0]


# ------------------------------------------------------------------ keys


def scene_with(geometry, law="von-mises", held=False, layers=(), **values):
    axis = Axis(start=0.0, end=1.0, size=0.25)
    material = Material(law="von-mises", young=1e6, poisson=0.49, density=1800.0, strength=1e4)
    if law == "hencky":
        material = Material(law="hencky", young=1e6, poisson=0.3, density=1800.0)
    return Scene(name="keys", grid=Grid(axis, axis, axis), soil=Soil(material, top=0.5, held=held, layers=layers),
                 bodies=(Body(geometry / "box.geo", 2000.0, rest_on=0.5, position=(0.5, 0.5, 0.0), **values),),
                 time=Time(0.01), stages=(Stage("one", 1),))


KINDS = {"hencky": {"young": 1e7, "poisson": 0.3}, "von-mises": {"young": 2.5e7, "poisson": 0.49, "strength": 1e4}}


@pytest.mark.parametrize("law, adhesion", [("hencky", None), ("von-mises", None), ("von-mises", 0.4)])
def test_bonds_hold_no_soil_along_a_face(law, adhesion, monkeypatch):
    """A strip of 2 m that stays attached is drawn along the soil: α s_u B, and nothing where it is smooth. With bonds along
    what was rounded off of its edges too it is not."""
    strip = Body(GEOMETRY / "box.geo", 1000.0, parameters={"length": 2.0, "width": 1.0, "height": 0.5, "size": 20.0},
                 position=(0.0, 0.5, 0.0), rest_on=0.0, tension="full", adhesion=adhesion, held=("z", "ry"), driven=("x",),
                 velocity=(0.002, 0.0, 0.0))
    described = Scene(
        name="drawn", grid=Grid(Axis(-3.0, 3.0, 0.25), Axis(0.0, 1.0, collapsed=True), Axis(-1.5, 0.5, 0.25),
                                Faces(z_min="fixed")),
        soil=Soil(Material(law=law, density=1.0, **KINDS[law]), top=0.0, geostatic=False), bodies=(strip,),
        time=Time(1.0, inertia=False), stages=(Stage("draw", 4),), gravity=(0.0, 0.0, 0.0))

    def drawn():
        *_, last = build(described).steps()
        return -last.bodies[0].contact_force[0]

    exact = 2e4 * (adhesion or 0.0)
    assert drawn() == pytest.approx(exact, rel=0.02, abs=10.0)
    monkeypatch.setattr(interface, "on_faces", lambda position, *_: np.ones(len(position), bool))
    monkeypatch.setattr(contact_points, "on_faces", interface.on_faces)
    assert drawn() > exact + 5e3


def test_a_block_that_slides_over_clay_has_friction_where_it_touches_anew(monkeypatch):
    """Drawn by a line at 18° with μ = 0.3 and more adhesion than friction: T (cos 18° + μ sin 18°) = μ W in every step.
    Where points that close in a step have no shear before adhesion is shared with them, single steps have less."""
    block = Body(GEOMETRY / "box.geo", 3000.0, parameters={"length": 1.0, "width": 1.0, "height": 0.5, "size": 20.0},
                 position=(0.05, 0.5, 0.0), rest_on=0.0, friction=0.3,
                 pull=Pull(point=(0.5, 0.0, 0.0), velocity=(0.01, 0.0, 0.00325), stiffness=2e5, length=10.0))
    described = Scene(
        name="drawn", grid=Grid(Axis(-2.0, 2.0, 0.25), Axis(0.0, 1.0, collapsed=True), Axis(-2.0, 0.5, 0.25),
                                Faces(z_min="fixed")),
        soil=Soil(Material(law="von-mises", young=1e7, poisson=0.49, density=1700.0, strength=2e4), top=0.0),
        bodies=(block,), time=Time(1.0, inertia=False), stages=(Stage("settle", 2, pull=False), Stage("draw", 10)))
    exact = 0.3 * 1500.0 * 9.81 / (np.cos(np.arctan(0.325)) + 0.3 * np.sin(np.arctan(0.325)))

    def largest_error():
        tensions = [record.bodies[0].line_tension for record in build(described).steps()]
        return np.abs(np.array(tensions[4:]) / exact - 1.0).max()

    assert largest_error() < 0.015
    monkeypatch.setattr(contact, "interface_of", lambda *of: replace(interface_of(*of), frictional=False))
    assert largest_error() > 0.02


def test_keys_are_accepted(geometry):
    for values in ({"adhesion": 0.5}, {"adhesion": 1.0, "friction": 0.3, "tension": "full"}, {"tension": 5e3}):
        body, = validate(scene_with(geometry, **values)).bodies
        assert {name: getattr(body, name) for name in values} == values


@pytest.mark.parametrize("values, soil, text", [
    ({"adhesion": 1.2}, {}, "body.0.adhesion = 1.2: must be from 0 to 1"),
    ({"adhesion": 0.5}, {"law": "hencky"}, "body.0.adhesion = 0.5: must be left out with law = 'hencky', which has no s_u"),
    ({"tension": 0.0}, {}, "body.0.tension = 0: must be positive, in Pa"),
    ({"tension": "half"}, {}, "body.0.tension = 'half': unknown; valid: full"),
    ({"tension": "full"}, {"held": True}, "body.0.tension = full: must be left out on held soil"),
])
def test_faults_are_refused(geometry, values, soil, text):
    with pytest.raises(SceneError) as error:
        validate(scene_with(geometry, **soil, **values))
    assert text in str(error.value)


def test_adhesion_alone_needs_no_friction_and_no_adhesion_is_smooth():
    for values, mu, adhesion in (({}, 0.0, None), ({"friction": 0.3}, 0.3, None), ({"adhesion": 0.5}, np.inf, 0.5),
                                 ({"adhesion": 0.5, "friction": 0.3}, 0.3, 0.5), ({"adhesion": 0.0}, 0.0, None),
                                 ({"adhesion": 0.0, "friction": 0.3}, 0.0, None)):
        described = Body("box.geo", 1.0, **values)
        made = interface_of(described)
        assert friction_of(described) == mu and (made and made.adhesion) == adhesion
    assert interface_of(replace(Body("box.geo", 1.0), tension="full")).tension == np.inf
    made = interface_of(Body("box.geo", 1.0, adhesion=0.0, friction=0.3), True)
    assert made.adhesion == 0.0 and friction_of(Body("box.geo", 1.0, adhesion=0.0, friction=0.3), True) == 0.3


@pytest.mark.parametrize("friction, elsewhere", [(0.3, np.inf), (None, 0.0)])
def test_soil_that_is_no_clay_has_friction_alone(friction, elsewhere):
    """Of points of clay, sand and rock; one in sand bears no clay's adhesion, and without friction there is no shear."""
    young = np.full(1, 1e7)
    law = merge([VonMises(young, 0.3, 2e4, "plane strain"), DruckerPrager(young, 0.3, 30.0, 0.0, 0.0, "plane strain"),
                 Hencky(young, 0.3)], [np.array([0]), np.array([1]), np.array([2])])
    assert law.undrained.tolist() == [True, False, False]
    assert not MohrCoulomb(young, 0.3, 1.0, 0.0, 1e4).undrained.any()
    made = interface_of(Body("box.geo", 1.0, adhesion=0.5, friction=friction), True)
    limits = made.of_points(law, np.zeros(3))
    assert limits.shear == pytest.approx([1e4, elsewhere, elsewhere])
    spread = interface._sheared(lambda values: np.full(3, values.sum()), limits.shear, np.array([2.0, 3.0, 4.0]))
    assert spread == pytest.approx([2e4, elsewhere or 2e4, elsewhere or 2e4])
    with np.errstate(invalid="raise"):      # no area, and no limit
        alone = interface._sheared(lambda values: values, limits.shear, np.zeros(3))
    assert alone == pytest.approx([0.0, elsewhere, elsewhere])


def on_rock(top, **given):
    """RigidBody on clay over a layer of rock that ends at `top`, all of the soil if None."""
    axis = Axis(0.0, 1.0, 0.5)
    rock = Layer("rock", top, law="hencky", material={"young": 1e9, "poisson": 0.3})
    clay = Material(law="von-mises", young=1e7, poisson=0.49, density=1800.0, strength=1e4)
    block = Body(GEOMETRY / "box.geo", 2000.0, rest_on=0.0, position=(0.5, 0.5, 0.0), **given,
                 parameters={"length": 0.5, "width": 0.5, "height": 0.5, "size": 5.0})
    body, = build(Scene(name="rock", grid=Grid(axis, axis, Axis(-1.0, 1.0, 0.5)), soil=Soil(clay, top=0.0, layers=(rock,)),
                        bodies=(block,), time=Time(0.01), stages=(Stage("rest", 1),))).model.bodies
    return body


@pytest.mark.parametrize("given", [{"friction": 0.5}, {"adhesion": 0.5}, {"adhesion": 0.5, "friction": 0.5}])
def test_clay_that_no_point_has_gives_no_adhesion(given):
    """soil.material is clay, and a layer of rock all of the soil."""
    body = on_rock(None, **given)
    assert body.interface is None and body.friction == given.get("friction", 0.0)


@pytest.mark.parametrize("given, adhesion, friction, elsewhere", [
    ({"friction": 0.5}, 1.0, 0.5, np.inf), ({"adhesion": 0.5}, 0.5, np.inf, 0.0),
    ({"adhesion": 0.0, "friction": 0.5}, 0.0, 0.5, np.inf)])
def test_a_body_on_clay_with_rock_below(given, adhesion, friction, elsewhere):
    body = on_rock(-0.5, **given)
    assert (body.interface.adhesion, body.friction, body.interface.elsewhere) == (adhesion, friction, elsewhere)
