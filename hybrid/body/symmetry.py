"""Planes of symmetry: the axes that they are normal to, and the halves of a body that they cut."""

from hybrid.runtime.errors import GeometryError

AXES = {"x": 0, "y": 1}     # of the normals of planes of symmetry
UNEQUAL = 0.01              # of the volume: halves that differ by more are no mirror images


def check_halves(whole, kept, axis, what):
    """GeometryError unless a volume `kept` [m³] of a `whole` one is half of it, or all of a body drawn as half."""
    if kept <= 0.0:
        raise GeometryError(f"{what}: nothing of it lies at {axis} > 0, which symmetry = '{axis}' keeps; mirror the "
                            f"drawing, or move its plane of symmetry to {axis} = 0")
    if kept < (1.0 - 1e-9) * whole and abs(2.0 * kept - whole) > UNEQUAL * whole:
        raise GeometryError(f"{what} is not symmetric about {axis} = 0: {kept:.4g} m³ lie at {axis} > 0 and "
                            f"{whole - kept:.4g} m³ at {axis} < 0; move the plane of symmetry of the drawing to "
                            f"{axis} = 0, or leave symmetry = '{axis}' out")
