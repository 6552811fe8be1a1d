"""Particles carried one way, against exact solutions (tools/validate_transport.py)."""
from tools.validate_transport import VALIDATIONS  # noqa: F401  (found by name)
