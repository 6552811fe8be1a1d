"""Ways that particles shut (lib/shut.idp): which they are, and how a run ends whose inflow has none left."""
import json

import pytest

from tests.conftest import standard_alone
from tests.test_boundaries import case

# an inlet on the left, two outlets on the right with a piece of wall between them, an island
FORK = """
border below(s = 0, 2) {{ x = s; y = 0; label = 13; }}
border low(s = 0, 0.4) {{ x = 2; y = s; label = 2; }}
border between(s = 0.4, 0.6) {{ x = 2; y = s; label = 5; }}
border high(s = 0.6, 1) {{ x = 2; y = s; label = 12; }}
border above(s = 2, 0) {{ x = s; y = 1; label = 14; }}
border into(s = 1, 0) {{ x = 0; y = s; label = 1; }}
border island(s = 0, 2*pi) {{ x = 1 + 0.15*cos(s); y = 0.5 + 0.15*sin(s); label = 6; }}
savemesh(buildmesh(below(20) + low(4) + between(2) + high(4) + above(20) + into(10) + island(-16)), "{file}");
"""
# who presses what (labels of walls, 100 and 101 the particles themselves), and who shuts the way then
PRESSES = {"from wall to wall": ("[0, 0]", "[13, 14]", "1 0"), "from a wall to the island": ("[0, 0]", "[13, 6]", "-1"), "past the island": ("[0, 0, 1, 1]", "[13, 6, 6, 14]", "1 0 1"),
           "one of two outlets": ("[0, 0]", "[14, 5]", "-1"), "both outlets": ("[0, 0, 1, 1]", "[14, 5, 5, 13]", "1 0 1"), "each other only": ("[0]", "[101]", "-1"),
           "two places of a wall": ("[0, 0]", "[14, 14]", "-1"), "a chain of two": ("[0, 0, 1]", "[13, 101, 14]", "1 0 1"), "a chain and one beside it": ("[0, 0, 1]", "[13, 14, 13]", "1 0 1")}


LOOK = """macro shutLook(those, walls) {
    int[int] who = those, what = walls, found(0);
    contactN = who.n;
    contactI.resize(contactN) = who; contactJ.resize(contactN) = what; contactImpulse.resize(contactN) = 1.;
    for (int k = 0; k < contactN; ++k) {
        contactJ[k] -= 100;
        if (what[k] < 100) for (int s = 0; s < contactSN; ++s) if (contactSLabel[s] == what[k]) contactJ[k] = -1 - s;
    }
    cout << "shut " << shutInlet(found);
    for (int k = 0; k < found.n; ++k) cout << " " << bodyId[found[k]];
    cout << endl;
} // EOM
"""


def test_ways_are_shut_from_wall_to_wall_only(freefem_text, tmp_path):
    # a macro's argument must not hold a comma, so the lists are arrays
    lists = "".join(f"int[int] who{k} = {who}, what{k} = {what};\n" for k, (who, what, _) in enumerate(PRESSES.values()))
    step = f"macro caseStep() {{ {' '.join(f'shutLook(who{k}, what{k})' for k in range(len(PRESSES)))} }} // EOM\n"
    text = case("{ bodyDisk(0.4, 0.3, 0.15, 2); bodyDisk(1.5, 0.7, 0.15, 2); }", walls="labelBottom, labelTop, labelObstacle, labelCylinder", moving="labelInlet", outlet="labelOutlet, labelRight",
                more="macro boundaryU() (4*y*(1 - y)) // EOM\n" + lists + LOOK + step)
    done = freefem_text(FORK.format(file=tmp_path / "fork.mesh") + standard_alone(text), "-mesh", tmp_path / "fork.mesh", "-dt", 0.001, "-tend", 0.001, "-out", tmp_path / "run")
    found = [line.removeprefix("shut ") for line in done.stdout.splitlines() if line.startswith("shut ")]
    assert dict(zip(PRESSES, found)) == {name: shut for name, (_, _, shut) in PRESSES.items()}


@pytest.mark.parametrize("cfl, status", [(1.5, 4), (0, 0)])
def test_a_run_whose_throat_is_shut_ends_in_words(cfl, status, freefem, coarse, tmp_path):
    """The steps went down to 1e-6 s without a word. With fixed steps the run goes on, as the disk rests as it should."""
    disk = tmp_path / "disk.csv"
    disk.write_text("id,x,y,radius,density\n5,0.2,0,0.06,1000\n")
    done = freefem("cases/pipe_obstacles.edp", "-mesh", coarse, "-number", 0, "-particles", disk, "-ramp", 0.05, "-cfl", cfl, "-dt", 0.004, "-every", 0.02, "-tend", 0.2, "-out", tmp_path / "run", check=False)
    assert done.returncode == status
    lines = done.stderr.splitlines()
    if status:
        assert len(lines) == 1 and "the fluid let in by label 1 (inlet) cannot reach an outlet: particle 5 closes the throat from wall to wall" in lines[0]
        assert json.loads((tmp_path / "run/run.json").read_text())["status"] == "failed (4)"
