"""The messages of a run: warnings of its model sheet and notes of its steps, each once."""

from types import SimpleNamespace

from hybrid.study.failure.simulate import messages, simulate
from hybrid.study.scenes import soil_scene


def test_messages_are_listed_once():
    simulation = SimpleNamespace(sheet=lambda: {"warnings": ["a", "b"]})
    records = [SimpleNamespace(notes=("b", "c")), SimpleNamespace(notes=()), SimpleNamespace(notes=("c", "d"))]
    assert messages(simulation, records) == ("a", "b", "c", "d")


def test_all_steps_are_taken():
    simulation, records, texts = simulate(soil_scene(steps=2))
    assert len(records) == 2 == simulation.state.step and isinstance(texts, tuple)
