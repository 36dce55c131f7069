"""What is special about the contact of two bodies with one another."""

from hybrid.scene.table import key, table


@table
class Contact:
    """Contact of two bodies with one another, where it differs from what holds for all: bodies that no joint connects
    touch, with the smaller friction of the two."""

    bodies: tuple[str, str] = key("names of the two bodies")
    friction: float | None = key("Coulomb coefficient μ between them; left out: the smaller of their `friction`", "-",
                                 default=None,
                                 at_least=0, remedy="0.2 to 0.5 is usual of steel on steel")
    load: float | None = key(
        "force under which they overlap by at most a thousandth of the smaller one; left out: the weight of the lighter "
        "one", "N",
        default=None, above=0, remedy="the force with which one presses on the other")
