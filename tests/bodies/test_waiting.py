"""Particles that wait (lib/bodies/waiting.idp, lib/motion/enter.idp): whether there is room for one, when it is due, and the motion
of the fluid whose place it takes."""
import numpy as np
import pytest

from tests.conftest import standard_alone
from tests.scenes import PERIODIC, case
from tests.tables import rows

ROOM = """
include "lib/bodies/waiting.idp"
queueX = {x0}; queueDirection = {way}; queuePeriodX = {period[0]}; queuePeriodY = {period[1]};
{queue}
int n;
ifstream f("{file}");
f >> n;
real[int] px(n), py(n), r(n), ax(1), ay(1), ar(1);
for (int k = 0; k < n; ++k) f >> px[k] >> py[k] >> r[k];
cout.precision(17);
for (int k = 0; k < queueWaiting; ++k) for (int i = 0; i < n; ++i) {{ ax[0] = px[i]; ay[0] = py[i]; ar[0] = r[i]; cout << "room " << queueRoom(k, ax, ay, ar) << endl; }}
for (int k = 0; k < queueWaiting; ++k) cout << "all " << queueRoom(k, px, py, r) << endl;
real[int] none(0);
cout << "none " << queueRoom(0, none, none, none) << endl;
"""


@pytest.mark.parametrize("period", [(0, 0), (3, 0), (0, 2.5), (3, 2.5)])
@pytest.mark.parametrize("way", [1, -1])
def test_there_is_room_where_no_image_of_a_disk_is_nearer_than_both_radii_and_a_margin(period, way, freefem_text, tmp_path):
    """A twentieth of the radius of who waits; ellipses need the room of the disk round them, and the plane is their rear's."""
    rng = np.random.default_rng(1)
    x0, number = 0.3, 12
    y, a, placed = rng.uniform(-3, 3, number), rng.uniform(0.05, 0.3, number), np.where(rng.random(number) < 0.5,
        rng.uniform(-3, 3, number), np.nan)
    queue = []
    for k in range(number):
        at, size = "" if np.isnan(placed[k]) else f"{placed[k]:.17g}, ", f"{a[k]:.17g}" + (f", {0.4 * a[k]:.17g}, 0.7"
            if k % 3 == 0 else "")
        queue.append(f"queue{'Ellipse' if k % 3 == 0 else ''}{'At' if at else '' if k % 3 == 0 else 'Add'}({at}{y[k]:.17g}, "
            f"{size}, 1, 0.);")
    x = np.where(np.isnan(placed), x0 + way * 1.05 * a, placed)
    disks = np.column_stack([rng.uniform(-6, 6, (400, 2)), rng.uniform(0.02, 0.6, 400)])
    (tmp_path / "disks.txt").write_text(f"{len(disks)}\n" + "".join(" ".join(f"{value:.17g}" for value in row) + "\n"
        for row in disks))
    out = freefem_text(ROOM.format(x0=x0, way=way, period=period, queue="\n".join(queue), file=tmp_path / "disks.txt")).stdout
    apart = [disks[:, axis] - np.column_stack([x, y])[:, axis:axis + 1] for axis in (0, 1)]
    apart = [off - length * np.round(off / length) if length else off for off, length in zip(apart, period)]
    room = np.hypot(*apart) >= disks[:, 2] + 1.05 * a[:, None]
    assert 10 < (~room).sum() and (rows(out, "room").reshape(room.shape) == room).all()
    assert (rows(out, "all")[:, 0] == room.all(1)).all() and rows(out, "none")[0, 0] == 1


def test_who_is_due_and_who_has_entered(freefem_text):
    """Times that are sums of steps are met in spite of rounding, and the others keep their places and numbers."""
    out = freefem_text("""
include "lib/bodies/waiting.idp"
real now = 0;
for (int k = 0; k < 3; ++k) now += 0.1;
real[int] times = [0.5, 0.3, 0.3, 0.2, 0.7, 0.];
for (int k = 0; k < 6; ++k) queueEllipseAt(k, 10 + k, 1 + k, 0.5 + 0.1*k, 0.01*k, 100 + k, times[k]);
queueTime[1] = now*(1 + 5e-13);
int[int] due(0), gone(2);
cout << "due " << queueDue(now, due);
for (int i = 0; i < due.n; ++i) cout << " " << due[i];
cout << endl;
gone[0] = due[2]; gone[1] = due[0];
int many = queueEnter(gone);
cout << "left " << many << " " << queueWaiting << " " << queueEntered << endl;
for (int k = 0; k < queueWaiting; ++k) cout << "who " << queuePlace[k] << " " << queueY[k] << " " << queueRadius[k] << " " << queueAspect[k]*queueRadius[k] << " " << queueTheta[k] << " " << queueDensity[k] << " " << queueTime[k] << endl;
int early = queueDue(0.6, due), later = queueDue(0.7, due), shapes = queueShapes();
queueEnter(due);
cout << "later " << early << " " << later << " " << shapes << " " << queueShapes() << " " << queueWaiting << " " << queueEntered << endl;
""").stdout
    assert rows(out, "due").tolist() == [[4, 1, 2, 3, 5]] and rows(out, "left").tolist() == [[2, 4, 2]]
    at = np.array([0, 2, 4, 5])  # 1 and 3 have entered
    np.testing.assert_allclose(rows(out, "who"), np.column_stack([at, 10 + at, 1 + at, 0.5 + 0.1 * at, 0.01 * at, 100 + at,
        [0.5, 0.3, 0.7, 0]]), rtol=1e-5)
    assert rows(out, "later").tolist() == [[3, 4, 1, 0, 0, 6]]


@pytest.mark.parametrize("queue, words", [("queueGaussian(3, 1, 0, 1, 0.3, 0.2, 1, 1, 0, 0);", "the smallest particle diameter "
    "0.3 is above the largest, 0.2"),
                                          ("queueGaussian(3, 1, 0, 1, 0.3, 0.96, 1, 1, 0, 0);", "a particle of diameter 0.96 "
                                              "does not fit into an inlet of height 1")])
def test_sizes_that_do_not_fit_are_refused(queue, words, freefem_text):
    done = freefem_text(f'include "lib/bodies/waiting.idp"\n{queue}', check=False)
    assert done.returncode == 3 and words in done.stderr


MOTION = """macro caseStart() {{ Wh oneU = {u}, oneV = {v}; flowU = oneU[]; flowV = oneV[]; real[int] motion(3); cout.precision(12);
    for (int k = 0; k < queueWaiting; ++k) {{ injectMotion(k, motion); cout << "motion " << motion[0] << " " << motion[1] << " " << motion[2] << endl; }} exit(0); }} // EOM"""


def motions(freefem_text, queue, u, v, *words, seam=0, **sides):
    text = case(queue, gravity=0, more=(PERIODIC + "\n" if seam else "") + MOTION.format(u=u, v=v), period=seam,
        **(sides or dict(walls="labelLeft, labelRight" + ("" if seam else ", labelBottom, labelTop"))))
    return rows(freefem_text(standard_alone(text), *words).stdout, "motion")


def test_who_enters_has_the_mean_motion_of_the_fluid_whose_place_it_takes(freefem_text, tmp_path):
    """In a linear flow: the velocity at its centre, and the angular momentum of that fluid over its moment of inertia."""
    shapes = [(0.4, 0.6, 0.2, 0.2, 0), (0.5, 0.45, 0.25, 0.1, 0.6), (0.6, 0.5, 0.2, 0.15, -1.1)]
    queue = "{ " + " ".join(f"queueEllipseAt({x}, {y}, {a}, {b}, {turn}, 1, 9);" for x, y, a, b, turn in shapes) + " }"
    found = motions(freefem_text, queue, "0.3 + 0.7*x - 2*y", "-0.2 + 0.5*x - 0.7*y", "-out", tmp_path / "run")
    for (x, y, a, b, turn), motion in zip(shapes, found, strict=True):
        c, s = np.cos(turn), np.sin(turn)
        xx, yy, xy = (a * c)**2 + (b * s)**2, (a * s)**2 + (b * c)**2, (a**2 - b**2) * c * s
        spin = (0.5 * xx - 0.7 * xy - 0.7 * xy + 2 * yy) / (xx + yy)
        np.testing.assert_allclose(motion, [0.3 + 0.7 * x - 2 * y, -0.2 + 0.5 * x - 0.7 * y, spin], atol=1e-9)


def test_who_enters_over_a_seam_has_the_motion_of_the_fluid_of_its_image(freefem_text, tmp_path):
    """A flow and a disk and an ellipse in it, once in the middle of the period and once across its side, and further periods
    away."""
    found = []
    for number, at in enumerate((0.5, 0.0, 3.0)):
        queue = f"{{ queueAt(0.4, {at + 0.05}, 0.12, 1, 9); queueEllipseAt(0.6, {at - 0.03}, 0.15, 0.07, 0.8, 1, 9); }}"
        found.append(motions(freefem_text, queue, f"(1 + x)*sin(2*pi*(y - {at % 1}))", f"x*cos(2*pi*(y - {at % 1}))", "-mesh",
            "meshes/cylinder_array.mesh", "-out", tmp_path / f"run{number}", seam=1))
    assert len(found[0]) == 2 and abs(found[0]).min() > 0.1
    np.testing.assert_allclose(found[1], found[0], atol=2e-3)
    np.testing.assert_allclose(found[2], found[1], atol=1e-9)


@pytest.mark.parametrize("u, v, motion", [("0.3", "0.8", (0.3, 0.8, 0)), ("0.3 - 2*(y - 0.95)", "0.8 + 2*(x - 0.96)",
    (0.3, 0.8, 2))])
def test_who_enters_partly_over_an_outlet_moves_as_a_rigid_body_that_the_fluid_there_is(u, v, motion, freefem_text, tmp_path):
    """Its points outside the mesh are left out, which made it turn in a uniform stream, and go another way in one that turns about
    its centre."""
    queue = "{ queueAt(0.96, 0.95, 0.12, 1, 9); queueEllipseAt(0.96, 0.95, 0.14, 0.1, 0.5, 1, 9); }"
    found = motions(freefem_text, queue, u, v, "-out", tmp_path / "run", walls="", moving="labelLeft, labelBottom",
        outlet="labelRight, labelTop")
    np.testing.assert_allclose(found, [motion, motion], atol=1e-9)


def test_who_enters_has_the_mean_velocity_of_a_flow_that_bends(freefem_text, tmp_path):
    """Twelve thirteenths of what the bend adds: a quarter of the square of the radius, or of the semi-axis (the thirteenth point is
    the centre)."""
    queue = "{ queueAt(0.4, 0.6, 0.2, 1, 9); queueEllipseAt(0.5, 0.45, 0.25, 0.1, 0, 1, 9); }"
    found, part = motions(freefem_text, queue, "y^2", "x^2", "-out", tmp_path / "run"), 12 / 13 / 4
    np.testing.assert_allclose(found[:, :2], [[0.6**2 + part * 0.2**2, 0.4**2 + part * 0.2**2], [0.45**2 + part * 0.1**2,
        0.5**2 + part * 0.25**2]], atol=1e-9)


@pytest.mark.parametrize("queue, status, words", [("queueAt(0.5, 0.1, 0.1, 1, sqrt(-1.));", 3, "a time that is not finite"),
    ("queueAt(0.5, 0.0999, 0.1, 1, 0);", 5, "would overlap a wall by 0.0001"), ("queueAt(0.5, 0.1, 0.1, 1, 0);", 0, ""),
                                                  ("queueAt(-0.06, 0.08, 0.1, 1, 0);", 0, ""), ("queueAt(-0.05, 0.08, 0.1, 1, 0);",
                                                      5, "would overlap a wall by 0.005")])
def test_who_waits_may_touch_a_wall_and_not_overlap_it(queue, status, words, freefem_text):
    done = freefem_text(f'include "lib/bodies/waiting.idp"\ncontactWallSegment(0, 1, 1, 1); contactWallSegment(1, 0, 0, '
        f'0);\n{queue}\nqueueCheck(1);', check=False)
    assert done.returncode == status and words in done.stderr
