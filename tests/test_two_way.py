"""Two-way coupling: what the fluid gets, in closed forms (tools/transport_two_way.py), and what it leaves alone."""
import pytest

from tools import transport_two_way
from tools.validation import Context


@pytest.mark.parametrize("name", ["momentum", "approach", "settled", "sheet", "pipe"])
def test_two_way(name, tmp_path):
    for row in getattr(transport_two_way, name)(Context("two_way", tmp_path, 300, lambda line: None)):
        assert row.passed, f"{row.quantity}: {row.measured} (target {row.target}, {row.allowed}) {row.reason}"


def test_one_way_does_not_depend_on_what_two_way_takes_down(freefem, tmp_path):
    """A depth so large that the fluid answers below round-off: the same paths; the fluid's shallow answer is not."""
    words = ["-number", 9, "-tend", 0.05, "-mu", 0.01, "-drag", "constant", "-lift", 1, "-coupling-width", 0.05]
    for name, more in (("one", ["-coupling", "one-way"]), ("deep", ["-depth", 1e30]), ("shallow", ["-depth", 0.01])):
        freefem("tests/transport/cloud.edp", "-out", tmp_path / name, *words, *more)
    texts = [(tmp_path / name / "particles.csv").read_text() for name in ("one", "deep", "shallow")]
    assert texts[0] == texts[1] != texts[2]
    assert not (tmp_path / "one/coupling.csv").exists()


@pytest.mark.parametrize("words, part", [
    (["-coupling", "both"], "must be one of one-way|two-way"),
    (["-depth", "0"], "must be above 0"),
    (["-coupling-width", "-1"], "must be above 0"),
])
def test_bad_option_is_one_line_and_status_3(freefem, run_folder, words, part):
    done = freefem("cases/pipe_transport.edp", "-out", run_folder, *words, check=False)
    assert done.returncode == 3
    assert len(done.stderr.splitlines()) == 1 and part in done.stderr
