// SPDX-License-Identifier: BSD-3-Clause
/**
 * @class   vtkKdStoreWriter
 * @brief   makes a store of a surface or point set: the file for KdStream's servers and viewers
 *
 * Step "build" of the pipeline picture, as a VTK writer: does what kdstream-build does with a mesh
 * that fits into memory.
 *
 * Input: a vtkPolyData; or a vtkPartitionedDataSet, vtkPartitionedDataSetCollection or
 * vtkMultiBlockDataSet of these, which is taken as one mesh without ghosts (vtkMeshPartition). So
 * the partitions of vtkKdTreePartition make the store of the whole mesh. Polygons and strips become
 * triangles. If there are neither, all points are a cloud; else vertices and lines are left out.
 * Every array of numbers that all parts have is written; a warning lists the other arrays.
 *
 * Several processes (Controller) can write one store together, as kdstream-build-mpi does. All of
 * them call Write, each with its part of the mesh; none holds the whole mesh. The store is that of
 * the parts in the order of the processes. Process 0 writes; its FileName and members count.
 * - Memory: about 250 bytes for each point of a process's part while the processes agree on one
 *   mesh. After that, the processes on a machine may use three quarters of its free memory; each
 *   takes at most its share of this, but at least 64 MiB.
 * - Disk: files of three to four times the part, beside the store. If a process other than 0 cannot
 *   write there, its files go to the system's folder for temporary files.
 * - Sources that give pieces, such as vtkKdStoreReader, are asked for the process's own piece.
 *   Other sources give the data that this process has; process 0 warns if all processes have the
 *   same mesh. A process that has no part of the mesh sets an empty vtkPolyData.
 * - An error of one process is an error of all processes; the message names the process. Examples:
 *   no input or one of another type, an error of its input, no memory left.
 *
 * So the output of vtkKdTreePartition on several processes makes the same store as on one process,
 * byte for byte.
 *
 * The store appears whole or not at all. It depends only on the input and the members, not on the
 * backend and the threads of vtkSMPTools. Aborting leaves no file. Errors: an input that could not
 * be made; no points; a coordinate that is not finite; an error of the file system; arrays with
 * names that no store can hold; on several processes, less memory than a partition needs.
 * GetErrorCode is then OutOfDiskSpaceError (the disk, a quota, the maximum file size),
 * CannotOpenFileError, NoFileNameError, or UnknownError.
 *
 * In the setters below, numbers out of range are clamped. It is an error to set a negative number
 * where none is allowed, NaN, or a vector that is not finite; the old value then stays.
 *
 * Complexity: O(n log n + t log t) for n points and t triangles; about 190 bytes a point on one
 * process.
 *
 * Source: sections 4.1 to 4.3 of the paper named in the README; levels by edge collapse are ours.
 *
 * @sa vtkKdMeshReader vtkKdTreePartition vtkKdStoreReader
 */
#ifndef vtkKdStoreWriter_h
#define vtkKdStoreWriter_h

#include "vtkKdStreamFiltersIOModule.h" // for the export macro
#include "vtkWriter.h"

#include <string> // for the texts

class vtkMultiProcessController;

class VTKKDSTREAMFILTERSIO_EXPORT vtkKdStoreWriter : public vtkWriter
{
public:
  static vtkKdStoreWriter* New();
  vtkTypeMacro(vtkKdStoreWriter, vtkWriter);
  void PrintSelf(ostream& os, vtkIndent indent) override;

  ///@{
  /**
   * The store to write, NAME.kds.
   */
  vtkSetFilePathMacro(FileName);
  vtkGetFilePathMacro(FileName);
  ///@}

  ///@{
  /**
   * Bits of each coordinate on the grid of the levels and the original, 8 to 24. 0: coordinates
   * stay as they are, to the bit. Default 20.
   */
  virtual void SetGridBits(int bits);
  vtkGetMacro(GridBits, int);
  ///@}

  ///@{
  /**
   * The maximum number of points in a partition, at least 1. Default 2000.
   */
  virtual void SetVerticesPerPartition(vtkIdType value);
  vtkGetMacro(VerticesPerPartition, vtkIdType);
  ///@}

  ///@{
  /**
   * The number of partitions, a power of two. 0, the default: VerticesPerPartition decides.
   */
  virtual void SetNumberOfPartitions(vtkIdType value);
  vtkGetMacro(NumberOfPartitions, vtkIdType);
  ///@}

  ///@{
  /**
   * The maximum number of points in a cell of the finest level, 1 to 1024. Default 8.
   */
  virtual void SetCellVertices(int value);
  vtkGetMacro(CellVertices, int);
  ///@}

  enum MakerType // as vtkKdClusterSimplification's
  {
    Collapse = 0, ///< levels by edge collapse
    Cluster = 1   ///< by the cells of the tree
  };
  ///@{
  /**
   * How the levels are made. Default Collapse.
   */
  vtkSetClampMacro(Maker, int, Collapse, Cluster);
  vtkGetMacro(Maker, int);
  const char* GetMakerAsString() const;
  void SetMakerToCollapse() { this->SetMaker(Collapse); }
  void SetMakerToCluster() { this->SetMaker(Cluster); }
  ///@}

  ///@{
  /**
   * Whether points in the same place with equal arrays become one first. Default on.
   */
  vtkSetMacro(Weld, bool);
  vtkGetMacro(Weld, bool);
  vtkBooleanMacro(Weld, bool);
  ///@}

  ///@{
  /**
   * Whether points in the same place become one, if they are in different parts of a composite
   * input. Used only if the input has no global ids. Points of one part are never joined. Default
   * off: Weld joins such points too, except if their arrays differ.
   */
  vtkSetMacro(WeldByPlace, bool);
  vtkGetMacro(WeldByPlace, bool);
  vtkBooleanMacro(WeldByPlace, bool);
  ///@}

  ///@{
  /**
   * Texts about the model that viewers show, in UTF-8. Default none.
   */
  vtkSetMacro(Title, std::string);
  vtkGetMacro(Title, std::string);
  vtkSetMacro(Credit, std::string);
  vtkGetMacro(Credit, std::string);
  vtkSetMacro(License, std::string);
  vtkGetMacro(License, std::string);
  vtkSetMacro(Unit, std::string);
  vtkGetMacro(Unit, std::string);
  ///@}

  ///@{
  /**
   * The up direction, and the direction from the model to the eye at the first view. (0, 0, 0), the
   * default: guessed from the shape.
   */
  virtual void SetUp(double x, double y, double z);
  virtual void SetUp(const double value[3]);
  vtkGetVector3Macro(Up, double);
  virtual void SetView(double x, double y, double z);
  virtual void SetView(const double value[3]);
  vtkGetVector3Macro(View, double);
  ///@}

  ///@{
  /**
   * The processes that have the parts of the mesh. Default: vtkMultiProcessController's global
   * controller. Null or a single process: this process has the whole mesh.
   */
  virtual void SetController(vtkMultiProcessController* controller);
  vtkGetObjectMacro(Controller, vtkMultiProcessController);
  ///@}

  int Write() override;

protected:
  vtkKdStoreWriter();
  ~vtkKdStoreWriter() override;

  vtkExecutive* CreateDefaultExecutive() override;
  int FillInputPortInformation(int port, vtkInformation* info) override;
  void WriteData() override;

private:
  vtkKdStoreWriter(const vtkKdStoreWriter&) = delete;
  void operator=(const vtkKdStoreWriter&) = delete;

  vtkMultiProcessController* Controller = nullptr;
  char* FileName = nullptr;
  int GridBits = 20;
  vtkIdType VerticesPerPartition = 2000;
  vtkIdType NumberOfPartitions = 0;
  int CellVertices = 8;
  int Maker = Collapse;
  bool Weld = true;
  bool WeldByPlace = false;
  bool HasBegun = false; // WriteData was called since the last Write
  std::string Title, Credit, License, Unit;
  double Up[3] = { 0, 0, 0 }, View[3] = { 0, 0, 0 };
};

#endif
