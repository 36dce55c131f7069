"""Penalty contact with Coulomb friction between the soil and rigid bodies.

1 places.py         places on the points' domains: quadrature points of faces, or corners (the published method)
2 search.py         finds those near a body
  contact_points.py they become material points carried by the grid, called contact points
3 first_contact.py  predicts where an open contact point will touch: the anchor of its tangential spring
4 closest_points.py closest points of the body's surface
  soil_to_body.py   which points press on it there
  law.py            law of contact: pressure, stick or slip, tangent
  reversals.py      points that Newton's method carries from slip to slip the other way, held in stick
  held_facets.py    points between two facets, held to one of them
  interface.py      clay that sticks: adhesion, tension until it breaks away
  interface_shares.py  the points that bear them
5 assembly.py       forces and tangent into the residual and the block system, through the nodes of their cells
6 contact_pair.py   does 2 to 5 for one body, as pair.py asks; tunnelling.py rejects a step that carried points through it

samples.py, edge_places.py, body_to_body.py: places on the surfaces of two bodies, and their contact with one another
(`hybrid.step.pair_terms`); relative_path.py: where they are predicted to touch first;
on_ground.py: the same of a body with level held ground where it stands on edges or plane faces, instead of 1 to 6;
soft_edges.py: springs beside sharp edges on elastic soil;
cover.py: how many layers of contact points lie on a body;
overlap.py: overlap of two bodies, refused at the start.
"""
