// SPDX-License-Identifier: BSD-3-Clause
/**
 * @class   vtkKdStoreReader
 * @brief   reads a store: the file of kdstream-build, which KdStream's servers and viewers take
 *
 * Any part of it, at any resolution, without reading the rest: see vtkKdModelSource. The file is
 * opened anew whenever the pipeline asks for information. An open file is used even if another
 * takes its name.
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
   * Whether all of the original is decoded, once, for more output information if Content is neither
   * Level nor View: for each partition BOUNDING_BOX, NUMBER_OF_POINTS and NUMBER_OF_CELLS with its
   * ghosts, and FIELD_RANGE of every array of one component. Default off: the information is that
   * of the store's metadata, and loading a part reads only that part.
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
