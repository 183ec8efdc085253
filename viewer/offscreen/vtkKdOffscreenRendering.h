// SPDX-License-Identifier: BSD-3-Clause
/**
 * @class   vtkKdOffscreenRendering
 * @brief   lets any program draw without a screen: on EGL, on OSMesa or on an X server
 *
 * A VTK that was built only for X11, such as Debian 12's, ends the program if there is no X server.
 * This class makes vtkRenderWindow draw by libEGL (without a display server, on a graphics card or
 * by Mesa's renderer) or by libOSMesa. The library is opened when it is first needed:
 *
 * @code
 * vtkNew<vtkKdOffscreenRendering> offscreen;
 * auto window = offscreen->MakeWindow(800, 600);   // a vtkSmartPointer<vtkRenderWindow>
 * @endcode
 *
 * A program that makes its windows by vtkRenderWindow::New() calls UseForAllWindows() at the
 * beginning of main. Or it stays unchanged, and runs with the environment variable
 * KDSTREAM_OFFSCREEN = auto, egl, osmesa or x11.
 *
 * The executable must be given to the CMake function kdstream_enable_offscreen(TARGET) of
 * find_package(KdStream COMPONENTS ViewerOffscreen). Otherwise the functions of this class report
 * an error that says so.
 *
 * Windows are ready for renderers, vtkWindowToImageFilter and passes; SetSize may be called at any
 * time. Edges are smoothed by 4 samples; in windows of vtkRenderWindow::New(), by VTK's default
 * number. The interactors of these windows (vtkGenericRenderWindowInteractor) have no events:
 * Start() returns at once.
 *
 * Cost: the first window of a process opens the library, which takes about 50 ms with Mesa; a
 * change of backend between windows costs about 1 ms. Threads: all windows of a process must be
 * used from one thread.
 *
 * @sa doc/offscreen.md
 */
#ifndef vtkKdOffscreenRendering_h
#define vtkKdOffscreenRendering_h

#include <vtkKdStreamViewerOffscreenModule.h> // for export macro
#include <vtkObject.h>
#include <vtkSmartPointer.h> // for the result of MakeWindow

class vtkRenderWindow;

class VTKKDSTREAMVIEWEROFFSCREEN_EXPORT vtkKdOffscreenRendering : public vtkObject
{
public:
  static vtkKdOffscreenRendering* New();
  vtkTypeMacro(vtkKdOffscreenRendering, vtkObject);
  void PrintSelf(ostream& os, vtkIndent indent) override;

  enum Backends
  {
    Auto,   ///< the first of the following that works
    Egl,    ///< libEGL without a display server
    OsMesa, ///< libOSMesa, Mesa's renderer in main memory
    X11     ///< the X server that DISPLAY names; nothing is shown there
  };

  ///@{
  /** What windows draw on. Default: Auto. */
  vtkSetClampMacro(Backend, int, Auto, X11);
  vtkGetMacro(Backend, int);
  void SetBackendToAuto() { this->SetBackend(Auto); }
  void SetBackendToEgl() { this->SetBackend(Egl); }
  void SetBackendToOsMesa() { this->SetBackend(OsMesa); }
  void SetBackendToX11() { this->SetBackend(X11); }
  const char* GetBackendAsString();
  /** "auto", "egl", "osmesa" or "x11"; false, an error event and no change for another name. */
  bool SetBackendFromString(const char* name);
  ///@}

  /**
   * Makes a window of width × height pixels, each 1 … 8192. Errors: returns null, with an error
   * event that says what each backend lacks (library, device, display).
   */
  vtkSmartPointer<vtkRenderWindow> MakeWindow(int width, int height);

  /**
   * The result of the last SetBackendFromString, MakeWindow or UseForAllWindows (vtkErrorCode.h):
   * NoError or UnknownError.
   */
  vtkGetMacro(ErrorCode, unsigned long);

  /**
   * From now on vtkRenderWindow::New() makes windows of this kind, and
   * vtkRenderWindowInteractor::New() makes interactors without events. If no backend can draw here,
   * returns false with an error event, and changes nothing.
   */
  bool UseForAllWindows();

  /**
   * Calls UseForAllWindows with the backend that the environment variable KDSTREAM_OFFSCREEN names,
   * if it is set. kdstream_enable_offscreen calls this before main. Returns false, with an error
   * message, if the name is wrong. Whether the backend works is only checked when the first window
   * is made.
   */
  static bool UseEnvironment();

protected:
  vtkKdOffscreenRendering();
  ~vtkKdOffscreenRendering() override;

private:
  vtkKdOffscreenRendering(const vtkKdOffscreenRendering&) = delete;
  void operator=(const vtkKdOffscreenRendering&) = delete;

  int Backend = Auto;
  unsigned long ErrorCode = 0; // NoError
};

#endif
