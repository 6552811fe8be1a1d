"""A periodic cell with two spheres that touch across its sides."""

SPACES = """
macro flowSpaces() fespace spaceWh(Th, P2, periodic = [[labelLeft, y, z], [labelRight, y, z], [labelFront, x, z],
    [labelBack, x, z]]); fespace spaceQh(Th, P1, periodic = [[labelLeft, y, z], [labelRight, y, z], [labelFront, x, z],
    [labelBack, x, z]]); // EOM
"""
# Two spheres between plates, carried and pushed together; the cell is periodic along x and y. -x and -y shift the scene.
SCENE = """
include "lib/spheres/case.idp"
optCase("scene", "two spheres in a periodic cell");
optDefault("-dt", "0.02"); optDefault("-tend", "0.6"); optDefault("-cfl", "0"); optDefault("-tolerance", "1e-9");
real dx0 = optReal("-x", 0, "", ""), dy0 = optReal("-y", 0, "", "");
real rhoFluid = 1, mu = 0.1, gravityX = 0, gravityY = 0, gravityZ = 0;
int[int] flowNoSlip = [labelBottom, labelTop], flowMoving(0), flowOutlet(0), flowSlip(0);
{spaces}
macro flowPeriodicLabels() [{labels}] // EOM
macro flowForceX() 2. // EOM
func real boundaryRamp(real t) {{ return 1; }}
func int fill() {{
    sphereMoves(bodySphere(0.8 + dx0, 0.52 + dy0, 0.47, {radius}, 8), 2, 0.3, 0);
    sphereMoves(bodySphere(0.4 + dx0, 0.47 + dy0, 0.52, {radius}, 8), 0, -0.2, 0.1);
    return sphereN;
}}
macro caseParticles() fill(); {more} // EOM
include "scripts/spheres.edp"
"""
LABELS = "labelLeft, labelRight, labelFront, labelBack"


def scene(spaces=SPACES, labels=LABELS, radius=0.2, more=""):
    """Text of the case. spaces, labels: of periodic sides; radius: of the spheres; more: further statements of caseParticles."""
    return SCENE.format(spaces=spaces, labels=labels, radius=radius, more=more)
