"""python -m tools.validate_transport: carried particles against exact solutions (tools/validation/spheres.py)."""
from tools.base.command import guarded
from tools.validation.spheres import main

if __name__ == "__main__":
    guarded(main)
