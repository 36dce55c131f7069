"""Helpers that every other package may use: errors, timing, memory, sums over points, texts of forces, notice of
compilation."""
