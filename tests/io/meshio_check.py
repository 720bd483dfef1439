"""The other side of meshio_test.cpp: reads what gradus wrote, as raw arrays, and writes what gradus is to read.

usage: meshio_check.py FOLDER: reads FOLDER/ours.* and dumps FOLDER/ours.EXT.points (float64), .triangles (int32) and, for
fields, .field.NAME; writes FOLDER/theirs.* from ours.meshb.
"""
import glob
import sys

import meshio
import numpy as np

folder = sys.argv[1]
for path in glob.glob(folder + "/ours.*"):
    mesh = meshio.read(path)
    np.asarray(mesh.points, np.float64).tofile(path + ".points")
    mesh.cells_dict["triangle"].astype(np.int32).tofile(path + ".triangles")
    for name, values in list(mesh.point_data.items()) + [(k, v[0]) for k, v in mesh.cell_data.items()]:
        if values is not None and np.issubdtype(np.asarray(values).dtype, np.number):
            np.asarray(values, np.float64).tofile(path + ".field." + name.replace(":", "_"))

source = meshio.read(folder + "/ours.meshb")
plain = meshio.Mesh(source.points, [("triangle", source.cells_dict["triangle"])])
for name, options in [
    ("theirs.mesh", {}),
    ("theirs.meshb", {}),
    ("theirs.obj", {}),
    ("theirs.off", {}),
    ("theirs-text.ply", {"binary": False}),
    ("theirs.ply", {"binary": True}),
    ("theirs-text.stl", {"binary": False}),
    ("theirs.stl", {"binary": True}),
]:
    meshio.write(folder + "/" + name, plain, **options)
print("done")
