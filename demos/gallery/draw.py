"""Draws the pictures of the gallery from what runs and studies have written: small PNG files, and one animation.

    .venv/bin/python demos/gallery/draw.py thumbnail out/anchor/soil_step_100.png demos/gallery/anchor.png
    .venv/bin/python demos/gallery/draw.py figure out/ladder/columns.png demos/gallery/ladder.png
    .venv/bin/python demos/gallery/draw.py animation out/anchor demos/gallery/anchor.gif

A thumbnail is the picture without its white border, 480 pixels wide at most, in as many colours as fit in 60 kB; a figure,
whose labels are to be read, 800 pixels and 150 kB. The animation has a frame for each pair of soil_*.vtu and body_*.vtu in
the folder of the run, with the same camera.
"""

import sys
from functools import partial
from pathlib import Path

import meshio
import numpy as np
from PIL import Image, ImageChops

from hybrid.output import picture_worker as worker
from hybrid.output.figures import DIVERGING
from hybrid.output.pictures import colour_limit

COLOURS = 256, 64, 16
THUMBNAIL, FIGURE = (480, 60_000), (800, 150_000)        # width [pixels]; size of the file [bytes]
ANIMATED, FRAME, PAUSE = 640, 160, 1600     # width [pixels]; of one frame, and of the last one [ms]


def thumbnail(picture, path, width=THUMBNAIL[0], largest=THUMBNAIL[1]):
    """Write a copy of `picture` at most `width` [pixels] wide and, by its colours, `largest` [bytes] to `path`."""
    image = Image.open(picture).convert("RGB")
    image = image.crop(ImageChops.difference(image, Image.new("RGB", image.size, "white")).getbbox())
    image.thumbnail((width, 4 * width), Image.LANCZOS)
    for colours in COLOURS:
        image.quantize(colours).save(path, optimize=True)
        if Path(path).stat().st_size <= largest:
            break


def animation(folder, path):
    """Write an animated GIF of the run in `folder` to `path`."""
    frames = [arrays(folder, file.stem.split("_")[-1]) for file in sorted(Path(folder).glob("soil_*.vtu"))]
    limit = max(frame["limit"] for frame in frames)
    extent = np.array([worker.bounds(frame) for frame in frames])
    lower, upper = extent[:, 0].min(axis=0), extent[:, 1].max(axis=0)
    images = cropped([drawn({**frame, "limit": limit}, lower, upper, frames[0]) for frame in frames])
    images = [image.resize((ANIMATED, ANIMATED * image.height // image.width), Image.LANCZOS) for image in images]
    palette = images[-1].quantize(COLOURS[1])
    first, *rest = [image.quantize(palette=palette, dither=Image.Dither.NONE) for image in images]
    first.save(path, save_all=True, append_images=rest, duration=[FRAME] * len(rest) + [PAUSE], loop=0, optimize=True)


def arrays(folder, step):
    """What `picture_worker` draws (see `pictures.scene_arrays`), read from the frames of one step."""
    soil = meshio.read(folder / f"soil_{step}.vtu")
    bodies = [meshio.read(file) for file in sorted(folder.glob(f"body_*_{step}.vtu"))]
    first = np.cumsum([0] + [len(body.points) for body in bodies])
    moved = [mesh.point_data["displacement"][:, 2].astype(float) for mesh in (soil, *bodies)]
    body = np.concatenate(moved[1:])
    return {
        "position": soil.points, "half": soil.point_data["half_widths"].astype(float), "soil": moved[0],
        "vertices": np.concatenate([mesh.points for mesh in bodies]), "body": body,
        "triangles": np.concatenate([mesh.cells_dict["triangle"] + n for mesh, n in zip(bodies, first)]),
        "limit": colour_limit(moved[0], body),
    }


def drawn(frame, lower, upper, first):
    """Image of one frame that the box [lower, upper] just fills, with the edges of the soil of the frame `first`."""
    import pyvista

    plotter = pyvista.Plotter(off_screen=True, window_size=worker.WINDOW, lighting="none")
    plotter.set_background("white")
    shown = {"scalars": "uz", "cmap": DIVERGING, "clim": (-frame["limit"], frame["limit"]), "show_scalar_bar": False}
    soil = worker.visible_faces(pyvista, frame["position"], frame["half"], frame["soil"])
    plotter.add_mesh(soil, ambient=0.35, diffuse=0.65, specular=0.0, **shown)
    worker.add_body(pyvista, plotter, frame, shown)
    block = np.array(worker.bounds({**first, "vertices": first["vertices"][:0]}))
    plotter.add_mesh(pyvista.Box(block.T.ravel()).extract_all_edges(), color="#808080", line_width=3, lighting=False)
    worker.add_lights(pyvista, plotter)
    worker.aim_camera(plotter, lower, upper)
    plotter.enable_anti_aliasing("ssaa")
    image = Image.fromarray(plotter.screenshot(None, return_img=True))
    plotter.close()
    return image


def cropped(images):
    """The images without the white border that they share."""
    paper = Image.new("RGB", images[0].size, "white")
    boxes = np.array([ImageChops.difference(image, paper).getbbox() for image in images])
    return [image.crop((*boxes[:, :2].min(axis=0), *boxes[:, 2:].max(axis=0))) for image in images]


if __name__ == "__main__":
    kind, given, path = sys.argv[1:]
    figure = partial(thumbnail, width=FIGURE[0], largest=FIGURE[1])
    kinds = {"thumbnail": thumbnail, "figure": figure, "animation": animation}
    kinds[kind](Path(given), path)
