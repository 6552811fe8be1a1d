"""Functions of the library and the drivers have at most six parameters, or stand in the table below and say why."""
import re

import pytest

from tests.conftest import ROOT
from tests.lint import files

MOST = 6
NUMBERS = {7: "Seven", 8: "Eight", 9: "Nine", 10: "Ten", 11: "Eleven", 12: "Twelve", 13: "Thirteen", 14: "Fourteen"}
PATHS = [path for path in files(".idp") + files(".edp") if path.startswith(("lib/", "scripts/"))]
SCENE = "its arguments are the arrays of a scene, which the caller has"
BOTH = "the whole mesh and the neighbourhood of the bodies have matrices and places of their own"
COMPONENTS = "called once for each component, with its arrays"
COLUMNS = "the columns of particles"
MANY = {
    "bodyAdd": "a body as a file or a case gives it",
    "particleRows": "the columns of the table, from resolved bodies, point particles or disks",
    "queueEllipseAt": "a particle as a case gives it",
    "queueGaussian": "the options of a case, once a run",
    "queuePoints": "one ellipse and its points, for particles of both kinds",
    "contactBodiesFromCsv": "the columns of the file",
    "contactValid": SCENE,
    "contactStart": SCENE,
    "contactTakeSet": "the arrays of a working set, which only contactAccelerated() has",
    "contactRowSet": "the arrays of one linearised problem, which only its caller has",
    "contactEllipseApart": "called for the whole list and for gathered parts of it, with five results",
    "contactEllipseProject": SCENE,
    "contactEllipseRub": SCENE,
    "contactEllipseStart": SCENE,
    "pairPlaces": "a matrix, the nodes and pairs of its elements, and the three arrays that are made",
    "filmCornerParts": "the integrals, with and without corners",
    "filmTriangles": "points, and what belongs to their triangles",
    "filmShape": "called for either body of the films, with the arrays of a scene",
    "formCircleSegment": "a circle, a segment and what is asked",
    "shapeAppend": "the columns of an entry",
    "shapeRate": "called for both directions, with their arms",
    "contactOutlineCross": "points and the two ends of a wall",
    "meshWallsCorners": "the graph of the boundary's edges, once a run",
    "contactProject": SCENE,
    "contactIdle": SCENE,
    "bendBeyond": "called for either end of the walls, with its arrays",
    "bendSlides": "the arrays of a projection, which its caller has",
    "bendOnLine": "called for disks and for ellipses, with their arrays",
    "rowsList": "FreeFEM has no structures, and a matrix by rows is four arrays",
    "rowsPart": "as rowsList()",
    "ghostConvection": "the points of the profiles and what is changed in place",
    "ghostAddBy": "velocities of two steps, at fixed points or in the frames",
    "motionForces": "arrays of this step, which only motionContacts() has",
    "frameBeside": "the pairs of this step, which only frameWindows() has",
    "momentumStart": "extrapolated values and loads of the step, which exist only during it",
    "pressureMean": BOTH,
    "ransTransport": "called for K and for E, each with its arrays",
    "ransUpwinding": "four fields at the points and three results, within one evaluation",
    "dragPiece": "the coefficients of a piece",
    "particleAppend": COLUMNS,
    "transportAppend": COLUMNS,
    "turbMove": COMPONENTS,
    "transportAlong": COMPONENTS,
}


def long_ones(text):
    """{name: (number of parameters, the comment directly above)} of the functions of more than MOST parameters."""
    found = {}
    for head in re.finditer(r"^func +[\w\[\], ]+? +(\w+)\(([^)]*)\) *\{", text, flags=re.M):
        number = len([word for word in re.sub(r"\[[^]]*\]", "", head[2]).split(",") if word.strip()])
        if number > MOST:
            above = re.search(r"(?:^//.*\n)*\Z", text[:head.start()], flags=re.M)[0]
            found[head[1]] = number, re.sub(r"\s*\n?// *", " ", above).strip()
    return found


@pytest.mark.parametrize("path", PATHS)
def test_functions_have_few_parameters_or_say_why(path):
    for name, (number, above) in long_ones((ROOT / path).read_text()).items():
        assert name in MANY, f"{name}() has {number} parameters: arrays of its file serve better, or a reason in this table"
        reason = f"({NUMBERS.get(number, number)} parameters: {MANY[name]}.)"
        assert reason in above, f"{name}() must say above it: {reason}"


def test_the_table_names_no_other_function():
    assert set(MANY) == {name for path in PATHS for name in long_ones((ROOT / path).read_text())}


def test_long_lists_of_parameters_are_found():
    text = ("// Adds.\n// (Seven parameters: a\n// reason.)\nfunc int many(real a, real[int] & b, real[int, int] & c, int d,\n"
        "    int e, mesh & f, string g) {\n}\nfunc real[int] few(real a, real[int, int] & b, int c, int d, int e, int f) {\n}\n")
    assert long_ones(text) == {"many": (7, "Adds. (Seven parameters: a reason.)")}
