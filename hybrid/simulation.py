"""A run: stages of outer steps over a model and its state, told to observers."""

import logging
from dataclasses import replace
from functools import cached_property

import numpy as np

from hybrid.body import rigid
from hybrid.body.attitude import quaternion
from hybrid.linalg.system_cache import Systems
from hybrid.monitors import Monitors, StepView
from hybrid.monitors.failure_hints import overstretched_domains
from hybrid.monitors.initial_equilibrium import initial_imbalance
from hybrid.monitors.limits import limit_warnings
from hybrid.output.model_sheet import model_sheet
from hybrid.output.record import BodyRecord, Record
from hybrid.runtime import timing
from hybrid.runtime.errors import HybridError, StepError
from hybrid.runtime.memory import map_large_arrays
from hybrid.step import newton
from hybrid.step.energy import balance_error, energies
from hybrid.step.equations import Step
from hybrid.step.increments import Control, outer_step

log = logging.getLogger("hybrid")


class Simulation:
    """Scene, model and committed state, with what observers ask for; made by `hybrid.setup.build.build`."""

    def __init__(self, scene, model, state, meshes, travel=None, level=""):
        map_large_arrays()      # PETSc is loaded by now
        self.scene, self.model, self.state, self.meshes = scene, model, state, meshes
        self.level = level      # what the scene's `accuracy` has changed in it
        self.travel = travel    # None: the grid stays
        self.initial_bodies = list(state.bodies)
        self.surfaces = [b.surface for b in model.bodies]
        self.body_names = [b.name for b in model.bodies]
        self.masses = [b.mass for b in model.bodies]
        self.evaluation = None
        self.increment = None   # [s] that the next step of this stage tries first; None: all of it
        start = Step(model, state, scene.time.step, False, Systems(model))
        evaluation = start.evaluate(start.at_rest())
        self._start_energy = energies(model, state, evaluation)     # a body may start in the soil a little
        self.imbalance = initial_imbalance(start, evaluation)
        start.system.destroy()
        self._monitors = Monitors(model, state)

    @property
    def initial_position(self):
        """(n, 3) [m] of the points."""
        return self.model.soil.constants.position

    def resume(self, state, increment=None):
        """Go on from `state`, trying steps of `increment` [s] first."""
        self.state, self.increment = state, increment
        if self.travel:
            self.model = self.travel.model(self.model, state.ground)

    @property
    def total_steps(self):
        """Outer steps of all stages."""
        return sum(stage.steps for stage in self.scene.stages)

    def sheet(self):
        """What is modelled and what is left out, with sizes: {section: {label: value}}."""
        return {**model_sheet(self.scene, self.model, self.imbalance, self.level, self.most_points),
                **({"warnings": list(self.warned)} if self.warned else {})}

    @cached_property
    def warned(self):
        """Texts about the limits that the scene exceeds; they depend on nothing that changes in a run."""
        return limit_warnings(self.scene, self.model)

    @property
    def most_points(self):
        """Points that are solved at once, those included that the grid takes in when the body that it goes with has
        sunk."""
        now = len(self.state.points)
        return max(now, self.travel.points_when_sunk(self.model, self.state)) if self.travel else now

    def contact_forces(self, b):
        """Force of the soil on each surface vertex of body b at the last accepted step, (V, 3) [N]."""
        forces = np.zeros((len(self.surfaces[b].vertices), 3))
        if self.evaluation is not None:
            for part in self.evaluation.contacts[b].passes:
                vertices = self.surfaces[b].triangles[part.triangle]
                np.add.at(forces, vertices, part.weights[:, :, None] * part.force[:, None])
        return forces

    def run(self, observers=()):
        """Run the steps that are left; returns the summary dict that observers get too.

        Observers are told of the end however it comes: completed, failed (StepError is raised again) or interrupted.
        """
        summary = {"outcome": "completed", "reason": ""}
        for observer in observers:
            observer.start(self)
        try:
            for record in self.steps():
                for observer in observers:
                    observer.accepted(record, self)
        except KeyboardInterrupt:
            summary.update(outcome="interrupted", reason="stopped from the keyboard; continue with --resume")
            raise
        except HybridError as error:
            summary.update(outcome="failed", reason=str(error))
            raise
        except BaseException as error:
            summary.update(outcome="failed", reason=f"{type(error).__name__}: {error}")
            raise
        finally:
            self._finish(observers, summary)
        return summary

    def _finish(self, observers, summary):
        """Tell every observer of the end, also when one of them fails; that is raised unless the run itself failed."""
        failure = None
        for observer in observers:
            try:
                observer.finish(summary, self)
            except Exception as error:
                log.warning("%s failed at the end of the run: %s", type(observer).__name__, error)
                failure = failure or error
        if failure and summary["outcome"] == "completed":
            raise failure

    def steps(self):
        """Generator of a Record per accepted outer step, from the present state to the end of the last stage."""
        systems = Systems(self.model)
        try:
            yield from self._steps(systems)
        finally:
            systems.destroy()

    def _steps(self, systems):
        scene = self.scene
        settings = newton.Settings(
            scene.solver.tolerance, scene.solver.iterations, scene.solver.line_search, scene.solver.augmentations,
            scene.solver.augmentation_tolerance, scene.solver.linear_tolerance, scene.solver.loosest_tolerance)
        first, starts = 0, 0.0
        for stage in scene.stages:
            length = stage.step or scene.time.step
            begun = self.state.step > first
            control = self._control(length, begun)
            model = self.stage_model(stage, starts)
            systems.renew(model)
            if not begun:
                self.state = model.begin(self.state)
            if stage.pull:
                self.state = replace(self.state, bodies=[
                    rigid.lay_out_line(b, s) for b, s in zip(self.model.bodies, self.state.bodies)])
            for stage_step in range(max(1, self.state.step - first + 1), stage.steps + 1):
                if self.travel:
                    self.model, self.state, moved = self.travel.follow(self.model, self.state)
                    if moved:
                        model = model.on(self.model.soil)
                        systems.renew(model)
                try:
                    self.state, report = outer_step(
                        model, systems, self.state, length, stage.pull, control, settings)
                except StepError as failure:
                    failure.args = ". ".join(
                        [str(failure), *self.warned, *overstretched_domains(self.model, self.state.points)]),
                    raise
                self.evaluation, self.increment = report.evaluation, control.dt
                yield self._record(stage.name, stage_step, report, model.scheme)
            first, starts = first + stage.steps, starts + stage.steps * length

    def stage_model(self, stage, starts):
        """Model of a `stage` that starts at a time [s]."""
        length = stage.steps * (stage.step or self.scene.time.step)
        return self.model.for_stage(
            stage.held, stage.beta, stage.gamma, self.model.loads.during(starts, length, stage.gravity))

    def _control(self, length, begun):
        """Increment control of a stage with outer steps of `length` [s], which goes on as it was if it has `begun`."""
        time, cell = self.scene.time, self.model.soil.grid.smallest_cell
        return Control(begun and self.increment or length, time.smallest or length / (4096 if time.accuracy else 64),
                       time.accuracy and time.accuracy * cell)

    def _record(self, stage, stage_step, report, scheme):
        state, evaluation = self.state, report.evaluation
        with timing.phase("energy"):
            energy = energies(self.model, state, evaluation)
            energy["error"] = balance_error(energy, self._start_energy)
        bodies = []
        for name, motion, trial, contact in zip(
                self.body_names, state.bodies, evaluation.body_trials, evaluation.contacts):
            bodies.append(BodyRecord(
                name, motion.position, quaternion(motion.rotation), motion.velocity, motion.spin,
                contact.force[:3], contact.force[3:], trial.tension, contact.largest_overlap))
        return Record(
            step=state.step, stage=stage, stage_step=stage_step, time=state.time, dt=report.dt,
            increments=report.increments, iterations=report.iterations, rejections=report.rejections,
            residual=evaluation.error, contacts=sum(len(c) for c in evaluation.contacts), seconds=timing.collect(),
            energies=energy, bodies=bodies, time_error=report.error, krylov=report.krylov,
            notes=self._initial_notes() + self._monitors.notes(StepView(self.model, state, scheme, report, energy)))

    def _initial_notes(self):
        """What is told once, with the first step of all."""
        if self.state.step != 1:
            return ()
        stage = self.scene.stages[0]
        if self.imbalance is None:
            return self.warned
        return self.warned + self.imbalance.notes(stage, self.model.scheme.with_pair(stage.beta, stage.gamma))
