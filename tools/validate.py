"""python -m tools.validate: comparisons with published and exact figures (tools/validation/main.py)."""
from tools.base.command import guarded
from tools.validation.main import main

if __name__ == "__main__":
    guarded(main)
