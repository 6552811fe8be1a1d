"""python -m tools.doctor: versions, plug-ins, solvers (tools/setup/doctor.py)."""
from tools.base.command import guarded
from tools.setup.doctor import main

if __name__ == "__main__":
    guarded(main)
