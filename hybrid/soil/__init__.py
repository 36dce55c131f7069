"""Soil as material points on a background grid: grid, basis, points, transfer, kinematics, forces."""
