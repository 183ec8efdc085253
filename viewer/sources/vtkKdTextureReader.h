// SPDX-License-Identifier: BSD-3-Clause
/**
 * @class   vtkKdTextureReader
 * @brief   reads a partition of a textured model: its surface with texture coordinates, its picture
 *
 * Of a store (FileName), or of what a source has open (ModelSource): a server's model.
 *
 * Port 0 is a vtkPolyData: the partition's triangles, but those that a partition of a lower number
 * has too, so that all partitions together have each once. Points are split where their corners
 * have different places in the picture; "TCoords", two floats, are the active texture coordinates,
 * v upwards. The arrays of points come along, but colours, which the picture stands for.
 *
 * Port 1 is a vtkImageData of unsigned char, RGB or RGBA, sRGB, for vtkTexture's
 * SetInputConnection:
 *
 *   texture->SetInputConnection(reader->GetOutputPort(1)); // InterpolateOn, ClampToEdge
 *   mapper->SetInputConnection(reader->GetOutputPort());
 *   actor->SetTexture(texture);
 *
 * Aborting is as vtkKdModelSource has it. Errors name the file or server: one without textures, a
 * partition that there is not, what is damaged; GetErrorCode tells that there was one
 * (vtkErrorCode.h). Complexity: of the partition, linear; of a server's model two blobs are
 * fetched.
 *
 * @sa vtkKdStoreReader vtkKdStreamSource
 */
#ifndef vtkKdTextureReader_h
#define vtkKdTextureReader_h

#include "vtkAlgorithm.h"
#include "vtkKdStreamViewerSourcesModule.h" // for the export macro

#include "vtkSmartPointer.h" // for the source

#include <atomic> // for aborts
#include <memory> // for what is open
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
   * Whether the file is a store with textures. Nothing is changed or told.
   */
  virtual int CanReadFile(VTK_FILEPATH const char* name);

  ///@{
  /**
   * A vtkKdStreamSource or vtkKdStoreReader, whose model is read instead of a file's, over its
   * connection; what else it loads does not matter. Default none.
   */
  void SetModelSource(vtkKdModelSource* source);
  vtkKdModelSource* GetModelSource() const;
  ///@}

  ///@{
  /**
   * Which partition, from 0 on. Default 0.
   */
  virtual void SetPartition(vtkIdType value);
  vtkGetMacro(Partition, vtkIdType);
  ///@}

  /**
   * How many the model has, known after UpdateInformation: 0 before.
   */
  vtkIdType GetNumberOfModelPartitions() const;

  vtkPolyData* GetOutput();
  vtkImageData* GetPicture();

  vtkMTimeType GetMTime() override;

  vtkTypeBool ProcessRequest(vtkInformation* request, vtkInformationVector** inputVector,
    vtkInformationVector* outputVector) override;

  // An abort counts from the begin of an Update, which asks for the time first; VTK forgets what
  // comes before RequestData.
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
  vtkIdType Partition = 0;
  // Since the last RequestInformation.
  std::shared_ptr<const kdstream::PieceSource> Model;
  std::vector<unsigned char> Tile;       // with the picture
  bool WasStopped = false;               // while that was opened
  std::atomic<bool> WasAborted{ false }; // since the Update began, by any thread
  bool IsStale = false;                  // stopped, or failed: to be read anew by the next Update
};

#endif
