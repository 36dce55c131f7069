"""Rigid bodies: mesh, mass, attitude, contact surface, motion, ways and pull line."""
