# SPDX-License-Identifier: BSD-3-Clause
# The questions of TestParaView to ParaView, run by pvbatch: PLUGIN WHAT ARGUMENTS. Each process writes a line of JSON for each
# answer into answers.RANK, because mpirun would mix long lines. TestParaView has the expected answers. In Python because that is
# ParaView's language.
import hashlib
import json
import sys

import numpy
from paraview import servermanager
from paraview.simple import *
from vtkmodules.util.numpy_support import vtk_to_numpy
from vtkmodules.vtkIOImage import vtkPNGReader


def tell(what, **numbers):
    rank = servermanager.vtkProcessModule.GetProcessModule().GetPartitionId()
    with open("answers." + str(rank), "a") as answers:
        answers.write(json.dumps({"what": what, **numbers}) + "\n")


def owned(data, count):
    ghosts = data.GetArray("vtkGhostType")
    return count if ghosts is None else int((vtk_to_numpy(ghosts) == 0).sum())


def count(what, source, port=0):
    """The points and cells of this process, those of others not counted."""
    source.UpdatePipeline()
    output = source.GetClientSideObject().GetOutputDataObject(port)
    whole = output.IsA("vtkPolyData")
    meshes = [output] if whole else [output.GetPartition(i) for i in range(output.GetNumberOfPartitions())]
    meshes = [mesh for mesh in meshes if mesh]
    vertices = [owned(mesh.GetPointData(), mesh.GetNumberOfPoints()) for mesh in meshes]
    tell(what, partitions=sum(each > 0 for each in vertices), vertices=sum(vertices),
         triangles=sum(owned(mesh.GetCellData(), mesh.GetNumberOfCells()) for mesh in meshes))


def contents(source):
    """All that a reader or a server is asked for."""
    for output in "Partitions", "One Mesh":
        source.OutputType = output
        source.Content = "Original"
        count("original, " + output, source)
        source.Content = "Level"
        source.LevelDepth = 14
        count("level 14, " + output, source)


def parts(source):
    """A few partitions, and the region around a point."""
    source.OutputType = "Partitions"
    source.Content = "Partitions"
    source.Partitions = [3, 4]
    count("partitions", source)
    source.Content = "Region"
    source.RegionPoint = [0.02, 0.1, 0.03]
    count("region", source)
    source.Content = "View"
    source.OutputType = "One Mesh"
    source.CameraPosition = [0, 0.12, 0.5]
    source.CameraFocalPoint = [0, 0.12, 0]
    source.NumberOfTriangles = 50000
    count("view", source)


def store(path):
    contents(OpenDataFile(path))


def server(url):
    source = KdStreamServer(Url=url)
    contents(source)
    parts(source)


def parts_of_store(path):
    parts(OpenDataFile(path))


def panel(path):
    """What the panel shows before anything is loaded, and what it asks for then."""
    KdStreamServer()  # from the menu, before there is an address: no error yet
    KdStreamMesh()
    source = OpenDataFile(path)
    count("at first", source)
    depths = source.GetProperty("LevelDepth").SMProperty.GetDomain("range")
    tell("levels", least=depths.GetMinimum(0), most=depths.GetMaximum(0))
    tell("arrays", names=list(source.PointArrays.Available))
    source.Content = "Original"
    for what, arrays in ("all arrays", source.PointArrays.Available), ("no arrays", []):
        source.PointArrays = arrays
        source.UpdatePipeline()
        tell(what, names=list(source.PointData.keys()))


def filters(path, mesh):
    """The filters on what the store has, as one mesh, in partitions and in composite data sets of both, and on the mesh
    that it was built of."""
    source = OpenDataFile(path)
    source.Content = "Original"
    blocks = OpenDataFile(path)
    blocks.Content = "Original"
    blocks.OutputType = "Partitions"
    group = GroupDatasets(Input=[blocks], OutputType="vtkPartitionedDataSetCollection")
    multiblock = GroupDatasets(Input=[source], OutputType="vtkMultiBlockDataSet")
    for each, of in (source, "store"), (KdStreamMesh(File=mesh), "mesh"), (blocks, "blocks"), \
            (group, "group"), (multiblock, "multiblock"):
        if of in ("store", "mesh"):
            count(of, each)
        cut = KdTreePartition(Input=each)
        count(of + " in partitions", cut)
        count(of + " with its partitions", cut, 1)
        count(of + " simplified", KdClusterSimplification(Input=each, Maker="Collapse", TargetNumberOfTriangles=20000))
    level = KdClusterSimplification(Input=OutputPort(cut, 1), Sheets=0)
    for what, name in ("cells", ""), ("clusters", "PartitionId"), ("cells again", ""):
        if what != "cells":
            level.Clusters = ["POINTS", name]
        count(what, level)


def turned(triangles):
    """Triangles with their least corner first: a store turns them."""
    corners = triangles.reshape(-1, 3)
    first = corners.argmin(axis=1)[:, None]
    return numpy.take_along_axis(corners, (first + [0, 1, 2]) % 3, axis=1)


def distributed(path):
    """The partitions of a mesh that the processes share, each with a digest of all that it has. Of a file the first
    process reads all; of a store each reads its part, with the ids that say which points and triangles are one."""
    source = OpenDataFile(path) if path.endswith(".kds") else KdStreamMesh(File=path)
    if path.endswith(".kds"):
        source.Content = "Original"
        source.OutputType = "One Mesh"
    cut = KdTreePartition(Input=source, GeneratePartitionIds=1)
    cut.UpdatePipeline()
    output = cut.GetClientSideObject().GetOutputDataObject(0)
    digests = {}
    for i in range(output.GetNumberOfPartitions()):
        part = output.GetPartition(i)
        if part:
            arrays = [vtk_to_numpy(part.GetPoints().GetData()),
                      turned(vtk_to_numpy(part.GetPolys().GetConnectivityArray()))]
            for data in part.GetPointData(), part.GetCellData():
                arrays += [vtk_to_numpy(data.GetArray(k)) for k in range(data.GetNumberOfArrays())]
            digests[str(i)] = hashlib.md5(b"".join(array.tobytes() for array in arrays)).hexdigest()
    tell("distributed", partitions=output.GetNumberOfPartitions(), digests=digests)


def failing(path, none):
    """The second process has no input at first, and then the same store as the others."""
    rank = servermanager.vtkProcessModule.GetProcessModule().GetPartitionId()
    source = KdStreamStore(FileName=none if rank == 1 else path)
    source.Content = "Original"
    source.OutputType = "One Mesh"
    cut = KdTreePartition(Input=source)
    count("failed", cut)
    tell("code", code=cut.GetClientSideObject().GetErrorCode())
    source.FileName = path
    cut.VerticesPerPartition = 1999
    count("mended", cut)


def picture(path, png):
    """The partitions, each in a colour of its own."""
    source = OpenDataFile(path)
    source.Content = "Original"
    source.OutputType = "Partitions"
    view = CreateView("RenderView")
    view.ViewSize = [800, 600]
    view.OrientationAxesVisibility = 0
    view.UseColorPaletteForBackground = 0
    view.Background = [1, 1, 1]
    shown = Show(source, view)
    ColorBy(shown, ("FIELD", "vtkBlockColors"))
    shown.SetScalarBarVisibility(view, False)
    GetColorTransferFunction("vtkBlockColors").ApplyPreset("Brewer Qualitative Set3", True)
    ResetCamera(view)
    view.CameraViewAngle = 22
    SaveScreenshot(png, view, ImageResolution=view.ViewSize)
    saved = vtkPNGReader()
    saved.SetFileName(png)
    saved.Update()
    pixels = vtk_to_numpy(saved.GetOutput().GetPointData().GetScalars())[:, :3].astype(int)
    shown = pixels[pixels.min(axis=1) < 255]
    vivid = shown[shown.max(axis=1) - shown.min(axis=1) > 40]
    version = GetParaViewVersion()
    tell("picture", shown=len(shown) / len(pixels), vivid=len(vivid) / len(shown),
         hues=len(set(map(tuple, vivid.argsort(axis=1)))),
         coloursPartitions=(version.major, version.minor) < (5, 12))


def broken(path, url):
    """What cannot be read: the errors go to the error output."""
    try:
        OpenDataFile(path)
    except RuntimeError:
        tell("not offered")
    for source in KdStreamStore(FileName=path), KdStreamServer(Url=url):
        source.UpdatePipeline()


plugin, what, *arguments = sys.argv[1:]
LoadPlugin(plugin, remote=False, ns=globals())
globals()[what](*arguments)
