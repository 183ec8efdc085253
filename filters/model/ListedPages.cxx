// SPDX-License-Identifier: BSD-3-Clause
#include "filters/model/ListedPages.h"

#include "filters/model/JsonWriter.h"

namespace kdstream
{

std::string WithPages(std::string list, std::string_view folder)
{
  if (!folder.empty())
  {
    list.insert(1, "\"pages\":" + JsonWriter().Put(folder).Text() + ","); // after the first {
  }
  return list;
}

}
