"""An OpenFOAM case that is divided among processors gives the flow of the whole one."""
import numpy as np
import pytest

from tests.conftest import ROOT
from tools.base.command import BadInput
from tools.flow import openfoam
from tools.flow.openfoam_files import Foam

PIPE = ROOT / "tests/data/openfoam_pipe"
HEAD = "FoamFile { version 2.0; format ascii; class x; object x; }\n"


def rows(values):
    """A list of numbers or vectors as text."""
    lines = [f"({' '.join(f'{one:.9g}' for one in row)})" if np.ndim(row) else str(row) for row in values]
    return f"{len(lines)}\n(\n" + "\n".join(lines) + "\n)\n"


def divided(folder, bounds=(0.31, 0.6)):
    """The steady time of the pipe in parts between these places along it, without what the parts do not need."""
    base = PIPE / "constant/polyMesh"
    points, faces, owner = Foam(base / "points").plain("vector"), Foam(base / "faces").faces(), Foam(base / "owner").plain("label")
    entries, _ = Foam(PIPE / "4/U").entries()
    patches, inner = openfoam.patches_of(base), min(run.start for _, run in openfoam.patches_of(base).values())
    middle = np.zeros(owner.max() + 1)
    for face, cell in zip(faces, owner):
        middle[cell] = points[face, 0].mean()
    part = np.searchsorted(bounds, middle)
    for k in range(len(bounds) + 1):
        cells = np.flatnonzero(part == k)
        number = np.full(len(part), -1)
        number[cells] = np.arange(len(cells))
        mine, boundary, values = [face for face in range(inner) if number[owner[face]] >= 0], [], []
        begin = len(mine)
        for name, (kind, run) in patches.items():
            some = [face for face in run if number[owner[face]] >= 0]
            boundary.append(f"{name} {{ type {kind}; nFaces {len(some)}; startFace {begin}; }}")
            begin += len(some)
            mine += some
            given = entries["boundaryField"][name]
            if isinstance(given.get("value"), np.ndarray):
                value = given["value"][[face - run.start for face in some]]
                values.append(f"{name} {{ type fixedValue; value nonuniform List<vector> {rows(value)}; }}")
            else:
                values.append(f"{name} {{ type {given['type']}; }}")
        boundary.append(f"procBoundary{k}to9 {{ type processor; nFaces 0; startFace {begin}; }}")
        used = np.unique(np.concatenate([faces[face] for face in mine]))
        place = np.full(len(points), -1)
        place[used] = np.arange(len(used))
        home = folder / f"processor{k}"
        (home / "constant/polyMesh").mkdir(parents=True)
        (home / "4").mkdir()
        texts = {"points": rows(points[used]), "owner": rows(number[owner[mine]]),
            "faces": f"{len(mine)}\n(\n" + "".join(f"{len(faces[face])}({' '.join(map(str, place[faces[face]]))})\n"
                for face in mine) + ")\n", "boundary": f"{len(boundary)}\n(" + "\n".join(boundary) + ")\n"}
        for name, text in texts.items():
            (home / "constant/polyMesh" / name).write_text(HEAD + text)
        (home / "4/U").write_text(HEAD + f"internalField nonuniform List<vector> {rows(entries['internalField'][cells])};\n"
            f"boundaryField {{ {' '.join(values)} }}\n")
    return folder


def test_a_case_in_parts_is_the_whole_one(tmp_path):
    whole, parts = openfoam.read(PIPE, "4:4", None), openfoam.read(divided(tmp_path), "last", None)
    assert parts.points.shape == whole.points.shape and len(parts.polygons) == len(whole.polygons) and parts.times == whole.times

    def cells(flow):
        """Middles of the cells with their velocities, in the order of the places."""
        middles = np.array([flow.points[one].mean(axis=0) for one in flow.polygons]).round(6)
        return np.column_stack([middles, flow.frames[0]["u"], flow.frames[0]["v"]])[np.lexsort(middles.T)]
    np.testing.assert_allclose(cells(parts), cells(whole), atol=1e-6)

    def sides(flow, name):
        """Middles of the sides of a patch, with the velocity there."""
        middles = flow.points[flow.sides[name]].mean(axis=1).round(6)
        return np.column_stack([middles, *flow.on_sides[0][name].values()])[np.lexsort(middles.T)]
    assert set(parts.sides) == set(whole.sides)
    for name in whole.sides:
        np.testing.assert_allclose(sides(parts, name), sides(whole, name), atol=1e-6)


def test_parts_of_other_times_are_refused(tmp_path):
    divided(tmp_path, (0.5,))
    (tmp_path / "processor1/4").rename(tmp_path / "processor1/5")
    with pytest.raises(BadInput, match="do not have the same times"):
        openfoam.read(tmp_path, "last", None)
