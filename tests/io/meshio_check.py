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
    mesh.cells_dict.get("line", np.zeros((0, 2))).astype(np.int32).tofile(path + ".lines")
    if path.endswith(".msh") and "gmsh:physical" in mesh.cell_data:
        mesh.cell_data_dict["gmsh:physical"]["triangle"].astype(np.int32).tofile(path + ".labels")
    for name, values in list(mesh.point_data.items()) + [(k, v.get("triangle")) for k, v in mesh.cell_data_dict.items()]:
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

# Finite-element formats, with lines, labels and fields. Numbers are those that the test makes, too.
points, triangles = source.points, source.cells_dict["triangle"]
lines = np.array([[0, 1], [1, 2]])
labels = (np.arange(len(triangles)) * 3 // len(triangles) + 4).astype(np.int32)
fields = {"size": 1 / (1 + np.arange(len(points))), "flow": np.arange(3.0 * len(points)).reshape(-1, 3) / 7}
tags = [labels, np.ones(2, np.int32)]
cells = [("triangle", triangles[labels == label]) for label in [4, 5, 6]] + [("line", lines)]
tags = [labels[labels == label] for label in [4, 5, 6]] + [np.ones(2, np.int32)]
q = [labels[labels == label] / 3 for label in [4, 5, 6]] + [np.zeros(2)]
# Version 4.1 wants nodes on entities, which are written in order: the first on the curve, the others on the surfaces.
entities = [[1, 1]] + [[2, 4 + 3 * k // len(points)] for k in range(1, len(points))]
for version, name, at_points in [("22", "gmsh22", fields), ("41", "gmsh", fields | {"gmsh:dim_tags": np.array(entities)})]:
    rich = meshio.Mesh(points, cells, at_points, {"gmsh:physical": tags, "gmsh:geometrical": tags, "q": q})
    for binary in [False, True]:
        meshio.write(f"{folder}/theirs{version}{'b' if binary else 'a'}.msh", rich, name, binary=binary)
vtk = meshio.Mesh(points, cells, fields, {"label": tags, "q": q})
vtk_options = {"text": dict(binary=False, compression=None), "plain": dict(binary=True, compression=None), "zlib": dict(binary=True, compression="zlib")}
for name, options in vtk_options.items():
    meshio.vtu.write(f"{folder}/theirs-{name}.vtu", vtk, **options)
mixed = [("quad", np.array([[0, 1, 9, 8], [1, 2, 10, 9]])), ("triangle6", np.array([[16, 17, 24, 18, 19, 20]]))]
mixed_data = {"q": [np.array([5.0, 6.0]), np.array([7.0])]}
mixed_data |= {name: [np.array([1, 1], np.int32), np.array([2], np.int32)] for name in ["gmsh:physical", "gmsh:geometrical"]}
halves = np.array([[2, 1 + 2 * k // len(points)] for k in range(len(points))])
meshio.write(folder + "/quads22.msh", meshio.Mesh(points, mixed, {}, mixed_data), "gmsh22", binary=True)
meshio.write(folder + "/quads41.msh", meshio.Mesh(points, mixed, {"gmsh:dim_tags": halves}, mixed_data), "gmsh", binary=False)
meshio.vtu.write(folder + "/quads.vtu", meshio.Mesh(points, mixed, {}, mixed_data))
print("done")
