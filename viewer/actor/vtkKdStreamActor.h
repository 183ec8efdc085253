// SPDX-License-Identifier: BSD-3-Clause
/**
 * @class   vtkKdStreamActor
 * @brief   a model of a server or a store in any renderer, refined for its camera as data arrive
 *
 * Added to a renderer it makes a plain vtkRenderWindow a viewer of models of any size:
 *
 *   vtkNew<vtkKdStreamActor> actor;
 *   actor->SetSource("http://127.0.0.1:8700"); // or "statue.kds"
 *   renderer->AddActor(actor);
 *
 * When its bounds are first asked for, or a picture is first taken, it connects and waits for the
 * preview (about 4,000 triangles), as a mapper waits for its pipeline. Each picture then follows
 * the renderer's active camera: what the camera needs is requested, and what has arrived is drawn,
 * most urgent first, for at most SecondsPerFrame. While the window is idle, a timer of its
 * interactor renders again as data arrive, until all have arrived. Without an interactor call
 * Refine, or render again. At any time one surface without holes is drawn, within NumberOfTriangles
 * and MemoryLimit; it is coarser if a view needs more.
 *
 * As a prop it is an assembly of actors in the model's coordinates, and can be moved, turned and
 * scaled (of scales that differ along axes the least counts; what is scaled to nothing along an
 * axis is not drawn). GetBounds is the box of the whole model from the first time on. Pickers
 * (vtkCellPicker, vtkPropPicker, vtkHardwareSelector) pick what is drawn. Do not change its parts.
 * Add it to a renderer: as a part of another vtkAssembly, which draws only leaves, it is not
 * refined. Textures are drawn if the model has them. Lights are the renderer's.
 *
 * One renderer at a time draws an actor: it follows the camera of the last one, with any
 * projection: parallel, off axis, explicit matrices, a window centre, transforms. A picture in
 * tiles (vtkWindowToImageFilter::SetScale) is followed as a whole, as fine as its pixels need, and
 * all its tiles show the same: take it again until IsComplete. Passes that draw for cameras of
 * their own (shadow maps) draw what the picture shows. Not supported: volumes, time steps,
 * sections.
 *
 * Errors: vtkErrorMacro names the server or file; GetErrorMessage and GetErrorCode have the last
 * error. Then there are no bounds, and nothing is drawn. vtkWarningMacro names, once, a part of a
 * model that cannot be fetched; that part stays coarser. Open connects anew: after an error, or
 * where the model was replaced.
 *
 * Numbers below that are out of their range are clamped. A negative number where none is allowed,
 * or NaN, is an error, and the old value stays.
 *
 * Complexity: a picture costs what its triangles cost, and SecondsPerFrame. Memory: MemoryLimit.
 * Threads: that of the window; a thread of its own only reads from the line or file.
 *
 * Source: section 5 of the paper named in the README; doc/viewing.md says what is refined first.
 *
 * @sa vtkKdStreamSource vtkKdStoreReader
 */
#ifndef vtkKdStreamActor_h
#define vtkKdStreamActor_h

#include "vtkAssembly.h"
#include "vtkKdStreamViewerActorModule.h" // for the export macro
#include "vtkNew.h"                       // for the property
#include "vtkWeakPointer.h"               // for who draws it

#include <array>  // for tiles
#include <memory> // for what is open
#include <string> // for names

class vtkProperty;
class vtkRenderWindow;
class vtkRenderWindowInteractor;
class vtkRenderer;

namespace kdstream
{
class ActorStream;
struct ServerAddress;
}

class VTKKDSTREAMVIEWERACTOR_EXPORT vtkKdStreamActor : public vtkAssembly
{
public:
  static vtkKdStreamActor* New();
  vtkTypeMacro(vtkKdStreamActor, vtkAssembly);
  void PrintSelf(ostream& os, vtkIndent indent) override;

  ///@{
  /**
   * Where the model is: a server, http://HOST:PORT or https://HOST:PORT; a store, NAME.kds; or a
   * folder of stores.
   */
  vtkSetMacro(Source, std::string);
  vtkGetMacro(Source, std::string);
  ///@}

  ///@{
  /**
   * The name of the model; empty, the default: the server's or folder's only one.
   */
  vtkSetMacro(ModelId, std::string);
  vtkGetMacro(ModelId, std::string);
  ///@}

  ///@{
  /**
   * As in vtkKdStreamSource, for a server: its token, a file of certificate authorities to trust,
   * and a folder for a cache of at most CacheSize bytes. Default none, the system's, none, and 10
   * GiB.
   */
  vtkSetMacro(Token, std::string);
  vtkGetMacro(Token, std::string);
  vtkSetMacro(CertificateAuthorities, std::string);
  vtkGetMacro(CertificateAuthorities, std::string);
  vtkSetMacro(CacheFolder, std::string);
  vtkGetMacro(CacheFolder, std::string);
  vtkSetMacro(CacheSize, vtkTypeUInt64);
  vtkGetMacro(CacheSize, vtkTypeUInt64);
  ///@}

  ///@{
  /**
   * Opening fails if nothing arrives for this number of seconds, 1 to 3600 (of connecting at most
   * 30). Default 60.
   */
  virtual void SetTimeout(int value);
  vtkGetMacro(Timeout, int);
  ///@}

  ///@{
  /**
   * About the maximum number of triangles (of a cloud, points) that are drawn, 1000 or more.
   * Default 2000000.
   */
  virtual void SetNumberOfTriangles(vtkIdType value);
  vtkGetMacro(NumberOfTriangles, vtkIdType);
  ///@}

  ///@{
  /**
   * About the maximum memory of what is drawn, decoded, in bytes, 16 MiB or more. Default 512 MiB.
   */
  virtual void SetMemoryLimit(vtkTypeUInt64 value);
  vtkGetMacro(MemoryLimit, vtkTypeUInt64);
  ///@}

  ///@{
  /**
   * The accepted screen-space error in pixels, 0.01 to 100. Default 1. A model whose original has
   * at most an eighth of NumberOfTriangles is shown four times as fine.
   */
  virtual void SetTolerance(double value);
  vtkGetMacro(Tolerance, double);
  ///@}

  ///@{
  /**
   * About how long one picture may process what has arrived, in seconds, 0 to 10; at least one
   * piece is processed. Default 0.02. If the window desires an update rate, as during an
   * interaction, at most a tenth of the frame's time.
   */
  virtual void SetSecondsPerFrame(double value);
  vtkGetMacro(SecondsPerFrame, double);
  ///@}

  ///@{
  /**
   * Whether the window's interactor renders again as data arrive. Default on.
   */
  vtkSetMacro(RefineWhenIdle, bool);
  vtkGetMacro(RefineWhenIdle, bool);
  vtkBooleanMacro(RefineWhenIdle, bool);
  ///@}

  ///@{
  /**
   * What is coloured: "own" (the model's colours or textures, else the property's colour), "none",
   * "partition", "resolution", or the name of an array of numbers that the model's levels have.
   * Default "own".
   */
  vtkSetMacro(ColorBy, std::string);
  vtkGetMacro(ColorBy, std::string);
  ///@}

  /**
   * Colour (of parts without one of their own), opacity, representation, edges, shininess. Default:
   * the stone of kdstream-view.
   */
  vtkProperty* GetProperty() { return this->Property; }

  /**
   * Connects anew, and waits for the preview. False: see GetErrorMessage. Only needed to learn of
   * errors early, or to try again after one.
   */
  bool Open();

  ///@{
  /**
   * The last error, a line, and its kind (vtkErrorCode.h; NoFileNameError if no Source is set);
   * empty and NoError if there was none since the source was opened.
   */
  std::string GetErrorMessage() const;
  vtkGetMacro(ErrorCode, unsigned long);
  ///@}

  /**
   * Takes in what the renderer's camera needs for at most this number of seconds, 0 or more,
   * without rendering. True: all of it has arrived; the next picture draws it. A window without a
   * size before its first picture counts as 300 x 300 pixels, VTK's default. Errors: a renderer
   * without a window; a negative number, or NaN.
   */
  bool Refine(vtkRenderer* renderer, double seconds);

  /**
   * Whether everything that the camera of the last picture needs has arrived.
   */
  bool IsComplete();

  ///@{
  /**
   * The number of triangles drawn, and the bytes received for them: 0 before it is open.
   */
  vtkIdType GetNumberOfDrawnTriangles() const;
  vtkIdType GetNumberOfDrawnPoints() const;
  vtkTypeUInt64 GetNumberOfReceivedBytes() const;
  ///@}

  using vtkAssembly::GetBounds;
  double* GetBounds() VTK_SIZEHINT(6) override;

  /**
   * Copies the settings of a vtkKdStreamActor, its place and a copy of its property; of other props
   * what vtkProp3D copies. Each actor keeps its own parts.
   */
  void ShallowCopy(vtkProp* prop) override;

  ///@{
  /**
   * For renderers and assemblies.
   */
  void SetAllocatedRenderTime(double seconds, vtkViewport* viewport) override;
  int RenderOpaqueGeometry(vtkViewport* viewport) override;
  void BuildPaths(vtkAssemblyPaths* paths, vtkAssemblyPath* path) override;
  ///@}

protected:
  vtkKdStreamActor();
  ~vtkKdStreamActor() override;

private:
  vtkKdStreamActor(const vtkKdStreamActor&) = delete;
  void operator=(const vtkKdStreamActor&) = delete;

  kdstream::ServerAddress Address() const;
  bool IsOpen();
  void Close();
  void FollowCamera(vtkRenderer& renderer);
  bool BeginsPicture(vtkRenderWindow& window);
  void TakeIn(double seconds);
  double SecondsFor(vtkRenderer& renderer);
  void WaitForIdle(vtkRenderer& renderer);
  void StopWaiting();
  void OnTimer(vtkObject* interactor, unsigned long event, void* timer);

  std::string Source, ModelId, Token, CertificateAuthorities, CacheFolder;
  vtkTypeUInt64 CacheSize = vtkTypeUInt64{ 10 } << 30;
  int Timeout = 60;
  vtkIdType NumberOfTriangles = 2000000;
  vtkTypeUInt64 MemoryLimit = vtkTypeUInt64{ 512 } << 20;
  double Tolerance = 1;
  double SecondsPerFrame = 0.02;
  bool RefineWhenIdle = true;
  std::string ColorBy = "own";
  vtkNew<vtkProperty> Property;

  std::unique_ptr<kdstream::ActorStream> Stream; // null: nothing is open
  // The server of Stream, or the one that could not be opened.
  std::unique_ptr<const kdstream::ServerAddress> Tried;
  double TriedTolerance = 0;
  std::string ErrorMessage, LastWarning;
  unsigned long ErrorCode = 0;          // NoError
  vtkWeakPointer<vtkRenderer> Renderer; // of the last picture
  vtkWeakPointer<vtkRenderWindowInteractor> Interactor;
  unsigned long TimerObserver = 0;
  int Timer = 0, LastTimer = 0;
  std::array<double, 4> Tile{}; // of the last picture: scales, bottom, left
  bool HasReportedAssembly = false;
};

#endif
