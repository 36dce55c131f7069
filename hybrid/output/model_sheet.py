"""The model sheet: what a scene models, what it does not model, and how large it is."""

import numpy as np

from hybrid.body.rigid import FREEDOMS, reduced_mass
from hybrid.body.symmetry import copies, part_of_whole
from hybrid.laws.sand import material_values
from hybrid.linalg.solver_choice import SolverChoice
from hybrid.runtime.comm import anywhere, largest, number
from hybrid.runtime.memory import direct_factor_memory
from hybrid.runtime.sandbox import shortcoming
from hybrid.scene.soil import USES, laws, of_layer, span
from hybrid.scene.table import shown
from hybrid.soil.size import LIBRARIES, PICTURES, growing_memory, sizes

PAIRS = 12      # of bodies in contact that the sheet lists


def model_sheet(scene, model, imbalance, level, most_points, decisions):
    """Sections {title: {label: value}} for `hybrid check` and summary.json.

    imbalance: InitialImbalance, None where the soil carries no weight; level: text about the scene's `accuracy`;
    most_points: largest number of points at a time, of a grid that follows a body; decisions: what was decided of keys
    that the scene left out.
    """
    soil = model.soil
    block, points = sizes(soil), number(soil.constants)
    nodes = int(np.prod([len(line) for line in soil.grid.lines]))
    growth = max(1.0, most_points / max(1, points))
    memory = (LIBRARIES + PICTURES * bool(scene.output.pictures)
              + growth * growing_memory(soil, points, block.entries, block.unknowns, model.solver))
    modelled = {
        **({"accuracy": level} if level else {}),
        "grid cells": " x ".join(map(str, soil.grid.cell_counts)),
        **_moving_grid(scene),
        "smallest cell [m]": float(f"{soil.grid.smallest_cell:.9g}"),    # as given, without round-off
        "material points": points,
        **({"most material points": f"{most_points}, once the body has sunk"} if growth > 1 else {}),
        "soil unknowns": block.unknowns,
        "body unknowns": model.body_unknowns,
        "entries of the soil block": block.entries,
        **({} if soil.held else {"inactive nodes": f"{nodes - block.nodes} of {nodes} (no soil, or fixed)"}),
        "bodies": [_body(*pair, soil) for pair in zip(scene.bodies, model.bodies)] or "none",
        **_parts(model.bodies),
        **({"joints": [_joint(joint) for joint in scene.joints]} if scene.joints else {}),
        **({"bodies in contact": _pairs(scene, model)} if len(scene.bodies) > 1 else {}),
        **({"gmsh": shortcoming()} if scene.bodies and shortcoming() else {}),
        **_symmetry(model),
        "soil law": _law(scene.soil.material, soil.law) if not soil.held else "none, the soil is held",
        "basis": scene.soil.basis if not soil.held else "none, the soil is held",
        "linear solver": _linear_solver(model, block.unknowns),
        "soil tangent": _tangent(scene.soil, soil.law) if not soil.held else "none, the soil is held",
        "steps": " + ".join(f"{s.steps} ({s.name})" for s in scene.stages),
        **_of_stages(scene),
        "time integration": _schemes(scene, model.scheme),
        "increments": _increments(scene, soil.grid.smallest_cell),
        "memory, estimated [MiB]": round(memory / 2**20),
        **({"decided": [str(decision) for decision in decisions]} if decisions else {}),
    }
    if imbalance is not None:
        modelled["initial imbalance"] = str(imbalance)
    if scene.soil.layers:
        modelled["soil layers"] = [_layer(layer, scene, soil) for layer in scene.soil.layers]
    return {"modelled": modelled, "not modelled": not_modelled(scene, model)}


def _moving_grid(scene):
    """Row about a grid that follows a body, if it does."""
    axes = [name for name in "xyz" if getattr(scene.grid, name).moves]
    followed = scene.grid.follow or scene.bodies[0].name if axes else ""
    return {"grid follows": f"{followed}, along {', '.join(axes)}"} if axes else {}


def _linear_solver(model, unknowns):
    """How the linear systems are solved, and the memory of a direct factor of so many soil unknowns."""
    if not unknowns:
        return "direct, for the bodies alone"
    plane = bool(model.soil.grid.collapsed.any())
    factor = direct_factor_memory(unknowns, plane)
    direct = f"a direct factor of about {max(1, round(factor / 2**20))} MiB"
    if model.solver.linear == "direct":
        return direct
    refusal = SolverChoice("auto", plane).refusal(unknowns)
    return f"GMRES alone: {refusal}" if refusal else f"GMRES, or {direct} where that costs less"


def _tangent(described, law):
    """Whether the soil block of the tangent is symmetric."""
    if "user" in laws(described):
        return "symmetric if that of the user's law is"
    return "unsymmetric" if anywhere([not law.symmetric]) else "symmetric"


def _increments(scene, cell):
    """How the length of increments is chosen."""
    time = scene.time
    if time.accuracy is None:
        return "one a step, halved where Newton's method fails"
    return (f"as long as time.accuracy = {time.accuracy:g} allows, an error of positions of {time.accuracy * cell:.3g} "
            "m a step")


def _law(material, law):
    """Law, the cone that it is matched to, and what changes its strength."""
    m, floor = material, material.residual_cohesion
    parts = [m.law if m.law != "user" else f"user, {law.name}"]
    if m.relative_density is not None:
        parts.append(_of_density(m))
    if "cone" in USES[m.law]:
        parts.append(f"cone matched in {m.cone}")
    if m.strength_gradient:
        parts.append(f"strength {m.strength:g} Pa and {m.strength_gradient:g} Pa/m of depth")
    if m.hardening:
        floor = m.residual_strength if floor is None else floor
        parts.append(f"hardening by {m.hardening:g} Pa" if m.hardening > 0 else
                     f"softening by {-m.hardening:g} Pa down to {floor:g} Pa")
    return ", ".join(parts)


def _of_density(material):
    """Values of a relative density, with those given instead."""
    m = material_values(material)
    young = f"E = {m['young']:.3g} Pa" if "young" in m else (
        f"E = {m['reference_young']:.3g} Pa at 100 kPa, power {m['stiffness_exponent']:.2g} of the stress")
    return (f"relative density {material.relative_density:g} %: φ = {m['friction_angle']:.3g}°, "
            f"ψ = {m['dilation_angle']:.3g}°, c = {m['cohesion']:g} Pa, {m['density']:.4g} kg/m³, ν = {m['poisson']:g}, "
            f"{young}")


def _layer(layer, scene, soil):
    """Range, law and values of a layer."""
    bottom, top = span(layer, scene.soil, scene.grid)
    values = layer.material if layer.k0 is None else {**layer.material, "k0": layer.k0}
    own = [f"{name} = {shown(value)}" for name, value in values.items()]
    parts = [f"{layer.name}: z = {bottom:g} to {top:g} m", _law(of_layer(scene.soil.material, layer), soil.law), *own]
    return ", ".join(parts)


def _body(described, body, soil):
    """Sizes of a body, its driven components and its contact with the soil."""
    whole = f", the whole {copies(body.mirrors) * body.mass.mass:.6g} kg" if body.mirrors else ""
    parts = [f"{len(body.surface.triangles)} contact triangles", f"{body.mass.mass:.6g} kg{whole}",
             f"{np.count_nonzero(body.free)} free components"]
    if described.driven:
        parts.append("driven " + " ".join(described.driven))
    if body.ground is not None:
        parts.append(f"contact at places {body.ground.spacing:.2g} m apart on its faces, and on its edges and corners"
                     f"{', where it lies on more than curved faces' * (body.ground.surface_points is not None)}")
    else:
        parts.append(f"contact at {len(body.places)} {described.contact} of each domain")
    penalty = body.penalty / largest(soil.law.young) if soil.held else body.penalty
    parts.append(f"penalty {penalty:.3g} /m")
    if described.adhesion:
        parts.append(f"shear at most {described.adhesion:g} s_u" + (
            "" if described.friction is None else f" and {described.friction:g} of the pressure"))
    if described.tension is not None:
        parts.append("never breaks away" if described.tension == "full" else f"breaks away at {described.tension:g} Pa")
    return f"{body.name}: {', '.join(parts)}"


def _parts(bodies):
    """Row about the parts of surfaces whose forces the history has apart; empty where geometries name none."""
    texts = [f"{body.name}: " + ", ".join(
        f"{name} {copies([mirror for mirror in body.mirrors if mirror.cut]) * area:.4g} m²"
        for name, area in zip(body.parts.names, body.parts.area)) + (", of the whole" if body.mirrors else "")
        for body in bodies if body.parts]
    return {"parts of surfaces, forces on each in the history": texts} if texts else {}


def _joint(joint):
    """Kind of a joint and what it joins."""
    limits = f", from {joint.limits[0]:g} to {joint.limits[1]:g} degrees" if joint.limits else ""
    friction = f", friction of {joint.friction_moment:g} N m" if joint.friction_moment else ""
    other = joint.bodies[1] if len(joint.bodies) == 2 else "the ground"
    return f"{joint.name}: {joint.kind} of {joint.bodies[0]} and {other}{limits}{friction}"


def _pairs(scene, model):
    """Friction and stiffness of the contact of bodies with one another, and which pairs have none."""
    names, rows = [body.name for body in scene.bodies], []
    for pair in model.pairs[:PAIRS]:
        one, other = (names[b] for b in pair.numbers)
        rows.append(f"{one} and {other}: friction {pair.law.mu:g}, an overlap of up to {pair.overlap:.3g} m under "
                    f"{pair.load:.4g} N{_contact_time(model, pair)}")
    rows += [f"and {len(model.pairs) - PAIRS} more"] if len(model.pairs) > PAIRS else []
    joined = sorted({" and ".join(joint.bodies) for joint in scene.joints if len(joint.bodies) == 2})
    return rows + ([f"none between {', '.join(joined)}: joined"] if joined else [])


def _contact_time(model, pair):
    """How long two bodies touch when they hit one another, which sets the increments; nothing about bodies that do not move
    by themselves."""
    mass = reduced_mass([model.bodies[b] for b in pair.numbers])
    if np.isinf(mass) or not model.scheme.inertia:
        return ""
    slow, impact = pair.contact_times(mass)
    return (f"; a slow contact takes {slow:.2g} s and an impact at v m/s {impact:.2g}/v s if that is less, "
            "increments in it a twentieth of that")


def _symmetry(model):
    """Row about the planes of symmetry that bodies lie in, if there are any."""
    mirrors = model.mirrors
    if not mirrors:
        return {}
    return {"symmetry": [part_of_whole(mirrors),
                         f"forces, masses and energies are those of this part; those of the whole, {copies(mirrors)} "
                         "times as large, are named so"]}


def _of_motion(motion):
    """Text of a motion: its body, its point, and which components are free, held and driven."""
    driven = (motion.component,) * (motion.component is not None)
    words = (("free", motion.free), ("held", motion.held), ("driven", driven))
    return " ".join(filter(None, (motion.body, _point(motion.point), *(
        f"{word} {' '.join(names)}" for word, names in words if names))))


def _of_stages(scene):
    """{label: motions and loads of bodies in the stages}, empty where they have none."""
    texts = []
    for stage in scene.stages:
        parts = [_of_motion(motion) for motion in stage.motions]
        parts += [" ".join(filter(None, (load.body, "loaded by a", " and a ".join(
            name for name in ("force", "moment") if getattr(load, name) is not None)))) for load in stage.loads]
        texts += [f"{stage.name}: {', '.join(parts)}"] if parts else []
    return {"motions and loads": texts} if texts else {}


def _point(point):
    """Text of a point whose motion is given, None of the centre of mass."""
    return point and f"at {point if isinstance(point, str) else ', '.join(f'{x:g}' for x in point)}"


def _schemes(scene, scheme):
    """The scheme of the scene, and of the stages that have their own."""
    own = [(stage.name, str(scheme.with_pair(stage.beta, stage.gamma))) for stage in scene.stages]
    return "; ".join([str(scheme), *(f"{name}: {other}" for name, other in own if other != str(scheme))])


def not_modelled(scene, model):
    """List of texts about what this scene leaves out, and the key that sets it where there is one."""
    soil, out = model.soil, []
    if soil.held:
        out.append("soil unknowns, stresses and transfers: the soil is held")
    else:
        out.append(f"soil outside the grid: its faces are {_faces(scene.grid.faces, soil.grid.collapsed)}")
        out += _outside_the_window(scene.grid, soil)
    if not model.scheme.inertia:
        out.append("inertia: the scene is quasi-static")
    for axis, collapsed in zip("xyz", soil.grid.collapsed):
        if collapsed:
            out.append(f"motion along {axis}: the axis is collapsed")
    for described, body in zip(scene.bodies, model.bodies):
        out += _not_modelled_of(described, body)
    if not soil.held:
        if not soil.law.plastic:
            out.append("plasticity: the law is elastic")
        elif soil.law.parameters is not None and not soil.law.hardens:
            out.append("hardening: the strength is constant")
        if not scene.soil.fbar:
            out.append("F-bar: soil.fbar = false")
        if not scene.soil.ghost:
            out.append("ghost penalty: soil.ghost = 0")
    return out


def _outside_the_window(grid, soil):
    """Texts about the cells and the soil that a grid that follows a body does without."""
    axes = {name: axis for name, axis in zip("xyz", grid.axes) if axis.moves}
    windows = [name for name, axis in axes.items() if axis.window]
    whole = 1
    for name, nodes in zip("xyz", soil.grid.lines):
        axis = axes.get(name)
        whole *= round((axis.end - axis.start) / axis.size) if axis else max(1, len(nodes) - 1)
    if axes:
        cells = np.prod(soil.grid.cell_counts)
        yield f"{whole - cells} of {whole} cells of the smallest size: away from the body they are coarser, or absent"
    if windows:
        yield (f"soil outside the window along {', '.join(windows)}: it enters the window at rest and is "
               + ("frozen" if grid.behind == "freeze" else "removed") + " when it leaves it")


def _faces(faces, collapsed):
    """Condition of each face of the grid."""
    axes = [name for name, away in zip("xyz", collapsed) if not away]
    kinds = {}
    for name in (f"{axis}_{end}" for axis in axes for end in ("min", "max")):
        kinds.setdefault(getattr(faces, name), []).append(name)
    return ", ".join(f"{kind} at {' '.join(names)}" for kind, names in kinds.items())


def _not_modelled_of(described, body):
    """Texts about what the contact of a body does without, and its held components."""
    if body.friction == 0.0:
        yield f"friction of {body.name}: body.{'adhesion' if described.adhesion == 0.0 else 'friction'} = 0"
    held = [name for name, free in zip(FREEDOMS, body.free) if not free and name not in described.driven]
    if held:
        yield f"motion of {body.name} in {', '.join(held)}: held"
