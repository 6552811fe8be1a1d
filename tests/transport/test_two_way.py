"""Two-way coupling: what the fluid gets, in closed forms (tools/validation/two_way.py), and what it leaves alone."""
import math
import re

import pytest

from tools.base.mesh_files import read_field
from tools.base.run_folder import RunFolder
from tools.base.tables import read_table
from tools.transport import coupling_effect
from tools.validation import Context
from tools.validation import two_way as transport_two_way


class Coarse(Context):
    """Comparisons on elements half as large again."""

    def mesh(self, recipe, size, *more):
        return super().mesh(recipe, 1.5 * size, *more)


@pytest.mark.parametrize("name", ["momentum", "approach", "settled", "sheet", "pipe"])
def test_two_way(name, tmp_path):
    for row in getattr(transport_two_way, name)(Coarse("two_way", tmp_path, 300, lambda line: None)):
        assert row.passed, f"{row.quantity}: {row.measured} (target {row.target}, {row.allowed}) {row.reason}"


def test_one_way_does_not_depend_on_what_two_way_takes_down(freefem, tmp_path):
    """A depth so large that the fluid answers below round-off: the same paths; the fluid's shallow answer is not."""
    words = ["-number", 9, "-tend", 0.05, "-mu", 0.01, "-drag", "constant", "-lift", 1, "-coupling-width", 0.05]
    for name, more in (("one", ["-coupling", "one-way"]), ("deep", ["-depth", 1e30]), ("shallow", ["-depth", 0.01])):
        freefem("tests/transport/scripts/cloud.edp", "-out", tmp_path / name, *words, *more)
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


BOX = """int[int] sides = [1, 2, 1, 1];
savemesh(square(16, 16, label = sides), "{mesh}");
include "lib/case.idp"
optCase("box", "spheres fly in a fluid at rest, two-way");
real rhoFluid = 1000, mu = 1e-3, gravityX = 0, gravityY = 0;
optDefault("-coupling", "two-way");
macro caseCarrier() {{ carrierWh u = 0., v = 0.; carrierFlow(u[], v[]); }} // EOM
macro caseTwoWay() twoWayHeld.resize(1); twoWayHeld = 1; twoWayInlet.resize(1); twoWayInlet = 1; twoWayOutlet.resize(1); twoWayOutlet = 2; twoWayBegin(timeStep); // EOM
macro caseParticles() {{
    real[int] x0 = [0.5, 0.3], y0 = [0.52, 0.4], r = [0.02, 0.01], d = [2500., 7000.], u0 = [1., 0.5], v0 = [0.2, -0.3], z = [0., 0.];
    transportAppend(x0, y0, r, d, u0, v0, z);
}} // EOM
include "scripts/transport.edp"
twoXh [a, b, q] = [0., 0., 0.];
a[] = twoWayW;
cout << "through " << int2d(Th)(a)/int2d(Th)(abs(a)) << endl;
"""


def test_a_fluid_at_rest_cannot_be_compressed_by_short_steps(freefem_text, tmp_path):
    """Nothing passes a section of a box with one open side (a share of 1e-2 did at the shorter steps, more the shorter)."""
    mesh = tmp_path / "box.mesh"
    done = freefem_text(BOX.format(mesh=mesh), "-mesh", mesh, "-coupling-width", 0.06, "-drag", "schiller-naumann", "-dt", 1e-5,
        "-tend", 1e-4, "-contacts", 0, "-out", tmp_path / "run")
    through = float(next(line for line in done.stdout.splitlines() if line.startswith("through")).split()[1])
    assert abs(through) < 1e-6


def test_what_a_floor_bears_does_not_reach_the_fluid(freefem_text, tmp_path):
    """A small sphere at rest, whose drag is fast: 14 % of its weight went into the fluid."""
    text = BOX.replace("x0 = [0.5, 0.3], y0 = [0.52, 0.4], r = [0.02, 0.01], d = [2500., 7000.], u0 = [1., 0.5], v0 = [0.2, -0.3]",
        "x0 = [0.5], y0 = [1e-4], r = [1e-4], d = [2500.], u0 = [0.], v0 = [0.]")
    text = text.replace("z = [0., 0.]", "z = [0.]").replace("gravityY = 0", "gravityY = -9.81").replace("macro caseTwoWay",
        "macro caseWallLabels() [1] // EOM\nmacro caseTwoWay")
    mesh = tmp_path / "box.mesh"
    freefem_text(text.format(mesh=mesh), "-mesh", mesh, "-coupling-width", 0.06, "-drag", "stokes", "-dt", 0.002, "-tend", 0.02,
        "-out", tmp_path / "run")
    weight = 1500 * 4 / 3 * 3.14159265 * 1e-12 * 9.81
    assert abs(RunFolder(tmp_path / "run").table("coupling")["force_y"]).max() < 1e-9 * weight


SOURCE = """mesh Th = square(10, 10);
include "lib/case.idp"
include "lib/transport/point_source.idp"
carrierWh fu = 0; carrierFlow(fu[], fu[]);
sourceBegin(0.1);
int n = 20000;
randinit(3);
real[int] px(n), py(n), fx(n), fy(n), s(sourceN), laid(sourceN);
for (int k = 0; k < n; ++k) px[k] = randreal1();
for (int k = 0; k < n; ++k) py[k] = randreal1();
for (int k = 0; k < n; ++k) fx[k] = randreal1() - 0.3;
for (int k = 0; k < n; ++k) fy[k] = randreal1() - 0.5;
carrierSample(px, py, 0);
real t0 = clock();
sourceSpread(fx, fy);
real spent = clock() - t0;
laid = 0.;
for (int k = 0; k < n; ++k) {
    int T = Th(px[k], py[k]).nuTriangle;
    real[int] l(3);
    for (int i = 0; i < 3; ++i) {
        real ax = Th[T][(i + 1) % 3].x, ay = Th[T][(i + 1) % 3].y, bx = Th[T][(i + 2) % 3].x, by = Th[T][(i + 2) % 3].y;
        l[i] = 0.5*((ax - px[k])*(by - py[k]) - (ay - py[k])*(bx - px[k]))/Th[T].area;
    }
    for (int i = 0; i < 3; ++i) laid[sourceQh(T, i)] += l[i]*fx[k];
}
s = sourceS^-1*laid; laid = sourceM*s; s = sourceS^-1*laid;
laid = s - sourceNodalX;
cout << "same " << laid.l2/s.l2 << " total " << abs(sourceTotalX - fx.sum) + abs(sourceTotalY - fy.sum) << " spent " << spent << endl;
"""


def test_the_source_of_many_particles_is_that_of_one_by_one_and_fast(freefem_text):
    """A loop over the particles took more than the time allowed here."""
    words = next(line for line in freefem_text(SOURCE).stdout.splitlines() if line.startswith("same ")).split()
    assert float(words[1]) < 1e-12 and float(words[3]) < 1e-9 and float(words[5]) < 0.15


def test_coupling_along_y_is_that_along_x(freefem_text, tmp_path):
    """A scene and its image in the line x = y, of which the mesh is its own image: fast spheres, whose flow needs the matrix
    anew."""
    image = {"sides = [1, 2, 1, 1]": "sides = [1, 1, 2, 1]", "x0 = [0.5, 0.3], y0 = [0.52, 0.4]": "y0 = [0.5, 0.3], x0 = [0.52, "
        "0.4]",
             "u0 = [10., 5.], v0 = [2., -3.]": "v0 = [10., 5.], u0 = [2., -3.]"}
    box = other = BOX.replace("u0 = [1., 0.5], v0 = [0.2, -0.3]", "u0 = [10., 5.], v0 = [2., -3.]")
    for word, instead in image.items():
        assert word in other
        other = other.replace(word, instead)
    runs = []
    for name, text in (("x", box), ("y", other)):
        freefem_text(text.format(mesh=tmp_path / f"{name}.mesh"), "-mesh", tmp_path / f"{name}.mesh", "-coupling-width", 0.06,
            "-depth", 0.002, "-lift", 1, "-drag", "schiller-naumann",
                     "-dt", 0.01, "-tend", 0.04, "-every", 0, "-contacts", 0, "-out", tmp_path / name)
        run = RunFolder(tmp_path / name)
        runs.append((run.particles, run.columns("coupling", "momentum_x", "momentum_y", "pressure_drop_change", "factorisations")))
    (along, flow), (across, flow1) = runs
    assert flow["factorisations"][-1] > 1
    for one, other in (("x", "y"), ("y", "x"), ("u", "v"), ("v", "u")):
        assert along[one] == pytest.approx(across[other], rel=1e-8, abs=1e-9)
    for one, other in (("momentum_y", "momentum_x"), ("pressure_drop_change", "pressure_drop_change")):
        assert flow[one] == pytest.approx(flow1[other], rel=1e-6, abs=1e-9) and abs(flow[one][-1]) > 1e-3


def made_up(folder, places, leaves, coupling=()):
    """A run of three particles, drawn by hand: places {id: x at 0, 1, 2 s}, leaves {id: time, outlet}; coupling: rows of
    coupling.csv."""
    folder.mkdir(parents=True)
    lines = [f"0,{t},{one},{x[t]},0,0,1,0,0,0.01" for t in (0, 1, 2) for one, x in places.items() if t < len(x)]
    (folder / "particles.csv").write_text("\n".join(["step,t,id,x,y,theta,u,v,omega,radius", *lines]) + "\n")
    (folder / "exits.csv").write_text("\n".join(["t,id,x,y,u,v,radius,density,outlet", *(f"{t},{one},1,0,1,0,0.01,2500,{outlet}"
        for one, (t, outlet) in leaves.items())]) + "\n")
    (folder / "run.json").write_text('{"case": "pipe_transport", "status": "finished", "parameters": {}}')
    if coupling:
        (folder / "coupling.csv").write_text("\n".join(["t,pressure_drop_change,speed_most,change_most,volume_fraction_most",
            *coupling]) + "\n")
    return folder


def test_the_effect_of_coupling_is_told_from_both_runs(tmp_path, monkeypatch, capsys):
    """Two of the three leave in both, 0.1 s later and 0.3 s earlier; the third lies 0.3 m further."""
    one = made_up(tmp_path / "one", {0: [0, 0.5], 1: [0, 0.4], 2: [0, 0.1, 0.2]}, {0: (1.5, 1), 1: (1.8, 1)})
    two = made_up(tmp_path / "two", {0: [0, 0.5], 1: [0, 0.6], 2: [0, 0.2, 0.5]}, {0: (1.6, 1), 1: (1.5, 1), 3: (1.9, 0)},
                  ["0,0,0,0,0", "1,4,2.0,0.001,0.1", "2,-1,1.7,0.3,0.2"])
    monkeypatch.setattr(coupling_effect, "compute", lambda seeds, out, options, jobs: [one if options["-coupling"] == "one-way"
        else two])
    assert coupling_effect.main(["--seeds", "1", "--out", str(tmp_path / "out")]) == 0
    row = {name: values[0] for name, values in read_table(tmp_path / "out/coupling_effect.csv").items()}
    assert row == pytest.approx({"seed": 1, "pressure_drop_change_mean_Pa": 1, "pressure_drop_change_least_Pa": -1,
        "pressure_drop_change_most_Pa": 4, "speed_most_change_m_s": -0.3,
                                 "velocity_change_most_m_s": 0.3, "volume_fraction_most": 0.2, "left_one_way": 2,
                                     "left_two_way": 2, "exit_time_mean_change_s": -0.1,
                                 "exit_time_median_difference_s": 0.2, "distance_median_m": 0.2})
    assert re.search(r"carried through +one-way +66.7 %, two-way +66.7 %", capsys.readouterr().out)
    assert (tmp_path / "out/coupling_effect.png").stat().st_size > 10000


def test_a_seed_of_which_nobody_leaves_has_no_part_in_the_mean_time_of_exit(tmp_path, monkeypatch, capsys):
    """The mean over the seeds was nan."""
    def runs(leaves):
        for seed, left in enumerate(leaves):
            flow = ["0,0,0,0,0", "1,4,2.0,0.001,0.1"]
            yield {way: made_up(tmp_path / f"{way}{len(leaves)}{seed}", {0: [0, 0.5, 0.6]},
                {0: (1.5 + 0.1 * (way == "two-way"), 1)} if left else {}, flow) for way in ("one-way", "two-way")}
    for leaves, says in (((1, 0), r"exit_time_mean_change_s +mean +0\.1 +least +0\.1 +most +0\.1"),
        ((0,), "exit_time_mean_change_s +none")):
        found = list(runs(leaves))
        monkeypatch.setattr(coupling_effect, "compute", lambda seeds, out, options, jobs, found=found: [pair[options["-coupling"]]
            for pair in found])
        assert coupling_effect.main(["--seeds", str(len(leaves)), "--out", str(tmp_path / "out")]) == 0
        said = capsys.readouterr().out
        assert re.search(says, said) and "nan" not in said


@pytest.mark.parametrize("turbulence", ["off", "fluctuation"])
def test_what_acts_back_is_without_the_stresses_of_the_undisturbed_flow(turbulence, freefem_text, tmp_path):
    """A sphere at rest in u = 3 x, v = -3 y: m_p dU/dt - m_f Du/Dt, with weight and buoyancy out; the acceleration is that of the
    mean flow where there are fluctuations."""
    text = BOX.replace("carrierWh u = 0., v = 0.; carrierFlow(u[], v[]);", "carrierWh u = 3*x, v = -3*y, k = 0.06, e = 0.6; "
        "carrierFlow(u[], v[]); carrierTurbulence(k[], e[]);")
    text = text.replace("x0 = [0.5, 0.3], y0 = [0.52, 0.4], r = [0.02, 0.01], d = [2500., 7000.], u0 = [1., 0.5], v0 = [0.2, "
        "-0.3], z = [0., 0.]",
                        "x0 = [0.5], y0 = [0.4], r = [0.02], d = [2500.], u0 = [0.], v0 = [0.], z = [0.]").replace("gravityX = 0, gravityY = 0", "gravityX = 2, gravityY = -9.81")
    mesh, dt = tmp_path / "box.mesh", 1e-3
    freefem_text(text.format(mesh=mesh), "-mesh", mesh, "-turbulence", turbulence, "-fluid-acceleration", 1, "-depth", 1e30, "-dt",
        dt, "-tend", dt, "-every", 0, "-contacts", 0,
                 "-out", tmp_path / "run")
    run = RunFolder(tmp_path / "run")
    flow, sphere, volume = run.table("coupling"), run.particles, 4 / 3 * math.pi * 0.02**3
    for axis, name, fluid, gravity in (("x", "u", 9 * 0.5, 2), ("y", "v", 9 * 0.4, -9.81)):
        gained = 2500 * volume * sphere[name][-1] / dt
        assert flow[f"force_{axis}"][-1] == pytest.approx(gained - 1000 * volume * fluid - 1500 * volume * gravity, rel=1e-8)
        assert abs(flow[f"source_{axis}"][-1] + flow[f"force_{axis}"][-1]) < 1e-9


FROZEN = """int[int] sides = [3, 2, 3, 1];
mesh Th = square(4, 4, label = sides);
include "lib/core/output.idp"
real rhoFluid = 1000, mu = 1, gravityX = 0, gravityY = 0, ransNu = mu/rhoFluid;
int ransAxis = 0;
include "lib/transport/two_way_saved.idp"
steadyK = 0.04 + 0.*x; steadyNut = 0.01 + 0.*x; steadyModel = "MODEL";
steadyU = 1.; steadyV = 0.;
carrierFlow(steadyU[], steadyV[]);
int[int] in0 = [1], out0 = [2], walls0 = [3];
twoWayOfSteady(0.01, in0, out0, walls0);
cout.precision(12);
cout << "FOUND " << int2d(Th)(twoWayViscosity) << " " << int1d(Th, twoWayWalls)(twoWayFriction) << " " << twoWayHeld.n << " " << twoWayWalls[0] << endl;
"""


@pytest.mark.parametrize("model", ["laminar", "k-epsilon"])
def test_the_coupled_flow_keeps_the_eddy_viscosity_and_the_law_of_the_wall(model, freefem_text):
    """nu + nu_t; u_k/u+ half an element off both walls, of which a laminar flow has none: it does not slip."""
    viscosity, friction, held, wall = map(float, freefem_text(FROZEN.replace("MODEL", model)).stdout.split("FOUND")[1].split()[:4])
    assert viscosity == pytest.approx(0.011, rel=1e-9)
    scale = 0.09**0.25 * 0.2
    if model == "laminar":
        assert (held, wall) == (2, -1)
    else:
        assert (held, wall) == (1, 3) and friction == pytest.approx(2 * scale * 0.41 / math.log(9 * max(30, scale * 0.125 / 1e-3)),
            rel=1e-9)


def test_rows_of_the_coupling_are_means_and_maxima_of_the_steps(freefem, tmp_path):
    """A source that is uniform, in a stream: a row of many steps against the rows of each; the volume fraction is that of the box,
    the speed that of the stream and its change."""
    words = ["-coupling-width", 10, "-stream", 1, "-start-u", 3, "-start-v", 0, "-mu", 0.01, "-drag", "constant", "-tend", 0.06,
        "-fields", 1]
    runs = []
    for name, every in (("each", 0), ("all", 0.03)):
        freefem("tests/transport/scripts/cloud.edp", "-out", tmp_path / name, "-every", every, *words)
        runs.append(RunFolder(tmp_path / name).table("coupling"))
    each, whole = runs
    assert len(each["t"]) == 7 and whole["t"] == pytest.approx([0, 0.03, 0.06])
    for name in ("force_x", "force_y", "source_x", "source_y"):
        assert whole[name][1:] == pytest.approx([each[name][1:4].mean(), each[name][4:].mean()], rel=1e-9, abs=1e-9)
    assert whole["momentum_x"][1:] == pytest.approx(each["momentum_x"][[3, 6]], rel=1e-9)
    # the kernel is not quite uniform
    assert each["volume_fraction_most"][1:] == pytest.approx(100 * 4 / 3 * math.pi * 0.01**3 / 0.001, rel=1e-5)
    assert each["change_most"][-1] > 0.1 and each["speed_most"] == pytest.approx(1 + each["change_most"], rel=1e-9)
    assert each["change_most"] == pytest.approx(each["momentum_x"] / (1000 * 0.001), rel=1e-5)
    freefem("tests/transport/scripts/cloud.edp", "-out", tmp_path / "apart", "-every", 0, "-converge", -20, "-coupling-width",
        0.05, "-mu", 0.01, "-drag", "stokes", "-tend", 0.03)
    # spheres that fly apart: of each row's own steps
    thinner = RunFolder(tmp_path / "apart").table("coupling")["volume_fraction_most"][1:]
    assert (thinner[1:] < 0.95 * thinner[:-1]).all()
    last = read_field(tmp_path / "each/fields_0000006.vtu")[1]["velocity"]
    assert last[:, 0] == pytest.approx(each["speed_most"][-1], rel=1e-5)


CHANNEL = """include "lib/case.idp"
include "lib/mesh/labels.idp"
optCase("channel", "a sphere that settles drives a fluid so viscous that it goes as one, between walls with a law");
optDefault("-mesh", "meshes/periodic_box.mesh");
optDefault("-coupling", "two-way");
real rhoFluid = 1000, mu = 1e5, gravityX = {along}, gravityY = {up};
macro twoWaySpaces() fespace twoXh(Th, [P2, P2, P1], periodic = [[{sides[0]}, {axis}], [{sides[1]}, {axis}]]); fespace sourceQh(Th, P1, periodic = [[{sides[0]}, {axis}], [{sides[1]}, {axis}]]); // EOM
macro twoWayFriction() 0.5 // EOM
macro caseCarrier() carrierWh u = 0., v = 0.; carrierFlow(u[], v[]); // EOM
macro caseTwoWay() twoWayWalls.resize(2); twoWayWalls[0] = {walls[0]}; twoWayWalls[1] = {walls[1]}; twoWayBegin(timeStep); // EOM
macro caseParticles() {{ real[int] x0 = [0.5], r = [0.01], d = [2500.], z = [0.]; transportAppend(x0, x0, r, d, z, z, z); }} // EOM
include "scripts/transport.edp"
"""


@pytest.mark.parametrize("way", ["x", "y"])
def test_walls_with_a_law_hold_the_fluid_by_their_friction(way, freefem_text, tmp_path):
    """d(momentum)/dt = weight less buoyancy - 2 c/H momentum; a part of the weight across the channel moves nothing."""
    sides, walls = ["labelLeft", "labelRight"], ["labelBottom", "labelTop"]
    words = {"along": 9.81, "up": -3, "sides": sides, "walls": walls, "axis": "y"} if way == "x" else {"along": -3, "up": 9.81,
        "sides": walls, "walls": sides, "axis": "x"}
    freefem_text(CHANNEL.format(**words), "-drag", "stokes", "-coupling-width", 10, "-contacts", 0, "-dt", 0.02, "-tend", 1,
        "-out", tmp_path / "run")
    flow = RunFolder(tmp_path / "run").table("coupling")
    along, across = ("momentum_x", "momentum_y") if way == "x" else ("momentum_y", "momentum_x")
    assert flow[along][-1] == pytest.approx(1500 * 4 / 3 * math.pi * 1e-6 * 9.81 * (1 - math.exp(-1)), rel=5e-3)
    assert abs(flow[across][-1]) < 1e-2 * flow[along][-1]
