"""One increment of time: its equations, their solution, and how long it may be.

1 increments.py     the outer step: begin, solve, accept, or shorten the increment
    model.py, workspace.py           what stays the same during a stage; memory that its steps share
    moving_grid.py, processes.py     a grid that follows a body; points that move to other processes
    error_estimate.py                length of an increment by a given accuracy
    support.py                       free bodies that cannot begin out of balance, without inertia
2 equations.py      R(u, w) = 0 and its tangent, the seed paper's (1) and (2)
    soil_terms.py                    internal force, inertia and loads of the soil
    body_terms.py                    inertia, weight, line of a body, and the soil's contact with it
    joint_terms.py, pair_terms.py    joints between bodies; bodies that touch one another
    loads.py, search_reach.py        gravity and given loads; how far from a body contact is searched for
3 newton.py         Newton's method: what is tried in turn; iteration.py: updates in one way until they converge
    first_guess.py, rolling.py       where it starts; a round body then rolls
    restriction.py, sticking.py      few nodes solved for by themselves; contact points held in stick for an update
4 joint_rates.py    rates that joints allow, and the impulses of stops
    work.py, energy.py, records.py   what the balance and the history keep of an accepted increment
    failure_message.py               what is said of one that failed
"""
