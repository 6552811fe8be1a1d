"""Scenes that several tests run: cases as text, meshes as text or as a file."""
import numpy as np

from tools.meshing.medit import write
from tools.meshing.plane_mesh import PlaneMesh

# What a case does with its words and files, and no more: starting it takes a quarter of the time of a driver.
READING = """
include "lib/case.idp"
optCase("reading", "words of the command line, a mesh and particles are read");
real dt = optPositive("-dt", 1, "s", "a number");
string meshFile = optFile("-mesh", "meshes/settling_disk.mesh", "mesh file");
string particleFile = optFile("-particles", "", "file of particles");
outDeclare();
optEnd();
mesh Th = meshRead(meshFile);
if (particleFile != "") bodyRead(particleFile);
bodyCheck();
outBegin(meshFile);
"""

CASE = """
include "lib/case.idp"
optCase("boundaries", "a scene of tests/scenes.py");
optDefault("-mesh", "meshes/couette_disk.mesh");
optDefault("-dt", "0.01");
real rhoFluid = 1, mu = {mu}, gravityX = 0, gravityY = {gravity};
include "lib/mesh/labels.idp"
int[int] flowNoSlip = [{walls}], flowMoving = [{moving}], flowOutlet = [{outlet}], flowSlip = [{slip}];
{more}
real flowPeriodX = 0, flowPeriodY = {period}, motionBound = 1e30;
func real boundaryRamp(real t) {{ return 1; }}
macro caseParticles() {particles} // EOM
include "scripts/resolved.edp"
"""


def case(particles, walls="labelLeft, labelRight, labelBottom, labelTop", moving="", outlet="", slip="", more="", period=0,
    mu=0.05, gravity=-1):
    """The text of a case in the unit square; empty lists of labels as FreeFEM writes them."""
    text = CASE.format(particles=particles, walls=walls, moving=moving, outlet=outlet, slip=slip, more=more, period=period, mu=mu,
        gravity=gravity)
    return text.replace(" = []", "(0)")


def filmed(run, film):
    """The runner of scripts `run` with -film 1 or 0, unless the words of a test say what films there are."""
    return lambda text, *words, **options: run(text, *([] if "-film" in words else ["-film", film]), *words, **options)


def ring(file):
    """A mesh between a cylinder of radius 0.4 (label 6) and one of radius 1 (label 3), in 24 and 60 chords."""
    return f"""
border outer(s = 0, 2*pi) {{ x = cos(s); y = sin(s); label = 3; }}
border inner(s = 0, 2*pi) {{ x = 0.4*cos(s); y = 0.4*sin(s); label = 6; }}
savemesh(buildmesh(outer(60) + inner(-24)), "{file}");
"""


SEAM = """macro boundaryU() 1. // EOM
macro flowSpaces() fespace Wh(Th, P2, periodic = [[labelBottom, x], [labelTop, x]]);
    fespace Qh(Th, P1, periodic = [[labelBottom, x], [labelTop, x]]); // EOM
macro flowPeriodicLabels() [labelBottom, labelTop] // EOM
macro caseStart() { Wh one = 1.; flowU = one[]; } // EOM"""


PERIODIC = "\n".join(SEAM.splitlines()[1:4])


def square(file, above="1 - s", edges=12, hole="", sides=12):
    """A mesh of the unit square, of so many edges a side; above: x of the vertices on the upper side, of so many edges, by s from 0
    to 1; hole: its border."""
    return f"""
border below(s = 0, 1) {{ x = s; y = 0; label = 13; }}
border beside(s = 0, 1) {{ x = 1; y = s; label = 12; }}
border upper(s = 0, 1) {{ x = {above}; y = 1; label = 14; }}
border before(s = 1, 0) {{ x = 0; y = s; label = 11; }}
{hole}
savemesh(buildmesh(below({sides}) + beside({sides}) + upper({edges}) + before({sides}){hole and " + hole(-20)"}), "{file}");
"""


# A box of N x N cells with disks; prints the rigid nodes. PERIODIC and DISKS are filled in.
SETS = """
include "lib/case.idp"
optCase("sets", "rigid sets"); optEnd();
real rhoFluid = 1, mu = 1, gravityX = 0, gravityY = 0;
int withConvection = 0;
mesh Th = square(16, 16, flags = 3);
int[int] flowNoSlip = [SOLID], flowMoving(0), flowOutlet(0), flowSlip(0);
real flowPeriodX = PERIOD, flowPeriodY = 0;
MACROS
include "lib/immersed/ghost_values.idp"
DISKS
rigidSetUp();
rigidFind();
cout.precision(15);
for (int k = 0; k < rigidCount; ++k) cout << "rigid " << rigidNode[k] << " " << rigidOwner[k] << " " << rigidX[k] << " " << rigidY[k] << endl;
for (int k = 0; k < flowNw; ++k) cout << "node " << k << " " << flowX[k] << " " << flowY[k] << " " << flowFreeU[k] << endl;
"""
PERIODIC_SPACES = """macro flowSpaces() fespace Wh(Th, P2, periodic = [[4, y], [2, y]]); fespace Qh(Th, P1, periodic = [[4, y], [2, y]]); // EOM
macro flowPeriodicLabels() [2, 4] // EOM"""


def script(disks, periodic=False, more=""):
    """The text of a script that finds and prints the nodes in disks (x, y, r) of a box of 16 by 16 cells; more: what it does
    then."""
    text = SETS.replace("PERIOD,", "1," if periodic else "0,").replace("SOLID", "1, 3" if periodic else "1, 2, 3, 4")
    text = text.replace("MACROS", PERIODIC_SPACES if periodic else "")
    return text.replace("DISKS", "\n".join(f"bodyDisk({x!r}, {y!r}, {r!r}, 1.);" for x, y, r in disks)) + more


CHANNEL = """
border below(s = 0, 4) {{ x = s; y = 0; label = 3; }}
border out(s = 0, 2) {{ x = 4; y = s; label = 2; }}
border above(s = 4, 0) {{ x = s; y = 2; label = 14; }}
border into(s = 2, 0) {{ x = 0; y = s; label = 1; }}
savemesh(buildmesh(below(36) + out(18) + above(36) + into(18)), "{file}");
"""
# A stream with disks and an ellipse that fall, touch the walls and leave; lengths, densities and times in units of the scene.
SCENE = """
include "lib/case.idp"
optCase("same_scene", "a scene of tests/scenes.py");
optDefault("-dt", "{dt:.17g}");
optDefault("-tend", "{end:.17g}");
optDefault("-every", "{every:.17g}");
real unit = {unit:.17g}, rhoFluid = {density:.17g}, mu = {viscosity:.17g}*rhoFluid*unit^2, gravityX = {gravity[0]:.17g}, gravityY = {gravity[1]:.17g};
include "lib/mesh/labels.idp"
int[int] flowNoSlip = [{walls}], flowMoving = [labelInlet], flowOutlet = [labelOutlet], flowSlip{slip};
func real up(real a, real b) {{ return (a - {origin[0]:.17g})/unit*{turn[0][1]:.17g} + (b - {origin[1]:.17g})/unit*{turn[1][1]:.17g}; }}
macro boundaryU() ({stream[0]:.17g}*up(x, y)*(2 - up(x, y))) // EOM
macro boundaryV() ({stream[1]:.17g}*up(x, y)*(2 - up(x, y))) // EOM
func real boundaryRamp(real t) {{ return min(1., t/{ramp:.17g}); }}
real flowPeriodX = 0, flowPeriodY = 0, motionBound = 1e30;
macro caseParticles() {{
{bodies}
}} // EOM
include "scripts/resolved.edp"
"""


def turned(angle):
    """The matrix (2, 2) of a turn, angle in rad."""
    return np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])


def write_moved(mesh, path, turn, unit=1.0, origin=(0.0, 0.0)):
    """Writes a mesh turned or mirrored, in another unit and about another origin; its triangles keep their sense."""
    triangles = mesh.triangles[:, ::-1] if np.linalg.det(turn) < 0 else mesh.triangles
    write(PlaneMesh(mesh.points @ np.transpose(turn) * unit + np.asarray(origin), triangles, mesh.edges, mesh.labels), path)


HELD = """include "lib/bodies/bodies.idp"
optCase("held", "a disk held in a periodic channel");
optDefault("-mesh", "meshes/couette_disk.mesh");
real rhoFluid = 1, mu = 0.3, gravityX = 0, gravityY = 0;
macro flowForceX() 1. // EOM
include "lib/mesh/labels.idp"
int[int] flowNoSlip = [labelTop, labelBottom], flowMoving(0), flowOutlet(0), flowSlip(0);
macro flowSpaces() fespace Wh(Th, P2, periodic = [[labelLeft, y], [labelRight, y]]);
    fespace Qh(Th, P1, periodic = [[labelLeft, y], [labelRight, y]]); // EOM
macro flowPeriodicLabels() [labelLeft, labelRight] // EOM
real flowPeriodX = 1, flowPeriodY = 0, motionBound = 1e30;
func real boundaryRamp(real t) { return 1; }
macro caseParticles() bodyAdd(0.51, 0.47, 0.2, 1, 0, 0, 0, 0); // EOM
include "scripts/resolved.edp"
"""


SIDES = """
border below(s = 0, 4) { x = s; y = 0; label = 3; }
border out(s = 0, 1) { x = 4; y = s; label = 2; }
border above(s = 4, 0) { x = s; y = 1; label = 3; }
border into(s = 1, 0) { x = 0; y = s; label = 1; }
"""
RING = "border ring{k}(s = 0, 2*pi) {{ x = {x} + {a}*cos(s)*cos({c}) - {b}*sin(s)*sin({c}); y = {y} + {a}*cos(s)*sin({c}) + {b}*sin(s)*cos({c}); label = {label}; }}\n"


STREAM = "macro boundaryU() (4*y*(1 - y)) // EOM"


CONTACTS = """
include "lib/bodies/bodies.idp"
include "lib/contact/walls.idp"
optCase("scene", "a scene of a test");
real gravityX = 0, gravityY = {gravity};
func int sceneWalls() {{ {walls} return 0; }}
func int sceneBodies() {{ {bodies} return 0; }}
macro caseWalls() sceneWalls(); // EOM
macro caseParticles() sceneBodies(); // EOM
{more}
include "scripts/contacts.edp"
"""


def write_walls(file, ends):
    """A CSV file of walls, ends (n, 4): x and y of the first and of the second end."""
    file.write_text("x1,y1,x2,y2\n" + "".join(",".join(f"{value:.17g}" for value in row) + "\n" for row in ends))


THROUGH = """
include "lib/case.idp"
optCase("through", "a channel, the velocity given at both ends");
optDefault("-mesh", "meshes/taylor_green.mesh");
include "lib/mesh/labels.idp"
real rhoFluid = 1, mu = 0.1;
int[int] flowNoSlip = [labelBottom, labelTop], flowMoving = [labelLeft, labelRight], flowOutlet(0), flowSlip(0);
real flowPeriodX = 0, flowPeriodY = 0;
macro boundaryU() (4*y*(1 - y)) // EOM
func real boundaryRamp(real t) { return 1; }
macro caseStart() { Wh start = 4*y*(1 - y); flowU = start[]; flowU1 = start[]; } // EOM
include "scripts/flow.edp"
"""


PARTICLES = "id,x,y,radius,density,u,v,omega\n"


def particles(folder, *rows):
    """A file of particles, each a row of id, x, y, radius, density, u, v, omega."""
    path = folder / "disks.csv"
    path.write_text(PARTICLES + "".join(f"{','.join(map(str, row))}\n" for row in rows))
    return path


PIPE_MESH = """MeshVersionFormatted 2
Dimension 2
Vertices
{vertices}
Triangles
{triangles}
Edges
{edges}
End
"""


def write_box(path, length, low, high, nx, ny, bottom):
    """A structured mesh of [0, length] x [low, high]: inlet, outlet, wall above, `bottom` below."""
    lines, triangles, edges = [], [], []
    for j in range(ny + 1):
        for i in range(nx + 1):
            label = 0
            lines.append(f"{length * i / nx:.12g} {low + (high - low) * j / ny:.12g} {label}")
    def at(i, j):
        return j * (nx + 1) + i + 1
    for j in range(ny):
        for i in range(nx):
            triangles.append(f"{at(i, j)} {at(i + 1, j)} {at(i + 1, j + 1)} 0")
            triangles.append(f"{at(i, j)} {at(i + 1, j + 1)} {at(i, j + 1)} 0")
    for i in range(nx):
        edges.append(f"{at(i, 0)} {at(i + 1, 0)} {bottom}")
        edges.append(f"{at(i + 1, ny)} {at(i, ny)} 3")
    for j in range(ny):
        edges.append(f"{at(nx, j)} {at(nx, j + 1)} 2")
        edges.append(f"{at(0, j + 1)} {at(0, j)} 1")
    path.write_text(PIPE_MESH.format(vertices="\n".join([str(len(lines)), *lines]),
                                     triangles="\n".join([str(len(triangles)), *triangles]),
                                     edges="\n".join([str(len(edges)), *edges])))
    return path


def sides(prefix, *corners):
    """FreeFEM borders round corners (x, y, label of the side from there on, edges)."""
    lines, calls = [], []
    for k, (x, y, label, edges) in enumerate(corners):
        to = corners[(k + 1) % len(corners)]
        name = f"{prefix}{k}"
        lines.append(f"border {name}(t = 0, 1) {{ x = {x} + t*({to[0] - x}); y = {y} + t*({to[1] - y}); label = {label}; }}")
        calls.append(f"{name}({edges})")
    return "\n".join(lines), " + ".join(calls)


ANALYTIC = "tests/transport/scripts/analytic.edp"


FORMULA = """
include "lib/case.idp"
optCase("formula", "spheres in a flow by a formula");
real rhoFluid = 1000, mu = 0.001, gravityX = 0, gravityY = 0;
macro carrierExact(px, py, t) {carrier} // EOM
macro caseParticles() {bodies} // EOM
include "scripts/transport.edp"
"""

# Ellipses in contact, walls and periods filled in; what is printed of their gaps, and of their projected velocities.
ELLIPSES = """
include "lib/contact/ellipse_project.idp"
optCase("contacts", "ellipses");
contactDeclare();
optEnd();
real[int] px = X, py = Y, turn = TURN, r = RADIUS, aspect = ASPECT, mass = MASS, moment = MOMENT, u = U, v = V, w = W;
int[int] id = 0:px.n - 1;
WALLS
contactPeriodic(0, -5, PERIOD, 0);
cout.precision(17);
"""
MEASURE_ELLIPSES = """
contactUpdate(px, py, r, id, 10.);
contactEllipseMeasure(px, py, turn, r, aspect);
for (int k = 0; k < contactN; ++k) cout << "gap " << contactI[k] << " " << contactJ[k] << " " << contactEllipseGap[k] << " " << contactEllipseEx[k] << " " << contactEllipseEy[k] << " " << contactEllipseArmI[k] << " " << contactEllipseArmJ[k] << endl;
"""
PROJECT_ELLIPSES = """
contactEllipseProject(px, py, turn, r, aspect, id, mass, moment, u, v, w, DT);
for (int k = 0; k < px.n; ++k) cout << "speed " << u[k] << " " << v[k] << " " << w[k] << endl;
for (int k = 0; k < contactN; ++k) cout << "press " << contactI[k] << " " << contactJ[k] << " " << contactImpulse[k] << endl;
cout << "worst " << contactWorstGap << endl << "passes " << contactIterations << endl;
"""
