"""Pictures of spheres and contacts alone: the run as it is seen from the front, along y.

SphereContactRun shows x to the right and z upwards, the spheres painted from the back to the front; tools/plot/contacts.py draws it
as it draws disks. Walls are the outlines of the triangles that do not face the viewer.
"""
import numpy as np

from tools.plot.contact_run import ContactRun

FACING = 0.99  # part of a unit normal along y from which a wall faces the viewer and is left out


class SphereContactRun(ContactRun):
    """A run of spheres without a fluid; frame(k) is a dict of columns at times[k], with z as y, from the back to the front."""

    upward = "z"

    def frame(self, k):
        columns = self.rows(k)
        columns["speed"] = np.sqrt(sum(columns[name]**2 for name in "uvw"))
        order = np.argsort(-columns["y"], kind="stable")
        columns = {name: values[order] for name, values in columns.items()}
        return columns | {"y": columns["z"], "v": columns["w"]}

    def walls_at(self, t):
        """The edges of the wall triangles as segments (S, 2, 2) in x and z, cut off above the spheres."""
        if not self.has("walls"):
            return np.zeros((0, 2, 2))
        table = self.columns("walls")
        corners = np.stack([np.column_stack([table[f"{c}{k}"] for c in "xyz"]) for k in (1, 2, 3)], axis=1)
        normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        shown = corners[abs(normals[:, 1]) < FACING * np.linalg.norm(normals, axis=1)][:, :, [0, 2]]
        segments = np.concatenate([shown[:, [0, 1]], shown[:, [1, 2]], shown[:, [2, 0]]])
        top = self.view[3]
        return np.stack([segments[:, :, 0], np.minimum(segments[:, :, 1], top)], axis=2)

    @property
    def view(self):
        p = self.particles
        x0, x1 = (p["x"] - p["radius"]).min(), (p["x"] + p["radius"]).max()
        z0, z1 = (p["z"] - p["radius"]).min(), (p["z"] + p["radius"]).max()
        room = 0.02 * max(x1 - x0, z1 - z0)
        return x0 - room, x1 + room, z0 - room, z1 + room

    @property
    def speeds(self):
        top = float(np.sqrt(sum(self.particles[name]**2 for name in "uvw")).max())
        return (1e-4 * top, top) if top > 0 else (1e-4, 1.0)
