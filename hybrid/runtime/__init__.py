"""What every other package may use: errors, timing, memory, sums over points, a notice of compilation."""
