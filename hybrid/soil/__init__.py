"""Soil as material points on a background grid.

1 points.py         points whose domains tile the cells, and their geostatic stress; domains.py: how domains deform
    given_ground.py                  heights of ground that is not level, on which contact begins
2 basis.py          GIMP basis; transfer.py: from points to nodes and back
3 model.py          the soil in one increment: begun, evaluated at trial displacements, accepted
    kinematics.py                    deformation of the points
    matrices.py, principal.py        3x3 matrices; principal values and directions of symmetric ones
    forces.py                        internal force
    tangent.py, stiffness.py         tangent of one point; of all, added into the soil block, by boxes.py
    closing.py                       soil that has opened closes before it carries pressure again
    fbar.py                          volume change shared by the cells around a point, against locking
    ghost.py, filled_cells.py        stiffness for cells that are hardly filled; which cells those are
    restriction.py                   the soil that a few nodes feel
    workspace.py, buffers.py         memory that evaluations share; arrays that keep theirs while points come and go
4 lost_points.py    points that leave the soil
    refinement.py, split_merge.py    points split and merged where cells change
    size.py, parcels.py              memory of a run before it begins; points of several processes put together
"""
