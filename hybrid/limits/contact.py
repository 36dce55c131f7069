"""Limits of bodies and of their contact with soil."""

LIMITS = ()
