"""The main case, short: particles in the pipe with obstacles, on a coarse mesh."""
import json
import textwrap

import numpy as np
import pytest

from tests.conftest import make_mesh, run_freefem
from tests.tables import distances_to_segments
from tools.base.run_folder import RunFolder
from tools.new import judged

CASE = "cases/pipe_obstacles.edp"
SHORT = ["-tend", "0.5", "-number", "12", "-first", "0", "-ramp", "0.05", "-every", "0.005"]
RADIUS, LENGTH = 0.1, 1.0


def read(folder, name):
    return np.genfromtxt(folder / name, delimiter=",", names=True)


@pytest.fixture(scope="module")
def short_run(coarse, tmp_path_factory):
    folder = tmp_path_factory.mktemp("pipe") / "run"
    run_freefem(CASE, "-mesh", coarse, "-out", folder, "-fields", "0.25", *SHORT, timeout=600)
    return folder


def solid_segments(mesh):
    """Ends of the boundary edges of walls, diaphragm and obstacle: two arrays (n, 2), m."""
    words = mesh.read_text().split()
    at = words.index("Vertices")
    count = int(words[at + 1])
    points = np.array(words[at + 2 : at + 2 + 3 * count], float).reshape(-1, 3)[:, :2]
    at = words.index("Edges")
    count = int(words[at + 1])
    edges = np.array(words[at + 2 : at + 2 + 3 * count], int).reshape(-1, 3)
    edges = edges[np.isin(edges[:, 2], [3, 4, 5])]
    return points[edges[:, 0] - 1], points[edges[:, 1] - 1]


def test_the_run_leaves_its_files(short_run):
    for name in ("run.json", "particles.csv", "fluid.csv", "contacts.csv", "fields.pvd", "mesh.mesh"):
        assert (short_run / name).is_file(), name
    run = json.loads((short_run / "run.json").read_text())
    assert run["status"] == "finished"
    assert run["parameters"]["-number"] == 12 and run["parameters"]["-scheme"] == "standard"
    assert run["units"]["-tend"] == "s"
    assert len(RunFolder(short_run).fields) == 3


def test_everything_is_finite_and_times_grow(short_run):
    for name in ("particles.csv", "fluid.csv"):
        table = read(short_run, name)
        for column in table.dtype.names:
            assert np.all(np.isfinite(table[column])), (name, column)
    t = read(short_run, "fluid.csv")["t"]
    assert np.all(np.diff(t) > 0) and t[-1] == pytest.approx(0.5, abs=1e-12)


def test_all_particles_enter_and_move_on(short_run):
    particles = read(short_run, "particles.csv")
    assert len(np.unique(particles["id"])) == 12
    last = particles[particles["t"] == particles["t"].max()]
    assert last["x"].max() > 0.5, "somebody has passed the diaphragm"


def test_nothing_overlaps(short_run):
    particles = read(short_run, "particles.csv")
    smallest = particles["radius"].min()
    for t in np.unique(particles["t"]):
        now = particles[particles["t"] == t]
        i, j = np.triu_indices(len(now), 1)
        gap = np.hypot(now["x"][i] - now["x"][j], now["y"][i] - now["y"][j]) - now["radius"][i] - now["radius"][j]
        assert len(gap) == 0 or gap.min() > -1e-6 * smallest, t


def test_nothing_leaves_the_pipe(short_run, coarse):
    particles = read(short_run, "particles.csv")
    inside = particles[particles["x"] < LENGTH]
    assert np.all(np.abs(particles["y"]) <= RADIUS - particles["radius"] * (1 - 1e-6))
    assert np.all(particles["x"] > 0)
    gap = distances_to_segments(inside["x"], inside["y"], *solid_segments(coarse)).min(1) - inside["radius"]
    assert gap.min() > -1e-6 * particles["radius"].min()
    # nobody tunnelled into a plate or a triangle
    plate = (np.abs(inside["x"] - 0.3) < 0.005) & (np.abs(inside["y"]) > 0.05)
    triangle = np.abs(inside["y"]) > 0.06 + 0.8 * np.abs(inside["x"] - 0.6)
    assert not plate.any() and not (triangle & (np.abs(inside["x"] - 0.6) < 0.05)).any()


def test_what_flows_in_flows_out(short_run):
    """The parabola brings 4/3 V R; the outflow differs by the divergence of the splitting only."""
    fluid = read(short_run, "fluid.csv")
    started = fluid["t"] > 0.06
    np.testing.assert_allclose(fluid["flux_in"][started], 4 / 3 * 2 * RADIUS, rtol=1e-6)
    np.testing.assert_allclose(fluid["flux_out"][started], fluid["flux_in"][started], rtol=0.03)
    assert np.mean(fluid["flux_out"][started] / fluid["flux_in"][started]) == pytest.approx(1, abs=0.003)


def test_the_same_seed_gives_the_same_csv_and_another_one_does_not(coarse, tmp_path):
    def particles(name, seed):
        options = ["-tend", "0.02", "-first", "0", "-interval", "0.005", "-ramp", "0.02", "-number", "3", "-seed", seed]
        run_freefem(CASE, "-mesh", coarse, "-out", tmp_path / name, *options)
        return (tmp_path / name / "particles.csv").read_bytes()

    one, again, other = particles("one", 3), particles("again", 3), particles("other", 4)
    assert one == again and one.count(b"\n") > 3
    assert one != other


def test_without_particles_nothing_is_done_for_them(coarse, tmp_path):
    run_freefem(CASE, "-mesh", coarse, "-out", tmp_path / "run", "-number", "0", "-tend", "0.05")
    fluid = read(tmp_path / "run", "fluid.csv")
    assert not fluid["particles"].any() and not fluid["contacts"].any()
    for name in ("particles.csv", "contacts.csv"):
        assert len((tmp_path / "run" / name).read_text().splitlines()) == 1


def test_the_published_scheme_runs_the_same_case(tmp_path):
    """Without particles the two schemes give one flow; with them both carry them on."""
    end = {}
    coarse, coarser = (make_mesh(tmp_path / f"{size}.mesh", "pipe_obstacles", "--size", size) for size in (0.02, 0.03))
    for scheme in ("published", "standard"):
        for number, dt, end_time, mesh in ((0, 0.0015, 0.027, coarse), (2, 0.003, 0.045, coarser)):
            folder = tmp_path / f"{scheme}{number}"
            options = ["-scheme", scheme, "-number", number, "-dt", dt]
            run_freefem(CASE, "-mesh", mesh, "-out", folder, "-tend", end_time, "-cfl", "0", "-first", "0", "-ramp", "0.02",
                *options)
            end[scheme, number] = read(folder, "fluid.csv")[-1]
        particles = read(tmp_path / f"{scheme}2", "particles.csv")
        assert np.isfinite(particles["x"]).all() and set(particles["id"]) == {0, 1}
        for one in (0, 1):
            x = particles["x"][particles["id"] == one]
            assert x[-1] > x[0]
    assert end["published", 0]["kinetic_energy"] == pytest.approx(end["standard", 0]["kinetic_energy"], rel=0.02)


BAD = [
    (["-tned", "0.2"], 3, "the nearest is -tend"),
    (["-mesh", "none.mesh"], 3, "cannot read the mesh file"),
    (["-mesh", "meshes/settling_disk.mesh"], 3, "the mesh reaches from"),
    (["-dmin", "0.03", "-dmax", "0.01"], 3, "above the largest"),
    (["-dmax", "0.25"], 3, "does not fit"),
    (["-particles", "{overlap}"], 5, "at the start"),
    (["-particles", "{outside}"], 5, "outside the mesh"),
    (["-particles", "{broken}"], 3, "missing or bad number"),
    (["-particles", "{header}"], 3, "first line"),
    (["-particles", "{twice}"], 3, "twice"),
    (["-particles", "{negative}"], 3, "radius"),
    (["-particles", "none.csv"], 3, "cannot read"),
    (["-mesh", "{truncated}"], 3, "ends too early"),
    (["-mesh", "{words}"], 3, "not a number"),
    (["-out", "/proc/nowhere"], 3, "cannot write"),
]


@pytest.mark.parametrize("words, status, says", BAD, ids=[" ".join(bad[0]) for bad in BAD])
def test_bad_input_is_refused_before_anything_is_computed(coarse, tmp_path, words, status, says):
    head = "id,x,y,radius,density\n"
    rows = {
        "overlap": head + "1,0.1,0,0.01,2500\n2,0.115,0,0.01,2500\n",
        "outside": head + "1,0.3,0.09,0.01,2500\n",
        "broken": head + "1,0.1,zero,0.01,2500\n",
        "header": "x,y\n1,2\n",
        "twice": head + "1,0.1,0,0.01,2500\n1,0.2,0,0.01,2500\n",
        "negative": head + "1,0.1,0,-0.01,2500\n",
        "truncated": "".join(coarse.read_text().splitlines(keepends=True)[:900]),
        "words": coarse.read_text().replace("Triangles", "Triangles ", 1).replace("\n0 ", "\nzero ", 1),
    }
    files = {}
    for name, text in rows.items():
        files[name] = tmp_path / name
        files[name].write_text(text)
    words = [word.format(**files) for word in words]
    if "-mesh" not in words:
        words += ["-mesh", str(coarse)]
    if "-out" not in words:
        words += ["-out", str(tmp_path / "run")]
    run = run_freefem(CASE, "-number", "1", "-tend", "0.01", *words, check=False)
    assert run.returncode == status, run.stdout[-500:] + run.stderr
    last = run.stderr.strip().splitlines()[-1]
    assert last.startswith("error: ") and says in last
    assert not (tmp_path / "run" / "particles.csv").exists()


def test_a_folder_that_holds_a_run_is_not_overwritten(coarse, tmp_path):
    options = ["-mesh", coarse, "-number", "0", "-tend", "0.004", "-out", tmp_path / "run"]
    run_freefem(CASE, *options)
    before = (tmp_path / "run" / "fluid.csv").read_bytes()
    run = run_freefem(CASE, *options, check=False)
    assert run.returncode == 3 and "already contains a run" in run.stderr
    assert (tmp_path / "run" / "fluid.csv").read_bytes() == before
    run_freefem(CASE, *options, "-overwrite", "1")


@pytest.mark.parametrize("name", sorted(__import__("cases").CASES))
def test_every_case_runs_a_few_steps(name, tmp_path):
    from tests.cases import CASES, COARSER

    mesh = ["-mesh", make_mesh(tmp_path / "coarser.mesh", name, *COARSER[name])] if name in COARSER else []
    run = run_freefem(f"cases/{name}.edp", *CASES[name], *mesh, "-out", tmp_path / "run", timeout=600)
    assert "results in" in run.stdout and "is used nowhere" not in run.stdout
    assert "No such file" not in run.stdout + run.stderr  # of a command of the shell
    lines, imports = judged(name, name)  # the test that tools.new writes for a case like this one
    exec(imports + textwrap.dedent(lines), {"run": RunFolder(tmp_path / "run")})
