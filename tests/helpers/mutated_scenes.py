"""Scene files with values that nobody would write on purpose, made from small right ones by a seed.

`python mutated_scenes.py FOLDER FIRST END` builds the scenes of these seeds, without a run, and prints a line for each:
"SEED OUTCOME reason", with an outcome of

    built       the scene is allowed
    refused     by a HybridError of some lines
    long        by one with more than LONGEST characters
    traceback   any other error
    hang        more than SECONDS of computing
    memory      more than BYTES
"""

import copy
import random
import resource
import signal
import sys
import tomllib
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
SECONDS, BYTES = 20, 6 * 2**30
LONGEST = 3000      # characters of a message that still is one

BODY = f"""
[[body]]
name = "box"
geometry = "{ROOT}/geometry/box.geo"
density = 2000.0
position = [1.0, 1.0, 0.0]
rest_on = 0.0
friction = 0.4
parameters = {{ length = 0.4, width = 0.4, height = 0.4, size = 1.0 }}
"""
BASES = ["""
[grid]
x = { start = 0.0, end = 2.0, size = 0.5 }
y = { start = 0.0, end = 2.0, size = 0.25, fine = [0.5, 1.5], growth = 1.5 }
z = { nodes = [-1.0, -0.5, 0.0, 0.5] }
faces = { z_min = "fixed" }
[soil]
top = 0.0
points_per_axis = 2
material = { relative_density = 38.0 }
layer = [{ name = "low", top = -0.5, material = { relative_density = 60.0 } }]
[time]
step = 0.01
[[stage]]
name = "settle"
steps = 2
pull = false
[[stage]]
name = "drag"
steps = 3
[output]
every = 2
pictures = [1, 3]
""" + BODY + "pull = { point = [0.2, 0.0, 0.0], velocity = [0.5, 0.0, 0.0], stiffness = 1e5, length = 5.0 }\n", """
gravity = [0.0, 0.0, -9.81]
method = "default"
[grid]
x = { start = -2.0, end = 6.0, size = 0.25, around = [0.5, 0.5], window = [1.0, 1.0], doublings = 2, growth = 1.5 }
y = { start = 0.0, end = 2.0, collapsed = true }
z = { start = -1.0, end = 1.0, size = 0.25 }
[soil]
top = 0.0
k0 = 0.9
material = { law = "von-mises", young = 5e6, poisson = 0.49, density = 1800.0, strength = 10e3, cone = "plane strain" }
[time]
step = 0.05
inertia = false
[[stage]]
name = "push"
steps = 3
[solver]
tolerance = 1e-5
""" + BODY.replace("width = 0.4", "width = 2.0") + """driven = ["z"]
held = ["x", "ry"]
velocity = [0.0, 0.0, -0.01]
""", """
accuracy = "draft"
[grid]
x = { start = 0.0, end = 4.0, size = 0.5 }
y = { start = 0.0, end = 1.0, size = 0.5 }
z = { start = 0.0, end = 2.0, size = 0.5 }
[soil]
upper = [2.0, 1.0, 2.0]
geostatic = false
material = { law = "hencky", young = 1e6, poisson = 0.3, density = 1700.0 }
[time]
step = 0.02
scheme = "newmark"
accuracy = 1e-3
[[stage]]
name = "fall"
steps = 2
gravity = [0.0, 1.0]
"""]

NUMBERS = [0, 0.0, -1, -0.5, 1, 1e-300, -1e300, 1e300, 1e25, 1e-25, 1e9, 10**12, float("nan"), float("inf"),
           float("-inf"), 10**5000, -10**400, 2**63, 1e-9, 0.3333333]
TEXTS = ["", " ", "x", "x" * 5000, "a\0b", "../../etc/passwd", "/dev/zero", "soil", "é\n\u202e", "g/" * 3000,
         "{}", "nan"]
OTHERS = [True, False, [], [[]], {}, {"a": {"b": {}}}, [1, "a", None], [0.0] * 10000, [float("nan")] * 3, [1e300] * 3]


def mutated(seed):
    """Text of the scene file of a seed."""
    generator = random.Random(seed)
    if seed % 25 == 0:      # text that is hardly TOML
        return _torn(generator)
    tables = tomllib.loads(generator.choice(BASES))
    for _ in range(generator.choice([1, 1, 1, 2, 3])):
        _mutate(tables, generator)
    return "".join(f"{_key(name)} = {_value(value)}\n" for name, value in tables.items())


def _torn(generator):
    text = generator.choice(BASES)
    at = generator.randrange(len(text))
    middle = generator.choice(["", "[" * 5000, "= =", "\x00", "\ud7ff", "9" * 5000, "a.b.c = 1\n", "'''",
                               "[[body]]\n" * 50, "x = " + "[" * 300 + "]" * 300 + "\n",
                               ".".join("a" * 3000) + " = 1\n"])
    return text[:at] + middle + (text[at:] if generator.random() < 0.7 else "")


def _places(table, path=()):
    """All (container, key) in nested tables and lists."""
    items = table.items() if isinstance(table, dict) else enumerate(table)
    for key, value in list(items):
        yield table, key
        if isinstance(value, (dict, list)):
            yield from _places(value)


def _mutate(tables, generator):
    place, key = generator.choice(list(_places(tables)))
    value, kind = place[key], generator.random()
    number = isinstance(value, (int, float)) and not isinstance(value, bool)
    if kind < 0.15 and isinstance(place, dict):
        del place[key]
    elif kind < 0.2 and isinstance(place, dict):
        place[generator.choice(["", "x", key + "s", key.upper(), "a\0"]) if isinstance(key, str) else key] = value
    elif kind < 0.25 and isinstance(value, list):
        value.extend(copy.deepcopy(value) * generator.choice([1, 3, 100]))
    elif number and kind < 0.5:
        place[key] = value * 10.0 ** generator.choice([-12, -6, -3, -1, 1, 3, 6, 12]) * generator.choice([1, 1, -1])
    elif number and kind < 0.85:
        place[key] = generator.choice(NUMBERS)
    elif isinstance(value, str) and kind < 0.85:
        place[key] = generator.choice(TEXTS)
    else:
        place[key] = copy.deepcopy(generator.choice([*NUMBERS, *TEXTS, *OTHERS]))


def _key(name):
    return _text(name)


def _text(text):
    inner = "".join(c if c.isprintable() and c not in '"\\' else f"\\U{ord(c):08x}" for c in text)
    return f'"{inner}"'


def _value(value):
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, int) and abs(value) > 10**4000:
        return ("-" if value < 0 else "") + "9" * 5000
    if isinstance(value, (int, float)):
        return repr(value)
    if isinstance(value, str):
        return _text(value)
    if isinstance(value, dict):
        return "{" + ", ".join(f"{_key(name)} = {_value(item)}" for name, item in value.items()) + "}"
    return "[" + ", ".join(_value(item) for item in value if item is not None) + "]"


# ------------------------------------------------------------------ the process that builds them


class Hang(BaseException):
    """The time is over."""


def _over(*_):
    raise Hang


def outcome(path, seconds=SECONDS):
    """(outcome, reason) of building the scene file at a path."""
    from hybrid.runtime.errors import HybridError
    from hybrid.scene.file import load_scene
    from hybrid.setup.build import build

    signal.setitimer(signal.ITIMER_PROF, seconds)
    used = resource.getrusage(resource.RUSAGE_SELF)
    most = int(used.ru_utime + used.ru_stime + 2 * seconds) + 1     # ends a process that does not see the signal
    resource.setrlimit(resource.RLIMIT_CPU, (most, resource.RLIM_INFINITY))
    try:
        build(load_scene(path)).sheet()
        return "built", ""
    except HybridError as error:
        text = str(error)
        return ("refused", text) if len(text) < LONGEST else ("long", f"a message of {len(text)} characters")
    except Hang:
        return "hang", ""
    except MemoryError as error:
        return "memory", str(error)
    except Exception as error:
        return "traceback", f"{type(error).__name__}: {str(error)[:150]}"
    finally:
        signal.setitimer(signal.ITIMER_PROF, 0.0)


def main(folder, first, end):
    resource.setrlimit(resource.RLIMIT_AS, (BYTES, BYTES))
    signal.signal(signal.SIGPROF, _over)
    for number, text in enumerate(BASES):       # imports and compiles what all scenes need
        path = Path(folder) / f"base_{number}.toml"
        path.write_text(text, encoding="utf-8")
        result = outcome(path, 600)
        assert result[0] == "built", result
    for seed in range(int(first), int(end)):
        path = Path(folder) / f"scene_{seed}.toml"
        path.write_text(mutated(seed), encoding="utf-8")
        result, reason = outcome(path)
        print(seed, result, reason.replace("\n", " "), sep="\t", flush=True)


if __name__ == "__main__":
    main(*sys.argv[1:])
