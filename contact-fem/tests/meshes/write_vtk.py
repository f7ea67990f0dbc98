"""Writes legacy `.vtk` files by VTK's own writer and by meshio: versions 4.2 and 5.1, as text and in binary.

Takes `pip install vtk meshio`. The meshes are those of `write_vtu.py`; cell data and fields without a meaning for a mesh stand between.
"""
import itertools

import meshio
import numpy as np
import vtk

from write_vtu import grid, rectangle


def write(made, version, is_binary, name):
    writer = vtk.vtkUnstructuredGridWriter()
    writer.SetInputData(made)
    writer.SetFileName(name)
    writer.SetFileVersion(version)
    writer.SetFileTypeToBinary() if is_binary else writer.SetFileTypeToASCII()
    writer.Write()


def with_more(made):
    """With what ParaView adds: scalars and vectors at points, a field, names with spaces, a component's name."""
    heat = vtk.vtkFloatArray()
    heat.SetName("heat of points")
    heat.SetNumberOfComponents(3)
    heat.SetComponentName(0, "first one")
    for k in range(made.GetNumberOfPoints()):
        heat.InsertNextTuple3(k, 0.5, -1e-3)
    made.GetPointData().SetVectors(heat)
    note = vtk.vtkStringArray()
    note.SetName("note")
    note.InsertNextValue("CELLS 3 of no meaning")
    made.GetFieldData().AddArray(note)
    made.GetCellData().SetScalars(made.GetCellData().GetArray("Label"))
    return made


for version, is_binary in itertools.product([42, 51], [False, True]):
    kind = "binary" if is_binary else "text"
    write(rectangle(2, 1), version, is_binary, f"vtk.{version}.{kind}.vtk")
write(with_more(rectangle(2, 1)), 51, True, "vtk.more.binary.vtk")
write(with_more(rectangle(2, 1)), 42, False, "vtk.more.text.vtk")
corners = [(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1), (1, 1, 1)]
write(grid(corners, [(10, (0, 1, 2, 3), 2), (10, (1, 2, 3, 4), 2), (5, (0, 1, 2), 5)]), 51, True, "vtk.space.vtk")
cells = [("triangle", np.array([[0, 1, 2], [0, 2, 3]])), ("line", np.array([[0, 1], [2, 3]]))]
labels = {"Label": [np.array([3, 3]), np.array([1, 7])]}
mesh = meshio.Mesh(np.array([[0, 0, 0], [2, 0, 0], [2, 1, 0], [0, 1, 0]], dtype=float), cells, cell_data=labels)
mesh.write("meshio.51.vtk", file_format="vtk51")
mesh.write("meshio.42.vtk", file_format="vtk42", binary=False)
labels = {"gmsh:geometrical": [np.array([8, 8]), np.array([9, 9])], "gmsh:physical": labels["Label"]}
meshio.Mesh(mesh.points, cells, cell_data=labels).write("meshio.physical.vtk", file_format="vtk51")
