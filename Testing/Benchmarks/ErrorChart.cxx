// SPDX-License-Identifier: BSD-3-Clause
#include "Testing/Benchmarks/ErrorChart.h"

#include "viewer/offscreen/OffscreenWindow.h"
#include "viewer/rendering/Picture.h"

#include <vtkAxis.h>
#include <vtkChartLegend.h>
#include <vtkChartXY.h>
#include <vtkContextActor.h>
#include <vtkContextScene.h>
#include <vtkDoubleArray.h>
#include <vtkMath.h>
#include <vtkNew.h>
#include <vtkPen.h>
#include <vtkPlot.h>
#include <vtkPlotPoints.h>
#include <vtkRenderWindow.h>
#include <vtkRenderer.h>
#include <vtkTable.h>
#include <vtkTextProperty.h>

#include <algorithm>
#include <cmath>

namespace kdstream::bench
{
namespace
{

constexpr int panelWidth = 760, panelHeight = 560;

// Hues at steps of the golden angle; every second one is darker.
void ColorOf(std::size_t number, double rgb[3])
{
  double hsv[3] = { std::fmod(0.618034 * double(number), 1.0), 0.85,
    number % 2 == 0 ? 0.85 : 0.55 };
  vtkMath::HSVToRGB(hsv, rgb);
}

vtkSmartPointer<vtkTable> TableOf(const ErrorCurve& curve)
{
  auto table = vtkSmartPointer<vtkTable>::New();
  vtkNew<vtkDoubleArray> x, y;
  x->SetName("cost");
  y->SetName(curve.name.c_str());
  for (std::size_t i = 0; i < curve.costs.size(); ++i)
  {
    x->InsertNextValue(curve.costs[i]);
    y->InsertNextValue(curve.errors[i]);
  }
  table->AddColumn(x);
  table->AddColumn(y);
  return table;
}

void StyleAxis(vtkAxis* axis, const std::string& title)
{
  axis->SetLogScale(true);
  axis->SetTitle(title);
  axis->GetTitleProperties()->SetFontSize(16);
  axis->GetLabelProperties()->SetFontSize(14);
  axis->GetGridPen()->SetColor(225, 225, 225);
}

vtkSmartPointer<vtkChartXY> MakeChart(
  const ErrorPanel& panel, std::vector<std::string>& names, bool legend)
{
  auto chart = vtkSmartPointer<vtkChartXY>::New();
  chart->SetAutoSize(false);
  chart->SetSize(vtkRectf(0, 0, panelWidth, panelHeight));
  chart->SetTitle(panel.title);
  chart->GetTitleProperties()->SetFontSize(18);
  StyleAxis(chart->GetAxis(vtkAxis::BOTTOM), panel.xTitle);
  StyleAxis(chart->GetAxis(vtkAxis::LEFT), panel.yTitle);
  for (const ErrorCurve& curve : panel.curves)
  {
    auto name = std::find(names.begin(), names.end(), curve.name);
    const auto number = static_cast<std::size_t>(name - names.begin());
    if (name == names.end())
    {
      names.push_back(curve.name);
    }
    vtkPlot* const plot = chart->AddPlot(vtkChart::LINE);
    plot->SetInputData(TableOf(curve), 0, 1);
    double rgb[3];
    ColorOf(number, rgb);
    plot->GetPen()->SetColorF(rgb[0], rgb[1], rgb[2]);
    plot->SetWidth(number == 0 ? 4 : 2);
    if (auto* const points = vtkPlotPoints::SafeDownCast(plot))
    {
      points->SetMarkerStyle(number == 0 ? vtkPlotPoints::CIRCLE : vtkPlotPoints::NONE);
    }
  }
  chart->SetShowLegend(legend);
  chart->GetLegend()->SetLabelSize(13);
  chart->GetLegend()->SetHorizontalAlignment(vtkChartLegend::RIGHT);
  chart->GetLegend()->SetVerticalAlignment(vtkChartLegend::TOP);
  return chart;
}

}

Status WriteErrorCharts(const std::vector<std::vector<ErrorPanel>>& rows, const std::string& file)
{
  std::size_t columns = 1;
  for (const auto& row : rows)
  {
    columns = std::max(columns, row.size());
  }
  const auto window = MakeOffscreenWindow(WindowBackend::Auto,
    static_cast<int>(columns) * panelWidth, static_cast<int>(rows.size()) * panelHeight);
  KDSTREAM_TRY(window);
  std::vector<std::string> names;
  for (std::size_t r = 0; r < rows.size(); ++r)
  {
    for (std::size_t c = 0; c < rows[r].size(); ++c)
    {
      vtkNew<vtkRenderer> renderer;
      const double tall = 1.0 / double(rows.size()), wide = 1.0 / double(columns);
      const double bottom = 1 - double(r + 1) * tall, left = double(c) * wide;
      renderer->SetViewport(left, bottom, left + wide, bottom + tall);
      renderer->SetBackground(1, 1, 1);
      vtkNew<vtkContextActor> actor;
      actor->GetScene()->AddItem(MakeChart(rows[r][c], names, c + 1 == rows[r].size()));
      renderer->AddActor(actor);
      actor->GetScene()->SetRenderer(renderer);
      (*window)->AddRenderer(renderer);
    }
  }
  // This first rendering only makes the charts find their ranges; without these, logarithmic axes
  // draw no lines.
  (*window)->Render();
  return WritePng(**window, file);
}

}
