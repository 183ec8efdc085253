// SPDX-License-Identifier: BSD-3-Clause
/**
 * @class   vtkKdMeshReader
 * @brief   reads PLY, STL, OBJ and OFF files as KdStream's programs do
 *
 * Step "read" of the pipeline picture, as a VTK source: the chunked readers of kdstream-build. The
 * whole file is read, or an error names what is wrong with it and where; then there is no output. A
 * warning says what is dropped or forgiven (points that are not finite, faces of two corners, …).
 *
 * PLY, as text or as binary of either byte order: polygons, triangle strips ("tristrips"), point
 * clouds, and every property of vertices and faces that is a number. STL as text or binary. OBJ:
 * polygons, and colours at vertices. OFF as text.
 *
 * Output: a vtkPolyData. Points are doubles if the file has doubles, or has decimals that floats
 * cannot hold; else they are floats. A convex polygon becomes a fan of triangles around its first
 * vertex; other polygons are cut into ears; a strip becomes triangles of alternating orientation. A
 * file without faces gives a vertex cell for each point. Normals, colours ("RGB", "RGBA") and
 * texture coordinates are the active arrays of their kinds.
 *
 * Before the mesh is read, the output information has what the file's header says. For text without
 * a header, it has what a first pass over the text finds:
 * - NUMBER_OF_POINTS, unless points in the same place are merged (Merging). NUMBER_OF_CELLS: the
 *   number of faces (a polygon or strip counts as one), or of points of a cloud. Points and faces
 *   that the reader will drop are still counted.
 * - for each array an entry in vtkDataObject::POINT_DATA_VECTOR or CELL_DATA_VECTOR: FIELD_NAME,
 *   FIELD_ARRAY_TYPE, FIELD_NUMBER_OF_COMPONENTS, and for points FIELD_NUMBER_OF_TUPLES.
 *
 * No header of these formats has bounds, or ranges of arrays.
 *
 * Complexity: linear in the size of the file. Text without such a header (OBJ, STL, OFF) is read
 * two times more: for the names of its arrays, and for its counts. Memory: twice the mesh, while
 * VTK's arrays are filled. Aborting leaves an empty output.
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
   * The file to read; its extension gives the format.
   */
  vtkSetFilePathMacro(FileName);
  vtkGetFilePathMacro(FileName);
  ///@}

  /**
   * Returns whether the file exists and is a mesh, judging by its extension and its header. Text
   * without a header (OBJ, STL, OFF) is read whole. Changes nothing and reports nothing.
   */
  virtual int CanReadFile(VTK_FILEPATH const char* name);

  ///@{
  /**
   * Whether points in the same place become one, in a format that gives each triangle its own
   * points (STL). Points whose arrays differ in any bit stay separate. Default on.
   */
  vtkSetMacro(Merging, bool);
  vtkGetMacro(Merging, bool);
  vtkBooleanMacro(Merging, bool);
  ///@}

  /**
   * Which arrays of points and of cells are read: one entry for each array of the file, known after
   * UpdateInformation. Default all. When FileName changes, the arrays of the new file replace those
   * of the old one; an array of the same name keeps its setting.
   */
  vtkDataArraySelection* GetPointDataArraySelection() { return this->PointArrays; }
  vtkDataArraySelection* GetCellDataArraySelection() { return this->CellArrays; }

  ///@{
  /**
   * Keys for the numbers in the output information before the mesh is read.
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
