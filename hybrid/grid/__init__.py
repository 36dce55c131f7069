"""The background grid: axes, axes that move with a body, node numbers, colouring for parallel sums."""
