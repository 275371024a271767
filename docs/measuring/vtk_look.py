#!/usr/bin/env python3
"""The first picture of VTK, for the sheet of look.py: what ParaView shows of a volume before anything is set.

    vtk_look.py VOLUME.vti PICTURE.png SIDE patient|other

Cool to warm over the range of the values, opacity rising from 0 to 1 over it, the unit distance of ParaView (the diagonal over the cube root
of the number of cells), no shading, steps of half a voxel; the whole box in the picture, from where
`vr` sees it. Drawn by vtkFixedPointVolumeRayCastMapper. Needs Python 3 with vtk.
"""
import sys

import vtk

source, picture, side, kind = sys.argv[1], sys.argv[2], int(sys.argv[3]), sys.argv[4]
reader = vtk.vtkXMLImageDataReader()
reader.SetFileName(source)
reader.Update()
image = reader.GetOutput()
# The mapper knows no directions: they become the volume's own.
place = vtk.vtkMatrix4x4()
for row in range(3):
    for column in range(3):
        place.SetElement(row, column, image.GetDirectionMatrix().GetElement(row, column))
    place.SetElement(row, 3, image.GetOrigin()[row])
image.SetDirectionMatrix(1, 0, 0, 0, 1, 0, 0, 0, 1)
image.SetOrigin(0, 0, 0)
low, high = image.GetScalarRange()

colors = vtk.vtkColorTransferFunction()
colors.SetColorSpaceToDiverging()
colors.AddRGBPoint(low, 0.231373, 0.298039, 0.752941)
colors.AddRGBPoint(high, 0.705882, 0.0156863, 0.14902)
opacity = vtk.vtkPiecewiseFunction()
opacity.AddPoint(low, 0.0)
opacity.AddPoint(high, 1.0)
look = vtk.vtkVolumeProperty()
look.SetColor(colors)
look.SetScalarOpacity(opacity)
look.SetInterpolationTypeToLinear()
look.SetScalarOpacityUnitDistance(image.GetLength() / max(image.GetNumberOfCells(), 1) ** (1 / 3))

mapper = vtk.vtkFixedPointVolumeRayCastMapper()
mapper.SetInputData(image)
mapper.AutoAdjustSampleDistancesOff()
mapper.SetSampleDistance(0.5 * min(image.GetSpacing()))
mapper.SetImageSampleDistance(1.0)
volume = vtk.vtkVolume()
volume.SetMapper(mapper)
volume.SetProperty(look)
volume.SetUserMatrix(place)

renderer, window = vtk.vtkRenderer(), vtk.vtkRenderWindow()
window.SetOffScreenRendering(1)
window.AddRenderer(renderer)
window.SetSize(side, side)
renderer.AddVolume(volume)
camera = renderer.GetActiveCamera()
# A patient, whose world is RAS, stands and faces the viewer.
position, up, azimuth, elevation = ((0, 1, 0), (0, 0, 1), 15, 10) if kind == "patient" else ((0, 0, 1), (0, 1, 0), 30, 20)
camera.SetPosition(position)
camera.SetViewUp(up)
camera.Azimuth(azimuth)
camera.Elevation(elevation)
camera.ParallelProjectionOn()
renderer.ResetCamera()
window.Render()

grab = vtk.vtkWindowToImageFilter()
grab.SetInput(window)
writer = vtk.vtkPNGWriter()
writer.SetFileName(picture)
writer.SetInputConnection(grab.GetOutputPort())
writer.Write()
