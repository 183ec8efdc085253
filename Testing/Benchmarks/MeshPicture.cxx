// SPDX-License-Identifier: BSD-3-Clause
#include "Testing/Benchmarks/MeshPicture.h"

#include "viewer/offscreen/OffscreenWindow.h"
#include "viewer/rendering/Picture.h"

#include <vtkActor.h>
#include <vtkBoundingBox.h>
#include <vtkCamera.h>
#include <vtkCellArray.h>
#include <vtkCellData.h>
#include <vtkIdList.h>
#include <vtkMath.h>
#include <vtkNew.h>
#include <vtkPolyDataMapper.h>
#include <vtkPolyDataNormals.h>
#include <vtkProperty.h>
#include <vtkRenderWindow.h>
#include <vtkRenderer.h>
#include <vtkTextActor.h>
#include <vtkTextProperty.h>
#include <vtkUnsignedCharArray.h>

#include <algorithm>
#include <cmath>

namespace kdstream::bench
{
namespace
{

// Hues at steps of the golden angle, so that neighbouring numbers differ.
vtkSmartPointer<vtkUnsignedCharArray> ColorsOf(const PictureCell& cell)
{
  auto colors = vtkSmartPointer<vtkUnsignedCharArray>::New();
  colors->SetNumberOfComponents(3);
  vtkNew<vtkIdList> points;
  for (vtkIdType c = 0; c < cell.mesh->GetNumberOfCells(); ++c)
  {
    cell.mesh->GetCellPoints(c, points);
    const std::uint32_t partition = cell.partitions[static_cast<std::size_t>(points->GetId(0))];
    double hsv[3] = { std::fmod(0.618034 * partition, 1.0), partition % 3 == 0 ? 0.65 : 0.45,
      partition % 2 == 0 ? 0.95 : 0.75 };
    double rgb[3];
    vtkMath::HSVToRGB(hsv, rgb);
    colors->InsertNextTuple3(255 * rgb[0], 255 * rgb[1], 255 * rgb[2]);
  }
  return colors;
}

vtkSmartPointer<vtkActor> MakeActor(const PictureCell& cell, const PictureOptions& options)
{
  vtkNew<vtkPolyData> mesh;
  mesh->ShallowCopy(cell.mesh);
  if (!cell.partitions.empty())
  {
    mesh->GetCellData()->SetScalars(ColorsOf(cell));
  }
  vtkNew<vtkPolyDataNormals> normals;
  normals->SetInputData(mesh);
  normals->SplittingOff();
  normals->ConsistencyOff();
  vtkNew<vtkPolyDataMapper> mapper;
  mapper->SetInputConnection(normals->GetOutputPort());
  mapper->SetScalarModeToUseCellData();
  mapper->SetScalarVisibility(!cell.partitions.empty());
  auto actor = vtkSmartPointer<vtkActor>::New();
  actor->SetMapper(mapper);
  vtkProperty* const look = actor->GetProperty();
  look->SetColor(0.82, 0.80, 0.76);
  look->SetEdgeVisibility(options.edges);
  look->SetEdgeColor(0.25, 0.25, 0.3);
  if (options.flat)
  {
    look->SetInterpolationToFlat();
  }
  return actor;
}

constexpr double captionShare = 0.12; // of a cell's height, at the bottom

// A camera for a parallel view along the wanted direction, in which the box fills a cell above the
// caption.
vtkSmartPointer<vtkCamera> MakeCamera(const vtkBoundingBox& box, const PictureOptions& options)
{
  auto camera = vtkSmartPointer<vtkCamera>::New();
  camera->ParallelProjectionOn();
  camera->Azimuth(options.azimuth);
  camera->Elevation(options.elevation);
  double centre[3], direction[3], up[3], right[3], corner[3];
  box.GetCenter(centre);
  camera->GetDirectionOfProjection(direction);
  camera->OrthogonalizeViewUp();
  camera->GetViewUp(up);
  vtkMath::Cross(direction, up, right);
  double halfWidth = 0, halfHeight = 0;
  for (int c = 0; c < 8; ++c)
  {
    box.GetCorner(c, corner);
    vtkMath::Subtract(corner, centre, corner);
    halfWidth = std::max(halfWidth, std::abs(vtkMath::Dot(corner, right)));
    halfHeight = std::max(halfHeight, std::abs(vtkMath::Dot(corner, up)));
  }
  const double aspect = double(options.cellWidth) / options.cellHeight;
  const double scale =
    1.05 * std::max({ halfHeight / (1 - captionShare), halfWidth / aspect, 1e-300 });
  camera->SetParallelScale(scale);
  const double distance = 2 * box.GetDiagonalLength() + scale;
  double focal[3], eye[3];
  for (int k = 0; k < 3; ++k)
  {
    focal[k] = centre[k] - captionShare * scale * up[k];
    eye[k] = focal[k] - distance * direction[k];
  }
  camera->SetFocalPoint(focal);
  camera->SetPosition(eye);
  return camera;
}

// The box around all meshes.
vtkBoundingBox BoxOf(const std::vector<std::vector<PictureCell>>& rows)
{
  vtkBoundingBox box;
  for (const std::vector<PictureCell>& row : rows)
  {
    for (const PictureCell& cell : row)
    {
      if (cell.mesh)
      {
        box.AddBounds(cell.mesh->GetBounds());
      }
    }
  }
  return box;
}

vtkSmartPointer<vtkTextActor> MakeCaption(const std::string& text, int width)
{
  auto caption = vtkSmartPointer<vtkTextActor>::New();
  caption->SetInput(text.c_str());
  caption->SetPosition(width / 2.0, 8);
  vtkTextProperty* const style = caption->GetTextProperty();
  style->SetFontSize(17);
  style->SetColor(0, 0, 0);
  style->SetJustificationToCentered();
  return caption;
}

}

Status WriteMeshPicture(const std::vector<std::vector<PictureCell>>& rows,
  const PictureOptions& options, const std::string& file)
{
  std::size_t columns = 1;
  for (const auto& row : rows)
  {
    columns = std::max(columns, row.size());
  }
  const auto window =
    MakeOffscreenWindow(WindowBackend::Auto, static_cast<int>(columns) * options.cellWidth,
      static_cast<int>(rows.size()) * options.cellHeight);
  KDSTREAM_TRY(window);
  const vtkBoundingBox all = BoxOf(rows);
  for (std::size_t r = 0; r < rows.size(); ++r)
  {
    for (std::size_t c = 0; c < rows[r].size(); ++c)
    {
      const PictureCell& cell = rows[r][c];
      vtkNew<vtkRenderer> renderer;
      const double height = 1.0 / double(rows.size()), width = 1.0 / double(columns);
      const double bottom = 1 - double(r + 1) * height, left = double(c) * width;
      renderer->SetViewport(left, bottom, left + width, bottom + height);
      renderer->SetBackground(1, 1, 1);
      renderer->AddViewProp(MakeCaption(cell.caption, options.cellWidth));
      (*window)->AddRenderer(renderer);
      if (!cell.mesh)
      {
        continue;
      }
      renderer->AddActor(MakeActor(cell, options));
      const vtkBoundingBox own(cell.mesh->GetBounds());
      renderer->SetActiveCamera(MakeCamera(options.oneScale ? all : own, options));
      renderer->ResetCameraClippingRange();
    }
  }
  return WritePng(**window, file);
}

}
