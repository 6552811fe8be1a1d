"""docs/reference/tables.md: the columns of every table, from the headers of the files that write them."""
import re
from dataclasses import dataclass

from tools.base.command import ROOT, BadInput
from tools.docs.headers import header, prose

HEAD = """# Columns of the tables

Every table is a CSV file with one line of names. Units are those of the case: where a unit stands here in SI, read it in
the units that the case uses. The columns are in the order of the file.

*This page is made by `python -m tools.docs` from the files that write the tables.*
"""


@dataclass
class Table:
    """A table: its name, the runs that write it, the file with outHeader(...), and where its columns are explained:
    (file, begin, end), the text of that file's header from the words `begin` up to the words `end`."""
    name: str
    runs: str
    writer: str
    about: tuple
    columns: str = ""  # where no outHeader(...) names them


PARTICLES = "lib/bodies/particle_table.idp"
RECORD = "lib/record/record.idp"
TRANSPORT = "scripts/transport.edp"
CONTACTS = "scripts/contacts.edp"
SPHERES = "lib/spheres/record.idp"
DRY = "lib/spheres/dry_record.idp"
ENTRIES, PRESENT = "lib/bodies/entry_table.idp", "lib/spheres/sphere_entries.idp"
FLUID = (RECORD, "step, t, dt (s), iterations", "Exit codes")
TABLES = [
    Table("particles.csv", "every run with particles", PARTICLES, (PARTICLES, "step, t (s), id", "; contacts.csv")),
    Table("contacts.csv", "every run with particles", PARTICLES, (PARTICLES, "t (s), i, j", "Needs:")),
    Table("walls.csv", "every run with walls", "", ("scripts/project_velocities.edp", "x1,y1,x2,y2", "Writes"), "x1,y1,x2,y2"),
    Table("fluid.csv", "`resolved.edp`", RECORD, FLUID),
    Table("fluid.csv", "`flow.edp`", "scripts/flow.edp", FLUID),
    Table("entries.csv", "`resolved.edp` and `contacts.edp`", ENTRIES, (ENTRIES, "t (s), x, y (m)", "shapes.csv id")),
    Table("exits.csv", "`resolved.edp`", RECORD, (RECORD, "for particles removed", "recordStep")),
    Table("shapes.csv", "`resolved.edp` and `contacts.edp`, where a particle is an ellipse", ENTRIES,
        (ENTRIES, "id, semi-axes in m", "Exit codes")),
    Table("forces.csv", "`resolved.edp` with `-forces 1`", "lib/record/body_forces.idp", ("lib/record/body_forces.idp",
        "t (s), id, fx, fy (N/m)", "Exit codes")),
    Table("forces.csv", "`flow.edp` with `-forces 1`", "scripts/flow.edp", ("scripts/flow.edp", "t, force_x, force_y in N/m",
        "with -wallforces")),
    Table("wallforces.csv", "with `-wallforces 1`", "lib/record/wall_forces.idp", ("lib/record/wall_forces.idp",
        "t,label,fx,fy (N/m)", "Exit codes")),
    Table("fluxes.csv", "with `-fluxes 1`", "lib/record/fluxes.idp", ("lib/record/fluxes.idp", "t (s), label, flux",
        "fluxesWrite")),
    Table("budget.csv", "`resolved.edp` with `-budget 1`", "lib/record/body_budget.idp", ("lib/record/body_budget.idp",
        "t, momentum (N s/m)", "bodyBudgetStep")),
    Table("budget.csv", "`flow.edp` with `-budget 1`", "lib/record/flow_budget.idp", ("lib/record/flow_budget.idp",
        "gained: increase", "Needs:")),
    Table("particles.csv", "`spheres.edp`", SPHERES, (SPHERES, "step, t (s), id, x, y, z", "contacts.csv ")),
    Table("contacts.csv", "`spheres.edp`", SPHERES, (SPHERES, "t (s), i, j (ids; -1 - k", "fluid.csv ")),
    Table("fluid.csv", "`spheres.edp`", SPHERES, (SPHERES, "step, t, dt (s), iterations", "Exit codes")),
    Table("forces.csv", "`spheres.edp` with `-forces 1`", "lib/spheres/sphere_forces.idp", ("lib/spheres/sphere_forces.idp",
        "t (s), id, fx, fy, fz (N)", "forcesFind")),
    Table("wallforces.csv", "`spheres.edp` with `-wallforces 1`", "lib/spheres/sphere_sides.idp", ("lib/spheres/sphere_sides.idp",
        "wallforces.csv: t, label", "sidesWrite")),
    Table("fluxes.csv", "`spheres.edp` with `-fluxes 1`", "lib/spheres/sphere_sides.idp", ("lib/spheres/sphere_sides.idp",
        "fluxes.csv: t (s), label, flux", "wallforces.csv: t")),
    Table("entries.csv", "`spheres.edp` and `contact_spheres.edp`", PRESENT, (PRESENT, "t, s; id", "presentRows")),
    Table("exits.csv", "`spheres.edp`", "lib/spheres/leave.idp", ("lib/spheres/leave.idp", "t, s; id", "leaveFind")),
    Table("budget.csv", "`spheres.edp` with `-budget 1`", "lib/spheres/sphere_budget.idp", ("lib/spheres/sphere_budget.idp",
        "t, momentum (3, N s)", "balanceTouch")),
    Table("particles.csv", "`contact_spheres.edp`", DRY, (SPHERES, "step, t (s), id, x, y, z", "contacts.csv ")),
    Table("contacts.csv", "`contact_spheres.edp`", DRY, (SPHERES, "t (s), i, j (ids; -1 - k", "fluid.csv ")),
    Table("motion.csv", "`contact_spheres.edp`", DRY, (DRY,
        "step, t (s), kinetic", "walls.csv ")),
    Table("walls.csv", "`contact_spheres.edp`", DRY, (DRY, "x1,y1,z1", "Exit codes")),
    Table("motion.csv", "`contacts.edp`", CONTACTS, (CONTACTS, "step, t (s), kinetic", "walls.csv ")),
    Table("wallmoves.csv", "`contacts.edp`", CONTACTS, (CONTACTS, "t,wall,x1", "Checkpoints")),
    Table("outlines.csv", "`contacts.edp` and `resolved.edp` with bodies of any shape", RECORD, ("scripts/contacts_shapes.idp",
        "id, part, closed", "Exit codes")),
    Table("entries.csv", "`transport.edp`", "lib/transport/record.idp", (TRANSPORT, "t (s), id, x, y (m)", "exits.csv ")),
    Table("exits.csv", "`transport.edp`", "lib/transport/record.idp", (TRANSPORT, "the same of each particle that leaves",
        "steps.csv ")),
    Table("steps.csv", "`transport.edp`", "lib/transport/record.idp", (TRANSPORT, "step, t (s), particles", "coupling.csv ")),
    Table("coupling.csv", "`transport.edp` with `-coupling two-way`", "lib/transport/two_way_record.idp",
        (TRANSPORT, "two-way: t (s); force_x", "Restarts")),
    Table("results.csv", "steady flows", "lib/steady/results.idp", ("scripts/steady_laminar.edp", "quantity, value, unit)", ";")),
    Table("wall.csv", "`steady.edp`", "scripts/steady.edp", ("lib/steady/measures.idp", "midpoint (m, m); -1", "measureZones")),
    Table("zones.csv", "`steady.edp`", "scripts/steady.edp", ("lib/steady/measures.idp", "side, from, to (m)", "measureFlux")),
]


def columns(table):
    """The columns as the code writes them. Raises BadInput where the writer has no such table."""
    if table.columns:
        return table.columns.split(",")
    found = re.search(rf'outHeader\("{re.escape(table.name)}",\s*"([^"]+)"(?: \+ \w+\(\))?\)', (ROOT / table.writer).read_text())
    if not found:
        raise BadInput(f'{table.writer} has no outHeader("{table.name}", ...); name its writer in tools/docs/tables.py')
    return found.group(1).split(",")


def explained(table):
    """What the header says of a table: a list of lines without the space in front. Raises BadInput where it has no such words."""
    path, begin, end = table.about
    text = "\n".join(header(path))
    spaced = r"\s+"  # a line may end within the words
    first = re.search(spaced.join(map(re.escape, begin.split())), text)
    start = first.start() if first else -1
    last = re.compile(spaced.join(map(re.escape, end.split()))).search(text, start + 1)
    stop = last.start() if last else -1
    if start < 0 or stop < 0:
        raise BadInput(f"the header of {path} no longer has '{begin}' ... '{end}'; name the new words in tools/docs/tables.py")
    return [line.rstrip() for line in text[start:stop].rstrip(" ,;\n").split("\n")]


def entries(lines):
    """Lines as (names, meaning) where they have the form of a list, else one entry without names."""
    found = []
    for line in lines:
        item = re.match(r" {1,3}([\w*, ]+?) {2,}(\S.*)$", line) if not line.startswith("     ") else None
        if item:
            found.append([item.group(1), item.group(2)])
        elif found:
            found[-1][1] += " " + line.strip()
        else:
            found.append(["", line.strip()])
    return found


def section(table):
    """One table as Markdown: its columns from the code, their meaning from the header."""
    names = columns(table)
    text = f"## `{table.name}`: {table.runs}\n\nColumns: " + ", ".join(f"`{name}`" for name in names) + ".\n\n"
    rows = []
    for listed, meaning in entries(explained(table)):
        # A table of another driver with fewer columns has the same header.
        kept = [name for name in listed.split(", ") if name in names or name.endswith("*")] if listed else []
        if kept:
            rows.append(f"| {', '.join(f'`{name}`' for name in kept)} | {prose(meaning)} |\n")
        elif not listed:
            whole = "(" + meaning if meaning.count(")") > meaning.count("(") else meaning
            text += "Meaning: " + prose(whole.rstrip(".")) + ".\n\n"
    if rows:
        text += "| column | meaning |\n| --- | --- |\n" + "".join(rows) + "\n"
    return text


def pages():
    """The page of the tables: a dict of path: text."""
    return {"docs/reference/tables.md": HEAD + "\n" + "".join(section(table) for table in TABLES).rstrip() + "\n"}
