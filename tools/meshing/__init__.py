"""The meshes of the cases: which recipe each case takes, and with which defaults.

A recipe is a module with add_options(parser) and build(options) -> (Outline, PlaneMesh), or
(None, SpaceMesh) in three dimensions.
"""
from tools.meshing import (
    backward_step,
    box,
    box_corridor,
    cavity,
    channel,
    couette,
    cylinder_channel,
    own,
    periodic_box,
    pipe,
    space_box,
    space_cell,
    space_pipe,
    space_stream,
    stream,
    sudden_expansion,
)

# A turbulent flow with wall functions: first node about 2 mm from the wall, y+ about 200 in water at 2 m/s.
NEAR_WALL = {"size": 0.008, "wall_factor": 0.3, "wall_band": 0.002, "throat_factor": 0.5, "layer_factor": 0.6}

# Name of a case or of a recipe: (recipe, defaults that differ from the recipe's own).
CASES = {
    "pipe_obstacles": (pipe, {}),
    "pipe_flow": (pipe, NEAR_WALL),
    "pipe_transport": (pipe, NEAR_WALL),
    "channel": (channel, {}),
    "box": (box, {}),
    "box_corridor": (box_corridor, {}),
    "cylinder_channel": (cylinder_channel, {}),
    "cylinder_steady": (cylinder_channel, {"size": 0.06, "circle_points": 64, "growth": 0.12, "wake_factor": 1.3,
        "wake_growth": 0.04}),
    "started_cylinder": (cylinder_channel, {"length": 50.0, "height": 50.0, "size": 4.0, "radius": 0.5, "centre": [16.0, 25.0],
        "circle_points": 320, "growth": 0.1, "wake_factor": 4.0}),
    "backward_step": (backward_step, {}),
    "sudden_expansion": (sudden_expansion, {}),
    "periodic_box": (periodic_box, {}),
    "cavity": (cavity, {}),
    "couette": (couette, {}),
    "settling_disk": (box, {}),
    "drafting_kissing_tumbling": (box, {"size": 1 / 24, "pattern": "alternating"}),  # symmetric about the line of fall
    "rotating_cylinder": (box, {"width": 1.0, "height": 1.0, "size": 1 / 22}),
    "oscillating_cylinder": (box_corridor, {"width": 16.0, "height": 16.0, "size": 1 / 12, "corridor_position": 8.0,
        "corridor_width": 3.0, "corridor_bottom": 6.0, "corridor_top": 10.0,
                                            "coarse_factor": 8.0, "growth": 0.15, "pattern": "alternating"}),
    "cylinder_beside_wall": (stream, {"length": 200.0, "height": 100.0, "centre": [100.0, 2.0], "size": 1 / 8, "stroke": 0.5,
        "reach": 1.4, "coarse_factor": 48.0, "growth": 0.15, "wake_factor": 48.0}),
    "cylinder_in_stream": (stream, {"length": 50.0, "height": 50.0, "centre": [16.0, 25.0], "size": 1 / 16, "stroke": 0.2,
        "coarse_factor": 24.0, "growth": 0.2, "wake_growth": 0.6}),
    "sprung_cylinder": (stream, {}),
    "held_cylinder": (stream, {"length": 2.2, "height": 0.41, "centre": [0.2, 0.2], "size": 0.1 / 16, "stroke": 0.002,
        "reach": 0.08, "coarse_factor": 4.0, "wake_width": 0.2}),
    "poiseuille": (channel, {"size": 1 / 8}),
    "cylinder_between_plates": (channel, {"length": 8.0, "size": 1 / 16}),
    "taylor_green": (periodic_box, {}),
    "cylinder_array": (periodic_box, {"size": 1 / 32}),
    "couette_disk": (couette, {"size": 1 / 32}),
    "segre_silberberg": (couette, {"size": 1 / 32}),
    "settling_sphere": (space_box, {}),
    "two_spheres": (space_box, {"part": "whole", "width": 1.0, "height": 4.0, "size": 1 / 18, "corridor": 0.22, "corridor_top": 3.8,
        "growth": 0.25}),
    "held_sphere": (space_stream, {}),
    "pipe_spheres": (space_pipe, {}),
    "sphere_array": (space_cell, {"size": 0.5 / 8}),
    "sphere_lattice": (space_cell, {"size": 1 / 8, "length": 1.0, "width": 1.0, "height": 1.0, "octants": "mirrored"}),
    "ellipse_in_shear": (couette, {"length": 2.0, "size": 1 / 80, "core": 0.3}),
}
# All that python -m tools.mesh knows: the cases, and what has no default mesh.
RECIPES = CASES | {"own": (own, {})}
