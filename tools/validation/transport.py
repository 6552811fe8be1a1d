"""Particles carried one way, against exact solutions (tools/validation/spheres.py)."""
from tools.validation.spheres import SPHERES

VALIDATIONS = SPHERES
