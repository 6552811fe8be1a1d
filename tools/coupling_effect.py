"""python -m tools.coupling_effect: what two-way coupling changes (tools/transport/coupling_effect.py)."""
from tools.base.command import guarded
from tools.transport.coupling_effect import main

if __name__ == "__main__":
    guarded(main)
