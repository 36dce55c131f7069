"""The background grid: axes, axes that move with a body, node numbers, colouring for parallel sums."""

import hybrid.runtime.kernel_copies  # noqa: F401 (before a kernel of this folder is compiled)
