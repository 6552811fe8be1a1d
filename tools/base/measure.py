"""Run a command and write down what it cost: python tools/base/measure.py REPORT COMMAND...

A process of its own, as small as can be: the peak memory that the system reports for a
child includes that of the process it was forked from. The report holds one line: status
(negative: the signal), CPU seconds, wall-clock seconds, peak memory in MiB.
"""
import os
import sys
import time


def main(report, command):
    """Run the command; ends with its status."""
    begin = time.perf_counter()
    child = os.posix_spawnp(command[0], command, os.environ)
    _, status, usage = os.wait4(child, 0)
    wall = time.perf_counter() - begin
    code = os.waitstatus_to_exitcode(status)
    peak = usage.ru_maxrss / (2**20 if sys.platform == "darwin" else 2**10)
    with open(report + ".new", "w") as stream:
        stream.write(f"{code} {usage.ru_utime + usage.ru_stime:.6f} {wall:.6f} {peak:.3f}\n")
    os.replace(report + ".new", report)
    return code if code >= 0 else 128 - code


if __name__ == "__main__":
    if len(sys.argv) < 3:
        sys.exit(f"usage: {sys.argv[0]} REPORT COMMAND...")
    sys.exit(main(sys.argv[1], sys.argv[2:]))
