// SPDX-License-Identifier: BSD-3-Clause
/**
 * @class   vtkKdStreamActor
 * @brief   shows a model of a server or a store in any renderer, refined for the renderer's camera
 *
 * Added to a renderer, it makes a plain vtkRenderWindow a viewer for models of any size:
 *
 *   vtkNew<vtkKdStreamActor> actor;
 *   actor->SetSource("http://127.0.0.1:8700"); // or "statue.kds"
 *   renderer->AddActor(actor);
 *
 * When its bounds or a picture are first needed, it connects, and waits for the preview (about
 * 4,000 triangles), as a mapper waits for its pipeline. Then each picture follows the renderer's
 * active camera. The pieces that the camera needs are requested. Pieces that have arrived are
 * drawn, the most urgent first, for at most SecondsPerFrame. While the window is idle, a timer of
 * its interactor renders again until all pieces have arrived. Without an interactor, call Refine,
 * or render again. At any time, the actor draws one surface without holes, within NumberOfTriangles
 * and MemoryLimit; if a view needs more, the surface is coarser.
 *
 * The actor is a prop: an assembly of actors in the model's coordinates, which can be moved, turned
 * and scaled. If it is scaled differently along the axes, the smallest scale determines how fine it
 * is; if it is scaled to nothing along an axis, it is not drawn. GetBounds returns the box of the
 * whole model, even while only the preview has arrived. Pickers (vtkCellPicker, vtkPropPicker,
 * vtkHardwareSelector) pick what is drawn. Do not change its parts. Add it directly to a renderer:
 * within another vtkAssembly it is not refined, because vtkAssembly draws only leaves. Textures are
 * drawn if the model has them. Lights are those of the renderer.
 *
 * Only one renderer at a time can draw an actor: the actor follows the camera of the last one, with
 * any projection (parallel, off axis, explicit matrices, a window centre, transforms). A picture in
 * tiles (vtkWindowToImageFilter::SetScale) is refined as a whole, for the size of its pixels, and
 * all its tiles show the same surface: take it again until IsComplete. Passes that draw for cameras
 * of their own (shadow maps) draw the surface that the picture shows. Not supported: volumes, time
 * steps, sections.
 *
 * Errors: vtkErrorMacro names the server or file; GetErrorMessage and GetErrorCode return the last
 * error. After an error there are no bounds, and nothing is drawn. If a part of a model cannot be
 * fetched, vtkWarningMacro names it once, and that part stays coarser. To connect again, after an
 * error or when the model was replaced, call Open.
 *
 * A number outside the range that is given below is clamped. NaN, or a negative number where none
 * is allowed, is an error, and the old value stays.
 *
 * Complexity: a picture costs the time to draw its triangles, and SecondsPerFrame. Memory:
 * MemoryLimit.
 * Threads: only the window's thread; the actor has one thread, which only reads from the connection
 * or file.
 *
 * Source: section 5 of the paper that the README cites; doc/viewing.md says what is refined first.
 *
 * @sa vtkKdStreamSource vtkKdStoreReader
 */
#ifndef vtkKdStreamActor_h
#define vtkKdStreamActor_h

#include "vtkAssembly.h"
#include "vtkKdStreamViewerActorModule.h" // for the export macro
#include "vtkNew.h"                       // for the property
#include "vtkWeakPointer.h"               // for the renderer and the interactor

#include <array>  // for tiles
#include <memory> // for the stream
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
   * The source of the model: a server, http://HOST:PORT or https://HOST:PORT; a store, NAME.kds; or
   * a folder of stores.
   */
  vtkSetMacro(Source, std::string);
  vtkGetMacro(Source, std::string);
  ///@}

  ///@{
  /**
   * The name of the model. Empty, the default, means the only model of the server or folder.
   */
  vtkSetMacro(ModelId, std::string);
  vtkGetMacro(ModelId, std::string);
  ///@}

  ///@{
  /**
   * As in vtkKdStreamSource, for a server: its token (default: none), a file of certificate
   * authorities to trust (default: the system's), and a folder for a cache (default: none) of at
   * most CacheSize bytes (default: 10 GiB).
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
   * Opening fails if nothing arrives for this number of seconds, 1 to 3600; connecting fails after
   * at most 30. Default 60.
   */
  virtual void SetTimeout(int value);
  vtkGetMacro(Timeout, int);
  ///@}

  ///@{
  /**
   * Approximately the maximum number of triangles (for a cloud: points) that are drawn, 1000 or
   * more. Default 2000000.
   */
  virtual void SetNumberOfTriangles(vtkIdType value);
  vtkGetMacro(NumberOfTriangles, vtkIdType);
  ///@}

  ///@{
  /**
   * Approximately the maximum memory of the decoded pieces that are drawn, in bytes, 16 MiB or
   * more. Default 512 MiB.
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
   * Approximately how long one picture may process pieces that have arrived, in seconds, 0 to 10;
   * at least one piece is processed. Default 0.02. If the window has a desired update rate, as
   * during an interaction, at most a tenth of the frame's time is used.
   */
  virtual void SetSecondsPerFrame(double value);
  vtkGetMacro(SecondsPerFrame, double);
  ///@}

  ///@{
  /**
   * Whether the window's interactor renders again when more pieces have arrived. Default on.
   */
  vtkSetMacro(RefineWhenIdle, bool);
  vtkGetMacro(RefineWhenIdle, bool);
  vtkBooleanMacro(RefineWhenIdle, bool);
  ///@}

  ///@{
  /**
   * The colours: "own" (the model's colours or textures, or else the property's colour), "none",
   * "partition", "resolution", or the name of an array of numbers that the model's levels have.
   * Default "own".
   */
  vtkSetMacro(ColorBy, std::string);
  vtkGetMacro(ColorBy, std::string);
  ///@}

  /**
   * The colour of parts without a colour of their own, and opacity, representation, edges,
   * shininess of all parts. Default: the stone of kdstream-view.
   */
  vtkProperty* GetProperty() { return this->Property; }

  /**
   * Connects again, and waits for the preview. Returns false after an error: see GetErrorMessage.
   * Call this only to learn of errors early, or to try again after an error.
   */
  bool Open();

  ///@{
  /**
   * The last error, in one line, and its kind (vtkErrorCode.h; NoFileNameError if no Source is
   * set); empty and NoError if there was no error since the source was opened.
   */
  std::string GetErrorMessage() const;
  vtkGetMacro(ErrorCode, unsigned long);
  ///@}

  /**
   * Takes in what the renderer's camera needs, for at most this number of seconds, 0 or more,
   * without rendering. Returns true if all of it has arrived; the next picture draws it. A window
   * without a size before its first picture counts as 300 x 300 pixels, VTK's default. Errors: a
   * renderer without a window; a negative number, or NaN.
   */
  bool Refine(vtkRenderer* renderer, double seconds);

  /**
   * Whether everything that the camera of the last picture needs has arrived.
   */
  bool IsComplete();

  ///@{
  /**
   * The number of triangles and points that are drawn, and the bytes that were received for them; 0
   * before the model is open.
   */
  vtkIdType GetNumberOfDrawnTriangles() const;
  vtkIdType GetNumberOfDrawnPoints() const;
  vtkTypeUInt64 GetNumberOfReceivedBytes() const;
  ///@}

  using vtkAssembly::GetBounds;
  double* GetBounds() VTK_SIZEHINT(6) override;

  /**
   * Copies the settings of another vtkKdStreamActor, its position and a copy of its property; of
   * any other prop, only what vtkProp3D copies. Each actor keeps its own parts.
   */
  void ShallowCopy(vtkProp* prop) override;

  ///@{
  /**
   * These are called by renderers and assemblies.
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
