"""The validation report: report.csv and report.html, headed by date, commit, host, versions."""
import html
import math
import os
from datetime import datetime, timezone

from tools.base.runner import commit, machine, versions
from tools.base.tables import write_table, write_text

COLUMNS = ["case", "quantity", "source", "target", "allowed", "measured", "difference", "pass", "cpu_s", "figure", "reason"]
STYLE = """body{font:15px/1.45 system-ui,sans-serif;max-width:70em;margin:2em auto;padding:0 1em;color:#111}
table{border-collapse:collapse;width:100%;margin:.6em 0 1.5em}
th,td{border-bottom:1px solid #ccc;padding:.3em .5em;text-align:left;vertical-align:top}
td.n,th.n{text-align:right;font-variant-numeric:tabular-nums;white-space:nowrap}
td.pass{color:#00573a}td.fail{color:#a33000;font-weight:bold}img{max-width:100%;height:auto}
dl{display:grid;grid-template-columns:max-content auto;gap:.1em 1em}dd{margin:0}"""


def heading():
    """What the figures depend on: [(name, text)]."""
    known = versions()
    first = ["FreeFEM", "python", "numpy", "gmsh"]
    order = first + [name for name in known if name not in first]
    return [("date", datetime.now(timezone.utc).strftime("%Y-%m-%d %H:%M UTC")),
            ("commit", commit()), ("host", machine()),
            ("versions", ", ".join(f"{name} {known[name]}" for name in order if name in known))]


def number(value):
    """A number for reading, empty if there is none."""
    return f"{value:.5g}" if math.isfinite(value) else ""


def relative(figure, folder):
    """A figure's path as the report links it."""
    return os.path.relpath(figure, folder).replace(os.sep, "/") if figure else ""


def difference(row):
    """measured - target, in per cent where the target is not 0."""
    if not (math.isfinite(row.measured) and math.isfinite(row.target)):
        return ""
    gap = row.measured - row.target
    return f"{100 * gap / abs(row.target):+.3g} %" if row.target else f"{gap:+.3g}"


def write_report(rows, head, folder, whole=True):
    """Write report.csv and report.html into the folder; whole: no comparison is still to come."""
    table = [[r.case, r.quantity, r.source, r.target, r.allowed, r.measured, r.measured - r.target,
              "yes" if r.passed else "no", r.cpu_s, relative(r.figure, folder), r.reason] for r in rows]
    write_table(folder / "report.csv", COLUMNS, table, [f"{name}: {value}" for name, value in head])
    write_text(folder / "report.html", page(rows, head, folder, whole))
    return folder / "report.html"


def page(rows, head, folder, whole):
    """The report as one page of HTML."""
    say = html.escape
    passed = sum(row.passed for row in rows)
    state = f"{passed} of {len(rows)} comparisons pass" + ("" if whole else "; the run is not finished")
    lines = ["<!doctype html>", '<html lang="en"><head><meta charset="utf-8"><title>Validation</title>',
             f"<style>{STYLE}</style></head><body>", "<h1>Validation</h1>", f"<p>{say(state)}.</p>", "<dl>"]
    lines += [f"<dt>{say(name)}</dt><dd>{say(value)}</dd>" for name, value in head] + ["</dl>"]
    for case in dict.fromkeys(row.case for row in rows):
        mine = [row for row in rows if row.case == case]
        lines += [f"<h2>{say(case.replace('_', ' '))}</h2>", "<table><thead><tr><th>quantity</th><th>source</th>"
                  '<th class="n">target</th><th class="n">allowed</th><th class="n">measured</th><th class="n">difference</th>'
                  '<th>pass</th><th class="n">CPU (s)</th></tr></thead><tbody>']
        for row in mine:
            word = "pass" if row.passed else "fail"
            remark = f"<br><small>{say(row.reason)}</small>" if row.reason else ""
            lines.append(f"<tr><td>{say(row.quantity)}{remark}</td><td>{say(row.source)}</td>"
                         f'<td class="n">{number(row.target)}</td><td class="n">{say(row.allowed)}</td>'
                         f'<td class="n">{number(row.measured)}</td><td class="n">{difference(row)}</td>'
                         f'<td class="{word}">{word}</td><td class="n">{number(row.cpu_s)}</td></tr>')
        lines.append("</tbody></table>")
        for figure in dict.fromkeys(relative(row.figure, folder) for row in mine if row.figure):
            lines.append(f'<p><img src="{say(figure, quote=True)}" alt="{say(case)}: {say(figure, quote=True)}"></p>')
    return "\n".join(lines + ["</body></html>", ""])
