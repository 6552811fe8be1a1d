"""Steady flows of the turbulence model and their laws: the runs of tools.validate_steady as rows of the report of `flow`."""
from tools.validate_steady import RUNS
from tools.validation import Failed


def turbulence(context):
    """Channel and pipe friction, steps, diaphragms, the pipe of the paper: k-epsilon with wall functions."""
    for name, script, options, targets in RUNS:
        try:
            run = context.run(script, options, name)
        except Failed as problem:
            for quantity, source, low, high in targets:
                yield context.failed(f"{name}: {quantity.replace('_', ' ')}", source, (low + high) / 2, problem)
            continue
        found = run.folder.results
        for quantity, source, low, high in targets:
            label, allowed = f"{name.replace('_', ' ')}: {quantity.replace('_', ' ')}", {"at_most": high} if low == 0 else {"atol": (high - low) / 2}
            yield context.row(label, source, 0 if low == 0 else (low + high) / 2, found[quantity], cpu_s=run.cpu_s, **allowed)
