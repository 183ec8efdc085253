// SPDX-License-Identifier: BSD-3-Clause
// Windows for a VTK that has only GLX (doc/design.md#pictures-without-a-screen): VTK's generic
// window with our own EGL or OSMesa context, and a variant of VTK's X11 window that can be used in
// the same process.
#include "viewer/offscreen/BackendWindows.h"
#include "viewer/offscreen/GlContext.h"

#include <vtkGenericOpenGLRenderWindow.h>
#include <vtkObjectFactory.h>
#include <vtk_glew.h>

#include <string>
#include <utility>

#include <vtkXOpenGLRenderWindow.h>

#include <GL/glx.h>
#undef Status
#undef InputOutput
#undef None

namespace kdstream
{
namespace
{

// A window that is only a context: everything is drawn into VTK's framebuffer objects, which have
// the window's size.
class ContextRenderWindow final : public vtkGenericOpenGLRenderWindow
{
public:
  static ContextRenderWindow* New();
  vtkTypeMacro(ContextRenderWindow, vtkGenericOpenGLRenderWindow);

  void PrintSelf(ostream& os, vtkIndent indent) override
  {
    this->Superclass::PrintSelf(os, indent);
    os << indent << "Context: " << this->Context.get() << "\n";
  }

  // Takes the context and makes VTK ready to draw with it.
  Result<void> Open(std::unique_ptr<GlContext> context)
  {
    this->Context = std::move(context);
    if (Result<void> status = this->Context->MakeCurrent(); !status)
    {
      return status;
    }
    this->SetReadyForRendering(true);
    this->OpenGLInit();
    if (!this->Initialized)
    {
      return Error{ ErrorCode::Unsupported, "VTK needs OpenGL 3.2, the context has " + Version() };
    }
    return {};
  }

  void MakeCurrent() override
  {
    if (!this->Context)
    {
      return;
    }
    if (const Result<void> status = this->Context->MakeCurrent(); !status)
    {
      vtkErrorMacro(<< status.GetError().message);
    }
  }

  bool IsCurrent() override { return this->Context && this->Context->IsCurrent(); }

  // VTK's own function would treat it as fatal that GLEW finds no GLX display.
  void OpenGLInitContext() override
  {
    this->ContextCreationTime.Modified();
    if (this->Initialized || !GLEW_VERSION_3_2)
    {
      return;
    }
    GLfloat lineWidths[2] = { 1.0f, 1.0f };
    glGetFloatv(GL_ALIASED_LINE_WIDTH_RANGE, lineWidths);
    this->MaximumHardwareLineWidth = lineWidths[1];
    this->GlewInitValid = true;
    this->Initialized = true;
  }

  void Finalize() override
  {
    if (this->Context)
    {
      this->MakeCurrent();
      this->Superclass::Finalize();
    }
  }

protected:
  ContextRenderWindow()
  {
    this->SetOwnContext(0);
    this->SetOffScreenRendering(1);
    this->SetFrameBlitModeToNoBlit();
    this->SetSupportsOpenGL(1);
    this->SetIsDirect(1);
    this->SetReadyForRendering(false);
  }

  ~ContextRenderWindow() override
  {
    this->Finalize();
    this->Context.reset();
  }

private:
  static std::string Version()
  {
    const GLubyte* version = glGetString(GL_VERSION);
    return version ? reinterpret_cast<const char*>(version) : "none";
  }

  std::unique_ptr<GlContext> Context;
};

vtkStandardNewMacro(ContextRenderWindow);

// VTK's X11 window, which releases other contexts before it makes its own current.
class X11RenderWindow final : public vtkXOpenGLRenderWindow
{
public:
  static X11RenderWindow* New();
  vtkTypeMacro(X11RenderWindow, vtkXOpenGLRenderWindow);

  void PrintSelf(ostream& os, vtkIndent indent) override
  {
    this->Superclass::PrintSelf(os, indent);
  }

  void MakeCurrent() override
  {
    if (!this->GetGenericContext())
    {
      return;
    }
    if (const Result<void> status = this->Context.MakeCurrent(); !status)
    {
      vtkErrorMacro(<< status.GetError().message);
    }
  }

  bool IsReady() const { return this->Initialized && this->GlewInitValid; }

protected:
  X11RenderWindow() = default;
  ~X11RenderWindow() override { this->Finalize(); }

private:
  class GlxContext final : public GlContext
  {
  public:
    explicit GlxContext(X11RenderWindow& window)
      : Window(window)
    {
    }

  protected:
    const GlLibrary& Library() const override { return SystemGlLibrary(); }

    Result<void> Bind() override
    {
      this->Window.Superclass::MakeCurrent();
      if (!this->IsBound())
      {
        return Error{ ErrorCode::InputOutput, "X11: the context cannot be made current" };
      }
      return {};
    }

    void Unbind() override
    {
      if (Display* display = this->Window.GetDisplayId())
      {
        glXMakeCurrent(display, 0, nullptr);
      }
    }

    bool IsBound() const override { return this->Window.Superclass::IsCurrent(); }

  private:
    X11RenderWindow& Window;
  };

  GlxContext Context{ *this };
};

vtkStandardNewMacro(X11RenderWindow);

WindowResult MakeContextWindow(
  Result<std::unique_ptr<GlContext>> (*makeContext)(), int width, int height)
{
  if (Result<void> status = CheckGlSymbols(); !status)
  {
    return status.GetError();
  }
  Result<std::unique_ptr<GlContext>> context = makeContext();
  KDSTREAM_TRY(context);
  const vtkNew<ContextRenderWindow> window;
  window->SetSize(width, height);
  if (Result<void> status = window->Open(std::move(*context)); !status)
  {
    return status.GetError();
  }
  return vtkSmartPointer<vtkRenderWindow>(window);
}

}

WindowResult MakeEglWindow(int width, int height)
{
  return MakeContextWindow(&MakeEglContext, width, height);
}

WindowResult MakeOsMesaWindow(int width, int height)
{
  return MakeContextWindow(&MakeOsMesaContext, width, height);
}

namespace
{

WindowResult Ready(X11RenderWindow* window)
{
  window->Initialize();
  window->OpenGLInit();
  if (!window->IsReady())
  {
    return Error{ ErrorCode::Unsupported, "X11: no OpenGL 3.2 on this display" };
  }
  return vtkSmartPointer<vtkRenderWindow>(window);
}

}

WindowResult MakeX11Window(int width, int height)
{
  const Result<X11Connection> connection = ConnectToX11();
  KDSTREAM_TRY(connection);
  const vtkNew<X11RenderWindow> window;
  window->SetOffScreenRendering(1);
  window->SetSize(width, height);
  return Ready(window);
}

WindowResult MakeX11ScreenWindow(int width, int height, const std::string& title)
{
  const Result<X11Connection> connection = ConnectToX11();
  KDSTREAM_TRY(connection);
  const vtkNew<X11RenderWindow> window;
  window->SetSize(width, height);
  window->SetWindowName(title.c_str());
  return Ready(window);
}

}
