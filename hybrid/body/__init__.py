"""Rigid bodies: mesh, mass, attitude, contact surface, motion and pull line."""
