"""python -m tools.validate_contacts: contacts against exact solutions and targets (tools/validation/contact_targets.py)."""
from tools.base.command import guarded
from tools.validation.contact_targets import main

if __name__ == "__main__":
    guarded(main)
