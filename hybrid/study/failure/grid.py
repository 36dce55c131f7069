"""Failure modes of the grid and of the points' domains: what a point's neighbours are, and where the grid ends."""

import functools

import numpy as np

from hybrid.laws import Response
from hybrid.laws.hencky import Hencky
from hybrid.scene import Axis, Faces, Grid, Material, Scene, Soil, Solver, Stage, Time
from hybrid.setup.build import build
from hybrid.study.failure.mode import Mode
from hybrid.study.failure.outcome import Observation
from hybrid.study.failure.simulate import messages, simulate
from hybrid.study.scenes import NO_OUTPUT, collapsed, driven, loaded_by_weight

DENSITY, GRAVITY = 1000.0, 10.0     # [kg/m³], [m/s²]
LENGTH, CELLS = 8.0, 32             # of the column [m]


def crossing(ratio, **soil):
    """Cell crossing: with standard shape functions the force of a point jumps to other nodes as it crosses a cell face.

    A column of 32 cells, ν = 0, is loaded by its own weight. It is softer from setting to setting; at ρgL/E = 1 its top
    sinks through about 16 cells. With GIMP the force passes gradually from one cell to the next. Exact: σ_zz = -ρ g (L
    - Z).
    """
    simulation = build(_column(ratio, **soil))
    records = list(simulation.steps())
    return Observation(_column_error(simulation), messages(simulation, records))


def _column(ratio, **soil):
    """Scene of a column with ρgL/E = ratio, loaded by its weight in 20 steps."""
    material = Material(law="hencky", young=DENSITY * GRAVITY * LENGTH / ratio, poisson=0.0, density=DENSITY)
    side = Axis(start=0.0, end=1.0, size=1.0, collapsed=True)
    grid = Grid(side, side, Axis(start=0.0, end=LENGTH, size=LENGTH / CELLS), Faces())
    return loaded_by_weight("column", grid, Soil(material, geostatic=False, **soil), 20, -GRAVITY)


def _column_error(simulation):
    """Mean error of the vertical stress over the weight of the column."""
    Z, stress = simulation.initial_position[:, 2], simulation.state.points.stress[:, 2, 2]
    return float((np.abs(stress + DENSITY * GRAVITY * (LENGTH - Z)) / (DENSITY * GRAVITY * LENGTH)).mean())


class Rubber(Hencky):
    """τ = E/2 (λ² - 1) in every principal direction."""

    def respond(self, strain, plastic_strain=None):
        young, square = self.young[:, None], np.exp(2 * strain)
        tangent = young[:, None] * square[:, None] * np.eye(3)
        return Response(0.5 * young * (square - 1), strain, tangent)

    def energy(self, elastic):
        return np.sum(self.young[:, None] / 4 * (np.exp(2 * elastic) - 1 - 2 * elastic), axis=1)


def domain_gap(stretch, points=2, **soil):
    """Gaps between domains: soil that is stretched by more than its number of points a cell separates.

        ////////    bar of 8 m, 16 cells, hung from its upper end by its weight, which grows in 20 quasi-static steps;
          |  |      stretch s at the top, 1 at the bottom; no lateral motion
          |  |
          |__|      law  τ = E/2 (λ² - 1), so P = τ/λ = E/2 (λ - 1/λ) always grows: the bar itself never tears

    Domains of n points a cell cover the bar until one is as wide as a cell, λ = n. They are cut off there, because
    wider ones would reach nodes outside the sparsity pattern. Points without domains can leave cells empty from λ = n
    on; domains of constant width leave gaps at once. Exact: Cauchy's stress is that of dead load, σ = ρ g (initial
    height above the lower end).
    """
    weight, size = DENSITY * GRAVITY * LENGTH, LENGTH / 16
    young = 2 * weight / (stretch - 1 / stretch)
    pull = weight / young * np.linspace(0.0, 1.0, 1000)
    length = LENGTH * np.mean(pull + np.sqrt(pull**2 + 1))
    soil = Soil(Material(law="user", density=DENSITY), geostatic=False, lower=(0.0, 0.0, -LENGTH),
                upper=(1.0, 1.0, 0.0), points_per_axis=(1, 1, points), **soil)
    grid = Grid(collapsed(), collapsed(), Axis(start=-size * (length // size + 3), end=0.0, size=size),
                Faces(z_min="free", z_max="fixed"))
    simulation, _, texts = simulate(loaded_by_weight("bar", grid, soil, 20, -GRAVITY),
                                    law=lambda p, stress: Rubber(np.full(len(p), young), 0.0))
    height, stress = simulation.initial_position[:, 2] + LENGTH, simulation.state.points.stress[:, 2, 2]
    return Observation(float((np.abs(stress - DENSITY * GRAVITY * height) / weight).mean()), texts)


SIDE, POSITIONS = 2.0, (0.6, 0.45, 0.9, 0.2)     # of the leaning block [m]; shares of a cell by which it is moved
STALLED = 1e-6     # tolerance that nodes without stiffness keep Newton's method from; 1e-4 hides their residual
EXACT = {0.01: 0.9092, 0.02: 0.9124, 0.05: 0.9237, 0.1: 0.9488, 0.2: 1.0389}    # mean displacement over the ratio [m]


def cuts(ratio, **soil):
    """Small cuts: a corner of the soil only just reaches into a cell, whose nodes then have hardly any stiffness.

        z |        ____________    block of 2 m, plane strain, fixed below, ν = 0.3, leaning under gravity (0.3 g, -g)
          |       /          /     that grows in 5 quasi-static steps; its edges reach a share s into the cells
          |______/__________/__ x

    A node whose functions reach only a corner of length s h carries s⁴ of the mass and stiffness of a full node, in
    plane strain: its displacement is arbitrary, and Newton's method stalls on it. The initial position does not decide,
    because the block moves on through the cells as it leans: each setting is run at four positions and the largest
    error counts. The ghost penalty couples such cells to their neighbours. Reference: the mean displacement along x on
    a grid four times as fine (64 cells, 20 steps, a weak penalty), within 0.5 % of that of 32 cells.
    """
    return Observation(max(abs(_lean(ratio, share, **soil) / EXACT[ratio] - 1) for share in POSITIONS))


def cut_ghost(share, ghost, **values):
    """Small cuts and the ghost penalty: how strong the penalty has to be, and how much it stiffens the soil.

    The leaning block of `cuts` at ρ g L / E = 0.2, over the share of a cell by which it is moved through the grid and
    the factor of the penalty. If the penalty is too weak, the run stops at some positions; if it is too strong, the
    block becomes stiff, because it is few cells thick and inner cells are coupled too. Reference: as for `cuts`.
    """
    return Observation(abs(_lean(0.2, share, ghost=ghost, **values) / EXACT[0.2] - 1))


def _lean(ratio, share, cells=8, steps=5, solver=(), **soil):
    """Mean displacement [m] along x over the ratio, of a block moved by a share of a cell; raises StepError."""
    size = SIDE / cells
    material = Material(law="hencky", young=DENSITY * GRAVITY * SIDE / ratio, poisson=0.3, density=DENSITY)
    grid = Grid(Axis(start=-size, end=size * round(4.0 / size), size=size), collapsed(),
                Axis(start=0.0, end=SIDE + size, size=size), Faces("free", "free", z_min="fixed"))
    soil = Soil(material, geostatic=False, lower=(0.0, 0.0, 0.0), upper=(SIDE, 1.0, SIDE), **soil)
    simulation = build(loaded_by_weight("block", grid, soil, steps, (0.3 * GRAVITY, 0.0, -GRAVITY),
                                        solver=Solver(**{"tolerance": STALLED, **dict(solver)})))
    position = simulation.state.points.position
    position[:, 0] += share * size
    start = position.copy()
    for _ in simulation.steps():
        pass
    return float((simulation.state.points.position - start)[:, 0].mean()) / ratio


CELL = 0.5      # [m] of the singular scenes
SCENES = {  # cells along each axis, points a cell, faces
    "one cell": ((1, 1, 1), 2, Faces()),
    "all held": ((1, 1, 1), 2, Faces(*["fixed"] * 6)),
    "on rollers": ((2, 2, 4), 2, Faces("free", "free", "free", "free", "roller")),
    "single row": ((1, 1, 4), (1, 1, 2), Faces()),
    "one point": ((1, 1, 1), 1, Faces()),
    "sparse": ((2, 2, 4), 1, Faces("free", "free", "free", "free", "fixed")),
    "unheld": ((2, 2, 2), 2, Faces(*["free"] * 6)),
}


def singular(name, linear="auto"):
    """Singular stiffness: more modes of motion than points that resist them, or soil that no face holds.

        one cell     8 points in a cell of 0.5 m            all held    its nodes are all held: no unknowns
        on rollers   a pillar, free to slide                single row  4 cells high, 1 x 1 x 2 points each
        one point    in one cell, 8 nodes                   sparse      a pillar, 1 point a cell
        unheld       a cube that no face holds, with weight

    A point at the centre of its cell resists no hourglass mode, and soil without inertia that nothing holds has no
    defined position. The stiffness is singular to round-off, so whether it can be factorised is accidental. Either the
    load is carried, or a message names what is missing; a crash or meaningless numbers are failures. ν = 0 and own
    weight, 2 quasi-static steps. Exact: the mean of σ_zz is -ρ g L/2 by equilibrium alone if nodes are free; 0 if all
    are held.
    """
    cells, points, faces = SCENES[name]
    axes = [Axis(start=0.0, end=n * CELL, size=CELL) for n in (*cells[:2], cells[2] + 1)]
    height, material = cells[2] * CELL, Material(law="hencky", young=1e6, poisson=0.0, density=DENSITY)
    soil = Soil(material, geostatic=False, top=height, points_per_axis=points)
    simulation, _, texts = simulate(loaded_by_weight(
        "singular", Grid(*axes, faces), soil, 2, -GRAVITY, solver=Solver(linear=linear)))
    stress = simulation.state.points.stress[:, 2, 2].mean() / (DENSITY * GRAVITY * height / 2)
    slip = abs((simulation.state.points.position - simulation.initial_position)[:, :2]).max() / height
    return Observation(float(max(abs(stress + (name != "all held")), slip)), texts)


GRIDS = {"short": {"end": 3.2}, "window": {"end": 6.4, "window": (1.0, 1.0)}, "long": {"end": 6.4}}


def grid_end(way, grid):
    """The end of the grid: there is no soil beyond it, so a body dragged over it meets no resistance.

    A box 0.8 m wide slides over elastic soil in plane strain and is pressed 20 mm into it on its way, quasi-statically.
    Its front starts 1.2 m from the end of a grid; the lift is compared with that on a grid of 6.4 m after the same way.

    A grid that moves with the body (`grid.x.window`) takes in the soil ahead at rest and stores the soil left behind.
    """
    lift, texts = _slide(way, grid)
    return Observation(abs(lift / _slide(way, "long")[0] - 1), texts)


@functools.cache
def _slide(way, grid):
    """(Lift [N], messages) of the box; way: over its initial distance from the end of the short grid."""
    step, depth = 0.12, 0.02      # [s], [m]
    steps = max(2, round(way * 1.2 / step))
    box = driven(0.8, 0.8, 0.6, velocity=(1.0, 0.0, -depth / (steps * step)), position=(1.6, 0.0, 0.3), rest_on=0.0)
    axes = Axis(0.0, size=0.2, growth=1.4, **GRIDS[grid]), Axis(-0.2, 0.2, collapsed=True), Axis(-1.6, 0.8, 0.2)
    soil = Soil(Material(law="hencky", young=2e6, poisson=0.3, density=1800.0), top=0.0)
    _, records, texts = simulate(Scene(
        name="slides", grid=Grid(*axes, Faces(z_min="fixed")), soil=soil, bodies=(box,), output=NO_OUTPUT,
        time=Time(step, inertia=False), stages=(Stage("slide", steps),)))
    return records[-1].bodies[0].contact_force[2], texts


SMALL_CUT = r"carries \S+ of the mass of a full one, limit .*soil\.ghost"
STANDARD = {"basis": "mpm", "domain": "none"}

MODES = {
    "crossing": Mode(
        title="cell crossing", parameters=("weight of a column over its modulus, ρ g L / E",),
        measure="error of the stress over the weight", right=0.01, wrong=0.05,
        methods={"standard MPM": STANDARD, "GIMP": {}}, default="GIMP",
        message=r"once points cross cells.*Set soil\.basis",
        full=(0.01, 0.03, 0.1, 0.3, 1.0, 3.0), quick=(0.03, 1.0), solve=crossing),
    "domain_gap": Mode(
        title="stretched soil", parameters=("largest stretch",),
        measure="error of the stress over the largest", right=0.01, wrong=0.05,
        methods={"standard MPM": STANDARD, "constant domains": {"domain": "none"},
                 "1 point a cell": {"points": 1}, "updated domains": {}, "3 points a cell": {"points": 3},
                 "4 points a cell": {"points": 4}}, default="updated domains",
        message=r"cells wide, limit .*soil\.points_per_axis|points_per_axis = .*limit 2|"
                r"soil\.(basis|domain) = .*Set soil\.",
        full=(1.1, 1.5, 1.8, 2.5, 3.5, 5.0), quick=(1.5, 5.0), solve=domain_gap),
    "cuts": Mode(
        title="small cuts", parameters=("weight of a leaning block over its modulus, ρ g L / E",),
        measure="error of the displacement, largest of four positions in the grid", right=0.05, wrong=0.25,
        methods={"no penalty": {"ghost": 0.0}, "ghost penalty": {}}, default="ghost penalty", message=SMALL_CUT,
        full=tuple(EXACT), quick=(0.02, 0.2), solve=cuts),
    "cut_ghost": Mode(
        title="small cuts", parameters=("share of the last cell filled", "factor of the ghost penalty, soil.ghost"),
        measure="error of the displacement", right=0.05, wrong=0.25,
        methods={"line search": {}, "whole updates": {"solver": {"line_search": False}}}, default="line search",
        message=SMALL_CUT,
        full=tuple((share, ghost) for share in (0.9, 0.7, 0.6, 0.5, 0.45, 0.4, 0.3, 0.2, 0.1, 0.03, 0.001)
                   for ghost in (0.0, 1e-4, 1e-3, 0.0033, 0.033, 0.33, 1.0)),
        quick=((0.2, 0.0), (0.9, 0.033), (0.3, 0.033)), solve=cut_ghost),
    "singular": Mode(
        title="singular scenes", parameters=("scene",),
        measure="error of the mean stress, or largest slip over the height", right=0.01, wrong=0.05,
        methods={"direct solver": {"linear": "direct"}, "automatic": {}}, default="automatic",
        message=r"points_per_axis = .*limit 2.*Set|nothing holds the soil along .*limit 1",
        full=tuple(SCENES), quick=("one cell", "unheld"), solve=singular),
    "grid_end": Mode(
        title="the end of the grid", parameters=("way over the distance to the end of the grid",),
        measure="error of the lift", right=0.05, wrong=0.25,
        methods={"fixed grid": {"grid": "short"}, "grid.x.window": {"grid": "window"}}, default="fixed grid",
        message=r"grid\.x\.end", full=(0.5, 0.8, 1.0, 1.2, 1.5, 2.0), quick=(0.5, 1.5), solve=grid_end),
}
