"""Points of several processes put together: sorted by the numbers that they have in the whole run, as one process has them.

A parcel is a Population with the ContactHistory of each body on its points. Contacts that are *named* have the numbers of
their points in the run instead of their places in the arrays of one process.
"""

from dataclasses import fields, replace

import numpy as np

from hybrid.soil.split_merge import concatenate
from hybrid.state import ContactHistory


def together(parcels):
    """(Population, named contacts), sorted, of parcels with named contacts."""
    populations, contacts = [points for points, _ in parcels], []
    number = np.concatenate([points.constants.number for points in populations])
    place = np.empty(len(number), np.int64)
    place[np.argsort(number, kind="stable")] = np.arange(len(number))
    points = concatenate(*populations, places=np.split(place, np.cumsum([len(one) for one in populations])[:-1]))
    for pieces in zip(*(histories for _, histories in parcels)):
        whole = ContactHistory(*(np.concatenate([getattr(piece, field.name) for piece in pieces])
                                 for field in fields(ContactHistory)))
        contacts.append(rows(whole, np.lexsort((whole.place, whole.point))))
    return points, contacts


def behind_together(populations):
    """All points left behind, in the order of their numbers; None where none are kept."""
    parcels = [(one, []) for one in populations if one is not None]
    return together(parcels)[0] if parcels else None


def named(contacts, numbers):
    """Contacts on points with `numbers` (n,) in the run, named. Places on a body, whose point is negative, keep it."""
    return [replace(history, point=np.where(history.point < 0, history.point, numbers[history.point]))
            for history in contacts]


def placed(contacts, numbers):
    """Named contacts with the places of their points among `numbers` (n,), increasing."""
    return [replace(history, point=np.where(history.point < 0, history.point, np.searchsorted(numbers, history.point)))
            for history in contacts]


def rows(history, chosen):
    """ContactHistory of the `chosen` contact points, an index array or a mask."""
    return ContactHistory(*(getattr(history, field.name)[chosen] for field in fields(ContactHistory)))


def without_numbers(population):
    """The Population as one process has it; of None, None."""
    return None if population is None else replace(population, constants=replace(population.constants, number=None))
