"""What every tool stands on: options and ends of a command, tables, run folders, meshes, runs of FreeFEM, quantities,
comparisons."""
