// SPDX-License-Identifier: BSD-3-Clause
// Catches the messages of VTK's readers. These report bad input only by messages, and then continue
// with an empty mesh.
#pragma once

#include "filters/core/Result.h"

#include <vtkSmartPointer.h>

#include <string>
#include <vector>

class vtkOutputWindow;

namespace kdstream
{

// While an object of this class exists, all errors and warnings of VTK are collected instead of
// printed. Only one thread may use this at a time.
class VtkMessages
{
public:
  VtkMessages();
  ~VtkMessages();
  VtkMessages(const VtkMessages&) = delete;
  VtkMessages& operator=(const VtkMessages&) = delete;

  // InvalidInput with the text of the first error, if there was one. A warning that data could not
  // be read counts as an error.
  Status FirstError() const;
  // All errors so far, each once.
  std::vector<std::string> Errors() const;
  // The warnings so far, each once.
  std::vector<std::string> TakeWarnings();

private:
  vtkSmartPointer<vtkOutputWindow> Before;
};

// VTK's message on one line, without source file, address and line breaks: "vtkSTLReader: Premature
// EOF".
std::string PlainVtkMessage(const std::string& text);

}
