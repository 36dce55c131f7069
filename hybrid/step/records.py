"""Record of an accepted outer step, with those of bodies, joints and pairs, by the Evaluation that it ended with."""

import numpy as np

from hybrid.body.attitude import log_so3, quaternion
from hybrid.body.joints import Joint
from hybrid.body.rigid import FREEDOMS, line_ends
from hybrid.output.record import BodyRecord, JointRecord, PairRecord, Record
from hybrid.runtime import comm, timing
from hybrid.step.work import drive_name, load_name


def step_record(stage, state, report, energies, copies, notes):
    """Record of the outer step that led to `state`. stage: (its name, number of the step in it); report: its Report;
    energies: {name: [J]}; copies: of the model in the whole; notes: texts of monitors."""
    evaluation = report.evaluation
    return Record(
        step=state.step, stage=stage[0], stage_step=stage[1], time=state.time, dt=report.dt,
        increments=report.increments, iterations=report.iterations, rejections=report.rejections,
        residual=evaluation.error, contacts=int(comm.total([len(terms.contact) for terms in evaluation.bodies])),
        seconds=dict.fromkeys(timing.PHASES, 0.0) | timing.collect(), energies=energies,
        bodies=[body_record(terms, state, evaluation.joints) for terms in evaluation.bodies],
        joints=joint_records(evaluation), pairs=pair_records(evaluation), time_error=report.error,
        krylov=report.krylov, judged=report.judged, copies=copies, notes=notes)


def body_record(terms, state, joints):
    """BodyRecord of a body, by its BodyTerms at the step that led to `state`."""
    motion, contact = state.bodies[terms.step.number], terms.contact
    reaction, load, work = _guided(terms.step.body, motion, state.work)
    for guide, force in joints.guides() if joints else ():
        if guide.bodies[0] == terms.step.number:
            reaction[guide.name], work[guide.name] = force, state.work[drive_name(terms.step.body, guide.name)]
    return BodyRecord(
        terms.step.body.name, motion.position, quaternion(motion.rotation), motion.velocity, _spin(terms.step, motion),
        contact.resultant[:3], contact.resultant[3:], terms.trial.tension, contact.largest_overlap,
        reaction, load, work, mirrors=terms.step.body.mirrors,
        parts=terms.step.body.parts.forces(contact) if terms.step.body.parts else {},
        line_ends=_line_ends(terms.step.body.line, motion))


def _spin(step, motion):
    """Rate of turning (3,) [rad/s] in the body frame; without inertia, where no state has one, that of the last increment,
    as of the velocity."""
    if step.scheme.inertia or not step.body.free[3:].any():
        return motion.spin
    return log_so3(step.state.rotation.T @ motion.rotation) / step.dt


def _line_ends(line, motion):
    """Pull and angles of a line that cuts through soil, zero before it is laid out; None of others."""
    if line is None or line.soil is None:
        return None
    return (0.0,) * 4 if motion.target is None else line_ends(line, motion)


def joint_records(evaluation):
    """[JointRecord] of an Evaluation."""
    if evaluation.joints is None:
        return []
    terms = evaluation.joints
    return [JointRecord(joint.name, force, float(np.degrees(joint.angle(pair))) if joint.turning else None,
                        evaluation.bodies[joint.bodies[0]].step.body.mirrors)
            for joint, pair, force in zip(terms.step.joints, terms.pairs, terms.forces()) if isinstance(joint, Joint)]


def pair_records(evaluation):
    """[PairRecord] of an Evaluation."""
    if evaluation.pairs is None:
        return []
    bodies = [terms.step.body for terms in evaluation.bodies]
    return [PairRecord(*(bodies[number].name for number in pair.numbers), *evaluation.pairs.of_pair(index),
                       bodies[pair.numbers[0]].mirrors) for index, pair in enumerate(evaluation.pairs.step.pairs)]


def _guided(body, motion, work):
    """Reactions, loads and their work of a body, as fields of its BodyRecord."""
    guided = [name for name, free in zip(FREEDOMS, body.free) if not free]
    done = {name: work[drive_name(body, name)] for name in guided if drive_name(body, name) in work}
    if load_name(body) in work:
        done["load"] = work[load_name(body)]
    reaction = {} if motion.reaction is None else {name: motion.reaction[FREEDOMS.index(name)] for name in guided}
    return reaction, motion.load, done
