"""One increment of time: its equations, their solution, and how long it may be. Numbers are those of FORMULATION.

increments.outer_step               until the end of the step is reached:
    equations.begin                     basis (3) and nodal mass (5) of the committed state; contact points near bodies
    newton.solve                        which updates are tried in turn
        first_guess.first_evaluation        where they start
        iteration.iterate                   until the residual is below the tolerance:
            Step.evaluate                       R(u, w), (1): soil (8) to (11), contact (38) to (40), bodies (33)
            Step.assemble                       its tangent K, (2)
            system.solve                        K δ = -R, (47)
            iteration.line_search               (u, w) <- (u, w) + s δ
    Step.accept                         the next committed state: points (6) and (7), bodies, history of contact

1 increments.py     the outer step: begin, solve, accept, or shorten the increment
    model.py, workspace.py           what stays the same during a stage; memory that its steps share
    moving_grid.py, carried_grid.py  a grid that follows a body; one that goes along with it by half a cell
    processes.py                     points that move to other processes
    error_estimate.py                length of an increment by a given accuracy
    support.py                       free bodies that cannot begin out of balance, without inertia
    stage_contact.py                 what contact answers to forces that begin to act
2 equations.py      R(u, w) = 0 and its tangent, the seed paper's (1) and (2)
    soil_terms.py                    internal force, inertia and loads of the soil
    body_terms.py                    inertia, weight, line of a body, and the soil's contact with it
    joint_terms.py, pair_terms.py    joints between bodies; bodies that touch one another
    assemblies.py                    support and scale of forces over joints
    evaluation.py                    trial values, and the residual there
    loads.py, search_reach.py        gravity and given loads; how far from a body contact is searched for
    flight.py                        bodies near nothing, whose scheme damps next to nothing
3 newton.py         Newton's method: what is tried in turn; iteration.py: updates in one way until they converge
    first_guess.py, rolling.py       where it starts; a round body then rolls
    contacts.py                      contact as it is steered; contact_resultants.py: its resultants on each body
    rejection.py                     what must not be accepted although it is solved
    restriction.py, sticking.py      few nodes solved for by themselves; contact points held in stick for an update
4 joint_rates.py    rates that joints allow, and the impulses of stops
    work.py, energy.py, records.py   what the balance and the history keep of an accepted increment
    failure_message.py               message of a failed increment
"""
