"""Numbers that are none: seen wherever they stand in an array (FreeFEM's linfty, min and max see a nan in the last place only)."""
import re

import pytest

from tests.conftest import ROOT

TRANSPORT = """include "lib/case.idp"
optCase("finite", "test");
real rhoFluid = 1000, mu = 0.001, gravityX = 0, gravityY = 0, none = sqrt(-1. - clock());
macro carrierExact(px, py, t) carrierU = 0.; {flow} // EOM
macro caseParticles() {{
    real[int] x0 = [0., 0.05, 0.1], y0 = [0., 0., 0.], r = [0.01, 0.01, 0.01], d = [2500., 500., 500.], u0 = [1., 1., 1.], z = [0., 0., 0.];
    {particles}
    transportAppend(x0, y0, r, d, u0, z, z);
}} // EOM
include "scripts/transport.edp"
"""


def test_every_place_is_looked_at(freefem_text):
    done = freefem_text("""
        include "lib/core/errors.idp"
        real none = sqrt(-1. - clock());
        real[int] a(4), empty(0);
        cout << "seen " << arrayFinite(empty);
        a = 1e90; cout << arrayFinite(a) << " ";
        for (int k = 0; k < 4; ++k) { a = 1.; a[k] = none; cout << arrayFinite(a); a[k] = 1e400; cout << arrayFinite(a); a[k] = -1e400; cout << arrayFinite(a); }
        a = [1e400, -1e400, 1., 1.]; cout << arrayFinite(a) << endl;
    """)
    assert "seen 11 " + 13 * "0" in done.stdout


@pytest.mark.parametrize("particles, flow, status, words", [
    ("r[0] = none;", "", 3, "a radius or a density that is not finite"),
    ("d[1] = none;", "", 3, "a radius or a density that is not finite"),
    ("u0[0] = none;", "", 3, "a position or velocity that is not finite"),
    ("x0[1] = none;", "", 3, "a position or velocity that is not finite"),
    ("", "if (t > 0.02) carrierU[0] = none;", 4, "no longer finite"),
])
def test_a_carried_particle_without_numbers_is_refused(freefem_text, run_folder, particles, flow, status, words):
    done = freefem_text(TRANSPORT.format(particles=particles, flow=flow), "-out", run_folder, "-tend", 0.05, "-dt", 0.01,
        "-contacts", 0, check=False)
    assert done.returncode == status and words in done.stderr and len(done.stderr.strip().splitlines()) == 1


def test_the_residual_of_contacts_sees_them(freefem_text):
    done = freefem_text("""
        include "lib/contact/constraints.idp"
        real[int] l = [0., 1., 0.], w = [1., 0., 1.];
        contactRowOfL.resize(3); contactRowOfW.resize(3); contactRowOfL = 1.; contactRowOfW = 1.;
        l[1] = sqrt(-1. - clock());
        cout << "large " << (contactNatural(l, w) > 1e200) << endl;
    """)
    assert "large 1" in done.stdout


def test_a_wrong_solver_is_seen_by_its_nan(freefem_text):
    done = freefem_text("""
        include "lib/core/solver_check.idp"
        int[int] I = [0, 1, 2];
        real[int] c = [1., 1., 1.], b = [1., 1., 1.];
        matrix A = [I, I, c], F = [I, I, c];
        set(A, solver = UMFPACK);
        b[0] = sqrt(-1. - clock());
        solverCheck(A, F, b, c, 1e-8, "the solver");
    """, check=False)
    assert done.returncode == 4 and "the solver is wrong" in done.stderr


def test_no_guard_trusts_the_largest_entry():
    bad = [f"{path.name}: {line.strip()}" for folder in ("lib", "scripts") for path in sorted((ROOT / folder).rglob("*.*"))
        for line in path.read_text().splitlines()
           if re.search(r"!\([^)]*\.(linfty|min|max)\b", line) and "arrayFinite" not in line]
    # a short cut, which a nan does not take; radii and densities that arrayFinite has seen in the line before
    known = ("move.idp: int beside = ", "particles.idp: if (!(particleRadius.min > 0 ",
        "particles.idp: if (!(particleDensity.min > 0 ")
    assert [line for line in bad if not line.startswith(known)] == []
