"""Tables of time: values, integrals, and the files that they are read from."""

from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import quad

from hybrid.body.table import Table
from hybrid.runtime.errors import SceneError
from hybrid.scene.stage import table_rows

ROWS = ((0.5, 0.0, 1.0), (1.0, 2.0, 1.0), (4.0, -1.0, 3.0))


def test_values_are_linear_between_times_and_constant_beyond():
    table = Table.of(ROWS, 10.0, 2.0)
    np.testing.assert_allclose(table.at(0.0), [0.0, 2.0])
    np.testing.assert_allclose(table.at(10.75), [2.0, 2.0])
    np.testing.assert_allclose(table.at(12.5), [1.0, 4.0])
    np.testing.assert_allclose(table.at(99.0), [-2.0, 6.0])


@pytest.mark.parametrize("begin, end", [(0.0, 0.4), (0.2, 0.8), (0.6, 3.9), (0.0, 9.0)])
def test_integral_over_several_times(begin, end):
    table = Table.of(ROWS, 0.0)
    expected = [quad(lambda t, i=i: table.at(t)[i], begin, end, points=(0.5, 1.0, 4.0))[0] for i in (0, 1)]
    np.testing.assert_allclose(table.integral(begin, end), expected, atol=1e-10)


def test_numbers_rows_and_files(tmp_path):
    path = tmp_path / "force.csv"
    path.write_text("time,x,y,z\n# start\n0, 1, 2, 3\n\n1.5,4,5,6\n")
    assert table_rows(path, 4, "force") == ((0.0, 1.0, 2.0, 3.0), (1.5, 4.0, 5.0, 6.0))
    assert table_rows(0.2, 2, "velocity") == ((0.0, 0.2),)
    assert table_rows((1.0, 2.0, 3.0), 4, "force") == ((0.0, 1.0, 2.0, 3.0),)


@pytest.mark.parametrize("text, match", [
    ("0,1\n1,2,3\n", "line '1,2,3' must have 2 finite numbers"), ("a,b\n0,nan\n", "finite numbers"),
    ("0,1\n0,2\n", "times must increase"), ("time,value\n", "at least one row"), (None, "cannot be read")])
def test_files_that_are_no_tables_are_refused(tmp_path, text, match):
    path = tmp_path / "table.csv"
    if text is not None:
        path.write_text(text)
    with pytest.raises(SceneError, match=match):
        table_rows(Path(path), 2, "stage.0.motion.0.velocity")
