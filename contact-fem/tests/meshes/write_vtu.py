"""Writes `.vtu` files by VTK's own writer and by meshio: in each data mode, compressed and not.

Takes `pip install vtk meshio`. A rectangle of 2 by 1 has the label 3, its bottom 1 and its top 7; a cube's half has the label 2.
"""
import itertools

import meshio
import numpy as np
import vtk


def grid(points, cells):
    made = vtk.vtkUnstructuredGrid()
    at = vtk.vtkPoints()
    at.SetDataTypeToDouble()
    for point in points:
        at.InsertNextPoint(point)
    made.SetPoints(at)
    labels = vtk.vtkIntArray()
    labels.SetName("Label")
    for kind, nodes, label in cells:
        ids = vtk.vtkIdList()
        for node in nodes:
            ids.InsertNextId(node)
        made.InsertNextCell(kind, ids)
        labels.InsertNextValue(label)
    made.GetCellData().AddArray(labels)
    return made


def rectangle(n, m):
    points = [(2 * i / n, j / m, 0) for j in range(m + 1) for i in range(n + 1)]
    cells, at = [], lambda i, j: j * (n + 1) + i
    for i, j in itertools.product(range(n), range(m)):
        low, high = (at(i, j), at(i + 1, j)), (at(i, j + 1), at(i + 1, j + 1))
        cells += [(5, (*low, high[1]), 3), (5, (low[0], high[1], high[0]), 3)]
    for i in range(n):
        cells += [(3, (at(i, 0), at(i + 1, 0)), 1), (3, (at(i, m), at(i + 1, m)), 7)]
    return grid(points, cells)


def write(made, mode, codec, header, name):
    writer = vtk.vtkXMLUnstructuredGridWriter()
    writer.SetInputData(made)
    writer.SetFileName(name)
    getattr(writer, {"text": "SetDataModeToAscii", "inline": "SetDataModeToBinary"}.get(mode, "SetDataModeToAppended"))()
    writer.SetEncodeAppendedData(mode == "appended")
    getattr(writer, f"SetCompressorTypeTo{codec}")()
    getattr(writer, f"SetHeaderTypeToUInt{header}")()
    writer.SetBlockSize(4096)
    writer.Write()


write(rectangle(2, 1), "text", "None", 32, "vtk.text.vtu")
for mode, (codec, header) in itertools.product(
    ["inline", "appended", "raw"], [("None", 32), ("ZLib", 64), ("LZ4", 32)]
):
    write(rectangle(2, 1), mode, codec, header, f"vtk.{mode}.{codec.lower()}.vtu")
write(rectangle(2, 1), "inline", "LZMA", 32, "vtk.inline.lzma.vtu")
write(rectangle(24, 12), "raw", "ZLib", 32, "vtk.blocks.vtu")
corners = [(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1), (1, 1, 1)]
write(grid(corners, [(10, (0, 1, 2, 3), 2), (10, (1, 2, 3, 4), 2), (5, (0, 1, 2), 5)]), "raw", "ZLib", 64, "vtk.space.vtu")
cells = [("triangle", np.array([[0, 1, 2], [0, 2, 3]])), ("line", np.array([[0, 1], [2, 3]]))]
labels = {"Label": [np.array([3, 3]), np.array([1, 7])]}
meshio.Mesh(np.array([[0, 0, 0], [2, 0, 0], [2, 1, 0], [0, 1, 0]], dtype=float), cells, cell_data=labels).write("meshio.vtu")
