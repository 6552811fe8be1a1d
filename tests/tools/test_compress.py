"""Fields in less room: tools.compress."""
import numpy as np
import pytest

from tests.conftest import run_tool
from tests.synthetic import write_run
from tools.base.run_folder import RunFolder


@pytest.mark.parametrize("single", [False, True])
def test_compressed_fields_hold_the_same_numbers_in_less_room(single, tmp_path):
    folder = write_run(tmp_path / "run", steps=10, fields=3, n=8)
    before = [RunFolder(folder).field(k) for k in range(4)]
    size = sum(path.stat().st_size for path in folder.glob("fields_*.vtu"))
    done = run_tool("compress", folder, *(["--single"] if single else []))
    assert done.returncode == 0 and done.stdout.startswith("4 fields: "), done.stderr
    assert sum(path.stat().st_size for path in folder.glob("fields_*.vtu")) < 0.65 * size
    for k, (mesh, values) in enumerate(before):
        grid, found = RunFolder(folder).field(k)
        assert np.array_equal(grid.points, mesh.points) and np.array_equal(grid.triangles, mesh.triangles)
        for name, array in values.items():
            assert np.array_equal(found[name], array.astype(np.float32) if single else array)
    once = [path.read_bytes() for path in sorted(folder.glob("fields_*.vtu"))]
    assert run_tool("compress", folder).returncode == 0
    assert [path.read_bytes() for path in sorted(folder.glob("fields_*.vtu"))] == once


def test_the_one_field_file_of_a_steady_flow_is_compressed(tmp_path):
    folder = write_run(tmp_path / "run", steps=10, fields=1, n=8)
    (folder / "fields_0.vtu").rename(folder / "fields.vtu")
    for path in (folder / "fields.pvd", *folder.glob("fields_*.vtu")):
        path.unlink()
    before, size = RunFolder(folder).field(0)[1]["velocity"], (folder / "fields.vtu").stat().st_size
    done = run_tool("compress", folder)
    assert done.returncode == 0 and done.stdout.startswith("1 field: "), done.stderr
    assert (folder / "fields.vtu").stat().st_size < 0.65 * size
    assert np.array_equal(RunFolder(folder).field(0)[1]["velocity"], before)


def test_runs_that_cannot_be_compressed_are_refused_in_a_line(tmp_path):
    folder = write_run(tmp_path / "run", steps=10)
    done = run_tool("compress", folder)
    assert done.returncode == 3 and "has no fields" in done.stderr and done.stderr.count("\n") == 1
    folder = write_run(tmp_path / "two", steps=10, fields=1, n=4)
    whole = (folder / "fields_0.vtu").read_bytes()
    (folder / "fields_0.vtu").write_bytes(whole[:500])
    done = run_tool("compress", folder)
    assert done.returncode == 3 and "fields_0.vtu" in done.stderr and (folder / "fields_0.vtu").read_bytes() == whole[:500]
