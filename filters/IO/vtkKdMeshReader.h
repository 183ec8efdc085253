// SPDX-License-Identifier: BSD-3-Clause
/**
 * @class   vtkKdMeshReader
 * @brief   reads PLY, STL, OBJ and OFF files as KdStream's programs do
 *
 * Step "read" of the pipeline picture, as a VTK source: the chunked readers of kdstream-build. All
 * of a file is read, or an error names what is wrong with it and where; there is no output then.
 * What is dropped or forgiven (points that are not finite, faces of two corners, …) is a warning.
 *
 * PLY, as text and binary of either byte order: polygons, triangle strips ("tristrips"), point
 * clouds; every property that is a number, of vertices and faces. STL as text and binary. OBJ:
 * polygons and colours at vertices. OFF as text.
 *
 * Output: a vtkPolyData. Points are floats, or doubles where the file has doubles, or decimals that
 * floats do not hold. Polygons become triangles: a fan around their first vertex, those that are
 * not convex ear by ear; strips triangles of alternating orientation. A file without faces gives a
 * vertex cell for each point.
 * Normals, colours ("RGB", "RGBA") and texture coordinates are the active ones of their kind.
 *
 * The output information has, before anything is read, what the file's header says (or a first pass
 * over text without a header):
 * - NUMBER_OF_POINTS, if points of one place do not become one (Merging); NUMBER_OF_CELLS: faces,
 *   each polygon and strip as one, or the points of a cloud. What is dropped is counted there.
 * - for each array an entry in vtkDataObject::POINT_DATA_VECTOR or CELL_DATA_VECTOR: FIELD_NAME,
 *   FIELD_ARRAY_TYPE, FIELD_NUMBER_OF_COMPONENTS, of points FIELD_NUMBER_OF_TUPLES.
 *
 * No header of these formats has bounds, or ranges of arrays.
 *
 * Complexity: linear in the size of the file. Text that does not say at its beginning what it has
 * (OBJ, STL, OFF) is read twice before: for the names of its arrays, and for its counts. Memory:
 * that of the mesh twice, while the arrays of VTK are filled. Aborting leaves an empty output.
 *
 * @sa vtkKdStoreWriter
 */
#ifndef vtkKdMeshReader_h
#define vtkKdMeshReader_h

#include "vtkKdStreamFiltersIOModule.h" // for the export macro
#include "vtkNew.h"                     // for the selections
#include "vtkPolyDataAlgorithm.h"

class vtkDataArraySelection;
class vtkInformationIdTypeKey;

class VTKKDSTREAMFILTERSIO_EXPORT vtkKdMeshReader : public vtkPolyDataAlgorithm
{
public:
  static vtkKdMeshReader* New();
  vtkTypeMacro(vtkKdMeshReader, vtkPolyDataAlgorithm);
  void PrintSelf(ostream& os, vtkIndent indent) override;

  ///@{
  /**
   * The file to read; its ending tells the format.
   */
  vtkSetFilePathMacro(FileName);
  vtkGetFilePathMacro(FileName);
  ///@}

  /**
   * Whether the file is there and a mesh, by its ending and its header; of text that does not
   * say before what it has (OBJ, STL, OFF) by all of it. Nothing is changed or told.
   */
  virtual int CanReadFile(VTK_FILEPATH const char* name);

  ///@{
  /**
   * Whether points of one place become one, where a format gives each triangle points of its own
   * (STL). Points that differ in a bit of an array stay apart. Default on.
   */
  vtkSetMacro(Merging, bool);
  vtkGetMacro(Merging, bool);
  vtkBooleanMacro(Merging, bool);
  ///@}

  /**
   * The arrays of points and of cells that the file has, known after UpdateInformation: which of
   * them to read. Default all. Those of another file take their place when FileName changes; what
   * was chosen of the same name stays.
   */
  vtkDataArraySelection* GetPointDataArraySelection() { return this->PointArrays; }
  vtkDataArraySelection* GetCellDataArraySelection() { return this->CellArrays; }

  ///@{
  /**
   * Keys of what is told of the output before anything is read.
   */
  static vtkInformationIdTypeKey* NUMBER_OF_POINTS();
  static vtkInformationIdTypeKey* NUMBER_OF_CELLS();
  ///@}

  vtkMTimeType GetMTime() override;

protected:
  vtkKdMeshReader();
  ~vtkKdMeshReader() override;

  int RequestInformation(vtkInformation* request, vtkInformationVector** inputVector,
    vtkInformationVector* outputVector) override;
  int RequestData(vtkInformation* request, vtkInformationVector** inputVector,
    vtkInformationVector* outputVector) override;

private:
  vtkKdMeshReader(const vtkKdMeshReader&) = delete;
  void operator=(const vtkKdMeshReader&) = delete;

  char* FileName = nullptr;
  bool Merging = true;
  vtkNew<vtkDataArraySelection> PointArrays;
  vtkNew<vtkDataArraySelection> CellArrays;
};

#endif
