"""Runs on several processes: the same mesh on more and more of them, meshes that grow with them, and a model beyond.

The settling disk and the settling sphere, on one process of plain FreeFem++ bound to one core and on 2, 4, ... up to the number
of cores, on a mesh for one process, a mesh twice as large for two, and so on. Wall clock of the whole run and of its last steps,
user CPU time and memory of the largest process. The sources of the runs on several processes are copies that count messages and
take the time of the linear systems of the whole mesh. tools/bench/partitions.py makes a model of them.
"""
import contextlib
import os
import re
import shutil
from dataclasses import dataclass, field

from tools.base.command import ROOT, BadInput
from tools.base.mesh_files import words_of
from tools.base.ranks import run_on
from tools.base.runner import make_mesh
from tools.base.timed import tree
from tools.bench.partitions import Cost, line_through, model, net_of, shares

MODELLED = (2, 4, 8, 16, 32)
TICK = """int benchCalls = 0;
func int benchTick() {
    if (benchCalls == BENCH_WARM || benchCalls == BENCH_STEPS) if (ranksFirst) exec("echo bench wall $(date +%s.%N)");
IFMACRO(ranksMany)
    if (benchCalls == BENCH_WARM) benchCount = 0.;
    if (benchCalls == BENCH_STEPS) {
        cout.precision(12); cout << "bench count";
        for (int k = 0; k < 7; ++k) cout << " " << benchCount[k];
        cout << endl;
    }
ENDIFMACRO
    return benchCalls++;
}
macro caseStep() benchTick(); // EOM
"""
# (file, what stands there, what is put behind it). Counted: passes, arrays of nodes and of vertices in them, sums, numbers in
# them, linear systems of the whole mesh, their seconds.
COUNTERS = (
    ("lib/core/ranks_mpi.idp", "macro ranksKindIncluded()1// EOM", "\nreal[int] benchCount(7);\nbenchCount = 0.;"),
    ("lib/core/ranks_mpi.idp", "func real ranksSum(real mine) {", " benchCount[3] += 1; benchCount[4] += 1;"),
    ("lib/core/ranks_mpi.idp", "func real ranksMax(real mine) {", " benchCount[3] += 1; benchCount[4] += 1;"),
    ("lib/core/ranks_mpi.idp", "func int ranksSums(real[int] & a) {", " benchCount[3] += 1; benchCount[4] += a.n;"),
    ("lib/core/ranks_mpi.idp", "func int ranksTops(real[int] & a) {", " benchCount[3] += 1; benchCount[4] += a.n;"),
    ("lib/core/parts_mpi.idp", "func int partPass(real[int] & a, int[int][int] & send, int[int][int] & take) {",
        " benchCount[0] += 1;"),
    ("lib/core/parts_mpi.idp", "func int partNodes(real[int] & u) {", " benchCount[1] += 1;"),
    ("lib/core/parts_mpi.idp", "func int partTriple(real[int] & s) {", " benchCount[1] += 3;"),
    ("lib/core/parts_mpi.idp", "func int partVertices(real[int] & p) {", " benchCount[2] += 1;"),
    ("lib/flow/parts_mpi.idp", "func int partPair(real[int] & s) {", " benchCount[1] += 2;"),
    ("lib/flow/parts_mpi.idp", "macro partBeside(s, all) ", "benchCount[1] += all ? 0. : 2./partLayers; "),
    ("lib/flow/parts_mpi.idp", "partGatherQ(r, right);", " benchCount[5] += 1; benchCount[6] -= mpiWtime();"),
    ("lib/flow/parts_mpi.idp", "all = A^-1*right;", " benchCount[6] += mpiWtime();"),
    ("lib/spheres/pressure_step.idp", "partGatherQ(r, right);", " benchCount[5] += 1; benchCount[6] -= mpiWtime();"),
    ("lib/spheres/pressure_step.idp", "pressureSolve(right, all);", " benchCount[6] += mpiWtime();"),
)


@dataclass
class Scene:
    """A case whose mesh has elements of `size` (m) for one process and of size/number^(1/dimension) for more; its time step for
    this size (s); steps, and the first that do not count."""
    name: str
    dimension: int
    size: float
    dt: float
    steps: int
    warm: int

    @property
    def script(self):
        return f"cases/{self.name}.edp"


SCENES = {False: (Scene("settling_disk", 2, 0.0208, 0.0007, 60, 20), Scene("settling_sphere", 3, 0.0019, 0.0063, 30, 10)),
          True: (Scene("settling_disk", 2, 0.05, 0.0014, 12, 4), Scene("settling_sphere", 3, 0.005, 0.012, 8, 4))}


@dataclass
class Run:
    """One run: wall clock of the whole and of a step (s), user CPU of the largest process (s), its memory (MiB); what a step
    counts (COUNTERS), nothing on one process."""
    wall_s: float
    step_s: float
    cpu_s: float
    memory_mb: float
    counts: tuple = ()


@dataclass
class Found:
    """What was measured of a scene: runs {(mesh, processes): [Run]}, a mesh being named by the processes it is made for; nodes
    {mesh: nodes of the velocity}; shares {parts: Share} of mesh 2; net; note: why something is missing."""
    scene: Scene
    runs: dict = field(default_factory=dict)
    nodes: dict = field(default_factory=dict)
    shares: dict = field(default_factory=dict)
    net: object = None
    note: str = ""


def counting(folder, scene):
    """A tree of the sources in which the case prints the times of its steps and what they count."""
    tree(folder, scene.script, scene.steps, scene.warm)
    path = folder / scene.script
    text = (ROOT / scene.script).read_text()
    driver = re.search(r'^include "scripts/\w+\.edp"', text, flags=re.M).start()
    tick = TICK.replace("BENCH_STEPS", str(scene.steps)).replace("BENCH_WARM", str(scene.warm))
    path.write_text(text[:driver] + tick + text[driver:])
    for name, place, more in COUNTERS:
        text = (folder / name).read_text()
        if text.count(place) != 1:
            raise BadInput(f"{name} has no line any more at which to count: {place}")
        (folder / name).write_text(text.replace(place, place + more))
    return folder


@contextlib.contextmanager
def on_cores(cores):
    """What is started within runs on these cores, where the system can be told so."""
    if not hasattr(os, "sched_setaffinity"):
        yield
        return
    before = os.sched_getaffinity(0)
    os.sched_setaffinity(0, cores)
    try:
        yield
    finally:
        os.sched_setaffinity(0, before)


def run_of(scene, folder, mesh, factor, processes, cores, limit):
    """The Run on a mesh whose elements are `factor` times those for one process."""
    dt = scene.dt * factor
    out = folder / "run"
    words = [scene.script, "-mesh", mesh, "-dt", f"{dt:.12g}", "-cfl", 0, "-tend", f"{dt * (scene.steps + 2):.12g}", "-every", 1000,
        "-out", out]
    shutil.rmtree(out, ignore_errors=True)
    with on_cores(cores if processes > 1 else {max(cores)}):
        done = run_on(processes, words, folder, limit)
    walls = [float(word) for word in re.findall(r"^bench wall (\S+)$", done.log, flags=re.M)]
    counted = scene.steps - scene.warm
    if len(walls) != 2:
        raise BadInput(f"{scene.script} ended before its last timed step")
    counts = re.search(r"^bench count (.*)$", done.log, flags=re.M)
    return Run(done.wall_s, (walls[1] - walls[0]) / counted, max(done.cpu_s), done.memory_mb,
        tuple(float(word) / counted for word in counts.group(1).split()) if counts else ())


def nodes_of(path, dimension):
    """Nodes of P2 on a mesh without holes: vertices and edges, by Euler's formula."""
    words = words_of(path)

    def number(name):
        return int(words[words.index(name) + 1])
    vertices = number("Vertices")
    if dimension == 2:
        return 2 * vertices + number("Triangles") - 1
    return 2 * vertices + number("Tetrahedra") + number("Triangles") // 2 - 1


def measure(scene, out, cores, repeats, limit, say):
    """The Found of a scene on 1, 2, 4, ... processes up to the number of `cores` (set)."""
    found = Found(scene)
    most = [number for number in (1, 2, 4, 8, 16, 32, 64) if number <= max(2, len(cores))]
    folder = counting(out / "trees" / f"processes_{scene.name}", scene)
    meshes = {}
    for number in most:
        size = scene.size * number ** (-1 / scene.dimension)
        meshes[number] = make_mesh([scene.name, "--size", f"{size:.12g}"], out / "meshes" / f"{scene.name}_on_{number}.mesh")
        found.nodes[number] = nodes_of(meshes[number], scene.dimension)
    wanted = [(mesh, number) for mesh in most for number in most if mesh in (1, 2) or number in (1, mesh)]
    for repeat in range(repeats):
        for mesh, number in wanted:
            run = run_of(scene, folder, meshes[mesh], mesh ** (-1 / scene.dimension), number, cores, limit)
            found.runs.setdefault((mesh, number), []).append(run)
            say(f"processes {scene.name}, {found.nodes[mesh]} nodes, on {number}, run {repeat + 1}: {run.wall_s:.2f} s, "
                f"{1e3 * run.step_s:.1f} ms a step")
    found.shares = shares(meshes[2], MODELLED, out / "trees" / f"parts_{scene.name}")
    with on_cores(cores):
        found.net = net_of(run_on(2, [ROOT / "tools/bench/ping_pong.edp"], limit=limit).log)
    return found


def run_processes(out, quick, limit, cores, say):
    """The Found of both scenes; without MPI with a note."""
    found = []
    for scene in SCENES[quick]:
        try:
            found.append(measure(scene, out, cores, 1 if quick else 2, limit, say))
        except BadInput as problem:
            found.append(Found(scene, note=str(problem)))
            say(f"processes {scene.name}: {problem}")
    return found


def least(runs, name):
    """Least of a number of the Runs: what else the machine does makes a run longer, never shorter."""
    return min(getattr(run, name) for run in runs)


def cost_of(found):
    """The Cost of a step on mesh 2: from its run on two processes, and both meshes on one process and on two."""
    counts = {mesh: [min(values) for values in zip(*(run.counts for run in found.runs[mesh, 2]))] for mesh in (1, 2)}
    alone = [least(found.runs[mesh, 1], "step_s") - counts[mesh][6] for mesh in (1, 2)]
    node, fixed = line_through([found.nodes[1], found.nodes[2]], alone)
    passes, arrays, vertex_arrays, sums, numbers, _, solve = counts[2]
    return Cost(node, fixed, solve, passes, arrays, vertex_arrays, sums, numbers)


def ranges(runs, name, factor=1.0, digits=1):
    """Least and largest of a number of the Runs, in words."""
    values = [factor * getattr(run, name) for run in runs]
    low, high = f"{min(values):.{digits}f}", f"{max(values):.{digits}f}"
    return low if low == high else f"{low} to {high}"


def measured_lines(found):
    """The table of what was measured."""
    lines = ["| nodes of the velocity | processes | whole run (s) | a step (ms) | faster: whole run, steps "
        "| user CPU of the largest process (s) | its memory (MiB) |", "|" + " --- |" * 7]
    for (mesh, number), runs in sorted(found.runs.items()):
        alone = found.runs[mesh, 1]
        faster = "" if number == 1 else ", ".join(f"{least(alone, name) / least(runs, name):.2f}"
            for name in ("wall_s", "step_s"))
        lines.append(f"| {found.nodes[mesh]:,} | {number} | {ranges(runs, 'wall_s')} | {ranges(runs, 'step_s', 1e3)} | {faster} | "
            f"{ranges(runs, 'cpu_s')} | {max(run.memory_mb for run in runs):.0f} |")
    grown = [f"{number}: {100 * least(found.runs[1, 1], 'step_s') / least(found.runs[number, number], 'step_s'):.0f} %"
        for number in sorted(found.nodes) if number > 1]
    return [*lines, "", "Weak scaling (time of a step on one process, over that on N processes with N times the nodes): "
        + ", ".join(grown) + "."]


def model_lines(found):
    """The table of the model."""
    cost, net, sizes = cost_of(found), found.net, sorted(found.shares)
    alone, two = (least(found.runs[2, number], "step_s") for number in (1, 2))
    far = type(net)(10 * net.message_s, 10 * net.byte_s, 10 * net.sum_s)
    lines = ["", f"**Model, not measured.** A step passes values to neighbours {cost.passes:.0f} times "
        f"({cost.arrays:.0f} arrays of nodes, {cost.vertex_arrays:.0f} of vertices) and sums over all processes {cost.sums:.0f} "
        f"times ({cost.numbers:,.0f} numbers). A message takes {1e6 * net.message_s:.1f} us and {1e9 * net.byte_s:.2f} ns a byte, "
        f"a sum {1e6 * net.sum_s:.1f} us. A node takes {1e6 * cost.node_s:.3f} us of a step, the linear systems of the whole mesh "
        f"(all on every process, as with -pressure-solver factor) {1e3 * cost.solve_s:.1f} ms, the rest "
        f"{1e3 * cost.fixed_s:.1f} ms. On 2 processes the model gives "
        f"{1e3 * model(cost, found.shares[2], net)['whole']:.1f} ms, the measurement {1e3 * two:.1f} ms.", "",
        "| processes | nodes of the largest part | neighbours | KiB of an array of nodes | nodes (ms) | alike on all | systems "
        "| messages | sums | a step (ms) | faster | faster, messages and sums ten times as long |", "|" + " --- |" * 12]
    for parts in sizes:
        share = found.shares[parts]
        step = {name: 1e3 * value for name, value in model(cost, share, net).items()}
        lines.append(f"| {parts} | {share.nodes:,} | {share.neighbours} | {8 * share.entries / 1024:.0f} | {step['nodes']:.1f} | "
            f"{step['fixed']:.1f} | {step['systems']:.1f} | {step['messages']:.1f} | {step['sums']:.1f} | {step['whole']:.1f} | "
            f"{1e3 * alone / step['whole']:.1f} | {alone / model(cost, share, far)['whole']:.1f} |")
    return lines


def processes_lines(results):
    """The section of the page."""
    lines = ["## Several processes", ""]
    for found in results:
        lines += [f"### {found.scene.name}, {found.scene.dimension}-D", ""]
        if found.note:
            lines += [found.note, ""]
            continue
        lines += [*measured_lines(found), *model_lines(found), ""]
    return lines
