"""Energy of a closed box whose lid drives fluid and a free disk."""
import numpy as np
import pytest

from tests.scenes import case
from tools.run_folder import RunFolder

# The lid moves faster in its middle than at its ends, where it meets the walls; nothing of the budget is taken from the library: the shear at the lid, the strain and the
# kinetic energy of fluid and disk (twice as heavy) are integrated here.
LID = """macro boundaryU() (16*(x*(1 - x))^2) // EOM
macro caseStart() outHeader("lid.csv", "t,work,dissipation,energy"); // EOM
macro caseStep() {
    Wh lidU, lidV;
    lidU[] = flowU; lidV[] = flowV;
    real[int] lidRow = [timeNow, int1d(Th, labelTop)(mu*(dy(lidU) + dx(lidV))*lidU), int2d(Th)(mu*(2*dx(lidU)^2 + 2*dy(lidV)^2 + (dy(lidU) + dx(lidV))^2)), int2d(Th)(0.5*rhoFluid*(lidU^2 + lidV^2))];
    outRow("lid.csv", lidRow);
} // EOM
"""


def budget(freefem_text, folder, cells, dt):
    folder.mkdir()
    text = f'int[int] sides = [13, 12, 14, 11];\nsavemesh(square({cells}, {cells}, label = sides, flags = 2), "{folder}/box.mesh");\n'
    text += case("bodyDisk(0.45, 0.6, 0.12, 2);", walls="labelLeft, labelRight, labelBottom", moving="labelTop", mu=0.05, gravity=-1, more=LID)
    freefem_text(text, "-mesh", folder / "box.mesh", "-dt", dt, "-cfl", 0, "-every", 0, "-tend", 1, "-out", folder / "run")
    run = RunFolder(folder / "run")
    table, disk = run.table("lid"), run.particles
    area, moment = np.pi * 0.12**2, np.pi * 0.12**4 / 2  # the disk's own mass over the fluid's that it displaces: 2 - 1 is not in the integral of the mesh
    energy = table["energy"] + 0.5 * area * (disk["u"]**2 + disk["v"]**2) + 0.5 * moment * disk["omega"]**2
    fallen = area * (0.6 - disk["y"])
    steps = np.diff(table["t"])
    sums = {name: np.concatenate([[0], np.cumsum(0.5 * (table[name][1:] + table[name][:-1]) * steps)]) for name in ("work", "dissipation")}
    return table["t"], sums, energy - energy[0], fallen - fallen[0]


@pytest.mark.parametrize("cells, dt, most", [(16, 0.02, 0.01), (24, 0.01, 0.004)])
def test_the_work_of_a_lid_is_stored_lifts_a_disk_or_is_dissipated(cells, dt, most, freefem_text, tmp_path):
    """Four and six elements across the disk, from 0.2 s on, behind the start at once. 1.4 % of the work lifts the disk, 3.6 % is kinetic energy, the rest is dissipated."""
    t, sums, energy, fallen = budget(freefem_text, tmp_path / "lid", cells, dt)
    begin = np.searchsorted(t, 0.2)
    work, dissipated, stored, given = (values[-1] - values[begin] for values in (sums["work"], sums["dissipation"], energy, fallen))
    assert given < -0.01 * work and stored > 0.03 * work
    assert abs(work + given - dissipated - stored) < most * work
