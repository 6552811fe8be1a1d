"""python -m tools.validate_steady: steady flows by the name of the run (tools/validation/turbulence.py)."""
from tools.base.command import guarded
from tools.validation.turbulence import main

if __name__ == "__main__":
    guarded(main)
