"""The `hybrid` command: run a scene, check it without running, measure speed, study precision, failures and random
scenes, mesh a geometry (`hybrid.arguments`: what each takes).

Each command imports what it needs when it runs, so that help and mistakes in the arguments are reported at once.
Exit codes: 0 done, 2 wrong arguments or an error that the user can correct, 130, 143, 129 interrupted by SIGINT, SIGTERM,
SIGHUP, 141 nobody reads what is printed (`hybrid demos | head -1`).
"""

import errno
import logging
import os
import sys
import traceback
from contextlib import nullcontext
from importlib import import_module
from pathlib import Path

from hybrid.arguments import geometry_parameters, mesh_density, parsed
from hybrid.bench import CASES
from hybrid.output.sheet_text import format_sheet, mesh_sheet
from hybrid.runtime import ranks
from hybrid.runtime.environment import open_streams, silence
from hybrid.runtime.errors import HybridError, SceneError, StepError
from hybrid.runtime.kernel_cache import require_folder

INTERRUPTED = 130   # 128 + SIGINT, as shells report it
UNREAD = 141        # 128 + SIGPIPE
MESH_ENDING = ".vtu"


def main(arguments=None):
    """Run the command line and return its exit code."""
    open_streams()
    logging.basicConfig(format="%(name)s: %(message)s")     # "hybrid: ...", as all that it reports
    logging.getLogger("hybrid").setLevel(logging.INFO)
    try:
        try:
            return _report("", _main(arguments))
        finally:
            sys.stdout.flush()      # here, where a failure can still be reported
    except BrokenPipeError:
        silence(1)
        return _report("", UNREAD)
    except OSError as error:
        if error.filename is None and error.errno in (errno.ENOSPC, errno.EIO, errno.EBADF):
            silence(1)      # what is left to print would fail again
        return _report(f"hybrid: {error.filename or 'output'}: {error.strerror or error}")


def _main(arguments):
    options = parsed(arguments)
    options.arguments = sys.argv[1:] if arguments is None else arguments
    if ranks.started() > 1:
        return _with_others(options)
    try:
        if options.command in ("run", "check", "bench", "study"):
            require_folder()
        COMMANDS[options.command](options)
    except HybridError as error:
        return _report(f"hybrid: {error}")
    except MemoryError as error:
        return _report(f"hybrid: out of memory ({error}); use larger cells, or a machine with more memory")
    except KeyboardInterrupt as stop:
        return _report(_interrupted(stop), getattr(stop, "exit_code", INTERRUPTED))
    return 0


def _interrupted(stop):
    """Message about a KeyboardInterrupt."""
    kept = getattr(stop, "kept", None)
    hint = f"; step {kept} is kept: continue with --resume" if kept is not None else ""
    return f"\nhybrid: interrupted{f' by {stop}' if str(stop) else ''}{hint}"


def _with_others(options):
    """Exit code of a run by several processes, one fault of which ends all: reported once, by the process that has it."""
    ranks.prepare()
    code, text = 0, ""
    try:
        if options.command != "run":
            raise SceneError("several ranks work together in `hybrid run` only; start this command without mpirun")
        require_folder()
        run(options)
    except HybridError as error:
        code, text = 2, f"hybrid: {error}"
    except KeyboardInterrupt as stop:
        code, text = getattr(stop, "exit_code", INTERRUPTED), _interrupted(stop)
    except BaseException:
        code, text = 1, f"hybrid: {traceback.format_exc()}"
    if not code:
        return 0
    if ranks.end_together():
        return code if ranks.rank() else _report(text, code)
    _report(f"{text}\nhybrid: this happened on rank {ranks.rank()} of {ranks.started()}; the others are ended", code)
    ranks.abort(code)
    return code


def _report(text, code=2):
    """The exit code, after an attempt to print a text to somebody who may have gone."""
    try:
        if text:
            print(text, file=sys.stderr)
        sys.stderr.flush()
    except OSError:
        silence(2)
    return code


def run(options):
    """`hybrid run`: the results go to --out, or out/<scene name> in the working folder."""
    from hybrid.scene.file import load_scene

    if options.ranks is not None and options.ranks != ranks.started():
        _start_ranks(options, options.ranks)
    scene = load_scene(options.scene, options.overrides)
    if options.ranks is None and ranks.may_start():
        _start_best(options, scene)
    from hybrid.api import run as run_scene
    from hybrid.runtime.jit_notice import compilation_notice  # late: a mistake in the scene is reported at once

    out = options.out or Path("out") / scene.name
    with compilation_notice() if ranks.rank() == 0 else nullcontext():
        run_scene(scene, out, resume=options.resume, overwrite=options.overwrite)


def _start_best(options, scene):
    """Become several processes where these are worth it and can be started; the run is made by this one otherwise."""
    from hybrid.runtime.memory import available_memory
    from hybrid.setup.best_ranks import best_ranks

    number, points = best_ranks(scene, len(os.sched_getaffinity(0)), available_memory())
    if number > 1 and ranks.can_start(number):
        print(f"{scene.name}: {number} processes for {points} points (--ranks 1: one process)", file=sys.stderr, flush=True)
        _start_ranks(options, number)


def _start_ranks(options, number):
    """Become mpirun, which starts this command that many times."""
    if number < 1 or ranks.started() > 1:
        raise SceneError(f"--ranks {number}: must be 1 or more, and under mpirun the number of its processes "
                         f"({ranks.started()}); leave it out there")
    cores = len(os.sched_getaffinity(0))
    if number > cores:
        print(f"--ranks {number}: more processes than the {cores} cores of this machine wait for one another, and each "
              f"needs its own memory; use at most --ranks {cores}", file=sys.stderr, flush=True)
    command, environment = ranks.launch(number, ["-m", "hybrid", *options.arguments])
    try:
        os.execvpe(command[0], command, environment)
    except OSError as error:
        raise SceneError(f"--ranks {number}: mpirun cannot be started ({error.strerror}); install it "
                         "(apt-get install openmpi-bin), or run on one rank") from None


def check(options):
    """`hybrid check`: the model without its first step, and the predicted cost of all steps."""
    from hybrid.scene.file import load_scene

    scene = load_scene(options.scene, options.overrides)
    from hybrid.runtime.jit_notice import compilation_notice
    from hybrid.setup.build import build  # late: a mistake in the scene is reported at once

    with compilation_notice():
        simulation = build(scene)
        sheet = simulation.sheet()
        print(format_sheet(sheet), flush=True)
        if not options.no_cost:
            print("\n" + format_sheet(_predicted_cost(simulation)))


def _predicted_cost(simulation):
    """Section of the model sheet with the predicted cost, or with the reason why there is none."""
    from hybrid.cost import predict

    try:
        return predict(simulation).sheet()
    except StepError as error:
        return {"predicted cost": [f"not available: {error}"]}


def demos(options):
    """`hybrid demos`: names and titles of the shipped scenes, or copies of those named, with their geometries."""
    from hybrid.runtime.data import copy_demo, demo_titles

    if not options.names:
        print(format_sheet({"shipped scenes": demo_titles()}))
    for name in options.names:
        print(f"hybrid run {copy_demo(name, options.to)}")


def bench(options):
    """`hybrid bench`: tables of the cases, and a file of all that was measured; or the pages made from that file."""
    from hybrid import bench as benchmarks

    if options.page:
        from hybrid.bench.pages import write_pages

        if options.cases or options.quick or options.out or options.peer:
            raise SceneError("--page: measures nothing; give it alone, after a run with --out demos/speed/bench.json")
        print(*(f"written to {path}" for path in write_pages()), sep="\n")
        return
    unknown = [name for name in options.cases if name not in CASES]
    if unknown:
        raise SceneError(f"bench {unknown[0]}: no such case; there are {', '.join(CASES)}")
    from hybrid.bench.peer import checked

    peer = checked(options.peer)
    from hybrid.runtime.jit_notice import compilation_notice  # late: a mistake in the arguments is reported at once

    with compilation_notice():
        benchmarks.run(options.cases, benchmarks.Options(options.quick, peer), options.out)


def study(options):
    """`hybrid study`: records of every problem, figures, and a table: of precision, how close each curve comes to the
    Pareto front; of failure, the number of outcomes of each kind; of random, the largest errors of each family."""
    from hybrid.bench.peer import checked
    from hybrid.bench.table import table
    from hybrid.runtime.jit_notice import compilation_notice

    report, runner = (import_module(f"hybrid.study.{options.study}.{name}") for name in ("report", "runner"))
    out = options.out or Path("out") / options.study
    if options.peer is not None and options.study != "precision":
        raise SceneError(f"--peer: study {options.study} has no peer; precision has one, in `column`")
    if options.list:
        print(table(report.listing()))
        return
    more = {"peer": checked(options.peer)} if options.study == "precision" else {}
    path = out / "records.json"
    if options.draw and not path.is_file():
        raise SceneError(f"--draw: there is no {path}; run the study first, or name its folder by --out")
    with compilation_notice():
        if options.draw:
            records = report.load(path)[1]
            print(*report.draw(path, out), sep="\n")
        else:
            records = runner.run(options.problems, options.quick, out, options.resume,
                                 lambda text: print(text, flush=True), **more)
    print(table(report.table(records)))


def schema(options):
    """`hybrid schema`: all keys of a scene file, as a JSON Schema or a page."""
    import json

    from hybrid.scene import reference

    if options.page:
        text = reference.page()
    else:
        text = json.dumps(reference.json_schema(), indent=1, ensure_ascii=False) + "\n"
    if options.out is None:
        print(text, end="")
        return
    try:
        options.out.write_text(text, encoding="utf-8")
    except OSError as error:
        raise SceneError(f"--out = {options.out}: cannot be written ({error.strerror}); name a file in an existing "
                         "folder that you may write to") from None
    print(f"written to {options.out}")


def mesh(options):
    """`hybrid mesh`: sizes, mass properties about the centre of mass, named points."""
    density = mesh_density(options.density)
    if options.out and options.out.suffix.lower() != MESH_ENDING:
        raise SceneError(f"--out {options.out}: the mesh is written as VTK XML; give a name that ends in "
                         f"{MESH_ENDING}, such as {options.out.with_suffix(MESH_ENDING)}")
    parameters = geometry_parameters(options.overrides)
    from hybrid.body.mesh import generate  # late: a mistake in the arguments is reported at once
    from hybrid.body.smooth_mass import mass_and_surface
    from hybrid.runtime.data import shipped_geometry

    volumes = tuple(density) if isinstance(density, dict) else ()
    given = options.geometry
    path = given if given.exists() else shipped_geometry(given) or given
    body = generate(path, parameters, None, options.scale, options.symmetry, volumes)
    mass, _ = mass_and_surface(body, density)
    print(format_sheet(mesh_sheet(body, mass, density)))
    if options.out:
        from hybrid.output.vtk import write_mesh

        write_mesh(options.out, body)
        print(f"\nwritten to {options.out}")


COMMANDS = {function.__name__: function for function in (run, check, demos, bench, study, schema, mesh)}
