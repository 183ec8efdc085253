// SPDX-License-Identifier: BSD-3-Clause
// What VTK's readers say, caught: they tell of bad input in messages only, and go on with an empty
// mesh.
#pragma once

#include "filters/core/Result.h"

#include <vtkSmartPointer.h>

#include <string>
#include <vector>

class vtkOutputWindow;

namespace kdstream
{

// From making one to its end all errors and warnings of VTK are collected instead of printed. Not
// for use by two threads at once.
class VtkMessages
{
public:
  VtkMessages();
  ~VtkMessages();
  VtkMessages(const VtkMessages&) = delete;
  VtkMessages& operator=(const VtkMessages&) = delete;

  // InvalidInput with the first error's text, if there was one. A warning that data could not be
  // read is an error.
  Status FirstError() const;
  // All errors so far, each once.
  std::vector<std::string> Errors() const;
  // The warnings so far, each once.
  std::vector<std::string> TakeWarnings();

private:
  vtkSmartPointer<vtkOutputWindow> Before;
};

// "vtkSTLReader: Premature EOF" for what VTK prints of an object in a source file: one line,
// without source file, address, and line ends.
std::string PlainVtkMessage(const std::string& text);

}
