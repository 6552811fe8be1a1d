"""Stability maps: where the schemes are accurate, stable, stop, or break (python -m tools.stress)."""
