"""The same benchmark flows with other finite-element packages, for tools.bench.

Each module is a script: python -m tools.peers.MODULE PROBLEM LEVEL. It prints one line of
JSON: unknowns, cpu_s (without the imports), and the problem's numbers.
"""
