"""A plane flow from an OpenFOAM case: a mesh that is one cell deep between patches of type empty, and values in the cells.

The plane is that of the cells' faces on the empty patches. Values at the boundary are those of the patches where these give some
(value, noSlip, zeroGradient). A case that is divided among processors (processor0, ...) is read part by part.
"""
import re
from dataclasses import replace
from pathlib import Path

import numpy as np
from scipy.spatial import cKDTree

from tools.base.command import BadInput
from tools.flow.given import Given, chosen_times, named, unused
from tools.flow.openfoam_files import Foam, constant
from tools.flow.seams import SAME, groups

FIELDS = ("k", "epsilon", "omega")


def read(path, times, velocity):
    """The Given of a case (its folder, or a file in it such as NAME.foam); times: --times; velocity: name of the field. Raises
    BadInput."""
    case = Path(path) if Path(path).is_dir() else Path(path).parent
    parts = sorted((one for one in case.glob("processor*") if re.fullmatch(r"processor\d+", one.name)),
        key=lambda one: int(one.name[9:]))
    if parts and not with_velocity(case, velocity or "U"):
        return together([whole(one, times, velocity) for one in parts], case)
    return whole(case, times, velocity)


def with_velocity(case, name):
    """[(time, folder)] of a case where there are velocities, in the order of time."""
    folders = sorted((float(one.name), one) for one in case.iterdir() if one.is_dir() and is_time(one.name))
    return [(time, one) for time, one in folders if any((one / f"{name}{end}").is_file() for end in ("", ".gz"))]


def whole(case, times, velocity):
    """The Given of a case, or of the part of one processor. Raises BadInput."""
    base, name = case / "constant" / "polyMesh", velocity or "U"
    collated = list(case.glob("processors*"))
    if not base.is_dir():
        raise BadInput(f"{case} is no OpenFOAM case: it has no constant/polyMesh" + ("; reconstructParMesh joins its parts"
            if collated else ""))
    flow, owner, names, axes = plane(base, case)
    folders = with_velocity(case, name)
    if not folders:
        raise BadInput(f"{case} has no velocities: no folder of a time with a field {name}" + ("; reconstructPar joins its parts"
            if collated else ""))
    for place in chosen_times([time for time, _ in folders], times, str(case)):
        time, folder = folders[place]
        if (folder / "polyMesh" / "points").is_file() or (folder / "polyMesh" / "points.gz").is_file():
            raise BadInput(f"{folder} has points of its own: the mesh moves, which particles do not follow")
        values, sides = frame(folder, name, len(flow.polygons), {patch: owner[face] for patch, face in names.items()})
        turned = values[name][:, [*axes, *({0, 1, 2} - set(axes))]]
        cells = {**{other: array for other, array in values.items() if other != name}, "velocity": turned}
        flow.frames.append(named(cells, None, str(folder / name)))
        flow.on_sides.append({patch: named_side(given, name, axes, flow.frames[-1]) for patch, given in sides.items()})
        flow.times.append(time)
        flow.unused = unused(values)
    return flow


def together(parts, case):
    """One Given of those of the processors, whose points meet. Raises BadInput where their times or fields differ."""
    first = parts[0]
    if any(one.times != first.times or [list(frame) for frame in one.frames] != [list(frame) for frame in first.frames]
            for one in parts):
        raise BadInput(f"{case}: its processors do not have the same times and fields; reconstructPar joins what is whole")
    before = np.cumsum([0] + [len(one.points) for one in parts])
    points = np.concatenate([one.points for one in parts])
    near = cKDTree(points).query_pairs(SAME * np.ptp(points, axis=0).max(), output_type="ndarray")
    place = groups(near, len(points))
    _, one_of = np.unique(place, return_index=True)
    flow = replace(first, points=points[one_of], kinds={}, sides={}, frames=[], on_sides=[],
        polygons=[place[polygon + by] for one, by in zip(parts, before) for polygon in one.polygons])
    for one in parts:
        flow.kinds |= one.kinds
    for name in flow.kinds:
        having = [(one, by) for one, by in zip(parts, before) if name in one.sides]
        flow.sides[name] = np.concatenate([place[one.sides[name] + by] for one, by in having])
    for k in range(len(first.times)):
        flow.frames.append({name: np.concatenate([one.frames[k][name] for one in parts]) for name in first.frames[k]})
        flow.on_sides.append({})
        for patch in flow.sides:
            given = [one.on_sides[k][patch] for one in parts if patch in one.sides]
            flow.on_sides[-1][patch] = {name: np.concatenate([one[name] for one in given]) for name in given[0]
                if all(name in one for one in given)}
    return flow


def is_time(name):
    return re.fullmatch(r"\d+(\.\d*)?([eE][-+]?\d+)?", name) is not None


def named_side(given, name, axes, inside):
    """u, v (and k, epsilon) at the edges of a patch, those that `given` has and that the cells have."""
    found = {}
    if name in given:
        found["u"], found["v"] = given[name][:, axes[0]], given[name][:, axes[1]]
    return found | {other: given[other] for other in ("k", "epsilon") if other in given and other in inside}


def frame(folder, name, cells, patches):
    """({field: values in the cells}, {patch: {field: values at its edges}}) of a time; patches: the cells along each."""
    inside, sides = {}, {patch: {} for patch in patches}
    for field in (name, *(other for other in FIELDS if any((folder / f"{other}{end}").is_file() for end in ("", ".gz")))):
        foam = Foam(folder / field)
        entries, _ = foam.entries()
        width = 3 if field == name else 1
        values = filled(entries.get("internalField"), cells, width)
        if values is None:
            raise BadInput(f"{folder / field} has no {'vectors' if width == 3 else 'numbers'} of its {cells} cells")
        inside[field] = values
        boundary = entries.get("boundaryField", {})
        for patch, along in patches.items():
            given = of_patch(boundary, patch)
            kind = given.get("type", "")
            value = filled(given.get("value"), len(along), width) if "value" in given else None
            if kind == "noSlip":
                value = np.zeros((len(along), 3))
            elif kind == "zeroGradient" or kind.endswith("WallFunction") and field == "k":
                value = values[along]
            if value is not None:
                sides[patch][field] = value
    return inside, sides


def of_patch(boundary, patch):
    """The dictionary of a patch, by its name or a pattern in quotes (the last that fits)."""
    if patch in boundary:
        return boundary[patch]
    fits = [entry for name, entry in boundary.items() if name.startswith('"') and re.fullmatch(name.strip('"'), patch)]
    return fits[-1] if fits else {}


def filled(entry, count, width):
    """Values of an entry, (count, width) or (count,), of a list or of one that is uniform; None where it has none of that form."""
    one = constant(entry)
    if one is not None and len(one) == width:
        return np.full((count, width), one) if width > 1 else np.full(count, one[0])
    if isinstance(entry, np.ndarray) and len(entry) == count and (entry.ndim == 1) == (width == 1):
        return entry
    return None


def plane(base, case):
    """(Given without times, owner cells of the faces, {patch: its faces}, axes of the plane) of a mesh one cell deep."""
    points, faces, owner = Foam(base / "points").plain("vector"), Foam(base / "faces").faces(), Foam(base / "owner").plain("label")
    patches = patches_of(base)
    if any(kind == "wedge" for kind, _ in patches.values()):
        raise BadInput(f"{case} is a wedge, of an axisymmetric flow; only plane flows are taken")
    sheets = np.array([face for kind, run in patches.values() if kind == "empty" for face in run], int)
    cells = owner.max() + 1
    if not len(sheets):
        raise BadInput(f"{case} is a 3-D flow: its mesh has no patches of type empty; only plane flows are taken")
    middle = np.array([points[faces[face]].mean(axis=0) for face in sheets])
    across = int(np.argmin(np.ptp(points[faces[sheets[0]]], axis=0)))
    low = middle[:, across] < 0.5 * (points[:, across].min() + points[:, across].max())
    sheet = sheets[low]
    polygons = [None] * cells
    for face in sheet:
        polygons[owner[face]] = faces[face]
    size = np.ptp(points, axis=0).max()
    if (any(one is None for one in polygons) or len(sheet) != cells
            or np.ptp(points[np.concatenate(polygons), across]) > 1e-6 * size):
        raise BadInput(f"{case} is not one cell deep between its empty patches, in a plane across x, y or z")
    used = np.unique(np.concatenate(polygons))
    number = np.full(len(points), -1)
    number[used] = np.arange(len(used))
    axes = [axis for axis in range(3) if axis != across]
    flow = Given(points[used][:, axes], [number[one] for one in polygons], [], [], True)
    names = {}
    for name, (kind, run) in patches.items():
        if kind == "empty" or kind.startswith("processor") or len(run) == 0:
            continue
        names[name] = np.arange(run.start, run.stop)
        ends = [number[faces[face]][number[faces[face]] >= 0] for face in names[name]]
        if any(len(pair) != 2 for pair in ends):
            raise BadInput(f"{case}: the patch {name} does not stand across the plane of the flow")
        flow.sides[name], flow.kinds[name] = np.array(ends), {"wall": "wall", "symmetry": "symmetry",
            "symmetryPlane": "symmetry"}.get(kind, "")
    return flow, owner, names, axes


def patches_of(base):
    """{name: (type, range of its faces)} of the file boundary."""
    foam = Foam(base / "boundary")
    begin = foam.data.find(b"(", foam.skip(0))
    entries, _ = foam.entries(begin + 1)
    try:
        return {name: (entry["type"], range(int(entry["startFace"]), int(entry["startFace"]) + int(entry["nFaces"])))
            for name, entry in entries.items() if isinstance(entry, dict)}
    except (KeyError, ValueError):
        raise foam.fault() from None
