"""tools.check: values, tolerances, alignment in time, and what it says of the worst place."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.conftest import run_tool
from tests.synthetic import write_csv, write_run
from tools.base.check import compare, main, tolerances
from tools.base.command import BadInput
from tools.base.tables import read_table, write_table


def table(path, times, values, name="u", ids=None):
    """A CSV with columns t (, id), name."""
    if ids is None:
        write_csv(path, ["t", name], zip(times, values))
    else:
        write_csv(path, ["t", "id", name], zip(times, ids, values))
    return path


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    return write_run(tmp_path_factory.mktemp("check") / "run")


def test_a_run_matches_itself(run):
    result = compare(run, run)
    assert result, result
    assert result.compared > 1000 and "within tolerance" in str(result)


def test_the_worst_place_is_named(run, tmp_path):
    other = write_run(tmp_path / "other")
    lines = (other / "particles.csv").read_text().splitlines()
    cells = lines[40].split(",")
    cells[3] = repr(float(cells[3]) + 0.01)
    lines[40] = ",".join(cells)
    (other / "particles.csv").write_text("\n".join(lines) + "\n")
    result = compare(other, run, ["x", "y"], rtol=1e-6)
    assert not result and result.failed == 1
    text = str(result)
    for part in ("particles.csv", "column x", f"t = {float(cells[1]):.9g}", f"id {int(cells[2])}", "got", "expected", "tolerance"):
        assert part in text


def test_a_column_brings_its_own_tolerance(tmp_path):
    a = table(tmp_path / "a.csv", [0, 1, 2], [1.0, 2.0, 3.0])
    b = table(tmp_path / "b.csv", [0, 1, 2], [1.0, 2.001, 3.0])
    assert not compare(b, a, ["u"])
    assert compare(b, a, ["u:1e-3"])
    assert not compare(b, a, ["u:1e-4"])
    assert compare(b, a, ["u:0:0.0011"])
    assert compare(b, a, {"u": (0, 0.0011)}) and compare(b, a, {"u": 1e-3})
    assert tolerances(["u", "v:1e-3", "y:0:2"], 1e-6, 0.5) == {"u": (1e-6, 0.5), "v": (1e-3, 0.5), "y": (0, 2)}


def test_gaps_are_compared_where_they_are_asked_for(tmp_path):
    a, b = write_run(tmp_path / "a"), write_run(tmp_path / "b")
    for folder, gap in ((a, 1e-16), (b, -2e-16)):
        write_csv(folder / "contacts.csv", "t,i,j,gap,nx,ny,impulse".split(","), [(0.1, 0, 1, gap, 0.0, 1.0, 2.0)])
    assert compare(b, a)
    assert not compare(b, a, ["gap"]) and compare(b, a, ["gap:0:1e-12"])


def test_times_are_aligned_from_either_side(tmp_path):
    fine, coarse = np.linspace(0, 1, 101), np.linspace(0, 1, 7)
    a = table(tmp_path / "fine.csv", fine, fine**2)
    b = table(tmp_path / "coarse.csv", coarse, coarse**2)
    assert compare(a, b, ["u"], rtol=0, atol=0.01**2 / 4)
    assert compare(b, a, ["u"], rtol=0, atol=0.01**2 / 4)  # the denser one is interpolated


def test_times_that_differ_by_more_than_rounding_are_interpolated(tmp_path):
    """A row a hundred-thousandth of the run beside the reference's is not taken for it."""
    reference = table(tmp_path / "a.csv", [0, 1, 2], [0, 1, 2])
    assert compare(table(tmp_path / "b.csv", [0, 1 + 1e-5, 2], [0, 1 + 1e-5, 2]), reference, ["u:1e-9"])
    assert compare(table(tmp_path / "c.csv", [0, 1 + 1e-10, 2], [0, 1, 2]), reference, ["u:1e-12"])  # rounding: the row itself


def test_the_rows_of_a_run_are_as_far_apart_as_most_of_them(tmp_path):
    """One gap among them does not let a later end lack."""
    reference = table(tmp_path / "a.csv", np.arange(11), np.arange(11))
    assert not compare(table(tmp_path / "b.csv", [0, 1, 2, 3, 7, 8], [0, 1, 2, 3, 7, 8]), reference, ["u"])


def test_a_reference_is_compared_with_the_table_of_its_name(tmp_path):
    """Also where another one has its columns too."""
    for folder, value in (("run", 1.0), ("reference", 2.0)):
        (tmp_path / folder).mkdir()
        table(tmp_path / folder / "fluid.csv", [0, 1], [1.0, 1.0], "energy")
        table(tmp_path / folder / "motion.csv", [0, 1], [value, value], "energy")
    result = compare(tmp_path / "run", tmp_path / "reference" / "motion.csv", ["energy"])
    assert not result and result.worst.file == "motion.csv"


def test_a_table_of_a_spreadsheet_is_read(tmp_path):
    """With the mark of its encoding; a column without a name is refused."""
    (tmp_path / "a.csv").write_bytes(b"\xef\xbb\xbft,u\r\n0,1\r\n1,2\r\n")
    assert list(read_table(tmp_path / "a.csv")) == ["t", "u"]
    (tmp_path / "b.csv").write_text("t,u,\n0,1,2\n")
    with pytest.raises(BadInput, match="empty or a repeated column name"):
        read_table(tmp_path / "b.csv")


def test_a_table_is_written_whole_with_twelve_digits(tmp_path):
    """Rows that break off leave the one that was there."""
    path = tmp_path / "a.csv"
    write_table(path, ["t", "u"], [[1 / 3, None], [2, -1e-9 / 3]], ["made up"])
    assert path.read_text() == "# made up\nt,u\n0.333333333333,\n2,-3.33333333333e-10\n"
    before = path.read_text()
    with pytest.raises(ZeroDivisionError):
        write_table(path, ["t", "u"], ([1, 1 / k] for k in (1, 0)))
    assert path.read_text() == before and [one.name for one in tmp_path.iterdir()] == ["a.csv"]
    path.write_text("# made up\n\nt,u\n \n1,2\n  # and so on\n")
    assert read_table(path)["u"] == [2]


def test_a_run_that_stops_early_fails(tmp_path):
    times = np.linspace(0, 1, 11)
    a = table(tmp_path / "whole.csv", times, times)
    b = table(tmp_path / "short.csv", times[:-1], times[:-1])
    result = compare(b, a)
    assert not result and "nothing at t = 1" in str(result)
    assert compare(a, b)  # a longer run is fine


def test_a_particle_may_enter_between_two_rows_of_a_coarser_run(tmp_path):
    fine = np.linspace(0, 1, 101)
    reference = table(tmp_path / "r.csv", fine[13:], fine[13:], ids=[4] * 88)
    coarse = np.linspace(0, 1, 11)[2:]
    assert compare(table(tmp_path / "c.csv", coarse, coarse, ids=[4] * 9), reference)
    late = coarse[1:]
    assert not compare(table(tmp_path / "d.csv", late, late, ids=[4] * 8), reference)


def test_particles_that_lack_or_are_too_many(tmp_path):
    times = np.tile(np.linspace(0, 1, 5), 2)
    two = table(tmp_path / "two.csv", times, times, ids=[0] * 5 + [7] * 5)
    one = table(tmp_path / "one.csv", times[:5], times[:5], ids=[0] * 5)
    assert "no row of id 7" in str(compare(one, two))
    assert "rows of id 7" in str(compare(two, one))
    assert compare(two, one, subset=True)


def test_rows_of_other_particles_do_not_mix(tmp_path):
    """Order within the file does not matter, each id is aligned by itself."""
    a = table(tmp_path / "a.csv", [0, 0, 1, 1], [1, 10, 2, 20], ids=[0, 1, 0, 1])
    b = table(tmp_path / "b.csv", [1, 0, 0, 1], [20, 10, 1, 2], ids=[1, 1, 0, 0])
    assert compare(a, b)


@pytest.mark.parametrize("bad", ["nan", "inf", "-inf"])
def test_what_is_not_finite_never_matches(tmp_path, bad):
    a = table(tmp_path / "a.csv", [0, 1], [1, 2])
    (tmp_path / "b.csv").write_text(f"t,u\n0,1\n1,{bad}\n")
    assert not compare(tmp_path / "b.csv", a, rtol=1e3)
    assert not compare(tmp_path / "b.csv", tmp_path / "b.csv")


@pytest.mark.parametrize("name, header", [("forces", "t,id,fx"), ("wallforces", "t,label,fx"), ("fluxes", "t,label,flux"),
    ("budget", "t,energy")])
def test_forces_and_budgets_are_compared_too(tmp_path, name, header):
    """Each particle and each label of the boundary by itself, where a folder is the reference."""
    who = (1, 2) if header.count(",") == 2 else (1,)
    rows = [[t, k, 10 * k + t] if len(who) == 2 else [t, 10 * k + t] for t in (0.0, 0.1, 0.2) for k in who]
    for folder, change in (("one", 0), ("other", 0.5)):
        (tmp_path / folder).mkdir()
        rows[-1][-1] += change
        write_csv(tmp_path / folder / f"{name}.csv", header.split(","), rows)
    assert compare(tmp_path / "one", tmp_path / "one")
    result = compare(tmp_path / "other", tmp_path / "one")
    assert not result and result.failed == 1 and f"{name}.csv" in str(result)


def test_a_reference_file_finds_its_table_in_the_run(run, tmp_path):
    rows = (run / "fluid.csv").read_text().splitlines()
    (tmp_path / "flux.csv").write_text("# source: made up\n" + "\n".join(rows[:20]) + "\n")
    assert compare(run, tmp_path / "flux.csv", ["flux_in", "flux_out"])


def test_contacts_need_rows_at_the_same_time(run, tmp_path):
    other = write_run(tmp_path / "other")
    lines = (other / "contacts.csv").read_text().splitlines()
    (other / "contacts.csv").write_text("\n".join(lines[:3] + lines[4:]) + "\n")
    assert compare(run, run, ["impulse"])
    assert "nothing at t" in str(compare(other, run, ["impulse"]))
    assert "the run has rows of i 0, j 1 at t" in str(compare(run, other, ["impulse"]))  # a contact too many
    assert compare(run, other, ["impulse"], subset=True)


def test_a_particle_of_which_no_value_is_compared_is_no_match(tmp_path):
    """Its only rows stand between those of the other table."""
    run = table(tmp_path / "run.csv", [0, 1, 2, 3, 2.5], [0, 1, 2, 3, 99], ids=[1, 1, 1, 1, 2])
    reference = table(tmp_path / "reference.csv", [0, 1, 2, 3, 3], [0, 1, 2, 3, 5], ids=[1, 1, 1, 1, 2])
    result = compare(run, reference)
    assert not result and "no value of id 2 could be compared" in str(result)


@pytest.mark.parametrize("text,words", [
    ("", "empty"), ("t,u\n0,1\n1\n", "line 3"), ("t,u\n0,x\n", "column u"), ("0,1\n1,2\n", "header"),
    ("t,u\n0,1\n0,2\n", "two rows"), ("t,t\n0,1\n", "repeated"), ("a,u\n0,1\n", "no column of time")])
def test_bad_tables_are_refused_in_words(tmp_path, text, words):
    good = table(tmp_path / "good.csv", [0, 1], [1, 2])
    (tmp_path / "bad.csv").write_text(text)
    with pytest.raises(BadInput, match=words):
        compare(tmp_path / "bad.csv", good)


def test_runs_that_were_cut_off_are_refused_on_either_side(run, tmp_path):
    path = write_run(tmp_path / "cut") / "fluid.csv"
    path.write_text(path.read_text()[:-3])
    table(tmp_path / "reference.csv", [0, 1], [1, 1], name="particles")
    for one, other in ((run, tmp_path / "cut"), (tmp_path / "cut", run), (tmp_path / "cut", tmp_path / "reference.csv")):
        with pytest.raises(BadInput, match="fluid.csv, line 102: the line has no end"):
            compare(one, other)


@pytest.mark.parametrize("columns", [["u:x"], ["u:1:2:3"], ["u:-1"], ["u:nan"], [":1"], ["u", "u"], [], ["w"]])
def test_bad_columns_are_refused(tmp_path, columns):
    good = table(tmp_path / "good.csv", [0, 1], [1, 2])
    with pytest.raises(BadInput):
        compare(good, good, columns)


def test_the_command_ends_with_0_1_3(tmp_path):
    a = table(tmp_path / "a.csv", [0, 1], [1, 2])
    b = table(tmp_path / "b.csv", [0, 1], [1, 3])
    assert main([str(a), str(a)]) == 0
    assert main([str(b), str(a), "--columns", "u:1e-3"]) == 1
    for words in ([str(a), str(tmp_path / "none.csv")], [str(a), str(a), "--rtol", "wide"], [str(a), str(a), "--rtol", "nan"],
        [str(a)]):
        done = run_tool("check", *words)
        assert done.returncode == 3 and done.stderr.startswith("error: ") and done.stderr.count("\n") == 1


reals = st.floats(-1e6, 1e6, allow_nan=False)


@settings(max_examples=60, deadline=None)
@given(values=st.lists(reals, min_size=2, max_size=20), at=st.integers(0, 19), size=st.floats(1e-9, 1e3),
       sign=st.sampled_from([-1, 1]))
def test_one_changed_value_is_found_where_it_stands(tmp_path_factory, values, at, size, sign):
    folder = tmp_path_factory.mktemp("h")
    at %= len(values)
    times = np.arange(len(values)) * 0.5
    changed = list(values)
    changed[at] += sign * size
    with open(folder / "a.csv", "w") as f, open(folder / "b.csv", "w") as g:
        for stream, numbers in ((f, values), (g, changed)):
            stream.write("t,u\n" + "".join(f"{t!r},{float(u)!r}\n" for t, u in zip(times.tolist(), numbers)))
    difference = abs(changed[at] - values[at])
    assert compare(folder / "b.csv", folder / "a.csv", rtol=0, atol=difference)
    if difference > 0:
        result = compare(folder / "b.csv", folder / "a.csv", rtol=0, atol=0.99 * difference)
        assert not result and result.failed == 1 and result.worst.time == times[at]


@settings(max_examples=40, deadline=None)
@given(slope=reals, start=reals, n=st.integers(2, 40), m=st.integers(2, 40))
def test_straight_lines_match_on_any_two_sets_of_times(tmp_path_factory, slope, start, n, m):
    folder = tmp_path_factory.mktemp("lines")
    for name, number in (("a", n), ("b", m)):
        times = np.linspace(0, 1, number)
        table(folder / f"{name}.csv", times, start + slope * times)
    assert compare(folder / "b.csv", folder / "a.csv", rtol=0, atol=1e-8 * (1 + abs(start) + abs(slope)))


def test_every_table_of_a_run_is_compared(tmp_path):
    for name, energy in (("run", 999), ("reference", 1)):
        (tmp_path / name).mkdir()
        (tmp_path / name / "motion.csv").write_text(f"step,t,kinetic_energy\n1,0.1,{energy}\n")
    assert not compare(tmp_path / "run", tmp_path / "reference", columns={"kinetic_energy": 1e-3})


def test_a_column_without_a_row_is_not_called_a_match(tmp_path):
    """Nothing of the impulses was compared where nothing touches; a column that the reference has not is still refused."""
    for name in ("run", "reference"):
        (tmp_path / name).mkdir()
        table(tmp_path / name / "fluid.csv", [0.1, 0.2], [1, 2], "top_speed")
        (tmp_path / name / "contacts.csv").write_text("t,i,j,impulse\n")
    result = compare(tmp_path / "run", tmp_path / "reference")
    assert result and "top_speed" in str(result) and "impulse" not in str(result)
    with pytest.raises(BadInput, match="no column angle"):
        compare(tmp_path / "run", tmp_path / "reference", columns=["top_speed", "angle"])
