// SPDX-License-Identifier: BSD-3-Clause
// The boxes of a region's partitions: see RegionBoxes.h.
#include "viewer/desktop/RegionBoxes.h"

#include "viewer/session/Geometry.h"

#include <vtkActor.h>
#include <vtkCellArray.h>
#include <vtkCellData.h>
#include <vtkPoints.h>
#include <vtkPolyData.h>
#include <vtkPolyDataMapper.h>
#include <vtkProperty.h>
#include <vtkRenderer.h>
#include <vtkUnsignedCharArray.h>

#include <array>

namespace kdstream
{
namespace
{

constexpr std::array<unsigned char, 3> pickedColor{ 255, 176, 64 };
constexpr std::array<unsigned char, 3> otherColor{ 217, 208, 192 };

// The edges of the boxes, in coordinates relative to `center`.
vtkSmartPointer<vtkPolyData> EdgesOf(const std::vector<Box>& boxes, const Vec3& center)
{
  const vtkNew<vtkPoints> points;
  const vtkNew<vtkCellArray> lines;
  const vtkNew<vtkUnsignedCharArray> colors;
  colors->SetNumberOfComponents(3);
  for (const Box& box : boxes)
  {
    const vtkIdType first = points->GetNumberOfPoints();
    const Vec3 lo = box.lo - center;
    const Vec3 hi = box.hi - center;
    for (int corner = 0; corner < 8; ++corner)
    {
      points->InsertNextPoint((corner & 1) != 0 ? hi[0] : lo[0], (corner & 2) != 0 ? hi[1] : lo[1],
        (corner & 4) != 0 ? hi[2] : lo[2]);
    }
    for (int corner = 0; corner < 8; ++corner)
    {
      for (const int axis : { 1, 2, 4 })
      {
        if ((corner & axis) == 0)
        {
          lines->InsertNextCell({ first + corner, first + corner + axis });
          colors->InsertNextTypedTuple(first == 0 ? pickedColor.data() : otherColor.data());
        }
      }
    }
  }
  const auto edges = vtkSmartPointer<vtkPolyData>::New();
  edges->SetPoints(points);
  edges->SetLines(lines);
  edges->GetCellData()->SetScalars(colors);
  return edges;
}

}

RegionBoxes::RegionBoxes(vtkRenderer& model)
  : Model(model)
{
  this->Actor->GetProperty()->LightingOff();
  this->Actor->PickableOff();
  this->Over->AddActor(this->Actor);
  this->Over->SetActiveCamera(model.GetActiveCamera());
  this->Over->AutomaticLightCreationOff();
  this->Over->InteractiveOff();
  this->Over->DrawOff();
}

void RegionBoxes::Show(const std::vector<Box>& boxes, const Vec3& center, double lineWidth)
{
  this->Over->SetDraw(!boxes.empty());
  this->Over->SetLayer(this->Model.GetLayer());
  this->Over->SetViewport(this->Model.GetViewport());
  this->Over->PreserveColorBufferOn(); // after SetLayer, which changes it
  this->Over->PreserveDepthBufferOn();
  this->Actor->GetProperty()->SetLineWidth(static_cast<float>(lineWidth));
  if (boxes == this->Shown && center == this->Center)
  {
    return;
  }
  this->Shown = boxes;
  this->Center = center;
  const vtkNew<vtkPolyDataMapper> mapper;
  mapper->SetInputData(EdgesOf(boxes, center));
  this->Actor->SetMapper(mapper);
}

}
