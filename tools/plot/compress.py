"""The fields of a run in less room: the same numbers in compressed files, which ParaView and the tools read as before.

    python -m tools.compress RUN [--single]

Rewrites each fields_*.vtu of fields.pvd, or the one field file of a steady flow, in place (zlib), one after
another; a call that is stopped leaves whole files, and a later one goes on. --single: values with 4 bytes a
number where they have 8. Units and values are untouched. Exit statuses: 0 done, 3 bad input.
"""
import meshio
import numpy as np

from tools.base.command import BadInput, Parser
from tools.base.mesh_files import read_vtu
from tools.base.run_folder import RunFolder
from tools.base.tables import whole


def compress(path, single=False):
    """Rewrites a .vtu file compressed, unless it is; its sizes before and after, in bytes. Raises BadInput for one
    that is not whole."""
    before = path.stat().st_size
    with open(path, "rb") as stream:
        packed = b"compressor=" in stream.read(400)
    if packed and not single:
        return before, before
    data = read_vtu(path)
    data.cells = [meshio.CellBlock(block.type, block.data.astype(np.int32)) for block in data.cells]
    if single:
        data.point_data = {name: np.asarray(values, np.float32) for name, values in data.point_data.items()}
    with whole(path) as part:
        meshio.write(part, data, file_format="vtu", compression="zlib")
    return before, path.stat().st_size


def parser():
    """The options."""
    options = Parser(prog="python -m tools.compress", description=__doc__)
    options.add_argument("run", help="run folder, such as results/pipe_obstacles/default")
    options.add_argument("--single", action="store_true", help="values with 4 bytes a number")
    return options


def main(words=None):
    """Compress the fields and print the sizes; 0."""
    given = parser().parse_args(words)
    run = RunFolder(given.run)
    if run.status == "running" and run.alive:
        raise BadInput(f"the run {given.run} is still running: compress its fields when it has ended")
    paths = [path for _, path in run.fields] or [run.field_file()]
    sizes = np.array([compress(path, given.single) for path in paths], float).sum(axis=0) / 1e6
    print(f"{len(paths)} field{'s' * (len(paths) > 1)}: {sizes[0]:.1f} MB before, {sizes[1]:.1f} MB after")
    return 0
