"""Helpers that every other package may use: errors, timing, memory, sums over points, notice of compilation."""
