"""Every case of cases/, with the options of a run of a few steps.

A case on disk that is not in this list fails the tests (tests/suite/test_setup.py): a case is a test.
"""

CASES = {
    "backward_step": ["-reynolds", "20"],
    "cavity": ["-reynolds", "10"],
    "cylinder_channel": ["-tend", "0.01"],
    "cylinder_steady": [],
    "sudden_expansion": ["-search", "0"],
    "hourglass": ["-tend", "0.02", "-number", "150", "-radius", "0.02", "-neck", "0.16"],
    "falling_particles": ["-tend", "0.1"],
    "heap": ["-tend", "0.1", "-number", "40"],
    "granular_collapse": ["-tend", "0.1", "-number", "60"],
    "fibres": ["-tend", "0.1", "-number", "10"],
    "hopper_clogging": ["-tend", "0.1", "-number", "40"],
    "poiseuille": ["-tend", "0.1"],
    "taylor_green": ["-tend", "0.02"],
    "pipe_obstacles": ["-tend", "0.01"],
    "pipe_jet": ["-tend", "0.01"],
    "pipe_transport": ["-tend", "0.02", "-model", "laminar", "-reynolds", "50"],
    "given_flow": ["-tend", "0.05"],
    "pipe_flow": ["-model", "laminar", "-reynolds", "20", "-coarse", "6"],
    "turbulent_channel": ["-cells", "12"],
    "turbulent_step": ["-size", "0.25", "-inlet", "5", "-outlet", "12", "-tolerance", "0.1"],
    "diaphragm_loss": ["-cells", "6", "-outlet", "4", "-tolerance", "0.9"],
    "settling_disk": ["-tend", "0.01"],
    "sinking_disk": ["-tend", "0.03"],
    "rolling_disk": ["-tend", "0.01"],
    "template": ["-tend", "0.01"],
    "branching_channel": ["-tend", "0.004"],
    "settling_ellipses": ["-tend", "0.01"],
    "drafting_kissing_tumbling": ["-tend", "0.002"],
    "cylinder_between_plates": ["-tend", "0.01"],
    "cylinder_array": ["-tend", "0.01"],
    "couette_disk": ["-tend", "0.1"],
    "sheared_suspension": ["-tend", "0.1"],
    "rotating_cylinder": ["-tend", "0.01"],
    "oscillating_cylinder": ["-tend", "0.1"],
    "sprung_cylinder": ["-tend", "0.2"],
    "held_cylinder": ["-tend", "0.01"],
    "ellipse_in_shear": ["-tend", "0.1"],
    "segre_silberberg": ["-tend", "2"],
    "carried_disk": ["-tend", "0.02"],
    "settling_sphere": ["-tend", "0.02"],
    "sphere_array": ["-tend", "0.04"],
    "pipe_spheres": ["-tend", "0.04", "-number", "3"],
}
# Cases that take long on their default mesh: the options of tools.mesh of a coarser one. tests/mesh/test_mesh.py looks at the
# labels of the default meshes.
COARSER = {
    "sudden_expansion": ["--size", 0.25, "--outlet-length", 12, "--stretch", 1.1],
    "pipe_flow": ["--size", 0.016],
    "pipe_transport": ["--size", 0.016],
    "backward_step": ["--size", 0.2],
    "drafting_kissing_tumbling": ["--size", 0.05],
    "cylinder_steady": ["--size", 0.12],
}
