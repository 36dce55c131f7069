"""The background grid: axes, axes that go with a body, colouring of its cells."""
