"""Limits of time steps, schemes and loads."""

LIMITS = ()
