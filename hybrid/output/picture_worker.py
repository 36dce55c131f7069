"""Draws one picture of soil and bodies: the child process of `hybrid.output.pictures`."""

import math
import sys

import numpy as np

LABEL = "vertical displacement [m]"
WINDOW = (2100, 1400)  # pixels, before cropping
VIEW = np.array([-0.3, -1.0, 0.42])  # from the focal point to the camera


def main(given, drawn, caption=""):
    from hybrid.output import figures

    with np.load(given) as file:
        arrays = dict(file)
    image, ends, length = draw(arrays, figures.DIVERGING)
    limit, values = float(arrays["limit"]), np.concatenate([arrays["soil"], arrays["body"]])
    below, above = np.any(values < -limit), np.any(values > limit)
    extend = {(0, 0): "neither", (1, 0): "min", (0, 1): "max", (1, 1): "both"}[int(below), int(above)]
    figures.picture(drawn, image, limit, LABEL, caption, extend, (*ends, f"{length:g} m"))


def draw(arrays, colours):
    """Image (rows, columns, 4: RGB and opacity), ruler ends (4,) in its pixels, ruler's length [m]."""
    import pyvista

    plotter = pyvista.Plotter(off_screen=True, window_size=WINDOW, lighting="none")
    plotter.set_background("white")
    limit = float(arrays["limit"])
    shown = {"scalars": "uz", "cmap": colours, "clim": (-limit, limit), "show_scalar_bar": False}
    if len(arrays["position"]):
        soil = visible_faces(pyvista, arrays["position"], arrays["half"], arrays["soil"])
        plotter.add_mesh(soil, ambient=0.35, diffuse=0.65, specular=0.0, **shown)
    if len(arrays["vertices"]):
        add_body(pyvista, plotter, arrays, shown)
    add_lights(pyvista, plotter)
    lower, upper = bounds(arrays)
    aim_camera(plotter, lower, upper)
    plotter.enable_anti_aliasing("ssaa")
    image = plotter.screenshot(None, return_img=True, transparent_background=True)
    length = ruler_length(upper[0] - lower[0])
    start = np.array([lower[0], lower[1], lower[2] - 0.02 * np.linalg.norm(upper - lower)])
    ends = np.concatenate([pixel(plotter, start), pixel(plotter, start + [length, 0, 0])])
    plotter.close()
    image, corner = cropped(image, ends)
    return image, ends - np.tile(corner, 2), length


def visible_faces(pyvista, centre, half, values):
    """The three faces of every box that face the camera, with cell data "uz"; the others are hidden."""
    faces = []
    for axis in range(3):
        side = math.copysign(1.0, VIEW[axis])
        u, v = (axis + 1) % 3, (axis + 2) % 3
        corners = np.empty((len(centre), 4, 3))
        corners[:, :, axis] = (centre[:, axis] + side * half[:, axis])[:, None]
        for i, (a, b) in enumerate(((-1, -1), (side, -side), (1, 1), (-side, side))):
            corners[:, i, u] = centre[:, u] + a * half[:, u]
            corners[:, i, v] = centre[:, v] + b * half[:, v]
        faces.append(corners)
    quads = np.concatenate(faces)
    numbers = np.arange(4 * len(quads)).reshape(-1, 4)
    mesh = pyvista.PolyData(quads.reshape(-1, 3), np.column_stack([np.full(len(quads), 4), numbers]).ravel())
    mesh.cell_data["uz"] = np.tile(values, 3)
    return mesh


def add_body(pyvista, plotter, arrays, shown):
    """Bodies with their sharp edges and silhouette; an open surface (half model) gets its cut face back."""
    triangles = np.column_stack([np.full(len(arrays["triangles"]), 3), arrays["triangles"]])
    surface = pyvista.PolyData(arrays["vertices"], triangles.ravel())
    surface.point_data["uz"] = arrays["body"]
    size = surface.length
    rim = surface.extract_feature_edges(
        boundary_edges=True, feature_edges=False, manifold_edges=False, non_manifold_edges=False
    )
    finish = {"ambient": 0.35, "diffuse": 0.65, "specular": 0.0}  # a highlight would be read as displacement
    smooth = {"smooth_shading": True, "split_sharp_edges": True, "feature_angle": 30}
    plotter.add_mesh(surface, **smooth, **finish, **shown)
    if rim.n_cells:
        cap = rim.strip().triangulate_contours()
        # In front of the soil's own cut face, where both lie in the symmetry plane.
        cap.points += 2e-3 * size * VIEW / np.linalg.norm(VIEW)
        plotter.add_mesh(cap, lighting=False, **shown)
        rim.points += 3e-3 * size * VIEW / np.linalg.norm(VIEW)
        plotter.add_mesh(rim, color="black", line_width=7, lighting=False)
    edges = surface.extract_feature_edges(
        feature_angle=30, boundary_edges=False, manifold_edges=False, non_manifold_edges=False
    )
    if edges.n_cells:
        plotter.add_mesh(edges, color="#202020", line_width=4, lighting=False)
    plotter.add_silhouette(surface, color="black", line_width=5)


def add_lights(pyvista, plotter):
    """Three far lights, one along each axis: white stays white on the cut face, and sides differ."""
    for position, strength in (((0, -1, 0), 1.0), ((0, 0, 1), 0.86), ((-1, 0, 0), 0.6)):
        plotter.add_light(pyvista.Light(position=position, focal_point=(0, 0, 0), intensity=strength))


def bounds(arrays):
    """Lower and upper corner (3,) [m] of everything drawn."""
    corners = [arrays["position"] - arrays["half"], arrays["position"] + arrays["half"], arrays["vertices"]]
    corners = np.concatenate([c for c in corners if len(c)])
    return corners.min(axis=0), corners.max(axis=0)


def aim_camera(plotter, lower, upper):
    """Parallel projection along VIEW that just holds the box [lower, upper]."""
    centre = (lower + upper) / 2
    away = VIEW / np.linalg.norm(VIEW)
    right = np.cross([0, 0, 1.0], away) / np.linalg.norm(np.cross([0, 0, 1.0], away))
    top = np.cross(away, right)
    reach = [np.abs(axis) @ (upper - lower) / 2 for axis in (right, top)]
    distance = 5 * np.linalg.norm(upper - lower)
    plotter.camera_position = [centre + distance * away, centre, (0, 0, 1)]
    plotter.camera.enable_parallel_projection()
    plotter.camera.parallel_scale = 1.06 * max(reach[1], reach[0] * WINDOW[1] / WINDOW[0])
    plotter.renderer.ResetCameraClippingRange()


def ruler_length(extent):
    """Round length [m] of about a sixth of the model's extent."""
    power = 10.0 ** math.floor(math.log10(extent / 6))
    return max(m * power for m in (1, 2, 5) if m * power <= extent / 6)


def pixel(plotter, point):
    """Column and row (2,) of the image at which a point (3,) [m] appears."""
    renderer = plotter.renderer
    renderer.SetWorldPoint(*point, 1.0)
    renderer.WorldToDisplay()
    column, row, _ = renderer.GetDisplayPoint()
    return np.array([column, plotter.window_size[1] - row])


def cropped(image, ends, margin=24):
    """The image without its white border, and the pixel (column, row) of the new upper left corner."""
    inked = np.argwhere(image[:, :, 3] > 0)
    columns = np.concatenate([inked[:, 1], ends[0::2].astype(int)])
    rows = np.concatenate([inked[:, 0], ends[1::2].astype(int) + 2 * margin])
    left, top = max(0, columns.min() - margin), max(0, rows.min() - margin)
    right, bottom = min(image.shape[1], columns.max() + margin), min(image.shape[0], rows.max() + margin)
    return image[top:bottom, left:right], np.array([left, top])


if __name__ == "__main__":
    main(*sys.argv[1:])
