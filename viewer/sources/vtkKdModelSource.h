// SPDX-License-Identifier: BSD-3-Clause
/**
 * @class   vtkKdModelSource
 * @brief   gives VTK a model's level, partitions, region, view of a camera, or all of the original
 *
 * This is what vtkKdStoreReader (a file) and vtkKdStreamSource (a server) have in common.
 *
 * The output is a vtkPartitionedDataSet, or one vtkPolyData (OutputType). Points are floats or
 * doubles, like those of the mesh that the store was built of; a cloud has a vertex cell for each
 * point. Normals, colours ("RGB", "RGBA") and texture coordinates are the active ones of their
 * kind; levels have only normals and colours.
 *
 * As vtkPartitionedDataSet: partition i is the model's partition i (for a level, its piece i, from
 * left to right in the tree); partitions that are not loaded are null. A partition has its own
 * points first, then the points of other partitions that its cells need, and each cell that touches
 * an own point. vtkGhostType marks repetitions as in vtkKdTreePartition: DUPLICATEPOINT the points
 * of another partition, DUPLICATECELL the cells that a loaded partition with a lower number has,
 * too. In a lossless store (GridBits 0) the partitions of the original are those of
 * vtkKdTreePartition with the same VerticesPerPartition, to the bit; points and cells are in the
 * store's order. This holds for welded points too.
 *
 * As vtkPolyData: partitions are glued together, each point and cell once. A level is drawn as in
 * viewers. What a camera needs (Content View) is one surface of mixed resolutions; as
 * vtkPartitionedDataSet it is the only partition.
 *
 * Pieces of a pipeline (UPDATE_PIECE_NUMBER of UPDATE_NUMBER_OF_PIECES): each gets its part of the
 * tree (a subtree if their number is a power of two), so each cell is in exactly one piece. With
 * ghost levels, a piece also gets the cells around it, marked. For the original these are the cells
 * of this number of rings of partitions (Rings); for a level, the cells that touch its points.
 * LOAD_REQUESTED_BLOCKS with UPDATE_COMPOSITE_INDICES loads only the partitions of these flat
 * indices (partition i has i + 1).
 *
 * The output information has, before anything is loaded:
 * - the model's box (vtkStreamingDemandDrivenPipeline::BOUNDS and vtkDataObject::BOUNDING_BOX);
 * - NUMBER_OF_POINTS and NUMBER_OF_CELLS, without ghosts, if Content is the whole original or a
 *   level; not for parts;
 * - for each array that is loaded an entry in vtkDataObject::POINT_DATA_VECTOR or CELL_DATA_VECTOR:
 *   FIELD_NAME, FIELD_ARRAY_TYPE, FIELD_NUMBER_OF_COMPONENTS; FIELD_NUMBER_OF_TUPLES if the counts
 *   above are known; and FIELD_RANGE of the original's values if the model knows it (for numbers of
 *   points);
 * - for partitions of the original, in COMPOSITE_DATA_META_DATA the BOUNDING_BOX of each
 *   partition's own points (from a server only if vtkKdStreamSource::BoundsOfPartitions is on).
 *
 * No piece is read for this, except if vtkKdStoreReader::MeasureOriginal is on: then the original
 * is decoded to give more information. The output's metadata have the BOUNDING_BOX of what was
 * loaded, with ghosts.
 *
 * Progress is also reported while the source waits. Aborting (SetAbortExecute of an observer or of
 * another thread) ends an Update within 100 ms, whatever the source waits for, and leaves an empty
 * output; the next Update loads again. Only the steps before the first and after the last piece of
 * a mesh, a level or a view are not interrupted: less than 0.1 s for each million triangles.
 *
 * Errors name the file or server, and what is wrong with the model. GetErrorCode is set
 * (vtkErrorCode.h; NoFileNameError without an address). After an error the next Update opens the
 * model again.
 *
 * Numbers out of the ranges below are clamped. A negative number where none is allowed, NaN, or a
 * vector that is not finite is an error, and the old value stays.
 *
 * Complexity: linear in the loaded data; a region also reads the boxes of all partitions, 48 bytes
 * each.
 *
 * Source: sections 4 and 5 of the paper named in the README.
 */
#ifndef vtkKdModelSource_h
#define vtkKdModelSource_h

#include "vtkDataObjectAlgorithm.h"
#include "vtkKdStreamViewerSourcesModule.h" // for the export macro
#include "vtkNew.h"                         // for the selections

#include <atomic> // for aborts
#include <memory> // for the open model
#include <string> // for names
#include <vector> // for partitions

class vtkDataArraySelection;
class vtkInformationIdTypeKey;

namespace kdstream
{
class PieceSource;
struct Error;
struct Execution;
struct OriginalFacts;
struct ViewDemand;
}

class VTKKDSTREAMVIEWERSOURCES_EXPORT vtkKdModelSource : public vtkDataObjectAlgorithm
{
public:
  vtkTypeMacro(vtkKdModelSource, vtkDataObjectAlgorithm);
  void PrintSelf(ostream& os, vtkIndent indent) override;

  enum OutputTypes
  {
    PartitionedDataSet,
    PolyData
  };
  ///@{
  /**
   * The type of the output. Default PartitionedDataSet.
   */
  vtkSetClampMacro(OutputType, int, PartitionedDataSet, PolyData);
  vtkGetMacro(OutputType, int);
  const char* GetOutputTypeAsString() const;
  void SetOutputTypeToPartitionedDataSet() { this->SetOutputType(PartitionedDataSet); }
  void SetOutputTypeToPolyData() { this->SetOutputType(PolyData); }
  ///@}

  enum Contents
  {
    Original,   ///< all of it; of a mesh, only points that cells use
    Level,      ///< the level that LevelDepth chooses
    Partitions, ///< partitions of the original, chosen by AddPartition
    Region,     ///< the partitions of the original around RegionPoint
    View        ///< what the camera needs: fine where it looks, at most NumberOfTriangles
  };
  ///@{
  /**
   * Which part of the model is loaded. Default Original.
   */
  vtkSetClampMacro(Content, int, Original, View);
  vtkGetMacro(Content, int);
  const char* GetContentAsString() const;
  void SetContentToOriginal() { this->SetContent(Original); }
  void SetContentToLevel() { this->SetContent(Level); }
  void SetContentToPartitions() { this->SetContent(Partitions); }
  void SetContentToRegion() { this->SetContent(Region); }
  void SetContentToView() { this->SetContent(View); }
  ///@}

  ///@{
  /**
   * The depth of the level, 0 to GetFinestLevel(). Each level is twice as fine as the one before.
   * -1, the default, stands for the preview, of about 4,000 triangles.
   */
  virtual void SetLevelDepth(int value);
  vtkGetMacro(LevelDepth, int);
  ///@}

  ///@{
  /**
   * The partitions that Content Partitions loads.
   */
  void AddPartition(vtkIdType partition);
  void RemoveAllPartitions();
  ///@}

  ///@{
  /**
   * The centre of Content Region, in model units, and the number of rings of cells around the
   * partition nearest to it, 0 to 16. Default (0, 0, 0), and 1.
   */
  virtual void SetRegionPoint(double x, double y, double z);
  virtual void SetRegionPoint(const double value[3]);
  vtkGetVector3Macro(RegionPoint, double);
  virtual void SetRings(int value);
  vtkGetMacro(Rings, int);
  ///@}

  ///@{
  /**
   * The camera of Content View, with the values of a vtkCamera: position, focal point and up in the
   * model's coordinates, the vertical angle in degrees, above 0 and below 180. Default: from the
   * point (0, 0, 1) to the origin, y up, 30.
   */
  virtual void SetCameraPosition(double x, double y, double z);
  virtual void SetCameraPosition(const double value[3]);
  vtkGetVector3Macro(CameraPosition, double);
  virtual void SetCameraFocalPoint(double x, double y, double z);
  virtual void SetCameraFocalPoint(const double value[3]);
  vtkGetVector3Macro(CameraFocalPoint, double);
  virtual void SetCameraViewUp(double x, double y, double z);
  virtual void SetCameraViewUp(const double value[3]);
  vtkGetVector3Macro(CameraViewUp, double);
  virtual void SetCameraViewAngle(double degrees);
  vtkGetMacro(CameraViewAngle, double);
  ///@}

  ///@{
  /**
   * The size of the camera's picture in pixels, each at least 1: larger pictures need finer pieces.
   * Default 800 x 600. Tolerance: the accepted screen-space error in pixels, 0.01 to 100; default
   * 1.
   */
  virtual void SetPictureSize(int width, int height);
  void SetPictureSize(const int size[2]) { this->SetPictureSize(size[0], size[1]); }
  vtkGetVector2Macro(PictureSize, int);
  virtual void SetTolerance(double value);
  vtkGetMacro(Tolerance, double);
  ///@}

  ///@{
  /**
   * The approximate maximum number of triangles for Content View, at least 1000. The preview, which
   * is always loaded, has up to about 5000. Default 2000000.
   */
  virtual void SetNumberOfTriangles(vtkIdType value);
  vtkGetMacro(NumberOfTriangles, vtkIdType);
  ///@}

  /**
   * Which arrays of points and of cells are loaded. There is one entry for each array of the model,
   * after UpdateInformation. Default: all. When another model is opened, its arrays replace those
   * of the old one; an array of the same name keeps its setting.
   */
  vtkDataArraySelection* GetPointDataArraySelection() { return this->PointArrays; }
  vtkDataArraySelection* GetCellDataArraySelection() { return this->CellArrays; }

  ///@{
  /**
   * The depths of the model's finest level and preview, known after UpdateInformation; -1 and 0
   * before. A store made by another partitioner than the k-d tree has no levels: -1.
   */
  int GetFinestLevel() const;
  int GetPreviewLevel() const;
  vtkIdType GetNumberOfModelPartitions() const;
  vtkIdType GetNumberOfModelPoints() const;
  vtkIdType GetNumberOfModelTriangles() const;
  ///@}

  /**
   * The range of LevelDepth, for a slider: from -1 to the finest level, or to 62 before that is
   * known.
   */
  vtkGetVector2Macro(LevelRange, int);

  ///@{
  /**
   * Keys of the counts that the output information has before anything is loaded, for the output
   * and for each partition.
   */
  static vtkInformationIdTypeKey* NUMBER_OF_POINTS();
  static vtkInformationIdTypeKey* NUMBER_OF_CELLS();
  ///@}

  vtkMTimeType GetMTime() override;

  // Overridden because an abort counts from the beginning of an Update: VTK would forget an abort
  // before RequestData.
  void SetAbortExecute(vtkTypeBool abort) override;
  int ComputePipelineMTime(vtkInformation* request, vtkInformationVector** input,
    vtkInformationVector* output, int port, vtkMTimeType* time) override;

protected:
  vtkKdModelSource();
  ~vtkKdModelSource() override;

  /**
   * Opens the model, or returns the open model if it is still up to date. If null, `error` says
   * why.
   */
  virtual std::shared_ptr<const kdstream::PieceSource> OpenModel(
    const kdstream::Execution& execution, kdstream::Error& error) = 0;
  /**
   * The open model must not be used any more.
   */
  virtual void CloseModel() {}
  /**
   * The name for errors: the file or the server.
   */
  virtual std::string ModelName() const = 0;
  /**
   * Whether the boxes of all partitions are read and reported.
   */
  virtual bool WantsBoxes() const = 0;
  /**
   * Whether all of the original is read for its description.
   */
  virtual bool WantsFacts() const { return false; }

  int RequestDataObject(vtkInformation* request, vtkInformationVector** inputVector,
    vtkInformationVector* outputVector) override;
  int RequestInformation(vtkInformation* request, vtkInformationVector** inputVector,
    vtkInformationVector* outputVector) override;
  int RequestData(vtkInformation* request, vtkInformationVector** inputVector,
    vtkInformationVector* outputVector) override;
  int FillOutputPortInformation(int port, vtkInformation* info) override;

private:
  vtkKdModelSource(const vtkKdModelSource&) = delete;
  void operator=(const vtkKdModelSource&) = delete;

  friend class vtkKdTextureReader; // which uses the open model

  int Fail(const kdstream::Error& error);
  void OpenAnewNextTime();
  kdstream::ViewDemand Demand() const;
  void TellModel(vtkInformation* outInfo) const;
  bool TellPartitions(vtkInformation* outInfo, const kdstream::Execution& execution);
  bool MeasureModel(const kdstream::Execution& execution);
  const kdstream::OriginalFacts* KnownFacts() const;
  int StopOpening();

  int OutputType = PartitionedDataSet;
  int Content = Original;
  int LevelDepth = -1;
  int LevelRange[2] = { -1, 62 };
  std::vector<vtkIdType> ChosenPartitions;
  double RegionPoint[3] = { 0, 0, 0 };
  int Rings = 1;
  double CameraPosition[3] = { 0, 0, 1 };
  double CameraFocalPoint[3] = { 0, 0, 0 };
  double CameraViewUp[3] = { 0, 1, 0 };
  double CameraViewAngle = 30;
  int PictureSize[2] = { 800, 600 };
  double Tolerance = 1;
  vtkIdType NumberOfTriangles = 2000000;
  vtkNew<vtkDataArraySelection> PointArrays;
  vtkNew<vtkDataArraySelection> CellArrays;
  std::shared_ptr<const kdstream::PieceSource> Model; // since the last RequestInformation
  std::shared_ptr<const kdstream::OriginalFacts> Facts;
  std::string MeasuredDigest;            // digest of the measured model
  bool WasStopped = false;               // while the model was opened
  std::atomic<bool> WasAborted{ false }; // since the Update began, by any thread
  bool IsStale = false;                  // stopped or failed: the next Update must load again
};

#endif
