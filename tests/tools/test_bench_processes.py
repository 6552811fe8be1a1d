"""tools.bench on several processes: the parts of a mesh, the model of a step, and its page, on numbers made by hand."""
import numpy as np
import pytest

from tools.base.command import BadInput
from tools.bench import processes
from tools.bench.partitions import Cost, Net, Share, largest_share, layers, line_through, model, net_of, shares

COST = Cost(node_s=1e-6, fixed_s=0.002, solve_s=0.003, passes=50, arrays=80, vertex_arrays=10, sums=20, numbers=1000)
NET = Net(message_s=2e-6, byte_s=1e-9, sum_s=3e-6)


def test_the_model_adds_up_what_was_measured():
    """1e5 nodes on 8 processes: 20 ms of nodes, 3 rounds of 20 sums, 50 messages to 4 neighbours, 8 bytes a number."""
    found = model(COST, Share(8, 100000, 20000, 4, 1000, 300), NET)
    assert found["nodes"] == pytest.approx(0.02) and found["fixed"] == 0.002 and found["systems"] == 0.003
    assert found["messages"] == pytest.approx(50 * 4 * 2e-6 + 8e-9 * (80 * 1000 + 10 * 300))
    assert found["sums"] == pytest.approx(20 * 3 * 3e-6 + 8e-9 * 1000 * 2 * 7 / 8)
    assert found["whole"] == pytest.approx(sum(value for name, value in found.items() if name != "whole"))
    alone = model(COST, Share(1, 100000, 100000, 0, 0, 0), NET)
    assert alone["whole"] == pytest.approx(0.105) and alone["messages"] == alone["sums"] == 0


def test_what_does_not_grow_with_the_mesh_is_read_from_two_meshes():
    assert line_through([100, 200], [0.3, 0.5]) == pytest.approx((0.002, 0.1))
    assert line_through([100, 200], [0.1, 0.5]) == pytest.approx((0.0025, 0))  # a smaller mesh that is faster than in proportion


def test_the_parts_of_a_strip_of_squares():
    """Four unit squares in a row, of two triangles each, the first two in part 0; one layer around each part."""
    lower, upper = np.arange(5), np.arange(5, 10)
    elements = np.array([[lower[k], lower[k + 1], upper[k + 1]] for k in range(4)]
        + [[lower[k], upper[k + 1], upper[k]] for k in range(4)])
    found = largest_share(elements, np.array([0, 0, 1, 1, 0, 0, 1, 1]), 1)
    # nodes: three squares of 3 x 3 in a row; part 1 takes the three of the middle line and the six of the square before it;
    # part 0 takes the six behind the middle line. Vertices: 4 and 2.
    assert found == Share(2, 27, 21, 1, 9 + 6, 4 + 2)


def test_a_mesh_is_divided_as_a_run_divides_it(tmp_path):
    """The default mesh of the settling disk on two processes: the nodes of a part, and what it takes from the other."""
    from tests.conftest import ROOT

    found = shares(ROOT / "meshes/settling_disk.mesh", [2, 4], tmp_path / "parts")
    assert found[2].whole == found[4].whole == 65 * 193 and layers() == 8  # 32 x 96 squares, and a node on each edge
    assert 0.5 < found[2].nodes / found[2].whole < 0.65 > found[4].nodes / found[4].whole > 0.25
    assert found[2].neighbours == 1 and found[2].vertices < found[2].entries / 3


def test_the_output_of_the_messages_is_read():
    assert net_of("message 8 2e-06\nmessage 800 1e-06\nmessage 8000 9e-06\nsum 4e-06\n") == Net(1e-6, pytest.approx(1e-9), 4e-6)


@pytest.mark.parametrize("scene", processes.SCENES[True], ids=lambda scene: scene.name)
def test_the_lines_at_which_messages_are_counted_still_stand(scene, tmp_path, monkeypatch):
    folder = processes.counting(tmp_path / "tree", scene)
    assert "benchCount[0] += 1" in (folder / "lib/core/parts_mpi.idp").read_text()
    monkeypatch.setattr(processes, "COUNTERS", (("lib/core/parts_mpi.idp", "func int gone()", ""),))
    with pytest.raises(BadInput, match="no line any more"):
        processes.counting(tmp_path / "tree", scene)


def test_the_page_tells_what_is_measured_and_what_is_a_model():
    scene = processes.SCENES[False][0]

    def run(step, counts=()):
        return processes.Run(60 * step, step, 50 * step, 100.0, counts)
    counts = (50.0, 80.0, 10.0, 20.0, 1000.0, 1.0)
    found = processes.Found(scene, {(1, 1): [run(0.06)] * 2, (1, 2): [run(0.03, (*counts, 0.001))], (2, 1): [run(0.1), run(0.11)],
        (2, 2): [run(0.06, (*counts, 0.003))]}, {1: 50000, 2: 100000}, {8: Share(8, 100000, 20000, 4, 1000, 300),
        2: Share(2, 100000, 55000, 1, 900, 300)}, NET)
    cost = processes.cost_of(found)
    assert cost.solve_s == 0.003 and cost.node_s == pytest.approx((0.1 - 0.003 - 0.059) / 50000)
    text = "\n".join(processes.processes_lines([found, processes.Found(scene, note="there is no mpiexec")]))
    for part in ("| 100,000 | 2 | 3.6 | 60.0 | 1.67, 1.67 |", "2: 100 %", "Model, not measured", "| 8 | 20,000 | 4 |",
        "there is no mpiexec"):
        assert part in text, text
