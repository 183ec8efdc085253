// SPDX-License-Identifier: BSD-3-Clause
/**
 * @class   vtkKdStoreReader
 * @brief   reads a store: a file made by kdstream-build, as for KdStream's servers and viewers
 *
 * Reads any part of the model, at any resolution, without reading the rest: see vtkKdModelSource.
 * The file is opened again whenever the pipeline asks for information. An open file stays in use
 * even if another file replaces it under its name.
 *
 * @sa vtkKdStreamSource vtkKdStoreWriter
 */
#ifndef vtkKdStoreReader_h
#define vtkKdStoreReader_h

#include "vtkKdModelSource.h"

class VTKKDSTREAMVIEWERSOURCES_EXPORT vtkKdStoreReader : public vtkKdModelSource
{
public:
  static vtkKdStoreReader* New();
  vtkTypeMacro(vtkKdStoreReader, vtkKdModelSource);
  void PrintSelf(ostream& os, vtkIndent indent) override;

  ///@{
  /**
   * The store.
   */
  vtkSetFilePathMacro(FileName);
  vtkGetFilePathMacro(FileName);
  ///@}

  ///@{
  /**
   * Whether all of the original is decoded, once, to give more output information if Content is
   * neither Level nor View: for each partition BOUNDING_BOX, NUMBER_OF_POINTS and NUMBER_OF_CELLS,
   * including ghosts, and FIELD_RANGE for every array with one component. Default off: the
   * information is that of the store's metadata, and loading a part reads only that part.
   */
  vtkSetMacro(MeasureOriginal, bool);
  vtkGetMacro(MeasureOriginal, bool);
  vtkBooleanMacro(MeasureOriginal, bool);
  ///@}

  /**
   * Whether the file is a store that can be opened. Changes nothing and reports nothing.
   */
  virtual int CanReadFile(VTK_FILEPATH const char* name);

protected:
  vtkKdStoreReader() = default;
  ~vtkKdStoreReader() override;

  std::shared_ptr<const kdstream::PieceSource> OpenModel(
    const kdstream::Execution& execution, kdstream::Error& error) override;
  std::string ModelName() const override { return this->FileName ? this->FileName : ""; }
  bool WantsBoxes() const override { return true; }
  bool WantsFacts() const override { return this->MeasureOriginal; }

private:
  vtkKdStoreReader(const vtkKdStoreReader&) = delete;
  void operator=(const vtkKdStoreReader&) = delete;

  char* FileName = nullptr;
  bool MeasureOriginal = false;
};

#endif
