"""Flows of other programs of which it is doubtful what they say: several velocities, two planes that differ."""
import re

import meshio
import numpy as np
import pytest

from tools.base.command import BadInput
from tools.flow.main import main

N = 4
X, Y = (one.ravel() for one in np.meshgrid(np.arange(2 * N + 1) / N, np.arange(N + 1) / N))
FIRST = np.array([row * (2 * N + 1) + k for row in range(N) for k in range(2 * N)])
QUADS = np.column_stack([FIRST, FIRST + 1, FIRST + 2 * N + 2, FIRST + 2 * N + 1])
FLOW = np.column_stack([Y * (1 - Y), 0 * X, 0 * X])
SIDES = ["--label", "inlet=x<1e-6", "--label", "outlet=x>1.9999", "--label", "wall=rest"]


def made(tmp_path, capsys, *words, **arrays):
    meshio.Mesh(np.column_stack([X, Y, 0 * X]), [("quad", QUADS)], point_data=arrays).write(tmp_path / "flow.vtu")
    assert main([str(tmp_path / "flow.vtu"), *SIDES, *words, "--out", str(tmp_path / "out")]) == 0
    return float(re.search(r"largest speed (\S+) m/s", capsys.readouterr().out).group(1))


def test_velocities_that_differ_under_two_names_are_asked_for(tmp_path, capsys):
    """The first of a list of names was taken in silence."""
    two = {"U": FLOW, "velocity": 2 * FLOW}
    for arrays in (two, {"u": FLOW[:, 0], "v": FLOW[:, 1], "velocity": 2 * FLOW}):
        with pytest.raises(BadInput, match="--velocity says which"):
            made(tmp_path, capsys, **arrays)
    assert made(tmp_path, capsys, "--velocity", "velocity", **two) == pytest.approx(0.5)
    assert made(tmp_path, capsys, "--velocity", "U", **two) == pytest.approx(0.25)
    assert made(tmp_path, capsys, U=FLOW, velocity=FLOW) == pytest.approx(0.25)


def test_a_slab_whose_two_planes_differ_is_no_plane_flow(tmp_path, capsys):
    """The lower one was taken in silence."""
    n = len(X)
    for factor in (1, 1.1):
        meshio.Mesh(np.concatenate([np.column_stack([X, Y, 0 * X + z]) for z in (0, 0.1)]), [("hexahedron", np.hstack([QUADS,
            QUADS + n]))], point_data={"U": np.concatenate([FLOW, factor * FLOW])}).write(tmp_path / "slab.vtu")
        words = [str(tmp_path / "slab.vtu"), *SIDES, "--out", str(tmp_path / "out")]
        if factor == 1:
            assert main(words) == 0 and "largest speed 0.25 m/s" in capsys.readouterr().out
        else:
            with pytest.raises(BadInput, match="between the two planes of its cells the velocity differs by up to 0.025 m/s"):
                main(words)
