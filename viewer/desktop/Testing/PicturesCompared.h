// SPDX-License-Identifier: BSD-3-Clause
// How much two PNG files differ, for tests.
#pragma once

#include <vtkImageData.h>
#include <vtkNew.h>
#include <vtkPNGReader.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>

namespace kdstream::testing
{

// Of the pixels of two pictures those that differ by more than 8 of 255; 1 for other sizes.
inline double ShareThatDiffers(const std::filesystem::path& a, const std::filesystem::path& b)
{
  const vtkNew<vtkPNGReader> first;
  const vtkNew<vtkPNGReader> second;
  first->SetFileName(a.c_str());
  second->SetFileName(b.c_str());
  first->Update();
  second->Update();
  const auto size = first->GetOutput()->GetNumberOfPoints();
  if (size == 0 || size != second->GetOutput()->GetNumberOfPoints())
  {
    return 1;
  }
  const auto* p = static_cast<const unsigned char*>(first->GetOutput()->GetScalarPointer());
  const auto* q = static_cast<const unsigned char*>(second->GetOutput()->GetScalarPointer());
  vtkIdType different = 0;
  for (vtkIdType i = 0; i < size; ++i)
  {
    int most = 0;
    for (vtkIdType c = 3 * i; c < 3 * i + 3; ++c)
    {
      most = std::max(most, std::abs(p[c] - q[c]));
    }
    different += most > 8 ? 1 : 0;
  }
  return static_cast<double>(different) / static_cast<double>(size);
}

}
