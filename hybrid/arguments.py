"""Arguments of the `hybrid` command: commands and options with their help texts, and what texts given for them mean.

Imports nothing heavy: help and mistakes in the arguments are reported at once.
"""

import argparse
from pathlib import Path

from hybrid.bench import CASES
from hybrid.runtime.errors import SceneError


def parser():
    """The argument parser; of what it has read, `command` is the name of the command."""
    top = argparse.ArgumentParser(
        prog="hybrid", allow_abbrev=False,
        description="Rigid bodies in highly deformable soil by the implicit material point method.",
        epilog="`hybrid COMMAND --help` lists the options of a command.")
    top.add_argument("--version", action=_Version, nargs=0, help="print the version and exit")
    commands = top.add_subparsers(metavar="COMMAND", required=True)

    for command in (_run, _check, _demos, _bench, _study, _schema, _mesh):
        command(commands)
    return top


def parsed(arguments):
    """Namespace of the arguments, None for those of the process; names may follow options as well."""
    top = parser()
    found, more = top.parse_known_args(arguments)
    names = next((vars(found)[name] for name in ("names", "cases", "problems") if name in found), None)
    if more and (names is None or any(word.startswith("-") for word in more)):
        top.error(f"unrecognized arguments: {' '.join(more)}")
    if more:
        names += more
    return found


def _run(commands):
    sub = _command(commands, "run", "run a scene and write its results to a folder")
    _scene_arguments(sub)
    sub.add_argument("--out", type=folder, metavar="DIR", help="folder of results (default: out/<scene name>)")
    sub.add_argument("--resume", action="store_true", help="continue from the last checkpoint in that folder")
    sub.add_argument("--overwrite", action="store_true", help="replace the results in that folder")
    sub.add_argument("--ranks", type=int, metavar="N",
                     help="number of processes that share the work, started by mpirun (default: one; with 4 cores or more "
                          "and 400000 points or more, one for each 100000 points)")


def _check(commands):
    sub = _command(commands, "check", "validate a scene; print the size of its model, warnings and the "
                                      "predicted cost of a run")
    _scene_arguments(sub)
    sub.add_argument("--no-cost", action="store_true",
                     help="do not predict the cost, which takes the time of a few steps")


def _demos(commands):
    sub = _command(commands, "demos", "list the shipped scenes, or copy some")
    sub.add_argument("names", nargs="*", metavar="NAME", help="scenes to copy (default: list all)")
    sub.add_argument("--to", type=folder, metavar="DIR", default=Path(), help="folder to copy to (default: this one)")


def _bench(commands):
    sub = _command(commands, "bench", "measure the speed of the benchmark cases on this machine")
    sub.add_argument("cases", nargs="*", metavar="CASE", help=", ".join(CASES) + " (default: all)")
    sub.add_argument("--quick", action="store_true", help="the smallest size of each case")
    sub.add_argument("--out", type=Path, metavar="FILE.json", help="write the measurements, with machine and versions")
    sub.add_argument("--peer", type=Path, metavar="PYTHON", help="a Python with Kratos MPM, run as well in `block`")
    sub.add_argument("--page", action="store_true",
                     help="write the tables of demos/speed/README.md from demos/speed/bench.json, measure nothing")


def _study(commands):
    sub = _command(commands, "study", "chart speed against accuracy, where methods fail, or random problems")
    sub.add_argument("study", choices=["precision", "failure", "random"], metavar="STUDY",
                     help="precision: error against cost; failure: known failure modes, with plain method and remedies; "
                          "random: scenes drawn at random with nothing set but the physics")
    sub.add_argument("problems", nargs="*", metavar="NAME",
                     help="some of its problems, failure modes or families (default: all; --list shows them)")
    sub.add_argument("--quick", action="store_true", help="a few settings or seeds of each of them, once")
    sub.add_argument("--out", type=folder, metavar="DIR", help="folder of records and figures (default: out/STUDY)")
    sub.add_argument("--resume", action="store_true",
                     help="keep the records of the folder and run the missing settings")
    sub.add_argument("--peer", type=Path, metavar="PYTHON", help="a Python with Kratos MPM, run as well in `column`")
    sub.add_argument("--draw", action="store_true", help="draw the figures from the folder's records, run nothing")
    sub.add_argument("--list", action="store_true", help="list the names of them, run nothing")


def _schema(commands):
    sub = _command(commands, "schema", "print the JSON Schema of scene files, for completion in an editor")
    sub.add_argument("--page", action="store_true", help="print all keys as a page in Markdown instead")
    sub.add_argument("--out", type=Path, metavar="FILE", help="write to a file instead")


def _mesh(commands):
    sub = _command(commands, "mesh", "mesh a geometry; print the size of the mesh and the mass of the body")
    sub.add_argument("geometry", type=Path, metavar="FILE", help="geometry (.geo), solid, triangles or mesh (.step, "
                                                                 ".iges, .brep, .stl, .msh)")
    sub.add_argument("--density", default="7850", metavar="RHO",
                     help="density of the body in kg/m³ (default: 7850, steel), or of each of its volumes, as "
                          "shank=7850,fluke=7200")
    sub.add_argument("--scale", type=float, default=1.0, metavar="METRES",
                     help="metres in a unit of the file, 0.001 for triangles in millimetres (default: 1)")
    sub.add_argument("--symmetry", choices=["x", "y"], help="cut the body in half: keep what lies at positive x or y")
    _set_argument(sub, "name=value", "set a parameter of the geometry, such as size=0.1")
    sub.add_argument("--out", type=Path, metavar="FILE.vtu", help="write the mesh as VTK XML, for ParaView")


def _command(commands, name, text):
    sub = commands.add_parser(name, help=text, description=text, allow_abbrev=False)
    sub.set_defaults(command=name)
    return sub


def _scene_arguments(sub):
    sub.add_argument("scene", type=Path, metavar="SCENE", help="scene file (TOML)")
    _set_argument(sub, "key=value", "replace values of the scene, such as time.step=0.01 body.anchor.friction=0.3")


def _set_argument(sub, metavar, text):
    sub.add_argument("--set", nargs="+", action="extend", default=[], dest="overrides", metavar=metavar,
                     help=text)


def folder(text):
    """Path of an argument that names a folder; "" would be the working folder."""
    if not text.strip() or "\0" in text:
        raise argparse.ArgumentTypeError(f"{text!r} names no folder; leave the option out, or give . for this one")
    return Path(text)


class _Version(argparse.Action):
    """Prints the version, which is looked up only then."""

    def __call__(self, parser, *_):
        import hybrid

        print(f"hybrid {hybrid.__version__}")
        parser.exit()


def mesh_density(text):
    """Density [kg/m³] of --density: one number, or {name of a volume: number}."""
    named = [part.rpartition("=") for part in text.split(",")]
    try:
        densities = {name.strip(): float(number) for name, _, number in named}
    except ValueError:
        densities = {}
    sound = len(densities) == len(named) and all(0 < rho < float("inf") for rho in densities.values())
    if not sound or len(named) > 1 and "" in densities:
        raise SceneError(f"--density = {text}: must be a positive number of kg/m³, 7850 is steel, or one for each volume, "
                         "such as shank=7850,fluke=7200")
    return densities.get("", densities)


def geometry_parameters(overrides):
    """Dict of the numbers in "name=value" texts; SceneError for anything else."""
    from hybrid.scene.file import toml_value

    parameters = {}
    for override in overrides:
        name, _, text = override.partition("=")
        value = toml_value(text)
        if not name.strip() or isinstance(value, bool) or not isinstance(value, (int, float)):
            raise SceneError(f"--set {override}: expected name=number, for example size=0.1")
        parameters[name.strip()] = float(value)
    return parameters
