"""A checkpoint in parts: together they are the state of one process, bit for bit, and each process takes its share."""

from dataclasses import fields, replace

import numpy as np
import pytest
from fake_run import FakeSimulation

from hybrid.output import checkpoint
from hybrid.output import checkpoint_parts as parts
from hybrid.output.checkpoint_file import IN_PARTS, write
from hybrid.soil.parcels import rows
from hybrid.soil.split_merge import select
from hybrid.state import Ground, PointConstants, Population

PROCESSES = 3


def whole_state(moves):
    """State at step 5; of a grid that moves, with constants, and points left behind."""
    simulation = FakeSimulation()
    state, n = simulation.state_at(5), len(simulation.initial_position)
    if not moves:
        return state
    constants = PointConstants(simulation.initial_position, simulation.initial_half, np.full(n, 1e-3), np.full(n, 2.0))
    behind = select(Population(state.points, constants, np.ones((n, 2))), np.arange(7))
    layout = np.array([(0, 3), (0, 0), (1, 4)])
    return replace(state, ground=Ground(layout, layout + 1, np.ones((2, 1, 3), bool), constants, np.full((n, 2), 5.0),
                                        behind))


def save(folder, state, owner):
    """Write the parts of processes that own the points `owner` (n,) of a State, and their list."""
    folder.mkdir(exist_ok=True)
    number, n, names = np.arange(len(owner)), len(owner), []
    stamp = {"format": IN_PARTS, "run": "one", "state/step": state.step}
    for rank in range(PROCESSES):
        mine = owner == rank
        contacts = [rows(history, mine[history.point]) for history in state.contacts]
        contacts = [replace(history, point=np.searchsorted(number[mine], history.point)) for history in contacts]
        ground, points = state.ground, Population(state.points, state.ground.constants if state.ground else
                                                  PointConstants(*np.zeros((2, n, 3)), *np.zeros((2, n))), np.zeros((n, 2)))
        own = select(points, mine)
        if ground:
            behind = replace(ground.behind,
                             constants=replace(ground.behind.constants, number=n + np.arange(len(ground.behind))))
            ground = replace(ground, constants=replace(own.constants, number=number[mine]), rows=ground.rows[mine],
                             behind=select(behind, slice(rank, None, PROCESSES)))
        of_points, others = parts.arrays(replace(state, points=own.points, contacts=contacts, ground=ground), number[mine])
        names.append(parts.name(state.step, rank))
        write(folder / names[-1], stamp | of_points)
    write(folder / "checkpoint.npz", stamp | others | {"parts": names})
    return folder / "checkpoint.npz"


def owner(n, seed=3):
    return np.random.default_rng(seed).integers(0, PROCESSES, n)


def flat(state):
    return {name: np.asarray(value).tobytes() for name, value in checkpoint.flattened(state).items()}


@pytest.mark.parametrize("moves", [False, True])
def test_parts_together_are_the_state_of_one_process(tmp_path, moves):
    state = whole_state(moves)
    path = save(tmp_path, state, owner(len(state.points)))
    assert flat(checkpoint.load(path)) == flat(state)
    assert parts.size(path) == sum(file.stat().st_size for file in tmp_path.iterdir())


@pytest.mark.parametrize("by", ["parts", "one process"])
@pytest.mark.parametrize("moves", [False, True])
def test_shares_of_other_processes_are_each_point_once(tmp_path, moves, by):
    state = whole_state(moves)
    path = save(tmp_path, state, owner(len(state.points)))
    if by == "one process":
        checkpoint.save(path, state)
    shares = [checkpoint.load_share(path, None, lambda number, rank=rank: number % 2 == rank) for rank in range(2)]
    for rank, (share, number) in enumerate(shares):
        assert np.array_equal(number, np.arange(rank, len(state.points), 2))
        assert np.array_equal(share.points.stress, state.points.stress[number])
        (contact,), (every,) = share.contacts, state.contacts
        mine = every.point % 2 == rank
        for field in fields(every):
            assert np.array_equal(getattr(contact, field.name), getattr(every, field.name)[mine])
        if moves:
            assert np.array_equal(share.ground.constants.position, state.ground.constants.position[number])
            behind = share.ground.behind.constants
            assert np.array_equal(share.ground.behind.points.stress,
                                  state.ground.behind.points.stress[behind.number - len(state.points)])
    if moves:
        assert sum(len(share.ground.behind) for share, _ in shares) == len(state.ground.behind)


def test_a_part_of_another_checkpoint_or_none_is_refused(tmp_path):
    state = whole_state(False)
    path = save(tmp_path, state, owner(len(state.points)))
    part = tmp_path / parts.name(5, 1)
    kept = part.read_bytes()
    part.unlink()
    with pytest.raises(checkpoint.CheckpointError, match="_r1.npz does not exist"):
        checkpoint.load(path)
    part.write_bytes(kept[:100])
    with pytest.raises(checkpoint.CheckpointError, match="_r1.npz is not a readable checkpoint"):
        checkpoint.load(path)
    with np.load(save(tmp_path / "other", state, owner(len(state.points))).with_name(part.name)) as file:
        write(part, {**file, "run": "two"})
    with pytest.raises(checkpoint.CheckpointError, match="belongs to another checkpoint .run two, listed one"):
        checkpoint.load(path)


def test_one_process_that_goes_on_removes_the_parts(tmp_path):
    simulation = FakeSimulation()
    save(tmp_path, whole_state(False), owner(len(simulation.state.points)))
    (tmp_path / "checkpoint_notes_r.txt").touch()
    simulation.run([checkpoint.Checkpoints(tmp_path)])
    assert sorted(path.name for path in tmp_path.iterdir()) == ["checkpoint.npz", "checkpoint_notes_r.txt"]
