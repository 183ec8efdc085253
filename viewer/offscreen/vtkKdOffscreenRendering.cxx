// SPDX-License-Identifier: BSD-3-Clause
#include "viewer/offscreen/vtkKdOffscreenRendering.h"

#include "viewer/offscreen/OffscreenWindow.h"

#include <vtkErrorCode.h>
#include <vtkGenericRenderWindowInteractor.h>
#include <vtkObjectFactory.h>
#include <vtkOpenGLRenderWindow.h>
#include <vtkVersion.h>

#include <cstdlib>

namespace
{

kdstream::WindowBackend BackendOf(int backend)
{
  return static_cast<kdstream::WindowBackend>(backend);
}

// A factory that takes precedence over VTK's own.
class WindowFactory final : public vtkObjectFactory
{
public:
  vtkTypeMacro(WindowFactory, vtkObjectFactory);

  // O(1) after the first call.
  static void Use(kdstream::WindowBackend backend)
  {
    chosen = backend;
    static bool registered = false;
    if (registered)
    {
      return;
    }
    registered = true;
    vtkObjectFactory::GetRegisteredFactories(); // makes VTK's list if it does not exist yet
    for (const char* name : { "vtkRenderWindow", "vtkRenderWindowInteractor" })
    {
      vtkObjectFactory::SetAllEnableFlags(0, name); // of the earlier factories
    }
    auto* const factory = new WindowFactory;
    vtkObjectFactory::RegisterFactory(factory);
    factory->Delete();
  }

  const char* GetVTKSourceVersion() override { return vtkVersion::GetVTKSourceVersion(); }
  const char* GetDescription() override
  {
    return "KdStream's windows for drawing without a screen";
  }

private:
  WindowFactory()
  {
    this->RegisterOverride(
      "vtkRenderWindow", "vtkKdOffscreenRendering", "draws without a screen", 1, &MakeWindow);
    this->RegisterOverride("vtkRenderWindowInteractor", "vtkGenericRenderWindowInteractor",
      "has no events", 1, &MakeInteractor);
  }

  static vtkObject* MakeWindow()
  {
    constexpr int side = 300; // VTK's default
    const auto window = kdstream::MakeOffscreenWindow(chosen, side, side);
    if (!window)
    {
      vtkGenericWarningMacro(<< window.GetError().message);
      return nullptr;
    }
    // The same as for VTK's own windows, so that a program's pictures are the same as on a screen.
    (*window)->SetMultiSamples(vtkOpenGLRenderWindow::GetGlobalMaximumNumberOfMultiSamples());
    (*window)->Register(nullptr);
    return *window;
  }

  static vtkObject* MakeInteractor() { return vtkGenericRenderWindowInteractor::New(); }

  static kdstream::WindowBackend chosen;
};

kdstream::WindowBackend WindowFactory::chosen = kdstream::WindowBackend::Auto;

}

static_assert(static_cast<int>(kdstream::WindowBackend::X11) == vtkKdOffscreenRendering::X11);

vtkStandardNewMacro(vtkKdOffscreenRendering);

vtkKdOffscreenRendering::vtkKdOffscreenRendering() = default;
vtkKdOffscreenRendering::~vtkKdOffscreenRendering() = default;

void vtkKdOffscreenRendering::PrintSelf(ostream& os, vtkIndent indent)
{
  this->Superclass::PrintSelf(os, indent);
  os << indent << "Backend: " << this->GetBackendAsString() << "\n";
  os << indent << "ErrorCode: " << vtkErrorCode::GetStringFromErrorCode(this->ErrorCode) << "\n";
}

const char* vtkKdOffscreenRendering::GetBackendAsString()
{
  return kdstream::NameOf(BackendOf(this->Backend));
}

bool vtkKdOffscreenRendering::SetBackendFromString(const char* name)
{
  const auto backend = kdstream::ParseWindowBackend(name ? name : "");
  this->ErrorCode = backend ? vtkErrorCode::NoError : vtkErrorCode::UnknownError;
  if (!backend)
  {
    vtkErrorMacro(<< backend.GetError().message);
    return false;
  }
  this->SetBackend(static_cast<int>(*backend));
  return true;
}

vtkSmartPointer<vtkRenderWindow> vtkKdOffscreenRendering::MakeWindow(int width, int height)
{
  auto window = kdstream::MakeOffscreenWindow(BackendOf(this->Backend), width, height);
  this->ErrorCode = window ? vtkErrorCode::NoError : vtkErrorCode::UnknownError;
  if (!window)
  {
    vtkErrorMacro(<< window.GetError().message);
    return nullptr;
  }
  return *window;
}

bool vtkKdOffscreenRendering::UseForAllWindows()
{
  if (!this->MakeWindow(1, 1))
  {
    return false;
  }
  WindowFactory::Use(BackendOf(this->Backend));
  return true;
}

bool vtkKdOffscreenRendering::UseEnvironment()
{
  const char* const name = std::getenv("KDSTREAM_OFFSCREEN");
  if (!name || !*name)
  {
    return true;
  }
  const auto backend = kdstream::ParseWindowBackend(name);
  if (!backend)
  {
    vtkGenericWarningMacro(<< "KDSTREAM_OFFSCREEN: " << backend.GetError().message);
    return false;
  }
  WindowFactory::Use(*backend);
  return true;
}
