"""Text of a sheet {section: {label: value}}, such as the model sheet, and the sheet of a mesh."""

from hybrid.runtime.sandbox import shortcoming


def mesh_sheet(body, mass, density):
    """Sections of `hybrid mesh` for a TetMesh and its MassProperties."""
    mesh_rows = {
        "nodes": len(body.points),
        "tetrahedra": len(body.tets),
        "contact triangles": len(body.contact),
        "symmetry triangles": len(body.symmetry),
        "watertight": "yes",  # generate() refuses any other
        **({"gmsh": shortcoming()} if shortcoming() else {}),
        "lower corner [m]": body.points.min(axis=0),
        "upper corner [m]": body.points.max(axis=0),
    }
    if body.regions:
        mesh_rows["volumes [m³]"] = [f"{name}: {volume:.6g}" for name, volume in body.region_volumes().items()]
    if body.parts:
        mesh_rows["parts of the surface"] = [f"{name}: {(body.part == k).sum()} triangles"
                                             for k, name in enumerate(body.parts)]
    mass_rows = {
        "density [kg/m³]": [f"{name}: {rho:g}" for name, rho in density.items()] if isinstance(density, dict)
        else density,
        **({"modelled": "half of a body, as is all that follows"} if len(body.symmetry) else {}),
        "mass [kg]": mass.mass,
        "centre of mass [m]": mass.centre * (abs(mass.centre) > 1e-12 * body.points.max()) + 0.0,
        "inertia about the centre [kg m²]": list(mass.inertia),
    }
    sheet = {f"mesh of {body.name}": mesh_rows, "mass": mass_rows}
    if body.named_points:
        sheet["named points [m]"] = body.named_points
    return sheet


def format_sheet(sheet):
    """Text of {section: {label: value}} with the values of all sections in one column.

    A list takes a line per item; a section may also be a list of texts.
    """
    tables = [rows for rows in sheet.values() if isinstance(rows, dict)]
    width = max((len(label) for rows in tables for label in rows), default=0)
    lines = []
    for title, rows in sheet.items():
        lines += [""] * bool(lines) + [title]
        if not isinstance(rows, dict):
            lines += [f"  {row}" for row in ([rows] if isinstance(rows, str) else rows)]
            continue
        for label, value in rows.items():
            first, *others = map(_text, value) if isinstance(value, list) and value else [_text(value)]
            lines.append(f"  {label:<{width}}  {first}")
            lines += [f"  {'':<{width}}  {other}" for other in others]
    return "\n".join(line.rstrip() for line in lines)


def _text(value):
    """Numbers readable and in columns: 6 digits, thousands apart."""
    if hasattr(value, "tolist"):
        value = value.tolist()
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, int):
        return f"{value:,}".replace(",", " ")
    if isinstance(value, float):
        return f"{value + 0.0:.6g}"
    if isinstance(value, (list, tuple)):
        if not all(isinstance(item, (int, float)) for item in value):
            return ", ".join(map(_text, value)) or "none"
        scale = max(map(abs, value), default=0.0)  # round-off next to large entries is shown as zero
        return "  ".join(f"{0.0 if abs(item) < 1e-12 * scale else item:<12.6g}" for item in value)
    return str(value)
