"""python -m tools.plot_contacts: pictures of contacts alone (tools/plot/contacts.py)."""
from tools.base.command import guarded
from tools.plot.contacts import main

if __name__ == "__main__":
    guarded(main)
