"""Demo scripts as modules, so that tests ask what a user sees."""

import importlib.util
import sys
from pathlib import Path

DEMOS = Path(__file__).parents[2] / "demos"


def demo(name):
    """Module of demos/NAME.py; its own imports of other demos work as when it is run."""
    spec = importlib.util.spec_from_file_location(f"{name}_demo", DEMOS / f"{name}.py")
    module = importlib.util.module_from_spec(spec)
    sys.path.insert(0, str(DEMOS))
    try:
        spec.loader.exec_module(module)
    finally:
        sys.path.remove(str(DEMOS))
    return module
