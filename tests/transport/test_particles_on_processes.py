"""Point particles dealt out among several processes: the bytes of one process."""
import pytest

from tests.conftest import ROOT, make_mesh, run_freefem
from tests.processes import ranks

ON_EDGES = """real[int] x0(Th.nbe), y0(Th.nbe), r0(Th.nbe), d0(Th.nbe), u0(Th.nbe), v0(Th.nbe), w0(Th.nbe);
    for (int k = 0; k < Th.nbe; ++k) { int T = Th.be(k).Element;
        x0[k] = (1 - 1e-7)*Th[T][0].x + 1e-7*Th[T][1].x; y0[k] = (1 - 1e-7)*Th[T][0].y + 1e-7*Th[T][1].y; }
    r0 = 1e-4; d0 = 2500; u0 = 0; v0 = 0; w0 = 0; transportAppend(x0, y0, r0, d0, u0, v0, w0); """
TABLES = ("particles.csv", "entries.csv", "exits.csv", "contacts.csv")


@pytest.fixture(scope="module")
def pipe(tmp_path_factory):
    return make_mesh(tmp_path_factory.mktemp("mesh") / "pipe.mesh", "pipe_obstacles", "--size", 0.025)


def assert_same_bytes(one, many, names=TABLES):
    for name in names:
        assert (one / name).read_bytes() == (many / name).read_bytes(), name
    rows = [[line.split(",")[:10] for line in (folder / "steps.csv").read_text().splitlines()] for folder in (one, many)]
    assert rows[0] == rows[1]  # without the times of computing


def same(tmp_path, number, *words, names=TABLES):
    run_freefem(*words, "-out", tmp_path / "one")
    ranks(number, *words, "-out", tmp_path / "many")
    assert_same_bytes(tmp_path / "one", tmp_path / "many", names)
    return tmp_path / "many"


def test_particles_that_enter_and_leave(pipe, tmp_path):
    """With seeded turbulence and history, some on edges of the mesh; the checkpoint is that of one process."""
    text = (ROOT / "tests/transport/scripts/queue.edp").read_text()
    case = tmp_path / "edges.edp"
    case.write_text(text.replace("macro caseParticles() ", "macro caseParticles() " + ON_EDGES))
    words = [case, "-mesh", pipe, "-contacts", "0", "-tend", "0.08", "-checkpoint", "40"]
    folder = same(tmp_path, 2, *words, names=[*TABLES, "restart_000000040.txt"])
    assert len((folder / "exits.csv").read_text().splitlines()) > 3


@pytest.mark.slow
@pytest.mark.parametrize("number, words", [
    (3, ["cases/given_flow.edp", "-contacts", "0", "-number", "7", "-tend", "0.9", "-history", "1", "-magnus", "1"]),
    (2, ["cases/given_flow.edp", "-contacts", "1", "-number", "7", "-tend", "0.3"]),
    (2, ["cases/pipe_transport.edp", "-contacts", "0", "-tend", "0.4", "-forces", "all"]),
])
def test_cases(tmp_path, number, words):
    same(tmp_path, number, *words)


@pytest.mark.slow
def test_a_checkpoint_serves_any_number_of_processes(pipe, tmp_path):
    words = ["tests/transport/scripts/queue.edp", "-mesh", pipe, "-contacts", "0", "-checkpoint", "20"]
    ranks(3, *words, "-tend", "0.06", "-out", tmp_path / "run")
    ranks(2, *words, "-tend", "0.1", "-restart", tmp_path / "run")
    run_freefem(*words, "-tend", "0.1", "-out", tmp_path / "whole")
    assert_same_bytes(tmp_path / "whole", tmp_path / "run")


@pytest.mark.slow
def test_a_case_that_reads_particles_has_them_all(pipe, tmp_path):
    text = (ROOT / "tests/transport/scripts/queue.edp").read_text()
    case = tmp_path / "reads.edp"
    case.write_text(text.replace("macro caseParticles() ",
        'macro caseStep() real[int] own = [timeNow, particleNumber]; outRow("mine.csv", own); // EOM\nmacro caseParticles() '))
    same(tmp_path, 2, case, "-mesh", pipe, "-contacts", "0", "-tend", "0.04", names=[*TABLES, "mine.csv"])


@pytest.mark.slow
def test_two_way_coupling_is_refused(pipe):
    run = ranks(2, "tests/transport/scripts/queue.edp", "-mesh", pipe, "-coupling", "two-way", check=False)
    lines = [line for line in run.stderr.splitlines() if line.startswith("error: ")]
    assert run.returncode == 3 and len(lines) == 1 and "two-way" in lines[0], run.stdout[-2000:] + run.stderr
