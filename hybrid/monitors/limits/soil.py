"""Limits of the soil's points, cells and laws."""

import numpy as np

from hybrid.body.rigid import FREEDOMS
from hybrid.laws.cone import CORNER, ETA, RATIO, RESIDUAL, SLOPE, STRENGTH, UNLIMITED, plane_strain_strength
from hybrid.laws.hencky import BULK, SHEAR
from hybrid.monitors.limits.start import initial_pose, initial_vertices
from hybrid.runtime.comm import anywhere, gathered, maximum, minimum
from hybrid.scene.body import out_of_plane
from hybrid.scene.defaults import POISSON
from hybrid.scene.soil import as_clay, materials
from hybrid.soil.points import extent

SHALLOW = 0.25      # of the height of the soil that is left where the ground is lowest
ALMOST = 1e-6       # [m] from the end of the grid, which is reached
LONG = 2.0          # cells: shorter stretches of the ground are steps
LOOSE = 0.02        # of the weight of sand as high as the ground is uneven: a cohesion below it hardly holds a slope


def cell_crossing(scene, model):
    """Standard shape functions: the force jumps when a point crosses a face of its cell."""
    if scene.soil.basis == "mpm" and not model.soil.held:
        yield ('soil.basis = "mpm": stresses are wrong by 100 % once points cross cells; limit: displacements of less '
               'than a cell. Set soil.basis = "gimp"')


def slab(scene, model):
    """Plane strain modelled in space: cells between rollers, along which nothing varies."""
    grid = model.soil.grid
    if model.soil.held or grid.collapsed.any():
        return
    for axis, name in enumerate("xy"):
        rollers = {scene.grid.faces.of(axis, side) for side in (0, 1)} == {"roller"}
        cells = len(grid.lines[axis]) - 1
        if rollers and (cells == 1 or _same_along(scene, model, axis)):
            which, fewer = ("one cell between rollers", "") if cells == 1 else (
                f"{cells} cells between rollers, along which nothing varies", " and one row of cells")
            yield (f"grid.{name} is {which}: that is plane strain. Set grid.{name}.collapsed = true: it takes two unknowns "
                   f"a node instead of three{fewer}, and the laws and notes of plane strain apply")
            return


def _same_along(scene, model, axis):
    """Whether soil and bodies are the same all along an axis, and nothing moves or loads them along it."""
    soil, surface = model.soil, model.soil.heights and model.soil.heights[0]
    ends, (low, high) = soil.grid.extent[axis], extent(soil.constants, axis)
    fills = low < ends[0] + ALMOST and high > ends[1] - ALMOST
    level = surface is None or surface[1] is None and axis == 1     # a profile is along x
    if not (fills and level and scene.gravity[axis] == 0.0 and model.loads.body_force is None):
        return False
    loaded = scene.joints or any(stage.loads for stage in scene.stages) or any(body.pull for body in scene.bodies)
    return all(_prism_along(described, body, axis, ends, loaded) for described, body in zip(scene.bodies, model.bodies))


def _prism_along(described, body, axis, ends, loaded):
    """Whether a body is a prism from one end of the grid [m] to the other, and stays one."""
    _, rotation = initial_pose(described, body)
    along = initial_vertices(described, body, body.outline)[:, axis]
    out = np.isin(FREEDOMS, out_of_plane("xyz"[axis]))
    still = not np.concatenate([described.velocity, described.spin])[out].any() and not body.drive[out].any()
    long = along.min() < ends[0] + ALMOST and along.max() > ends[1] - ALMOST
    return still and long and (not loaded or body.guided[out].all()) and body.outline.is_prism(rotation[axis])


def turned_gravity(scene, model):
    """Soil that yields under gravity along x or y: what few cells do to footings and walls is known with z upwards."""
    along = np.abs(scene.gravity)
    if not model.soil.held and model.soil.law.plastic and along[:2].max() > along[2]:
        yield (f"gravity acts along {'xy'[along[:2].argmax()]}: notes on few cells at footings, plates, walls and slopes "
               "are given for scenes whose z points up, and are missing here. Turn the scene, gravity = [0, 0, -9.81]")


def domain_update(scene, model):
    """Domains of points that do not follow the soil when it is stretched."""
    if scene.soil.domain == "none" and scene.soil.basis == "gimp" and not model.soil.held:
        yield ('soil.domain = "none": domains overlap where soil is compressed and separate where it is extended: stresses '
               'are wrong by 4 % at a stretch of 1.5, and there is no equilibrium at 2.5. Set soil.domain = "moments"')


def volumetric_locking(scene, model):
    """Nearly incompressible soil without F-bar is too stiff in bending."""
    nu = _poisson(model.soil.law)
    if nu >= POISSON - 1e-9 and not (model.soil.fbar or model.soil.held):
        yield (f"soil.material.poisson = {nu:g}: nearly incompressible soil locks without F-bar, limit {POISSON:g}: a "
               "beam of 4 cells through its height deflects 6 % too little at 0.4, 12 % at 0.45, 39 % at 0.49, 86 % at "
               '0.4999. Leave out soil.fbar = false and method = "published"')


def plastic_locking(scene, model):
    """Plastic strain at nearly constant volume locks without F-bar, as nearly incompressible soil does."""
    law = model.soil.law
    if model.soil.held or model.soil.fbar or not law.plastic or law.parameters is None:
        return
    if anywhere(law.parameters[:, STRENGTH] < UNLIMITED):
        names = sorted({f'"{m.law}"' for m in materials(scene.soil) if m.law != "hencky"})
        yield (f"soil.material.law = {', '.join(names)}: plastic strain at nearly constant volume locks without F-bar, "
               "so that collapse loads are too high: of a footing on clay by 14 to 33 % with 8 cells in half its "
               "width, by 39 to 85 % with 2, limit 5 %; a drag anchor stays 0.3 m too high with cells of 0.3 m. Leave out "
               'soil.fbar = false and method = "published"')


def softening(scene, model):
    """Softening localises in one row of cells."""
    law = model.soil.law
    if model.soil.held or not law.hardens or minimum(law.parameters[:, SLOPE]) >= 0.0:
        return
    slopes = law.parameters[:, SLOPE]
    softest = law.parameters[slopes == minimum(slopes)][:1]     # of this process, if it has it
    strength, slope, residual = gathered(softest[:, [STRENGTH, SLOPE, RESIDUAL]])[0]
    cell = model.soil.grid.smallest_cell
    slip = np.sqrt(3.0) * (strength - residual) / -slope * cell     # √3 times the plastic strain in simple shear
    modulus = min(m.hardening or 0.0 for m in materials(scene.soil))
    yield (f"soil.material.hardening = {modulus:g} Pa: softening (limit 0) localises in bands one cell wide: the "
           f"strength is lost after a slip of {slip:.2g} m in cells of {cell:g} m, "
           "and after half of that in cells half as large. Choose hardening for this size of cells, and change it in "
           f"proportion to that size{_along_bodies(scene, model, residual / strength)}")


def _along_bodies(scene, model, residual):
    """What softening of clay does not reach: strength along bodies that rub, of which a share is `residual` in the end."""
    names = [body.name for body in model.bodies if body.friction or body.interface and body.interface.adhesion]
    clay = any((m.hardening or 0.0) < 0.0 and as_clay(m).law == "von-mises" for m in materials(scene.soil))
    if not names or not clay:
        return ""
    return (f". Where clay slips along {', '.join(names)} and does not yield beside it, it keeps the strength that it has "
            f"at the start: for a long slip give body.adhesion times {residual:.2g}, the residual share")


def strong_cone(scene, model):
    """A cone through the compression corners of Mohr-Coulomb's pyramid, or of Tresca's prism, where soil is sheared in a
    plane, as all of it is in plane strain; and there Willam and Warnke's arc through these, which sand of a relative density
    has because its angle is that of triaxial compression."""
    law, collapsed = model.soil.law, model.soil.grid.collapsed.sum()
    if model.soil.held or collapsed > 1 or not law.plastic or law.parameters is None:
        return
    found = [m for m in materials(scene.soil) if m.cone == "compression"]
    if any(m.law == "drucker-prager" and m.friction_angle != 0.0 for m in found):
        angle, *_ = _sheared_in_a_plane(law, law.opens)
        name, where = (("cone", "in plane strain") if collapsed else
                       ("law", "where it is sheared in a plane, as before a blade, under a strip or between rollers"))
        given = 'soil.material.cone = "compression"' if collapsed else 'soil.material.law = "drucker-prager", in space'
        yield (f"{given}: this cone has a friction angle of {angle:.3g} degrees {where}, far more than the "
               f"one given, its limit. Leave soil.material.{name} out")
    if not collapsed:
        return
    arcs = [m for m in materials(scene.soil) if m.law == "willam-warnke" and m.relative_density is None]
    if arcs:
        arc = (law.parameters[:, RATIO] < 1.0) | (law.parameters[:, [ETA, CORNER]] == 0.0).all(axis=1)
        angle, cohesion, _ = _sheared_in_a_plane(law, arc)
        yield (f'soil.material.law = "willam-warnke": this law has a friction angle of {angle:.3g} degrees in plane '
               f"strain, the {max(m.friction_angle for m in arcs):.3g} given in triaxial compression, and {cohesion:.3g} of "
               "the cohesion. Leave soil.material.law out if the values given are those of plane strain")
    if any(m.law == "von-mises" for m in found):
        yield ('soil.material.cone = "compression": in plane strain this cone carries 2/√3 = 1.15 of the strength given, '
               'limit 1. Leave soil.material.cone out')


def _sheared_in_a_plane(law, which):
    """Largest friction angle [degrees], cohesion over that given, and dilation angle [degrees], in plane strain, of the
    points `which` (n,) bool."""
    found = np.array([plane_strain_strength(row) for row in np.unique(law.parameters[which], axis=0)]).reshape(-1, 3)
    return tuple(maximum(values) for values in found.T)


def steep_slopes(scene, model):
    """Ground steeper than the angle at which sand without cohesion slides along a plane, which is less than its friction
    angle where it dilates less (Davis 1968)."""
    soil, law, surface = model.soil, model.soil.law, model.soil.heights and model.soil.heights[0]
    if soil.held or surface is None or surface[1] is not None or not law.plastic or law.parameters is None:
        return
    x, _, z = surface
    long = np.diff(x) > LONG * soil.grid.smallest_cell
    slope = np.degrees(np.arctan(np.abs(np.diff(z)[long] / np.diff(x)[long]).max(initial=0.0)))
    stress = maximum(soil.constants.mass / soil.constants.volume) * -scene.gravity[2] * np.ptp(z)
    loose = law.opens & (law.parameters[:, STRENGTH] < LOOSE * stress)
    if not anywhere(loose):
        return
    friction, _, dilation = _sheared_in_a_plane(law, loose)
    sine, of_flow = np.sin(np.radians([friction, dilation]))
    bears = np.degrees(np.arctan(sine * np.sqrt(1.0 - of_flow**2) / (1.0 - sine * of_flow)))
    if slope > bears:
        yield (f"soil.ground falls by {slope:.3g} degrees. Sand with a friction angle of {friction:.3g} and a dilation "
               f"angle of {dilation:.3g} degrees slides along a plane from {bears:.3g} degrees on, tan = sin φ cos ψ / (1 - "
               "sin φ sin ψ), limit that: a steeper slope creeps, faster and faster. Flatten soil.ground, or give the sand "
               "a cohesion, or a dilation_angle nearer to its friction angle")


def smooth_base(scene, model):
    """Soil that no body holds back and that can spread on the roller at the lower end of the grid, which has no friction."""
    soil, cell = model.soil, model.soil.grid.smallest_cell
    faces, (bottom, top) = scene.grid.faces, extent(soil.constants, 2)
    if soil.held or not soil.law.plastic or soil.grid.collapsed[2] or scene.gravity[2] >= 0.0 or scene.bodies:
        return
    if faces.z_min != "roller" or bottom > soil.grid.extent[2, 0] + ALMOST:
        return
    ends = [np.abs(np.subtract(extent(soil.constants, axis), soil.grid.extent[axis])).max() for axis in (0, 1)]
    lowest = top if soil.heights is None else min(soil.heights[0][2].min(), top)
    if max(ends) > 0.5 * cell or lowest - bottom < SHALLOW * (top - bottom):
        yield (f"the soil can spread on the lower end of the grid, z = {bottom:.3g} m, a roller (grid.faces.z_min), which "
               "is a base without friction: a column of sand let go there gave up 1.7 times the energy, one of "
               'clay 1.5. Set grid.faces = { z_min = "fixed" }, unless the base is as smooth as ice')


def _poisson(law):
    """Largest Poisson's ratio of a law's points; 0 of a user's law, whose value is unknown."""
    if law.parameters is None:
        return 0.0
    bulk, shear = law.parameters[:, BULK], law.parameters[:, SHEAR]
    return maximum((3 * bulk - 2 * shear) / (6 * bulk + 2 * shear))


LIMITS = (cell_crossing, slab, turned_gravity, domain_update, volumetric_locking, plastic_locking, softening, strong_cone,
          steep_slopes, smooth_base)
