"""python -m tools.study: runs over sizes and steps, with order and limit (tools/study/study.py)."""
from tools.base.command import guarded
from tools.study.study import main

if __name__ == "__main__":
    guarded(main)
