// SPDX-License-Identifier: BSD-3-Clause
/**
 * @class   vtkKdTextureReader
 * @brief   reads a partition of a textured store: its surface with texture coordinates, its picture
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
 * Errors name the file: one without textures, a partition that there is not, what is damaged;
 * GetErrorCode tells that there was one (vtkErrorCode.h).
 * Complexity: of the partition, linear.
 *
 * @sa vtkKdStoreReader
 */
#ifndef vtkKdTextureReader_h
#define vtkKdTextureReader_h

#include "vtkAlgorithm.h"
#include "vtkKdStreamViewerSourcesModule.h" // for the export macro

#include <memory> // for what is open

class vtkImageData;
class vtkPolyData;

namespace kdstream
{
class Store;
struct Error;
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

  vtkTypeBool ProcessRequest(vtkInformation* request, vtkInformationVector** inputVector,
    vtkInformationVector* outputVector) override;

protected:
  vtkKdTextureReader();
  ~vtkKdTextureReader() override;

  int FillOutputPortInformation(int port, vtkInformation* info) override;

private:
  vtkKdTextureReader(const vtkKdTextureReader&) = delete;
  void operator=(const vtkKdTextureReader&) = delete;

  int RequestInformation(vtkInformationVector* outputVector);
  int RequestData(vtkInformationVector* outputVector);
  int Fail(const kdstream::Error& error);

  char* FileName = nullptr;
  vtkIdType Partition = 0;
  std::shared_ptr<const kdstream::Store> Model; // since the last RequestInformation
};

#endif
