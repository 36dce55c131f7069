"""Shipped geometries and demo scenes: found in a checkout, listed, copied, and named where a scene file is missing."""

import pytest

from hybrid import cli
from hybrid.runtime.data import DEMOS, GEOMETRY, copy_demo, demo_titles
from hybrid.runtime.errors import SceneError
from hybrid.scene.file import load_scene


def test_shipped_files_are_there():
    assert {"box.geo", "sphere.geo", "stockless_anchor.geo"} <= {path.name for path in GEOMETRY.iterdir()}
    titles = demo_titles()
    assert {"anchor", "slope"} <= set(titles) == {path.stem for path in DEMOS.glob("*.toml")}
    assert all(len(title) > 20 for title in titles.values())


@pytest.mark.parametrize("name", demo_titles())
def test_a_copied_scene_is_complete(name, tmp_path):
    copied = load_scene(copy_demo(name, tmp_path))
    assert all(body.geometry.parent == tmp_path / "geometry" and body.geometry.is_file() for body in copied.bodies)
    assert copied.name == load_scene(DEMOS / f"{name}.toml").name


def test_nothing_is_overwritten(tmp_path):
    (tmp_path / "geometry").mkdir()
    mine = tmp_path / "geometry" / "box.geo"
    mine.write_text("mine")
    scene = copy_demo("slope", tmp_path)
    assert mine.read_text() == "mine" and (tmp_path / "geometry" / "sphere.geo").is_file()
    with pytest.raises(SceneError, match=f"{scene}: exists already; remove it, or choose another folder by --to"):
        copy_demo("slope", tmp_path)


def test_a_folder_that_cannot_be_written(tmp_path):
    (tmp_path / "demos").write_text("a file")
    with pytest.raises(SceneError, match="demos.*cannot be written: .*--to"):
        copy_demo("slope", tmp_path)


def test_the_command_lists_and_copies(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    assert cli.main(["demos"]) == 0
    listed = capsys.readouterr().out.splitlines()
    assert [line.split()[0] for line in listed[1:]] == list(demo_titles())
    assert cli.main(["demos", "slope", "--to", "mine"]) == 0
    assert capsys.readouterr().out.splitlines()[-1] == "hybrid run mine/demos/slope.toml"
    assert cli.main(["demos", "nowhere"]) == 2
    assert "demo 'nowhere': no such shipped scene; there are ac14, anchor, " in capsys.readouterr().err


@pytest.mark.parametrize("given", ["anchor", "anchor.toml", "demos/anchor.toml"])
def test_a_missing_scene_of_a_shipped_name(given, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    with pytest.raises(SceneError, match=f"^{given}: no such scene file; .* copy it here with `hybrid demos anchor`$"):
        load_scene(given)
