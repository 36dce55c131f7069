"""A run: stages of outer steps over a model and its state, reported to observers.

What a user reads, stable from version to version:

    simulation.steps()                      generator of a Record (`hybrid.output.record`) for each accepted outer step
    simulation.state                        the last accepted state (`hybrid.state`)
    simulation.state.time, .step            [s], number of the outer step
    simulation.state.bodies[i].position, .rotation, .velocity, .spin
    simulation.state.points.position
    record.bodies[i].contact_force          (3,) [N] of the soil on the body
"""

from contextlib import closing
from copy import copy
from functools import cached_property

import numpy as np

from hybrid.body.symmetry import copies
from hybrid.contact.closest_points import forces_on_vertices
from hybrid.monitors import Monitors, StepView
from hybrid.monitors.failure_hints import overstretched_domains
from hybrid.monitors.initial_equilibrium import initial_imbalance
from hybrid.monitors.limits import limit_warnings
from hybrid.output.model_sheet import model_sheet
from hybrid.output.observers import finish, notify
from hybrid.runtime import comm, ranks, timing
from hybrid.runtime.errors import HybridError, OutputError, StepError
from hybrid.runtime.memory import map_large_arrays
from hybrid.soil.model import Refusal
from hybrid.step import processes
from hybrid.step.energy import balance_error, energies
from hybrid.step.equations import begin
from hybrid.step.increments import Control, outer_step
from hybrid.step.records import step_record
from hybrid.step.workspace import Workspace

AFRESH = 10     # steps after which no tangent is carried on, where no checkpoints are written


class Simulation:
    """Scene, model and committed state; made by `hybrid.setup.build.build`.

    scene, model, state   what is modelled, all keys decided, what stays the same in a stage, the last accepted State
    meshes                TetMesh of each body
    moving_grid           how the grid follows a body, None where it does not
    carried_grid          how the nodes go along with driven bodies, None for nodes that stay
    level                 texts about what `accuracy` has changed in the scene
    decisions             what was decided of keys that the scene left out (`hybrid.scene.defaults`)
    start                 rows {label: value} of the sheet about bodies in place and how the soil has settled
    evaluation            Evaluation that led to the state, None before the first step
    increment             [s] that the next step of this stage tries first, None: all of it
    solver_memory         (9,) counts of the linear solver (`SolverChoice.memory`), None before the first step
    imbalance             of the initial state, None for soil that is held or weighs nothing
    """

    def __init__(self, scene, model, state, meshes, moving_grid=None, carried_grid=None, level="", decisions=(),
                 start=None):
        map_large_arrays()      # PETSc is loaded by now
        self.scene, self.model, self.state, self.meshes = scene, model, state, meshes
        self.moving_grid, self.carried_grid = moving_grid, carried_grid
        self.level, self.decisions, self.start = level, decisions, start or {}
        self.initial_bodies = list(state.bodies)
        self.evaluation, self.increment, self.backtrack, self.solver_memory = None, None, None, None
        self._initial_position = None
        workspace = Workspace(model)
        step = begin(model, state, scene.time.step, False, workspace)
        evaluation = step.evaluate(step.at_rest())
        if isinstance(evaluation, Refusal):
            raise StepError(f"the state at the start {evaluation.reason}")
        self._start_energy = energies(model, state, evaluation)     # a body may start with a small overlap
        self.imbalance = initial_imbalance(step, evaluation)
        workspace.destroy()
        self._sheet = self._forces = None
        if ranks.started() > 1:
            self._sheet = self.sheet()      # of the start, by all processes together
            self._sheet["modelled"]["processes"] = ranks.started()
        self._monitors = Monitors(self.model, self.state)

    @property
    def surfaces(self):
        """ContactSurface of each body's geometry, as it is drawn."""
        return [body.outline for body in self.model.bodies]

    @property
    def body_names(self):
        """Name of each body."""
        return [body.name for body in self.model.bodies]

    @property
    def masses(self):
        """MassProperties of each body."""
        return [body.mass for body in self.model.bodies]

    @property
    def mirrors(self):
        """Planes of symmetry of the model, each once."""
        return self.model.mirrors

    @property
    def initial_position(self):
        """(n, 3) [m] of the points."""
        return self._initial_position if self._initial_position is not None else self.model.soil.constants.position

    def resume(self, state, increment=None, backtrack=None, solver_memory=None, remembered=None, number=None):
        """Continue from `state`, with an increment of `increment` [s] first, with backtracking in Newton's method first
        where `backtrack`, and with what the choice of the linear solver and the monitors remember: `solver_memory` (9,) and
        `remembered`.

        Of several processes each is given what it `keeps`, with the numbers (n,) of its points, increasing
        (`hybrid.output.checkpoint_parts.share`)."""
        self.warned     # found now, where the scene starts: the grid has moved on since
        self.increment, self.backtrack, self.solver_memory = increment, bool(backtrack), solver_memory
        if remembered is not None:
            self._monitors.restore(str(remembered))
        if self.moving_grid:
            self.model = self.moving_grid.model_with(self.model, state.ground)
        if ranks.started() > 1:
            self.model, state = processes.resumed(self.model, state, number)
        self.state = state

    def keeps(self):
        """Function of numbers of points: which ones this process of several is to be given when the run is resumed."""
        return processes.keeps(self.model, self.state)

    @property
    def notes(self):
        """Texts that steps have given, also those before the run was resumed."""
        return self._monitors.given

    @property
    def remembered(self):
        """Function that gives the text of the notes so far and of what the monitors have seen, for `resume`."""
        return self._monitors.memory()

    @property
    def total_steps(self):
        """Outer steps of all stages."""
        return sum(stage.steps for stage in self.scene.stages)

    def sheet(self):
        """What is modelled and what is left out, with sizes: {section: {label: value}}."""
        if self._sheet:
            return self._sheet
        sheet = model_sheet(self.scene, self.model, self.imbalance, self.level, self.most_points, self.decisions)
        sheet["modelled"].update(self.start)
        return {**sheet, **({"warnings": list(self.warned)} if self.warned else {})}

    @cached_property
    def warned(self):
        """Texts about the limits that the scene exceeds; they depend on nothing that changes in a run."""
        return limit_warnings(self.scene, self.model) + self._hazards

    @property
    def _hazards(self):
        """The same about soil that is far from equilibrium at the start, or has settled and is not in equilibrium yet."""
        if self.imbalance is None:
            return ()
        if "settled at the start" in self.start:
            return self._imbalance_notes
        return () if self.model.scheme.inertia else tuple(self.imbalance.hazards())

    @property
    def later_notes(self):
        """{note as it was given: the note with its value at the last step} of notes whose values have changed since."""
        return self._monitors.later()

    @property
    def most_points(self):
        """Number of points in the grid, now or when the body that it follows has sunk, whichever is larger."""
        now = comm.number(self.state.points)
        return max(now, self.moving_grid.points_when_sunk(self.model, self.state)) if self.moving_grid else now

    def contact_forces(self, b):
        """Force of the soil on each surface vertex of body b at the last accepted step, (V, 3) [N]; of several processes,
        which all call this, of the soil of all."""
        if self._forces is not None:
            return self._forces[b]
        if self.evaluation is None:
            return np.zeros((len(self.surfaces[b].vertices), 3))
        contact, rotation = self.evaluation.contacts[b], self.state.bodies[b].rotation
        return comm.total([forces_on_vertices(contact, rotation, self.surfaces[b])])

    def with_all_forces(self):
        """This simulation with the forces of all processes, which all call this, to be asked for by one of them."""
        whole = copy(self)
        whole._forces = [self.contact_forces(b) for b in range(len(self.surfaces))]
        return whole

    def with_all_points(self):
        """This simulation as it is drawn: in the first of several processes, which all call this, with the points of all.
        Nothing else needs all points in one process."""
        whole = copy(self)
        whole.state, whole._initial_position = processes.gather(self.model, self.state)
        return whole

    def run(self, observers=()):
        """Run the remaining steps; returns the summary dict {"outcome", "reason"} that observers get too.

        Of several processes each has the same observers, which are shown its own points; their calls are collective, and
        raise the same error everywhere (`hybrid.output.first`).

        `finish` of every observer is called however the run ends: completed, failed (the error is raised again) or
        interrupted. Raises OutputError, which interrupts the run, for an OSError of an observer.
        """
        summary, stop, shared = {"outcome": "completed", "reason": ""}, None, True
        notify(observers, lambda observer: observer.start(self))
        try:
            with closing(self.steps()) as steps:        # their matrices, also where an observer ends the run
                for record in steps:
                    notify(observers, lambda observer, record=record: observer.accepted(record, self))
        except (KeyboardInterrupt, OutputError) as error:
            summary.update(outcome="interrupted", reason=str(error) or "SIGINT")
            stop, shared = error, getattr(error, "of_all", isinstance(error, OutputError))
            raise
        except HybridError as error:
            summary.update(outcome="failed", reason=str(error))
            raise
        except BaseException as error:
            summary.update(outcome="failed", reason=f"{type(error).__name__}: {error}")
            shared = False      # it may be of this process alone
            raise
        finally:
            finish(observers, summary, self, ranks.started() == 1 or shared and ranks.all_here())
            if stop is not None:
                stop.kept = summary.get("checkpoint_step")
        return summary

    def steps(self):
        """Generator of a Record per accepted outer step, from the present state to the end of the last stage.

        Raises StepError when a step fails; `state` is then that of the last accepted step.
        """
        workspace = Workspace(self.model)
        if self.solver_memory is not None:
            workspace.systems.choice.restore(self.solver_memory)
        try:
            first, starts, before = 0, 0.0, None      # steps and time before the stage, and the model of the one before
            for number, stage in enumerate(self.scene.stages):
                yield from self._stage_steps(number, stage, first, starts, before, workspace)
                before = self.stage_model(number, starts)
                first, starts = first + stage.steps, starts + stage.steps * self.scene.step_of(stage)
        finally:
            workspace.destroy()

    def _stage_steps(self, number, stage, first, starts, before, workspace):
        """Records of the remaining steps of a stage that comes after `first` steps and starts at a time [s]; before: Model
        of the stage before it, or None."""
        length, begun = self.scene.step_of(stage), self.state.step > first
        control, model = self._control(length, begun), self.stage_model(number, starts)
        workspace.renew(model)
        if not begun:
            ended, pulled = self.state, number > 0 and self.scene.stages[number - 1].pull
            self.state = model.begin_stage(ended, before, stage.pull - pulled)
            control.pushed = model.pushed(ended if number else None, self.state)
        if stage.pull:
            self.state = model.lay_out_lines(self.state)
        for stage_step in range(max(1, self.state.step - first + 1), stage.steps + 1):
            model = self._follow(model, workspace, length)
            if self.state.step % (self.scene.output.checkpoint or AFRESH) == 0:
                workspace.systems.assemble_afresh()     # as a run does that is continued from a checkpoint
            try:
                self.state, report = outer_step(model, workspace, self.state, length, stage.pull, control)
            except StepError as failure:
                self._add_hints(failure)
                raise
            self.evaluation, self.increment, self.backtrack = report.evaluation, control.dt, control.backtrack
            self.solver_memory = workspace.systems.choice.memory()
            # points have gone to other processes
            if self.model.soil.grid.nodes is not None and report.soil is not self.model.soil:
                self.model, model = self.model.with_soil(report.soil), model.with_soil(report.soil)
            record, lost = self._record(stage.name, stage_step, report, model.scheme)
            yield record
            if lost:
                raise StepError(f"stopped after step {self.state.step}, whose state is kept: {lost}")

    def _follow(self, model, workspace, length):
        """The `model` of a stage, with the grid for the place of the bodies in the next step of this `length` [s]."""
        if self.moving_grid:
            self.model, self.state, moved = self.moving_grid.follow(self.model, self.state)
            if moved:
                model = model.with_soil(self.model.soil)
                workspace.renew(model)
        if self.carried_grid:
            model, self.state = self.carried_grid.follow(model, self.state, workspace, length)
            self.model = self.model.with_soil(model.soil)
        return model

    def _add_hints(self, failure):
        """Add to the message of a failure, which keeps its kind, what the scene and the state have to do with it."""
        texts = [str(failure), *self.warned, *overstretched_domains(self.model, self.state.points)]
        failure.args = (". ".join(texts),)

    def stage_model(self, number, starts):
        """Model of the stage of a `number`, from 0, that starts at a time [s]."""
        stage = self.scene.stages[number]
        loads = self.model.loads.during(starts, stage.steps * self.scene.step_of(stage), stage.gravity)
        return self.model.for_stage(stage.held, stage.beta, stage.gamma, loads, number, starts)

    def _control(self, length, begun):
        """Control of a stage with outer steps of `length` [s]; one that has `begun` goes on from its last increment."""
        time, cell = self.scene.time, self.model.soil.grid.smallest_cell
        return Control(begun and self.increment or length, time.smallest or length / (4096 if time.accuracy else 64),
                       time.accuracy and time.accuracy * cell, bool(begun and self.backtrack))

    def _record(self, stage, stage_step, report, scheme):
        """(Record of a step, why the run cannot go on or "")."""
        state = self.state
        with timing.phase("energy"):
            energy = energies(self.model, state, report.evaluation)
            energy["error"] = balance_error(energy, self._start_energy)
        view = StepView(self.model, state, scheme, report, energy, state.step == self.total_steps)
        record = step_record((stage, stage_step), state, report, energy, copies(self.mirrors),
                             self._monitors.notes(view, self._initial_notes()))
        return record, self._monitors.stop(view)

    def _initial_notes(self):
        """Notes that go with the first step of the run."""
        if self.state.step != 1:
            return ()
        if self.imbalance is None or self._hazards:
            return self.warned
        return self.warned + self._imbalance_notes

    @property
    def _imbalance_notes(self):
        stage = self.scene.stages[0]
        return self.imbalance.notes(stage, self.model.scheme.with_pair(stage.beta, stage.gamma),
                                    self.scene.step_of(stage), "settled at the start" in self.start)
