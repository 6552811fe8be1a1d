"""Bodies of any shape in a flow: a capsule in Stokes flow, against meshes that fit it.

tools/peers/body_fitted/shapes_stokes.edp, of which the drags differ by 3e-4 from those with half as many points.
"""
import numpy as np

from tools.validation import Failed

SOURCE = "body-fitted computation"
DRAG = {0.125: (10.94, 18.91), 0.0625: (9.332, 18.24)}  # along and across the stream, over viscosity and velocity; by the radius
SCENE, VISCOSITY = "tools/validation/capsule_in_box.edp", 10.0


def turn(track):
    """The time of a whole turn from that of the half turn that begins at the angle 0. Raises Failed where there is none."""
    turned = -track["theta"]
    if not turned[-1] >= np.pi:
        raise Failed(f"it has turned by {turned[-1]:.3g} rad only")
    return 2 * float(np.interp(np.pi, turned, track["t"]) - np.interp(0, turned, track["t"]))


def capsule_drag(context):
    """Drag of capsules of length 1 with two, four and eight elements across."""
    for cells in (16, 32):
        mesh = context.mesh("box", 1 / cells, "--width", "4", "--height", "4", "--sides", "named")
        for radius, drags in DRAG.items():
            for way, angle, target in (("along", 0.0, drags[0]), ("across", np.pi / 2, drags[1])):
                name = (f"capsule 1:{0.5 / radius:g}, {cells} elements in its length: drag {way} the stream over viscosity and "
                    "velocity")
                try:
                    run = context.run(SCENE, {"-radius": radius, "-angle": angle, "-forces": 1},
                        f"capsule_{radius:g}_{way}_{cells}", mesh=mesh)
                    drag = run.folder.table("forces")["fx"][-1] / VISCOSITY
                    yield context.row(name, SOURCE, target, drag, rtol=0.01, cpu_s=run.cpu_s)
                except Failed as problem:
                    yield context.failed(name, SOURCE, target, problem)


TURN = 24.15  # time of a turn of the capsule of radius 0.125


def capsule_turn(context):
    """Time of a turn in shear."""
    mesh = context.mesh("box", 1 / 16, "--width", "4", "--height", "4", "--sides", "named")
    name = "capsule 1:4, 16 elements in its length: time of a turn times the shear rate"
    try:
        run = context.run(SCENE, {"-shear": 1, "-angle": 0.3, "-dt": 0.1, "-tend": 18}, "capsule_turn", mesh=mesh)
        yield context.row(name, SOURCE, TURN, turn(next(iter(run.folder.tracks.values()))), rtol=0.01, cpu_s=run.cpu_s)
    except Failed as problem:
        yield context.failed(name, SOURCE, TURN, problem)


VALIDATIONS = [capsule_drag, capsule_turn]
