"""Mass, centre, inertia and gravity load of a rigid body, assembled once with linear Lagrange elements.

With shape functions N_i, the consistent mass and the load of unit gravity along axis k are

    M_ij = ∫ ρ N_i N_j dV I        f_i,k = ∫ ρ N_i dV e_k        (seed paper, Eq. 2)

and condensed to the six unknowns of the body, about its centre of mass: a node at r_i from it moves by w_i = Δc + Δφ × r_i =
C_i Δq, Δq = (Δc, Δφ),

    C_i = [ I , -r̃_i ]             C^T M C = diag(m I, J)         C^T f = [ m I ; 0 ]

exactly, because rigid motions are linear functions; the values are those of the polyhedron that the mesh fills.
Nothing is reassembled when the body moves: J rotates with it.

| symbol   | field          | shape  | unit        |
|----------|----------------|--------|-------------|
| m        | mass           | -      | kg          |
|          | centre         | (3,)   | m           |
| J        | inertia        | (3, 3) | kg m²       |
| C^T f    | gravity_load   | (6, 3) | kg, kg m    |

Equations: FORMULATION (30).
"""

import logging
from contextlib import contextmanager
from dataclasses import dataclass, replace

import dolfinx.fem.petsc
import dolfinx.mesh
import numpy as np
import ufl
from dolfinx import fem
from mpi4py import MPI
from scipy.sparse import csr_matrix

from hybrid.runtime.errors import GeometryError


@dataclass(frozen=True)
class MassProperties:
    """Condensed mass of one body; fields in the module's table.

    `centre` is in the geometry's coordinates; `inertia` and `gravity_load` are about the centre, along
    the geometry's axes. Gravity g (3,) [m/s²] in those axes gives the load gravity_load @ g [N, N m].
    """

    mass: float
    centre: np.ndarray
    inertia: np.ndarray
    gravity_load: np.ndarray

    def times(self, share):
        """That of a share [-] of the body, with the same centre."""
        return replace(self, mass=share * self.mass, inertia=share * self.inertia, gravity_load=share * self.gravity_load)


def condensed_mass(mesh, density):
    """MassProperties of a TetMesh of uniform `density` [kg/m³]. GeometryError unless that is positive."""
    if not (np.isfinite(density) and density > 0.0):
        raise GeometryError(f"density = {density} kg/m³ of body '{mesh.name}' must be positive and finite")
    # About the middle of the mesh first: far from the origin the squared coordinates would cost digits.
    middle = 0.5 * (mesh.points.min(axis=0) + mesh.points.max(axis=0))
    nodes, matrix, loads = assemble(mesh.points - middle, mesh.tets, float(density))
    total = condensation(nodes).T @ loads
    mass = total[:3].trace() / 3.0
    # unit gravity g has the moment m s x g about the middle, which gives the offset s of the centre
    arm = total[3:] / mass
    offset = 0.5 * np.array([arm[2, 1] - arm[1, 2], arm[0, 2] - arm[2, 0], arm[1, 0] - arm[0, 1]])
    c = condensation(nodes, offset)
    inertia = (c.T @ (matrix @ c))[3:, 3:]
    return MassProperties(
        mass=float(mass),
        centre=middle + offset,
        inertia=0.5 * (inertia + inertia.T),
        gravity_load=c.T @ loads,
    )


def condensation(nodes, centre=(0.0, 0.0, 0.0)):
    """Condensation matrix C (3n, 6) of `nodes` (n, 3) [m] about `centre` (3,) [m]; rows x, y, z of node 0, then 1."""
    r = np.asarray(nodes, dtype=float) - np.asarray(centre, dtype=float)
    blocks = np.zeros((len(r), 3, 6))
    blocks[:, :, :3] = np.eye(3)
    blocks[:, 0, 4], blocks[:, 0, 5] = r[:, 2], -r[:, 1]
    blocks[:, 1, 3], blocks[:, 1, 5] = -r[:, 2], r[:, 0]
    blocks[:, 2, 3], blocks[:, 2, 4] = r[:, 1], -r[:, 0]
    return blocks.reshape(-1, 6)


def combined(parts):
    """MassProperties of a body of several `parts`, each a MassProperties in the same coordinates."""
    if len(parts) == 1:
        return parts[0]
    mass = sum(part.mass for part in parts)
    centre = sum(part.mass * part.centre for part in parts) / mass
    inertia = sum(part.inertia + steiner(part.mass, part.centre - centre) for part in parts)
    return point_mass(mass, centre, inertia)


def steiner(mass, arm):
    """Inertia (3, 3) [kg m²] of a point mass [kg] at `arm` (3,) [m]."""
    return mass * (arm @ arm * np.eye(3) - np.outer(arm, arm))


def point_mass(mass, centre, inertia):
    """MassProperties of a mass [kg] at its `centre` (3,) [m] with `inertia` (3, 3) [kg m²] about it."""
    return MassProperties(float(mass), centre, inertia, mass * np.eye(6, 3))


def assemble(points, tets, density):
    """Nodes (n, 3) in dolfinx's order, sparse mass (3n, 3n) [kg] and loads of unit gravity (3n, 3) [kg]."""
    with without_compiler_log():
        domain = dolfinx_mesh(points, tets)
        space = vector_space(domain)
    u, v = ufl.TrialFunction(space), ufl.TestFunction(space)
    # constants, so that the compiled forms serve every density and every direction
    rho, gravity = fem.Constant(domain, density), fem.Constant(domain, np.zeros(3))
    with without_compiler_log():
        inertia = fem.form(rho * ufl.inner(u, v) * ufl.dx)
        load = fem.form(rho * ufl.inner(gravity, v) * ufl.dx)
    matrix = fem.petsc.assemble_matrix(inertia)
    matrix.assemble()
    start, columns, values = matrix.getValuesCSR()
    size = matrix.getSize()
    matrix.destroy()
    loads = np.empty((size[0], 3))
    for axis in range(3):
        gravity.value[:] = np.eye(3)[axis]
        vector = fem.petsc.assemble_vector(load)
        loads[:, axis] = vector.array
        vector.destroy()
    return space.tabulate_dof_coordinates(), csr_matrix((values, columns, start), shape=size), loads


@contextmanager
def without_compiler_log():
    """Suppress the compiler's command lines, which are logged when a form is first compiled."""
    before = logging.root.manager.disable
    logging.disable(max(before, logging.INFO))
    try:
        yield
    finally:
        logging.disable(before)


def dolfinx_mesh(points, tets):
    """The mesh as a dolfinx mesh, complete on this process. dolfinx may renumber nodes and cells."""
    if hasattr(fem, "functionspace"):  # dolfinx 0.7 and later
        import basix.ufl

        geometry = ufl.Mesh(basix.ufl.element("Lagrange", "tetrahedron", 1, shape=(3,)))
    else:
        geometry = ufl.Mesh(ufl.VectorElement("Lagrange", ufl.Cell("tetrahedron", geometric_dimension=3), 1))
    cells = np.ascontiguousarray(tets, dtype=np.int64)
    nodes = np.ascontiguousarray(points, dtype=np.float64)
    return dolfinx.mesh.create_mesh(MPI.COMM_SELF, cells, nodes, geometry)


def vector_space(domain):
    """Continuous linear vector functions on a dolfinx mesh."""
    if hasattr(fem, "functionspace"):  # dolfinx 0.7 and later
        return fem.functionspace(domain, ("Lagrange", 1, (3,)))
    return fem.VectorFunctionSpace(domain, ("Lagrange", 1))
