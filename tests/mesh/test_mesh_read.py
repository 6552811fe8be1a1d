"""Meshes that FreeFEM has written are read again."""


def test_a_mesh_of_savemesh_is_read_again_from_the_folder_of_the_run(freefem, freefem_text, freefem_refused, tmp_path):
    """savemesh names a second file beside the mesh, without which FreeFEM reads neither."""
    freefem_text(f'mesh Th = readmesh("meshes/poiseuille.mesh");\nsavemesh(Th, "{tmp_path}/mine.mesh");\n')
    assert "Geometry" in (tmp_path / "mine.mesh").read_text()
    freefem("cases/poiseuille.edp", "-mesh", tmp_path / "mine.mesh", "-tend", 0.01, "-out", tmp_path / "run")
    (tmp_path / "mine.mesh.gmsh").unlink()
    freefem("cases/poiseuille.edp", "-mesh", tmp_path / "run/mesh.mesh", "-tend", 0.01, "-out", tmp_path / "again")
    assert "Geometry" in freefem_refused(3, "cases/poiseuille.edp", "-mesh", tmp_path / "mine.mesh", "-out", tmp_path / "none")
