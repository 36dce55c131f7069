"""Penalty contact with Coulomb friction between the soil and rigid bodies, in two passes that share the contact.

1 corners.py        finds the corners of the points' domains near a body; they are material points carried by the grid
2 first_contact.py  predicts where an open corner will touch: the anchor of its tangential spring
3 soil_to_body.py   first pass: corners against the body's triangles; pressure, stick or slip, tangent
4 exposed_faces.py, body_to_soil.py   second pass: samples of the body against the faces at which the soil ends
5 assembly.py       forces and tangents of both into the residual and the block system, through the corners' nodes
6 contact_pair.py   does 1 to 5 for one body; tunnelling.py rejects a step that carried corners through it
"""
