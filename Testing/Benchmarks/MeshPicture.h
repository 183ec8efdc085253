// SPDX-License-Identifier: BSD-3-Clause
// Pictures of the benchmarks: meshes in rows and columns, each with a caption, as the paper's
// figures show them.
#pragma once

#include "filters/core/Result.h"

#include <vtkPolyData.h>
#include <vtkSmartPointer.h>

#include <cstdint>
#include <string>
#include <vector>

namespace kdstream::bench
{

// One cell of the grid.
struct PictureCell
{
  vtkSmartPointer<vtkPolyData> mesh; // null: the cell is empty
  std::string caption;
  // The partition of each point. Neighbouring numbers get different colours; a triangle has the
  // colour of its first point. If this is empty, the mesh has one colour.
  std::vector<std::uint32_t> partitions;
};

struct PictureOptions
{
  int cellWidth = 480; // pixels
  int cellHeight = 420;
  bool edges = false;                // whether the triangles' edges are drawn
  bool flat = false;                 // whether shading is flat
  double azimuth = 0, elevation = 0; // of the camera, degrees, from the z axis
  bool oneScale = true;              // the same scale for all meshes; else each fills its cell
};

// Draws the grid off screen into a PNG file. A parallel view shows a whole mesh above its caption.
// Rows may have different lengths. Errors: those of MakeOffscreenWindow and WritePng.
Status WriteMeshPicture(const std::vector<std::vector<PictureCell>>& rows,
  const PictureOptions& options, const std::string& file);

}
