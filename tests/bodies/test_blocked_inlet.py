"""Ways that particles shut (lib/motion/blocked_inlet.idp): which they are, and how a run ends whose inflow has none left."""
import json
import re

import pytest

from tests.conftest import standard_alone
from tests.scenes import case

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
PRESSES = {"from wall to wall": ("[0, 0]", "[13, 14]", "1 0"), "from a wall to the island": ("[0, 0]", "[13, 6]", "-1"),
    "past the island": ("[0, 0, 1, 1]", "[13, 6, 6, 14]", "1 0 1"),
           "one of two outlets": ("[0, 0]", "[14, 5]", "-1"), "both outlets": ("[0, 0, 1, 1]", "[14, 5, 5, 13]", "1 0 1"),
               "each other only": ("[0]", "[101]", "-1"),
           "two places of a wall": ("[0, 0]", "[14, 14]", "-1"), "a chain of two": ("[0, 0, 1]", "[13, 101, 14]", "1 0 1"),
               "a chain and one beside it": ("[0, 0, 1]", "[13, 14, 13]", "1 0 1")}


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
    text = case("{ bodyDisk(0.4, 0.3, 0.15, 2); bodyDisk(1.5, 0.7, 0.15, 2); }", walls="labelBottom, labelTop, labelObstacle, "
        "labelCylinder", moving="labelInlet", outlet="labelOutlet, labelRight",
                more="macro boundaryU() (4*y*(1 - y)) // EOM\n" + lists + LOOK + step)
    done = freefem_text(FORK.format(file=tmp_path / "fork.mesh") + standard_alone(text), "-mesh", tmp_path / "fork.mesh", "-dt",
        0.001, "-tend", 0.001, "-out", tmp_path / "run")
    found = [line.removeprefix("shut ") for line in done.stdout.splitlines() if line.startswith("shut ")]
    assert dict(zip(PRESSES, found)) == {name: shut for name, (_, _, shut) in PRESSES.items()}


@pytest.mark.parametrize("cfl, status", [(1.5, 4), (0, 0)])
def test_a_run_whose_throat_is_shut_ends_in_words(cfl, status, freefem, coarse, tmp_path):
    """The steps went down to 1e-6 s without a word. With fixed steps the run goes on, as the disk rests as it should."""
    disk = tmp_path / "disk.csv"
    disk.write_text("id,x,y,radius,density\n5,0.2,0,0.06,1000\n")
    done = freefem("cases/pipe_obstacles.edp", "-mesh", coarse, "-number", 0, "-particles", disk, "-ramp", 0.05, "-cfl", cfl,
        "-dt", 0.004, "-every", 0.02, "-tend", 0.2, "-out", tmp_path / "run", check=False)
    assert done.returncode == status
    lines = done.stderr.splitlines()
    if status:
        assert len(lines) == 1 and "the fluid let in by label 1 (inlet) cannot reach an outlet: particle 5 closes the throat from wall to wall" in lines[0]
        assert json.loads((tmp_path / "run/run.json").read_text())["status"] == "failed (4)"


@pytest.mark.parametrize("order, turned", [([5, 0, 9, 3, 12, 7, 1, 10, 13, 4, 2, 8, 6, 11], 0),
    ([13, 12, 11, 10, 9, 8, 7, 6, 5, 4, 3, 2, 1, 0], 1)])
def test_ways_are_shut_wherever_the_list_of_edges_begins(order, turned, freefem_text, tmp_path):
    """The same scene, its borders in halves and in another order, which begin in the middle of an opening or a wall, and mirrored;
    a wall of the case that is none of the mesh stands in nobody's way."""
    text, halves = FORK.format(file=tmp_path / "fork.mesh"), []
    for line in text.strip().splitlines()[:-1]:
        name, low, high = re.match(r"border (\w+)\(s = (\S+), (.*?)\) \{", line).groups()
        for half, ends in (("A", f"{low}, 0.5*({low} + {high})"), ("B", f"0.5*({low} + {high}), {high}")):
            halves.append((name + half, re.sub(r"border \w+\(s = .*?\) \{", f"border {name}{half}(s = {ends}) {{", line)))
    edges = {"below": 10, "low": 2, "between": 1, "high": 2, "above": 10, "into": 5, "island": -8}
    mesh = "\n".join(line for _,
        line in halves) + f'\nmesh Fork = buildmesh({" + ".join(f"{halves[k][0]}({edges[halves[k][0][:-1]]})" for k in order)});\n'
    if turned:  # in the line y = 1/2: below and above change places
        mesh += "Fork = movemesh(Fork, [x, 1 - y]);\nint[int] other = [13, 14, 14, 13, 2, 12, 12, 2];\nFork = change(Fork, label = other);\n"
    mesh += f'savemesh(Fork, "{tmp_path / "fork.mesh"}");\n'
    presses = PRESSES | {f"a wall of the case and {label}": ("[0, 0]", f"[0, {label}]", "-1") for label in (13, 14)}
    lists = "".join(f"int[int] who{k} = {who}, what{k} = {what};\n" for k, (who, what, _) in enumerate(presses.values()))
    step = f"macro caseStep() {{ {' '.join(f'shutLook(who{k}, what{k})' for k in range(len(presses)))} }} // EOM\n"
    scene = case("{ bodyDisk(0.4, 0.3, 0.15, 2); bodyDisk(1.5, 0.7, 0.15, 2); contactWallSegment(0, 0, 0.1, 0.05); "
        "contactWallSegment(0, 1, 0.1, 0.95); }",
                 walls="labelBottom, labelTop, labelObstacle, labelCylinder", moving="labelInlet",
                     outlet="labelOutlet, labelRight", more="macro boundaryU() (4*y*(1 - y)) // EOM\n" + lists + LOOK + step)
    done = freefem_text(mesh + standard_alone(scene), "-mesh", tmp_path / "fork.mesh", "-dt", 0.001, "-tend", 0.001, "-out",
        tmp_path / "run")
    found = [line.removeprefix("shut ") for line in done.stdout.splitlines() if line.startswith("shut ")]
    assert dict(zip(presses, found)) == {name: shut for name, (_, _, shut) in presses.items()}


# two openings on the left with a piece of wall between them, through which `back` times as much comes in below as above; on the
# right an outlet, or an outlet and an opening without a wall between; a drain
POCKET = """
border below(s = 0, 2) {{ x = s; y = 0; label = 13; }}
border out(s = 0, 0.6) {{ x = 2; y = s; label = 2; }}
border beside(s = 0.6, 1) {{ x = 2; y = s; label = {beside}; }}
border above(s = 2, 0) {{ x = s; y = 1; label = 14; }}
border upper(s = 1, 0.6) {{ x = 0; y = s; label = 1; }}
border between(s = 0.6, 0.4) {{ x = 0; y = s; label = 5; }}
border lower(s = 0.4, 0) {{ x = 0; y = s; label = 11; }}
border hole(s = 0, 2*pi) {{ x = 1 + 0.15*cos(s); y = 0.5 + 0.15*sin(s); label = {hole}; }}
savemesh(buildmesh(below(20) + out(6) + beside(4) + above(20) + upper(7) + between(2) + lower(4) + hole(-16)), "{file}");
"""


@pytest.mark.parametrize("back, beside, hole, shut", [
    (-1, 2, 6, ["-1", "1 1", "1 0 1", "-1"]),  # what comes in above goes out below, unless somebody shuts one of the two off
    (0.5, 2, 6, ["(1|11) 0", "1 1", "(1|11) 0 1", "11 1"]),
    (-0.5, 2, 6, ["1 0", "1 1", "1 0 1", "-1"]),
    (-2, 2, 6, ["-1", "1 1", "1 0 1", "-1"]),
    (-1, 12, 6, ["-1", "1 1", "1 0 1", "-1"]),  # an opening with an outlet in it is one
    (0.5, 2, 4, ["-1", "-1", "-1", "-1"]),  # a drain in the middle, to which a way may be open
])
def test_what_comes_in_may_go_out_by_another_opening_on_the_same_side(back, beside, hole, shut, freefem_text, tmp_path):
    """From wall to wall; in the corner above; from wall to wall and in the corner below."""
    lists = "int[int] a = [0, 0], b = [13, 14], c = [1, 1], d = [5, 14], e = [0, 0, 1, 1], f = [13, 14, 13, 5], g = [1, 1], h = [13, 5];\n"
    step = "macro caseStep() { shutLook(a, b) shutLook(c, d) shutLook(e, f) shutLook(g, h) } // EOM\n"
    speed = f"(x > 1 ? 0.1 : (y > 0.5 ? 25*(y - 0.6)*(1 - y) : 25*{back}*y*(0.4 - y)))"
    scene = case("{ bodyDisk(1.5, 0.5, 0.15, 2); bodyDisk(0.4, 0.7, 0.15, 2); }", walls="labelBottom, labelTop, labelObstacle"
        + (", labelCylinder" if hole == 6 else ""), moving="labelInlet, labelLeft" + (", labelRight" if beside == 12 else ""),
                 outlet="labelOutlet" + (", labelDiaphragm" if hole == 4 else ""), more=f"macro boundaryU() {speed} // EOM\n"
                     + lists + LOOK + step)
    mesh = POCKET.format(file=tmp_path / "pocket.mesh", beside=beside, hole=hole)
    done = freefem_text(mesh + standard_alone(scene), "-mesh", tmp_path / "pocket.mesh", "-dt", 0.001, "-tend", 0.001, "-out",
        tmp_path / "run")
    found = [line.removeprefix("shut ") for line in done.stdout.splitlines() if line.startswith("shut ")]
    assert len(found) == 4 and all(re.fullmatch(one, said) for one, said in zip(shut, found)), found


def test_a_run_ends_when_a_way_was_shut_in_so_many_steps_in_a_row(freefem_text, tmp_path):
    """Thrice shut, once open, four times shut: the fourth is the end, with the first five of those who shut it."""
    bodies = " ".join(f"bodyDisk({0.2 + 0.25 * k}, {0.2 if k % 2 else 0.8}, 0.1, 2);" for k in range(7))
    lists = "int[int] who = [0, 1, 2, 3, 4, 5, 5], what = [101, 102, 103, 104, 105, 14, 14], acts = [0, 0];\n"
    press = """macro shutPress(last) { contactN = 7; contactI.resize(7) = who; contactJ.resize(7) = what; contactImpulse.resize(7) = 1.;
    for (int k = 0; k < 7; ++k) { contactJ[k] -= 100; if (what[k] < 100) for (int s = 0; s < contactSN; ++s) if (contactSLabel[s] == what[k]) contactJ[k] = -1 - s; }
    for (int s = 0; s < contactSN; ++s) if (contactSLabel[s] == last) { contactI[6] = 0; contactJ[6] = -1 - s; }
    cout << "told " << shutStop(1e-4, 0.5) << endl; } // EOM
"""
    step = "macro caseStep() { shutMost = 4; shutPress(13) shutPress(13) shutPress(13) shutPress(14) shutPress(13) shutPress(13) shutPress(13) shutPress(13) } // EOM\n"
    scene = case("{ " + bodies + " }", walls="labelBottom, labelTop", moving="labelLeft", outlet="labelRight",
        more="macro boundaryU() (4*y*(1 - y)) // EOM\n" + lists + press + step)
    box = f'int[int] sides = [13, 12, 14, 11];\nsavemesh(square(40, 20, [2*x, y], label = sides), "{tmp_path / "box.mesh"}");\n'
    done = freefem_text(box + standard_alone(scene), "-mesh", tmp_path / "box.mesh", "-dt", 0.001, "-tend", 0.001, "-out",
        tmp_path / "run", check=False)
    told = [line.removeprefix("told ") for line in done.stdout.splitlines() if line.startswith("told ")]
    assert told == ["1", "2", "3", "0", "1", "2", "3"] and done.returncode == 4
    assert "at t = 0.5 s the fluid let in by label 11 (left) cannot reach an outlet: particles 0, 1, 2, 3, 4 and others close the throat" in done.stderr
