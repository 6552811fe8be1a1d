"""tools.transport_table: fates of particles over classes of diameter."""
import json

import numpy as np
import pytest

from tools.base.command import BadInput
from tools.base.run_folder import RunFolder
from tools.transport.fates import fates, main as transport_table, table_of


def carried(folder, diameters, status="finished", **parameters):
    """A run of transport, made up: the particles pass the pipe in half a second, and leave it."""
    folder.mkdir()
    records = [f"0,{t},{k},{2 * t},0,0,2,0,0,{d / 2}" for t in (0, 0.25, 0.5) for k, d in enumerate(diameters)]
    (folder / "particles.csv").write_text("\n".join(["step,t,id,x,y,theta,u,v,omega,radius", *records]) + "\n")
    exits = [f"0.5,{k},1,0,2,0,{d / 2},2500,1" for k, d in enumerate(diameters)]
    (folder / "exits.csv").write_text("\n".join(["t,id,x,y,u,v,radius,density,outlet", *exits]) + "\n")
    (folder / "run.json").write_text(json.dumps({"case": "pipe_transport", "status": status, "parameters": {f"-{name}": value
        for name, value in parameters.items()}}))
    return RunFolder(folder)


def test_the_table_counts_every_particle_once(tmp_path):
    """Also those beyond the classes of the paper; the last row is all."""
    records = table_of([carried(tmp_path / "a", [0.005, 0.012, 0.028, 0.07]), carried(tmp_path / "b", [0.012, 0.09])])
    assert sum(row[2] for row in records[:-1]) == records[-1][2] == 3
    assert records[-1][3:5] == [100, 0]


def test_fates_are_what_the_table_says(tmp_path):
    """Tracks drawn by hand: of each particle its times, x (at the first and the last of them), y, a time with u < 0 and at which x,
    and its outlet (-1: still there)."""
    tracks = {0: ((0, 1), (0.1, 0.9), 0, 0, 0, 1),  # carried through
              1: ((0, 2), (0.1, 0.2), 0, 0, 0, -1),  # before the diaphragm for two seconds
              2: ((1.2, 2), (0, 0.2), 0, 0, 0, -1),  # on its way
              3: ((0, 2), (0, 0.6), 0, 0.04, 0.5, -1),  # behind it, carried back for too short a time
              4: ((0, 2), (0, 0.6), 0, 0.06, 0.5, -1),  # long enough
              5: ((0, 1.5), (0, 0.2), 0, 0.2, 0.1, 0),  # carried back before it; left, but not by the outlet
              6: ((0, 2), (0, 0.9), -0.085, 0, 0, 1),  # along the bottom: 5 mm above it
              7: ((0, 2), (0, 0.9), -0.075, 0, 0, 1)}  # 15 mm above it
    lines, left, step = ["step,t,id,x,y,theta,u,v,omega,radius"], ["t,id,x,y,u,v,radius,density,outlet"], 0.02
    for t in np.arange(0, 2 + step / 2, step):
        for one, ((start, end), (first, last), y, back, where, outlet) in tracks.items():
            if start - 1e-9 <= t <= end + 1e-9 - step * (outlet >= 0):
                x = first + (last - first) * (t - start) / (end - start)
                u = -1 if back and where <= x and t < start + (end - start) * (where - first) / (last - first) + back - 1e-9 else 1
                lines.append(f"0,{t},{one},{x},{y},0,{u},0,0,0.01")
    left += [f"{end},{one},{last},{y},1,0,0.01,2500,{outlet}" for one, ((_, end), (_, last), y, _, _, outlet) in tracks.items()
        if outlet >= 0]
    for name, text in (("particles.csv", lines), ("exits.csv", left)):
        (tmp_path / name).write_text("\n".join(text) + "\n")
    (tmp_path / "run.json").write_text(json.dumps({"case": "pipe_transport", "status": "finished", "parameters": {}}))
    sizes, found = fates(RunFolder(tmp_path))
    assert sizes == pytest.approx(0.02)
    assert {name: list(np.flatnonzero(values)) for name, values in found.items()} == {
        "carried through": [0, 6, 7], "trapped": [1], "behind": [3, 4], "recirculation": [4], "bottom": [6]}


@pytest.mark.parametrize("diameters, words, says", [
    ([], {}, "holds no particles"),
    ([0.02], {"status": "failed (4)"}, "not come to its end"),
    ([0.02], {"length": 2}, "-length 2"),
])
def test_the_table_refuses_runs_that_it_cannot_judge(tmp_path, diameters, words, says):
    with pytest.raises(BadInput, match=says):
        table_of([carried(tmp_path / "run", diameters, **words)])


def test_a_run_counts_once_in_the_table(tmp_path):
    with pytest.raises(BadInput, match="given twice"):
        transport_table(["--runs", "results/a", str(tmp_path), "results/../results/a"])


@pytest.mark.parametrize("name, text, says", [
    ("exits.csv", "a,b\n1,2\n", "exits.csv has no column id"),
    ("exits.csv", "t,id,outlet\n0.5,0,nan\n", "exits.csv, line 2: outlet is nan"),
    ("particles.csv", "step,t,id,x,y,theta,u,v,omega,radius\n0,0,0,nan,0,0,2,0,0,0.01\n", "particles.csv, line 2: x is nan"),
    ("run.json", '{"status": "finished", "parameters": {"-radius": "wide"}}', '-radius must be a number, not "wide"'),
])
def test_the_table_names_what_is_damaged(tmp_path, name, text, says):
    run = carried(tmp_path / "run", [0.012])
    (tmp_path / "run" / name).write_text(text)
    with pytest.raises(BadInput, match=says):
        table_of([RunFolder(run.folder)])


def test_the_table_is_of_one_scene(tmp_path, capsys):
    first, same, other = (carried(tmp_path / name, [0.012, 0.028], **given) for name, given in (("a", {"seed": 1, "vmax": 2}),
        ("b", {"seed": 2, "vmax": 2}), ("c", {"seed": 3, "vmax": 1})))
    assert len(table_of([first, same])) == 5
    with pytest.raises(BadInput, match=r"differ in -vmax \(2 and 1\)"):
        table_of([first, same, other])
    assert transport_table(["--runs", str(first.folder), "--out", str(tmp_path / "table")]) == 0
    said = capsys.readouterr().out
    assert "nan" not in said and "100.0       -" in said


def test_a_seed_counts_once_in_the_table(tmp_path):
    """Whatever the folders; another seed of the turbulence is another run."""
    one, again, other = (carried(tmp_path / name, [0.012], **{"seed": 4, "turbulence-seed": turbulence}) for name,
        turbulence in (("a", 1), ("b", 1), ("c", 2)))
    assert len(table_of([one, other])) == 5
    with pytest.raises(BadInput, match="both of -seed 4"):
        table_of([other, one, again])


def test_a_table_that_is_refused_leaves_nothing(tmp_path):
    run = carried(tmp_path / "run", [0.012])
    for words, says in ((["--runs", str(tmp_path / "none")], "no run folder"), (["--runs", str(run.folder), "-reynolds", "50"],
        "-reynolds is for runs that are made")):
        with pytest.raises(BadInput, match=says):
            transport_table([*words, "--out", str(tmp_path / "table")])
        assert not (tmp_path / "table").exists()
