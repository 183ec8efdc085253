// SPDX-License-Identifier: BSD-3-Clause
// For tests: how much two PNG files differ, and where.
#pragma once

#include <vtkImageData.h>
#include <vtkNew.h>
#include <vtkPNGReader.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <limits>

namespace kdstream::testing
{

// Calls visit(column, row) for each pixel that differs by more than 8 of 255 in a channel; row 0 is
// at the bottom. Returns the number of pixels; 0 if the pictures have different sizes.
template <class Visit>
vtkIdType ForEachThatDiffers(
  const std::filesystem::path& a, const std::filesystem::path& b, const Visit& visit)
{
  const vtkNew<vtkPNGReader> first;
  const vtkNew<vtkPNGReader> second;
  first->SetFileName(a.c_str());
  second->SetFileName(b.c_str());
  first->Update();
  second->Update();
  const auto size = first->GetOutput()->GetNumberOfPoints();
  if (size != second->GetOutput()->GetNumberOfPoints())
  {
    return 0;
  }
  const int width = first->GetOutput()->GetDimensions()[0];
  const auto* p = static_cast<const unsigned char*>(first->GetOutput()->GetScalarPointer());
  const auto* q = static_cast<const unsigned char*>(second->GetOutput()->GetScalarPointer());
  for (vtkIdType i = 0; i < size; ++i)
  {
    int most = 0;
    for (vtkIdType c = 3 * i; c < 3 * i + 3; ++c)
    {
      most = std::max(most, std::abs(p[c] - q[c]));
    }
    if (most > 8)
    {
      visit(static_cast<int>(i % width), static_cast<int>(i / width));
    }
  }
  return size;
}

// The share of pixels in which two pictures differ; 1 if their sizes differ.
inline double ShareThatDiffers(const std::filesystem::path& a, const std::filesystem::path& b)
{
  vtkIdType different = 0;
  const vtkIdType size = ForEachThatDiffers(a, b, [&](int, int) { ++different; });
  return size == 0 ? 1 : static_cast<double>(different) / static_cast<double>(size);
}

// Counts the pixels of this colour. tolerance: per channel, 0-255.
inline vtkIdType CountOfColor(
  const std::filesystem::path& file, const std::array<int, 3>& color, int tolerance = 4)
{
  const vtkNew<vtkPNGReader> reader;
  reader->SetFileName(file.c_str());
  reader->Update();
  const auto* p = static_cast<const unsigned char*>(reader->GetOutput()->GetScalarPointer());
  vtkIdType count = 0;
  for (vtkIdType i = 0; i < reader->GetOutput()->GetNumberOfPoints(); ++i, p += 3)
  {
    bool same = true;
    for (std::size_t c = 0; c < 3; ++c)
    {
      same = same && std::abs(p[c] - color[c]) <= tolerance;
    }
    count += same ? 1 : 0;
  }
  return count;
}

// The box around the pixels that differ: least column and row, greatest column and row.
inline std::array<int, 4> BoxThatDiffers(
  const std::filesystem::path& a, const std::filesystem::path& b)
{
  constexpr int most = std::numeric_limits<int>::max();
  std::array<int, 4> box{ most, most, -1, -1 };
  ForEachThatDiffers(a, b,
    [&](int column, int row)
    {
      box = { std::min(box[0], column), std::min(box[1], row), std::max(box[2], column),
        std::max(box[3], row) };
    });
  return box;
}

}
