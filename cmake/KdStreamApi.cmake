# SPDX-License-Identifier: BSD-3-Clause
# The API: the headers that users of an installed KdStream may include, besides those of the VTK modules' classes.
# doc/api.md has a line for each (TestApi). These headers are installed, and so are the headers that they include, which
# may change with any version.
set(KDSTREAM_API_HEADERS
  filters/core/Attribute.h
  filters/core/Execution.h
  filters/core/Result.h
  filters/core/Types.h
  filters/core/drawing/Cut.h
  filters/core/drawing/DrawnSurface.h
  filters/core/drawing/Surface.h
  filters/core/pieces/Piece.h
  filters/core/tree/KdTree.h
  filters/core/tree/PieceDepth.h
  filters/core/tree/Region.h
  filters/codec/CoordinateGrid.h
  filters/codec/PieceCodec.h
  filters/codec/TextureTile.h
  filters/codec/TreePage.h
  filters/model/ModelDescription.h
  filters/store/PieceSource.h
  filters/store/Store.h
  filters/protocol/BlobId.h
  viewer/client/ClientEvent.h
  viewer/client/ConnectServer.h
  viewer/client/DiskCache.h
  viewer/client/LocalClient.h
  viewer/client/ModelSource.h
  viewer/offscreen/OffscreenWindow.h
  viewer/offscreen/ScreenWindow.h
  viewer/session/Camera.h
  viewer/session/GestureRecognizer.h
  viewer/session/SessionOptions.h
  viewer/session/SessionTypes.h
  viewer/session/ViewerSession.h
  viewer/session/appearance/SceneAppearance.h)

# The headers to install: the API, and those of our headers that it includes.
function(kdstream_find_installed_headers result)
  set(installed "")
  set(waiting ${KDSTREAM_API_HEADERS})
  while(waiting)
    list(POP_FRONT waiting header)
    if(header IN_LIST installed)
      continue()
    endif()
    list(APPEND installed "${header}")
    file(STRINGS "${PROJECT_SOURCE_DIR}/${header}" includes REGEX "^#[ ]*include \"")
    list(TRANSFORM includes REPLACE ".*\"([^\"]+)\".*" "\\1")
    list(APPEND waiting ${includes})
  endwhile()
  set(${result} "${installed}" PARENT_SCOPE)
endfunction()
kdstream_find_installed_headers(KDSTREAM_INSTALLED_HEADERS)
