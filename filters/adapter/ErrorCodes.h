// SPDX-License-Identifier: BSD-3-Clause
// Converts core's errors to the codes of VTK's readers.
#pragma once

#include "filters/core/Result.h"

#include <vtkErrorCode.h>

namespace kdstream
{

// For vtkAlgorithm::GetErrorCode: a vtkErrorCode::ErrorIds, never NoError.
inline unsigned long VtkErrorCodeOf(const Error& error)
{
  switch (error.code)
  {
    case ErrorCode::NotFound:
      return vtkErrorCode::FileNotFoundError;
    case ErrorCode::Unsupported:
      return vtkErrorCode::UnrecognizedFileTypeError;
    case ErrorCode::InputOutput:
      return vtkErrorCode::CannotOpenFileError;
    case ErrorCode::DiskFull:
      return vtkErrorCode::OutOfDiskSpaceError;
    case ErrorCode::InvalidArgument:
      return vtkErrorCode::UnknownError; // the file is not at fault
    default:
      return vtkErrorCode::FileFormatError;
  }
}

}
