"""python -m tools.bench_contacts: the projection beside packages for quadratic programs (tools/peers/contact_packages.py)."""
from tools.base.command import guarded
from tools.peers.contact_packages import main

if __name__ == "__main__":
    guarded(main)
