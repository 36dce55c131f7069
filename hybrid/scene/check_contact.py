"""Checks of the contacts between the bodies of a scene."""

from hybrid.scene.read import clipped, did_you_mean
from hybrid.scene.table import need


def contact_faults(scene):
    """Texts of all faults in the contacts of a Scene."""
    names, met = [body.name for body in scene.bodies], set()
    for i, contact in enumerate(scene.contacts):
        key, pair = f"contact.{i}.bodies", frozenset(contact.bodies)
        yield from need(len(pair) == 2, key, contact.bodies, "two different names", "a body does not touch itself")
        for name in contact.bodies:
            yield from need(name in names, key, clipped(name), f"names of bodies: {', '.join(names) or 'none'}",
                            f"name a [[body]]{did_you_mean(name, names)}")
        yield from need(pair not in met, key, contact.bodies, "in one [[contact]]", "put its keys together")
        joined = any(frozenset(joint.bodies) == pair for joint in scene.joints)
        yield from need(not joined, key, contact.bodies, "bodies that no joint connects",
                        "joined bodies do not touch one another")
        met.add(pair)
