"""Where the maps end: the limits in words, each with its remedy; the defaults must lie inside."""
from tools.stress.classes import FAILED, GOOD, LETTERS, WORDS
from tools.base.tables import write_table, write_text

COLUMNS = ["map", "class", "where", "cells", "example", "remedy"]


def places(one, grid, cells):
    """Where cells stand, in words: for each y the run of x; like ys together."""
    xs = list(dict.fromkeys(x for x, _ in grid))
    found = {}
    for y in dict.fromkeys(y for _, y in grid):
        mine = [x for x in xs if (x, y) in cells]
        if mine:
            found.setdefault(tuple(mine), []).append(y)
    words = []
    for mine, ys in found.items():
        at = f"{one.x.name} {stretch([one.x.text(x) for x in mine], [one.x.text(x) for x in xs])}{' ' + one.x.unit if one.x.unit else ''}"
        words.append(f"{at} at {one.y.name} {' / '.join(one.y.text(y) for y in ys)}{' ' + one.y.unit if one.y.unit else ''}")
    return "; ".join(words)


def stretch(mine, every):
    """'0.008 to 0.032' for neighbours on the axis, a list for others."""
    places = [every.index(word) for word in mine]
    if len(mine) > 1 and places == list(range(places[0], places[-1] + 1)):
        return "all" if len(mine) == len(every) else f"{mine[0]} to {mine[-1]}"
    return ", ".join(mine)


def limits_of(one, grid, rows):
    """Rows of limits.csv: one for each class of a map but "accurate", and but those that are
    stable and have no reference."""
    found = []
    for kind in LETTERS:
        cells = [pair for pair in grid if rows[pair]["class"] == kind and (kind != "stable" or rows[pair]["tolerance"] > 0)]
        if kind == "accurate" or not cells:
            continue
        example = next((rows[pair]["reason"] for pair in cells if rows[pair]["reason"]), "")
        found.append([one.name, kind, places(one, grid, cells), len(cells), example, one.remedies.get(kind, "")])
    return found


def inside(one, grid, rows):
    """(true if the default lies well inside, what is wrong in words): its own cell and its
    neighbours on the whole map are stable, those of them that were run."""
    xs, ys = one.x.values, one.y.values
    i, j = xs.index(one.default[0]), ys.index(one.default[1])
    lines = [(i, j)]
    lines += [(i + d, j) for d in (-1, 1) if 0 <= i + d < len(xs) and not isinstance(one.default[0], str)]
    lines += [(i, j + d) for d in (-1, 1) if 0 <= j + d < len(ys) and not isinstance(one.default[1], str)]
    bad = [(xs[a], ys[b]) for a, b in lines if (xs[a], ys[b]) in grid and rows[xs[a], ys[b]]["class"] not in GOOD]
    return not bad, "; ".join(f"{one.x.name} {one.x.text(x)}, {one.y.name} {one.y.text(y)}: {WORDS[rows[x, y]['class']]}" for x,
        y in bad)


def defaults_inside(maps):
    """[(map, true or false, words)], with the map of the cases: each stable at its time step and at twice it."""
    found = []
    for one, grid, rows in maps:
        if one.name == "defaults":
            bad = [(x, y) for x, y in grid if x in (1, 2) and rows[x, y]["class"] not in GOOD]
            found.append((one.name, not bad, "; ".join(f"{y} at {x:g} times its time step: {rows[x, y]['class']}" for x, y in bad)))
        elif one.default in grid:
            found.append((one.name, *inside(one, grid, rows)))
    return found


def write_limits(maps, out, head):
    """limits.csv and limits.md; returns the rows of the first."""
    rows = [row for one, grid, cells in maps for row in limits_of(one, grid, cells)]
    write_table(out / "limits.csv", COLUMNS, rows)
    text = ["# Limits of stability", "", head, "", "| map | class | cells | where | remedy |", "| --- | --- | --- | --- | --- |"]
    for name, kind, where, number, _, remedy in rows:
        text.append(f"| {name} | {WORDS[kind]} | {number} | {where} | {remedy} |")
    text += ["", "Cells of each class:", ""]
    for one, grid, cells in maps:
        count = {kind: sum(cells[pair]["class"] == kind for pair in grid) for kind in LETTERS}
        text.append(f"- {one.title}: " + ", ".join(f"{number} {WORDS[kind]}" for kind, number in count.items() if number)
            + f". Accurate: {one.held}.")
    text += ["", "The defaults of the cases lie well inside (their own cell and its neighbours are stable):", ""]
    text += [f"- {name}: {'yes' if good else 'NO, ' + words}" for name, good, words in defaults_inside(maps)]
    write_text(out / "limits.md", "\n".join(text) + "\n")
    return rows


def failures(maps):
    """[words] on each cell that went wrong without the run saying so."""
    return [f"{one.name}: {one.x.name} {one.x.text(x)}, {one.y.name} {one.y.text(y)}: {WORDS[rows[x, y]['class']]}: {rows[x, y]['reason']}"
            for one, grid, rows in maps for x, y in grid if rows[x, y]["class"] in FAILED]
