// SPDX-License-Identifier: BSD-3-Clause
// Collects the errors of a VTK object, which are then not printed.
#pragma once

#include <vtkCallbackCommand.h>
#include <vtkCommand.h>
#include <vtkNew.h>
#include <vtkObject.h>

#include <string>
#include <utility>

namespace kdstream::testing
{

class ReportedErrors
{
public:
  explicit ReportedErrors(vtkObject& object, unsigned long event = vtkCommand::ErrorEvent)
  {
    this->Callback->SetClientData(this);
    this->Callback->SetCallback([](vtkObject*, unsigned long, void* self, void* message)
      { static_cast<ReportedErrors*>(self)->Text += static_cast<const char*>(message); });
    object.AddObserver(event, this->Callback);
  }
  ~ReportedErrors() { this->Callback->SetCallback(nullptr); }
  ReportedErrors(const ReportedErrors&) = delete;
  ReportedErrors& operator=(const ReportedErrors&) = delete;

  // All errors since the last call.
  std::string Take() { return std::exchange(this->Text, {}); }

private:
  std::string Text;
  vtkNew<vtkCallbackCommand> Callback;
};

}
