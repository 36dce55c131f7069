"""The background grid: axes, axes that move with a body or go along with it, node numbers, colouring for parallel sums."""
