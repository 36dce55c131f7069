"""Penalty contact with Coulomb friction between corners of the points' domains and the triangles of rigid bodies."""
