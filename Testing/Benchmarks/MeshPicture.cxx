#include "Testing/Benchmarks/MeshPicture.h"

#include "viewer/rendering/OffscreenWindow.h"
#include "viewer/rendering/Picture.h"

#include <vtkActor.h>
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

// Hues one golden angle apart, so that neighbouring numbers differ.
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
  if (!window)
  {
    return window.GetError();
  }
  vtkSmartPointer<vtkCamera> camera;
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
      if (!camera)
      {
        camera = renderer->GetActiveCamera();
        camera->Azimuth(options.azimuth);
        camera->Elevation(options.elevation);
        renderer->ResetCamera();
        camera->Zoom(options.zoom);
      }
      renderer->SetActiveCamera(camera);
      renderer->ResetCameraClippingRange();
    }
  }
  return WritePng(**window, file);
}

}
