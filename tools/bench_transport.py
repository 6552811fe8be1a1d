"""What a step of the transport costs, against the number of particles.

    python -m tools.bench_transport [--out DIR] [--numbers 100,1000,10000,100000] [--steps 20]

One way, every force but history (Brown-Lawler drag, weight less buoyancy, added mass, fluid
acceleration, lift, Magnus, fluctuations), no contacts, one core; and with history too.
Writes bench_transport.csv and bench_transport.png into DIR (default results/bench_transport).
Target: 100,000 particles at 5 steps a second, growth linear. Status 0 if met, else 1.
"""
from pathlib import Path

import numpy as np

from tools.command import ROOT, BadInput, Parser, guarded, whole
from tools.plotting import MARKERS, PAGE_WIDTH, curve, plt, save
from tools.run_folder import RunFolder
from tools.runner import machine, run_case
from tools.tables import write_table

SCRIPT, TARGET = "tests/transport/bench.edp", 5.0


def measure(number, steps, history, out):
    """(seconds of CPU a step in the flow, in the forces, peak MiB). The first steps of a run
    are its most expensive: the figure is over all of them."""
    folder = out / "runs" / f"{number}_{history}"
    done = run_case(SCRIPT, {"-number": number, "-tend": 0.001 * steps, "-history": history}, out=folder)
    if not done.ok:
        raise BadInput(f"{number} particles: {done.reason}")
    table = RunFolder(folder).table("steps")
    return table["time_flow"][-1] / steps, table["time_forces"][-1] / steps, done.memory_mb


def parser():
    """The options."""
    options = Parser(prog="python -m tools.bench_transport", description=__doc__)
    options.add_argument("--out", default=str(ROOT / "results" / "bench_transport"), metavar="DIR", help="where the files go")
    options.add_argument("--numbers", default="100,1000,10000,100000", metavar="N1,N2,...", help="numbers of particles")
    options.add_argument("--steps", type=whole(2), default=20, metavar="N", help="steps a run (default 20)")
    return options


def main(words=None):
    """Run, write and judge."""
    given = parser().parse_args(words)
    try:
        numbers = sorted(int(word) for word in given.numbers.split(","))
    except ValueError:
        raise BadInput(f"--numbers needs whole numbers with commas between, not '{given.numbers}'") from None
    if numbers[0] < 1:
        raise BadInput("--numbers are at least 1")
    out = Path(given.out).resolve()
    out.mkdir(parents=True, exist_ok=True)
    rows = []
    for history in (0, 1):
        for number in numbers:
            flow, forces, memory = measure(number, given.steps, history, out)
            rows.append([number, history, flow, forces, 1 / (flow + forces), 1e6 * (flow + forces) / number, memory])
            print(f"{number:>8} particles, history {history}: {1e3 * flow:8.2f} ms flow, {1e3 * forces:8.2f} ms forces, {rows[-1][4]:8.1f} steps/s, "
                  f"{rows[-1][5]:6.2f} us a particle and step, {memory:.0f} MiB", flush=True)
    write_table(out / "bench_transport.csv", ["particles", "history", "flow_s", "forces_s", "steps_per_s", "us_per_particle_step", "peak_mib"], rows)
    figure, axes = plt.subplots(figsize=(0.6 * PAGE_WIDTH, 3.0), layout="constrained")
    for history, label in ((0, "all forces but history"), (1, "with history (window 20)")):
        mine = np.array([row for row in rows if row[1] == history])
        axes.loglog(mine[:, 0], mine[:, 2] + mine[:, 3], marker=MARKERS[history], markersize=4, label=label, **curve(history))
    top = np.array([numbers[-1] / 100, numbers[-1]], dtype=float)
    axes.loglog(top, 0.04 * top / 1e5, color="#777777", linewidth=0.8, label="linear")
    if numbers[-1] >= 100000:
        axes.plot([1e5], [1 / TARGET], "*", color="black", markersize=8, label="target: 5 steps/s at 100,000")
    axes.set_xlabel("particles")
    axes.set_ylabel("CPU time of a step (s)")
    axes.grid(True)
    axes.legend()
    print(save(figure, out / "bench_transport.png"))
    print(machine())
    rates = [row[4] for row in rows if row[0] == 100000 and row[1] == 0]
    if not rates:
        return 0
    print(f"target {TARGET:g} steps/s with 100,000 particles, measured {rates[0]:.1f}: {'pass' if rates[0] >= TARGET else 'FAIL'}")
    return 0 if rates[0] >= TARGET else 1


if __name__ == "__main__":
    guarded(main)
