"""Under a locale with decimal commas, in which awk may read 1.5 as 1: the same results, byte for byte."""
import os
import subprocess

import pytest

from tests.conftest import run_freefem

LOCALES = {"LANG": "fr_FR.UTF-8", "LC_ALL": "fr_FR.UTF-8", "LC_NUMERIC": "fr_FR.UTF-8"}
RUNS = {  # a case of each driver, and the table that is compared
    "resolved, with particles of a file": (["cases/template.edp", "-tend", 0.005, "-particles", "{0}/one.csv"], "particles.csv"),
    "flow": (["cases/poiseuille.edp", "-tend", 0.02], "mesh.mesh"),
    "steady laminar": (["cases/cavity.edp", "-reynolds", 10], "lines.csv"),
    "contacts": (["cases/falling_particles.edp", "-number", 5, "-tend", 0.2], "particles.csv"),
    "transport": (["tests/transport/scripts/analytic.edp", "-tend", 0.02], "particles.csv"),
    "projection": (["scripts/project_velocities.edp", "-bodies", "tests/data/contact/random_50_bodies.csv", "-walls",
        "tests/data/contact/random_50_walls.csv"], ""),
}


@pytest.fixture(scope="module")
def commas(tmp_path_factory):
    """The environment of a locale with decimal commas."""
    folder = tmp_path_factory.mktemp("locales")
    made = subprocess.run(["localedef", "-i", "fr_FR", "-f", "UTF-8", folder / "fr_FR.UTF-8"], capture_output=True, text=True)
    environment = os.environ | LOCALES | {"LOCPATH": str(folder)}
    point = subprocess.run(["locale", "decimal_point"], env=environment, capture_output=True, text=True).stdout
    if point != ",\n":
        pytest.skip(f"no locale with decimal commas can be made here: {made.stderr.strip()[:200]}")
    return environment


@pytest.mark.parametrize("driver", RUNS)
def test_a_case_computes_the_same(driver, commas, tmp_path, monkeypatch):
    words, table = RUNS[driver]
    (tmp_path / "one.csv").write_text("id,x,y,radius,density\n7,0.7,2.5,0.2,2.25\n")
    words = [str(word).format(tmp_path) for word in words]
    run_freefem(*words, "-out", tmp_path / "points")
    for name in (*LOCALES, "LOCPATH"):
        monkeypatch.setenv(name, commas[name])
    run_freefem(*words, "-out", tmp_path / "commas")
    assert (tmp_path / "commas" / table).read_bytes() == (tmp_path / "points" / table).read_bytes()


def test_a_run_continues_the_same(commas, tmp_path, monkeypatch):
    """Rows after the checkpoint stayed in the tables without a word."""
    words = ["cases/falling_particles.edp", "-number", 5, "-dt", 0.015, "-every", 0, "-checkpoint", 4, "-tend"]
    run_freefem(*words, 0.36, "-out", tmp_path / "whole")
    run_freefem(*words, 0.27, "-out", tmp_path / "broken")
    max((tmp_path / "broken").glob("restart_*.sha")).unlink()  # as if killed before it was written
    for name in (*LOCALES, "LOCPATH"):
        monkeypatch.setenv(name, commas[name])
    run_freefem(*words, 0.36, "-restart", tmp_path / "broken")
    assert (tmp_path / "broken/particles.csv").read_bytes() == (tmp_path / "whole/particles.csv").read_bytes()
