"""A cantilever bent right down by a dead load at its end, in plane strain, against elastica and shear-flexible beam.

    wall |===========  10 m x 1 m, E = 12 MPa, ν = 0.2, load F = 100 kN, E' = E/(1 - ν²), G = E/2(1 + ν)
         |       F |
                   v   50 quasi-static steps

With θ(s) the turn of a section and the load along -z, moment and forces on it (per metre of width, height H):

    E'H³/12 θ' = F (x_tip - x)      N = F sin θ,  Q = F cos θ        elastica: no stretch, no shear
    x' = (1 + N/E'H) cos θ + Q/(5/6 G H) sin θ      -z' = (1 + N/E'H) sin θ - ... see `beam`

The beam that stretches and shears is Reissner's (J. Appl. Math. Phys. 23, 1972, 795-804), whose end is clamped
without holding back its lateral strain; the points' clamp holds it back.
"""
