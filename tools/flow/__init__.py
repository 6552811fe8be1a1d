"""A flow that another program has computed, made into the mesh and nodal values that point particles follow."""
