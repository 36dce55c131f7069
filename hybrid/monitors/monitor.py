"""The one shape of all monitors: a monitor looks at every accepted outer step and gives each of its warnings once."""

from dataclasses import dataclass

import numpy as np

from hybrid.runtime.comm import anywhere, maximum


@dataclass(frozen=True)
class StepView:
    """An accepted outer step, as monitors see it.

    model: Model at its end; state: State at its end; scheme: Scheme of its stage; report: Report of its increments;
    energy: {name: [J]} at its end, with the "error" of the balance; last: whether it is the last step of the run.
    """

    model: object
    state: object
    scheme: object
    report: object
    energy: dict
    last: bool = False

    @property
    def contacts(self):
        """Contact of each body at the end of the step."""
        return self.report.evaluation.contacts

    @property
    def bodies(self):
        """(index, RigidBody, BodyState, Contact) of each body."""
        return zip(range(len(self.contacts)), self.model.bodies, self.state.bodies, self.contacts)

    @property
    def bodies_in_contact(self):
        """Whether bodies touch one another: the scheme hands an impulse on over some steps, so that energy is missing for
        a while."""
        pairs = self.report.evaluation.pairs
        return pairs is not None and pairs.energy > 0.0

    @property
    def touches_soil(self):
        """Whether any body does."""
        return anywhere([len(contact) for contact in self.contacts])

    @property
    def keeps_energy(self):
        """Whether the scheme loses none of a motion that the steps resolve: with inertia, and not of first order."""
        return self.scheme.inertia and not self.scheme.first_order

    def work(self, names):
        """[J] sum of the energies of these names."""
        return sum(self.energy.get(name, 0.0) for name in names)

    def finer(self, accuracy):
        """Remedy of increments that are too long: this time.accuracy, such as "1e-3", or a smaller one than is given."""
        return f"time.accuracy = {accuracy}" if self.report.error is None else "a smaller time.accuracy"

    def surface(self):
        """Height [m] of the highest soil."""
        points = self.state.points
        return maximum((points.position[:, 2] + points.half_width[:, 2])[points.active], -np.inf)


class Monitor:
    """Base of all monitors. A subclass yields (key, text) from `warnings`; a text is given for the first of each key.
    Texts from `stops` end the run.

    model, state: Model and State that the run begins from.
    grows: whether the value in a text goes on changing, so that the end of the run has its last one (`later`).
    forgets: names of attributes that are not part of what it remembers (`memory`).
    of_end: whether its texts are about a run that has ended, and not about one that is resumed.
    """

    grows = of_end = False
    forgets = ()

    def __init__(self, model, state):
        self._given = set()
        self._first, self._latest = {}, {}      # {key: text} of warnings that grow

    def notes(self, view):
        """Texts about a StepView that have not been given before."""
        texts = []
        for key, text in self.warnings(view):
            if key not in self._given:
                self._given.add(key)
                self._first[key] = text
                texts.append(text)
            if self.grows:
                self._latest[key] = text
        return tuple(texts)

    def later(self):
        """{text as it was given: the last one} of warnings whose values have changed since."""
        return {self._first[key]: text for key, text in self._latest.items() if text != self._first[key]}

    def given(self, key):
        """Whether the warning of this key has been given, so that nothing has to be computed for it."""
        return key in self._given

    def memory(self):
        """{name: value} of what it has seen so far, for a run that is resumed."""
        forgets = {*self.forgets, *(("_given", "_first", "_latest") if self.of_end else ())}
        return {name: value for name, value in vars(self).items() if name not in forgets}

    def texts(self):
        """Texts that have been given."""
        return list(self._first.values())

    def restore(self, memory):
        """Go on from the `memory` of another one."""
        vars(self).update(memory)

    def warnings(self, view):
        """Yield (key, text) of all that is wrong at a StepView."""
        return ()

    def stops(self, view):
        """Yield texts of what makes it useless to go on from a StepView."""
        return ()
