"""python -m tools.check: compares the tables of a run with those of another; in pytest: from tools.check import compare (see
tools/base/check.py)."""
from tools.base.check import Comparison, Place, compare, main  # noqa: F401  (compare is for tests of users)
from tools.base.command import guarded

if __name__ == "__main__":
    guarded(main)
