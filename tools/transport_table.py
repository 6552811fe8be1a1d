"""python -m tools.transport_table: fates of carried particles over classes of diameter (tools/transport/fates.py)."""
from tools.base.command import guarded
from tools.transport.fates import main

if __name__ == "__main__":
    guarded(main)
