// SPDX-License-Identifier: BSD-3-Clause
/**
 * @class   vtkKdTextureReader
 * @brief   reads a piece of a textured model: its surface with texture coordinates, its picture
 *
 * Reads from a store (FileName), or from the open model of a source (ModelSource), for example from
 * a server.
 *
 * A piece is a partition of the original, or of a level (Level). Port 0 is a vtkPolyData: the
 * piece's triangles, without those that a piece with a lower number has too, so that each triangle
 * is in exactly one piece. Points are split where their corners have different places in the
 * picture; "TCoords", two floats, are the active texture coordinates, v upwards. It has all arrays
 * of points except colours, which the picture replaces.
 *
 * Port 1 is a vtkImageData of unsigned char, RGB or RGBA, sRGB, for vtkTexture's
 * SetInputConnection:
 *
 *   texture->SetInputConnection(reader->GetOutputPort(1)); // InterpolateOn, ClampToEdge
 *   mapper->SetInputConnection(reader->GetOutputPort());
 *   actor->SetTexture(texture);
 *
 * Aborting works as in vtkKdModelSource. Errors, which name the file or server: no textures, a
 * piece that does not exist, damaged data. GetErrorCode is set (vtkErrorCode.h). Complexity: linear
 * in the size of the piece; from a server, two blobs are fetched.
 *
 * @sa vtkKdStoreReader vtkKdStreamSource
 */
#ifndef vtkKdTextureReader_h
#define vtkKdTextureReader_h

#include "vtkAlgorithm.h"
#include "vtkKdStreamViewerSourcesModule.h" // for the export macro

#include "vtkSmartPointer.h" // for the source

#include <atomic> // for aborts
#include <memory> // for the open model
#include <string> // for names
#include <vector> // for the picture

class vtkImageData;
class vtkKdModelSource;
class vtkPolyData;

namespace kdstream
{
class PieceSource;
struct Error;
struct Execution;
}

class VTKKDSTREAMVIEWERSOURCES_EXPORT vtkKdTextureReader : public vtkAlgorithm
{
public:
  static vtkKdTextureReader* New();
  vtkTypeMacro(vtkKdTextureReader, vtkAlgorithm);
  void PrintSelf(ostream& os, vtkIndent indent) override;

  ///@{
  /**
   * The store.
   */
  vtkSetFilePathMacro(FileName);
  vtkGetFilePathMacro(FileName);
  ///@}

  /**
   * Whether the file is a store with textures. Changes nothing and reports nothing.
   */
  virtual int CanReadFile(VTK_FILEPATH const char* name);

  ///@{
  /**
   * A vtkKdStreamSource or vtkKdStoreReader. Its model is read instead of a file, over its
   * connection; its other settings do not matter. Default none.
   */
  void SetModelSource(vtkKdModelSource* source);
  vtkKdModelSource* GetModelSource() const;
  ///@}

  ///@{
  /**
   * The level whose pieces are read, 0 to 30, if levels of the store have textures. -1, the
   * default: the original.
   */
  virtual void SetLevel(int value);
  vtkGetMacro(Level, int);
  ///@}

  ///@{
  /**
   * The number of the partition, or of the level's piece, from 0. Default 0.
   */
  virtual void SetPartition(vtkIdType value);
  vtkGetMacro(Partition, vtkIdType);
  ///@}

  /**
   * The number of partitions of the model, or of pieces of the level, known after
   * UpdateInformation: 0 before.
   */
  vtkIdType GetNumberOfModelPartitions() const;

  vtkPolyData* GetOutput();
  vtkImageData* GetPicture();

  vtkMTimeType GetMTime() override;

  vtkTypeBool ProcessRequest(vtkInformation* request, vtkInformationVector** inputVector,
    vtkInformationVector* outputVector) override;

  // Overridden because an abort counts from the beginning of an Update: VTK would forget an abort
  // before RequestData.
  void SetAbortExecute(vtkTypeBool abort) override;
  int ComputePipelineMTime(vtkInformation* request, vtkInformationVector** input,
    vtkInformationVector* output, int port, vtkMTimeType* time) override;

protected:
  vtkKdTextureReader();
  ~vtkKdTextureReader() override;

  int FillOutputPortInformation(int port, vtkInformation* info) override;

private:
  vtkKdTextureReader(const vtkKdTextureReader&) = delete;
  void operator=(const vtkKdTextureReader&) = delete;

  int RequestInformation(vtkInformationVector* outputVector);
  int RequestData(vtkInformationVector* outputVector);
  std::string ModelName() const;
  bool OpenModel(const kdstream::Execution& execution, kdstream::Error& error);
  int Fail(const kdstream::Error& error);

  char* FileName = nullptr;
  vtkSmartPointer<vtkKdModelSource> ModelSource;
  int Level = -1;
  vtkIdType Partition = 0;
  // Since the last RequestInformation.
  std::shared_ptr<const kdstream::PieceSource> Model;
  std::vector<unsigned char> Tile;       // the tile's blob, with the picture
  bool WasStopped = false;               // while the model was opened
  std::atomic<bool> WasAborted{ false }; // since the Update began, by any thread
  bool IsStale = false;                  // stopped or failed: the next Update must read again
};

#endif
