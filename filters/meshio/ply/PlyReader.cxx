// SPDX-License-Identifier: BSD-3-Clause
// Reads PLY files in chunks: step "read" of the pipeline picture. This class decides which element
// is read when; PlyBody reads the records.
#include "filters/meshio/ply/PlyReader.h"

#include "filters/meshio/DroppedPoints.h"
#include "filters/meshio/MakeRoom.h"

#include <algorithm>
#include <limits>
#include <set>
#include <string_view>
#include <utility>

namespace kdstream
{

namespace
{

constexpr std::uint64_t mostPlyVertices = noVertex - 1;
// How many bytes the repeated attributes of faces may take for each byte of the file.
constexpr std::uint64_t mostRepeated = 16;

}

Result<std::unique_ptr<MeshReader>> PlyReader::Open(
  ByteSource source, const std::filesystem::path& scratch)
{
  Result<PlyHeader> header = ReadPlyHeader(source);
  KDSTREAM_TRY(header);
  return OpenAs(std::move(source), std::move(*header), scratch);
}

Result<std::unique_ptr<MeshReader>> PlyReader::OpenAs(ByteSource source, PlyHeader header,
  const std::filesystem::path& scratch, const Tolerance& reported)
{
  std::unique_ptr<PlyReader> reader(new PlyReader(std::move(source), std::move(header), scratch));
  reader->FileInfo.tolerance = reported;
  KDSTREAM_TRY(reader->UnderstandHeader());
  KDSTREAM_TRY(reader->CheckOrder());
  return std::unique_ptr<MeshReader>(std::move(reader));
}

PlyReader::PlyReader(ByteSource source, PlyHeader header, std::filesystem::path scratch)
  : Source(std::move(source))
  , Header(std::move(header))
  , Body(PlyBody::Make(this->Header, this->Source))
  , ElementBegins{ this->Source.Position() }
  , Scratch(std::move(scratch))
{
}

Status PlyReader::UnderstandHeader()
{
  const std::vector<PlyElement>& elements = this->Header.elements;
  const auto vertices = std::find_if(elements.begin(), elements.end(),
    [](const PlyElement& element) { return element.name == "vertex"; });
  if (vertices == elements.end())
  {
    return Error{ ErrorCode::InvalidInput, "the header names no element 'vertex'" };
  }
  this->VertexElement = static_cast<std::size_t>(vertices - elements.begin());
  KDSTREAM_TRY(this->UnderstandVertices());
  for (std::size_t i = 0; i < elements.size(); ++i)
  {
    const bool polygons = elements[i].name == "face";
    if ((!polygons && elements[i].name != "tristrips") || elements[i].count == 0)
    {
      continue;
    }
    const auto kind = polygons ? PlyFaceSink::Kind::Polygon : PlyFaceSink::Kind::Strip;
    KDSTREAM_TRY(this->UnderstandFaces(i, kind));
  }
  this->FindAttributes();
  this->ListIgnoredAttributes();
  this->FileInfo.mostTriangles = this->MostTriangles();
  return {};
}

Status PlyReader::UnderstandVertices()
{
  const PlyElement& element = this->Header.elements[this->VertexElement];
  if (element.count > mostPlyVertices)
  {
    return Error{ ErrorCode::LimitExceeded, "the header claims " + std::to_string(element.count) +
                                              " vertices; " + std::to_string(mostPlyVertices) +
                                              " are the most that can be read" };
  }
  this->FileInfo.vertices = element.count;
  this->FileInfo.scalarType = ScalarType::Float32;
  const std::array<const char*, 3> names{ "x", "y", "z" };
  for (std::size_t k = 0; k < 3; ++k)
  {
    const std::size_t found =
      std::min(element.Find(names[k]), element.Find(std::string(1, "XYZ"[k])));
    if (found == element.properties.size())
    {
      const bool packed = element.Find("packed_position") < element.properties.size();
      return BadInput(
        std::string("element 'vertex' has no property '") + names[k] + "'" +
          (packed ? ", but 'packed_position': compressed Gaussian splats are not read, export them "
                    "uncompressed"
                  : ""),
        packed ? Remedy::InMessage : Remedy::Repair);
    }
    const PlyProperty& property = element.properties[found];
    if (property.isList)
    {
      return Error{ ErrorCode::InvalidInput,
        std::string("property '") + names[k] + "' of element 'vertex' is a list, not a number" };
    }
    if (property.type != AttributeType::Float32 && SizeOf(property.type) > 2)
    {
      this->FileInfo.scalarType = ScalarType::Float64;
    }
    this->Coordinates[k] = found;
  }
  return {};
}

Status PlyReader::UnderstandFaces(std::size_t element, PlyFaceSink::Kind kind)
{
  const PlyElement& faces = this->Header.elements[element];
  const std::size_t none = faces.properties.size();
  const std::size_t list = faces.FindCorners();
  if (list == none)
  {
    return Error{ ErrorCode::InvalidInput,
      "element '" + faces.name + "' has no list 'vertex_indices' or 'vertex_index'" };
  }
  if (faces.Find("vertex_indices") != none && faces.Find("vertex_index") != none)
  {
    return Error{ ErrorCode::InvalidInput,
      "element '" + faces.name + "' has both 'vertex_indices' and 'vertex_index'" };
  }
  const PlyProperty& property = faces.properties[list];
  if (!property.isList)
  {
    return Error{ ErrorCode::InvalidInput,
      "property '" + property.name + "' of element '" + faces.name + "' is not a list" };
  }
  if (!IsNameOfCorners(property.name))
  {
    this->FileInfo.tolerance.Tell("element '" + faces.name + "': its only list of integers, '" +
                                  property.name + "', is taken for the corners");
  }
  this->Faces.push_back({ element, list, kind });
  this->FileInfo.strips |= kind == PlyFaceSink::Kind::Strip;
  const std::uint64_t room = std::numeric_limits<std::uint64_t>::max() - this->FileInfo.faces;
  this->FileInfo.faces += std::min(room, faces.count);
  return {};
}

// A bound from the bytes that remain if all other values take the fewest bytes possible: each
// number that fits into them could be a corner, and each corner could make a triangle.
std::uint64_t PlyReader::MostTriangles() const
{
  if (this->Faces.empty())
  {
    return 0;
  }
  const bool isText = this->Header.encoding == PlyEncoding::Ascii;
  const auto bytesOf = [&](AttributeType type) // in a text, at least a digit and a blank
  { return isText ? std::size_t{ 2 } : SizeOf(type); };
  std::uint64_t rest = this->Source.Size() - this->Source.Position() + (isText ? 1 : 0);
  std::uint64_t ofCorner = sizeof(double);
  for (std::size_t i = 0; i < this->Header.elements.size(); ++i)
  {
    const PlyElement& element = this->Header.elements[i];
    const auto faces = std::find_if(this->Faces.begin(), this->Faces.end(),
      [i](const FaceElement& candidate) { return candidate.element == i; });
    if (faces != this->Faces.end())
    {
      const std::uint64_t begin = this->Source.Size() - std::min(this->Source.Size(), rest);
      if (this->Faces.size() == 1 && this->BytesOfTriangles(*faces, begin, element.count) > 0)
      {
        return element.count;
      }
      ofCorner = std::min<std::uint64_t>(ofCorner, bytesOf(element.properties[faces->list].type));
    }
    std::uint64_t least = 0;
    for (const PlyProperty& property : element.properties)
    {
      least += bytesOf(property.isList ? property.countType : property.type);
    }
    // If an element's claim does not fit into the file, it is ignored.
    rest -= least > 0 && element.count <= rest / least ? least * element.count : 0;
  }
  return rest / ofCorner;
}

// Lists point arrays, then cell arrays, and marks all properties that are used.
void PlyReader::FindAttributes()
{
  for (const PlyElement& element : this->Header.elements)
  {
    this->Read.emplace_back(element.properties.size(), false);
  }
  const PlyElement& vertices = this->Header.elements[this->VertexElement];
  const std::vector<PlyArray> arrays =
    FindPlyArrays(vertices, AttributeAssociation::Point, this->Coordinates, mostAttributes);
  this->VertexArrays = PlyArraySink(vertices, arrays);
  this->PointArrays = arrays.size();
  std::vector<bool>& read = this->Read[this->VertexElement];
  for (const std::size_t p : this->Coordinates)
  {
    read[p] = true;
  }
  for (const PlyArray& array : arrays)
  {
    this->FileInfo.attributes.push_back(array.info);
    for (const std::size_t p : array.properties)
    {
      read[p] = true;
    }
  }
  this->FindFaceAttributes();
}

// Takes the arrays that every element with faces has, in the order of the first element. Others are
// left out, because their missing values could not be distinguished from real ones.
void PlyReader::FindFaceAttributes()
{
  std::vector<std::vector<PlyArray>> ofElement;
  for (const FaceElement& faces : this->Faces)
  {
    this->Read[faces.element][faces.list] = true;
    ofElement.push_back(FindPlyArrays(this->Header.elements[faces.element],
      AttributeAssociation::Cell, std::array{ faces.list }, mostAttributes - this->PointArrays));
  }
  std::vector<AttributeInfo> common;
  for (std::size_t k = 0; !ofElement.empty() && k < ofElement[0].size(); ++k)
  {
    const AttributeInfo& info = ofElement[0][k].info;
    const bool everywhere = std::all_of(ofElement.begin(), ofElement.end(),
      [&](const std::vector<PlyArray>& arrays)
      {
        return std::any_of(
          arrays.begin(), arrays.end(), [&](const PlyArray& array) { return array.info == info; });
      });
    if (everywhere)
    {
      common.push_back(info);
    }
  }
  for (std::size_t i = 0; i < this->Faces.size(); ++i)
  {
    FaceElement& faces = this->Faces[i];
    std::vector<PlyArray> arrays;
    for (const AttributeInfo& info : common)
    {
      arrays.push_back(*std::find_if(ofElement[i].begin(), ofElement[i].end(),
        [&](const PlyArray& array) { return array.info == info; }));
      for (const std::size_t p : arrays.back().properties)
      {
        this->Read[faces.element][p] = true;
      }
    }
    faces.arrays = PlyArraySink(this->Header.elements[faces.element], arrays);
  }
  this->FileInfo.attributes.insert(this->FileInfo.attributes.end(), common.begin(), common.end());
}

void PlyReader::ListIgnoredAttributes()
{
  std::vector<std::string>& ignored = this->FileInfo.ignoredAttributes;
  if (!this->Header.strayLine.empty())
  {
    ignored.push_back("an unknown line of the header: " + this->Header.strayLine);
  }
  for (std::size_t i = 0; i < this->Header.elements.size(); ++i)
  {
    const PlyElement& element = this->Header.elements[i];
    const bool known =
      i == this->VertexElement || std::any_of(this->Faces.begin(), this->Faces.end(),
                                    [i](const FaceElement& faces) { return faces.element == i; });
    if (element.count == 0)
    {
      continue;
    }
    if (!known)
    {
      ignored.push_back(element.name);
      continue;
    }
    std::set<std::string_view> names;
    for (std::size_t p = 0; p < element.properties.size(); ++p)
    {
      const std::string& name = element.properties[p].name;
      const bool isFirst = names.insert(name).second;
      if (!this->Read[i][p])
      {
        ignored.push_back(
          element.name + "." + name + (isFirst ? "" : ", which is named twice: the first counts"));
      }
    }
  }
  for (const std::string& texture : this->Header.textures)
  {
    ignored.push_back("texture " + texture);
  }
}

// Moves the source to a record of an element: forward from the current record, or, if the source is
// already past the wanted record, from the beginning of the element.
Status PlyReader::MoveTo(std::size_t element, std::uint64_t record)
{
  if (element < this->CurrentElement ||
      (element == this->CurrentElement && record < this->CurrentRecord))
  {
    this->Source.Seek(this->ElementBegins[element]);
    this->CurrentElement = element;
    this->CurrentRecord = 0;
  }
  while (this->CurrentElement < element)
  {
    if (this->CurrentElement + 1 < this->ElementBegins.size())
    {
      this->Source.Seek(this->ElementBegins[this->CurrentElement + 1]);
    }
    else
    {
      KDSTREAM_TRY(this->SkipToRecord(this->Header.elements[this->CurrentElement].count));
      this->ElementBegins.push_back(this->Source.Position());
    }
    ++this->CurrentElement;
    this->CurrentRecord = 0;
  }
  return this->SkipToRecord(record);
}

Status PlyReader::SkipToRecord(std::uint64_t record)
{
  Status skipped = this->Body->SkipRecords(
    this->Header.elements[this->CurrentElement], this->CurrentRecord, record - this->CurrentRecord);
  this->CurrentRecord = record;
  return skipped;
}

template <class Number>
Result<Number> PlyReader::Remember(Result<Number> result)
{
  if (!result)
  {
    this->Failure = result.GetError();
  }
  return result;
}

Result<std::size_t> PlyReader::ReadVertices(Mesh& mesh, std::size_t limit)
{
  return this->Failure ? *this->Failure : this->Remember(this->ReadSomeVertices(mesh, limit));
}

Result<std::size_t> PlyReader::ReadTriangles(Mesh& mesh, std::size_t limit)
{
  return this->Failure ? *this->Failure : this->Remember(this->ReadSomeTriangles(mesh, limit));
}

Result<std::uint64_t> PlyReader::SkipVertices(std::uint64_t count)
{
  if (this->Failure)
  {
    return *this->Failure;
  }
  const std::uint64_t number = std::min(count, this->FileInfo.vertices - this->VerticesRead);
  if (number > 0)
  {
    const Status moved = this->MoveTo(this->VertexElement, this->VerticesRead + number);
    if (!moved)
    {
      return this->Remember(Result<std::uint64_t>(moved.GetError()));
    }
  }
  this->VerticesRead += number;
  return number;
}

Result<std::uint64_t> PlyReader::SkipFaces(std::uint64_t count)
{
  return this->Failure ? *this->Failure : this->Remember(this->SkipSomeFaces(count));
}

Result<std::uint64_t> PlyReader::SkipSomeFaces(std::uint64_t count)
{
  std::uint64_t done = 0;
  while (this->FaceElementsDone < this->Faces.size())
  {
    const FaceElement& faces = this->Faces[this->FaceElementsDone];
    const PlyElement& element = this->Header.elements[faces.element];
    const std::uint64_t number = std::min(count - done, element.count - this->FacesRead);
    Status moved = this->MoveTo(faces.element, this->FacesRead);
    if (moved && this->TriangleBytes == 0)
    {
      this->TriangleBytes =
        this->BytesOfTriangles(faces, this->Source.Position(), element.count - this->FacesRead);
      this->TrianglesBegin = this->Source.Position() - this->FacesRead * this->TriangleBytes;
    }
    if (moved && this->TriangleBytes > 0)
    {
      this->Source.Seek(this->Source.Position() + number * this->TriangleBytes);
      this->CurrentRecord += number;
    }
    else if (moved)
    {
      moved = this->MoveTo(faces.element, this->FacesRead + number);
    }
    KDSTREAM_TRY(moved);
    this->FacesRead += number;
    done += number;
    if (done == count)
    {
      break;
    }
    ++this->FaceElementsDone;
    this->FacesRead = 0;
  }
  return done;
}

// The size of a face in bytes, if all `number` faces from offset `begin` to the end of the file
// must be triangles. This is so if the rest of the file is exactly as large as this number of
// triangles, because a polygon has at least three corners. 0: the sizes may differ.
std::uint64_t PlyReader::BytesOfTriangles(
  const FaceElement& faces, std::uint64_t begin, std::uint64_t number) const
{
  const PlyElement& element = this->Header.elements[faces.element];
  if (this->Header.encoding == PlyEncoding::Ascii || faces.kind != PlyFaceSink::Kind::Polygon ||
      faces.element + 1 != this->Header.elements.size())
  {
    return 0;
  }
  std::uint64_t bytes = 0;
  for (std::size_t p = 0; p < element.properties.size(); ++p)
  {
    const PlyProperty& property = element.properties[p];
    if (property.isList && p != faces.list)
    {
      return 0;
    }
    bytes += property.isList ? SizeOf(property.countType) + 3 * SizeOf(property.type)
                             : SizeOf(property.type);
  }
  const std::uint64_t rest = this->Source.Size() - begin;
  return rest % bytes == 0 && rest / bytes == number ? bytes : 0;
}

// Whether the faces that were skipped can all be triangles: checks that those read up to here were.
Status PlyReader::CheckTriangles(const FaceElement& faces) const
{
  const std::uint64_t expected = this->TrianglesBegin + this->FacesRead * this->TriangleBytes;
  if (this->TriangleBytes == 0 || this->Source.Position() == expected)
  {
    return {};
  }
  return BadInput("element '" + this->Header.elements[faces.element].name +
                    "': truncated, or a face of fewer than three vertices: " +
                    "the file has room only for triangles, but one of the faces up to face " +
                    std::to_string(this->FacesRead) + " is another polygon",
    Remedy::CopyAgain);
}

// Checks that there are not more triangles than a build relies on.
Status PlyReader::CountTriangles(const PlyElement& element, std::uint64_t made)
{
  this->TrianglesMade += made;
  return this->TrianglesMade <= this->FileInfo.mostTriangles
           ? Status()
           : BadInput("element '" + element.name +
                        "': truncated, or a face of fewer than three vertices: the file has room " +
                        "for " + std::to_string(this->FileInfo.mostTriangles) +
                        " triangles, and there are more",
               Remedy::CopyAgain);
}

Result<std::size_t> PlyReader::ReadSomeVertices(Mesh& mesh, std::size_t limit)
{
  PrepareArrays(mesh, this->FileInfo);
  this->VertexArrays.Start(
    std::span(mesh.attributes).first(this->PointArrays), mostRepeated * this->Source.Size());
  const std::uint64_t number =
    std::min<std::uint64_t>(limit, this->FileInfo.vertices - this->VerticesRead);
  if (number == 0)
  {
    return std::size_t{ 0 };
  }
  KDSTREAM_TRY(this->MoveTo(this->VertexElement, this->VerticesRead));
  const PlyElement& element = this->Header.elements[this->VertexElement];
  const Result<bool> finite = this->Body->ReadPoints(
    element, this->Coordinates, this->VerticesRead, number, mesh.points, this->VertexArrays);
  KDSTREAM_TRY(finite);
  this->Finite = *finite;
  this->CountLongLines();
  this->VerticesRead += number;
  this->CurrentRecord = this->VerticesRead;
  return static_cast<std::size_t>(number);
}

Result<std::size_t> PlyReader::ReadSomeTriangles(Mesh& mesh, std::size_t limit)
{
  PrepareArrays(mesh, this->FileInfo);
  std::uint64_t done = 0;
  while (done < limit && this->FaceElementsDone < this->Faces.size())
  {
    FaceElement& faces = this->Faces[this->FaceElementsDone];
    const PlyElement& element = this->Header.elements[faces.element];
    if (this->FacesRead == element.count)
    {
      ++this->FaceElementsDone;
      this->FacesRead = 0;
      continue;
    }
    const std::uint64_t number =
      std::min<std::uint64_t>(limit - done, element.count - this->FacesRead);
    KDSTREAM_TRY(this->MoveTo(faces.element, this->FacesRead));
    PlyFaceSink sink(faces.kind, this->FileInfo.vertices, mesh.triangles, this->Polygons);
    faces.arrays.Start(
      std::span(mesh.attributes).subspan(this->PointArrays), mostRepeated * this->Source.Size());
    const std::size_t before = mesh.triangles.size();
    KDSTREAM_TRY(
      this->Body->ReadFaces(element, faces.list, this->FacesRead, number, sink, faces.arrays));
    KDSTREAM_TRY(this->CountTriangles(element, mesh.triangles.size() - before));
    this->FileInfo.tolerance.Count(Lapse::FaceTooSmall, sink.GetSmallFaces(),
      element.name + " " + std::to_string(sink.GetFirstSmall()));
    this->CountLongLines();
    this->FacesRead += number;
    this->CurrentRecord = this->FacesRead;
    done += number;
    KDSTREAM_TRY(this->CheckTriangles(faces));
  }
  KDSTREAM_TRY(this->CutPolygons(mesh));
  if (this->FaceElementsDone == this->Faces.size() && !this->CheckedBytesAfterEnd)
  {
    KDSTREAM_TRY(this->CheckBytesAfterEnd());
  }
  return static_cast<std::size_t>(done);
}

// Counts lines that have more values than their records have properties.
void PlyReader::CountLongLines()
{
  this->FileInfo.tolerance.Count(
    Lapse::ValuesNotNamed, this->Body->TakeLongLines(), this->Body->FirstLongLine());
}

// Takes the positions from the mesh's points if the mesh has all of them, else from a table.
Status PlyReader::CutPolygons(Mesh& mesh)
{
  if (this->Polygons.Empty())
  {
    return {};
  }
  if (mesh.points.size() == this->FileInfo.vertices)
  {
    return this->Polygons.Cut(
      mesh.triangles, [&](VertexId vertex) { return Result<Vec3>(mesh.points[vertex]); });
  }
  if (!this->Places)
  {
    KDSTREAM_TRY(this->KeepPlaces());
  }
  return this->Polygons.Cut(
    mesh.triangles, [&](VertexId vertex) { return this->Places->Get(vertex); });
}

// Checks the byte order by the first points of a binary point cloud. In a mesh, the indices show
// the order.
Status PlyReader::CheckOrder() const
{
  constexpr std::uint64_t most = 4096;
  const PlyElement& vertices = this->Header.elements[this->VertexElement];
  const AttributeType type = vertices.properties[this->Coordinates[0]].type;
  const bool isOfOne = std::all_of(this->Coordinates.begin(), this->Coordinates.end(),
    [&](std::size_t p) { return vertices.properties[p].type == type; });
  const bool isInteger = type == AttributeType::Int32 || type == AttributeType::UInt32;
  const bool isFloat = type == AttributeType::Float32 || type == AttributeType::Float64;
  if (this->Header.encoding == PlyEncoding::Ascii || !isOfOne || !(isFloat || isInteger) ||
      this->VertexElement > 0 || !this->Faces.empty())
  {
    return {};
  }
  Result<ByteSource> again = this->Source.Again();
  KDSTREAM_TRY(again);
  again->Seek(this->ElementBegins[0]);
  PlyArraySink noArrays;
  std::vector<Vec3> points;
  const Result<bool> read = PlyBody::Make(this->Header, *again)
                              ->ReadPoints(vertices, this->Coordinates, 0,
                                std::min(most, vertices.count), points, noArrays);
  if (!read)
  {
    return {}; // the reader reports errors when it reaches them
  }
  return isInteger ? CheckByteOrderOfIntegers(points, type == AttributeType::Int32)
                   : CheckByteOrder(points,
                       type == AttributeType::Float32 ? ScalarType::Float32 : ScalarType::Float64);
}

// Reads the vertices once more, into a table of positions.
Status PlyReader::KeepPlaces()
{
  constexpr std::uint64_t atOnce = std::uint64_t{ 1 } << 15;
  Result<ByteSource> again = this->Source.Again();
  KDSTREAM_TRY(again);
  again->Seek(this->ElementBegins[0]);
  const std::unique_ptr<PlyBody> body = PlyBody::Make(this->Header, *again);
  for (std::size_t i = 0; i < this->VertexElement; ++i)
  {
    const PlyElement& element = this->Header.elements[i];
    KDSTREAM_TRY(body->SkipRecords(element, 0, element.count));
  }
  this->Places = std::make_unique<ScratchTable<Vec3>>(this->Scratch);
  const PlyElement& vertices = this->Header.elements[this->VertexElement];
  PlyArraySink noArrays;
  std::vector<Vec3> points;
  for (std::uint64_t done = 0; done < vertices.count; done += points.size())
  {
    points.clear();
    KDSTREAM_TRY(body->ReadPoints(vertices, this->Coordinates, done,
      std::min(atOnce, vertices.count - done), points, noArrays));
    for (const Vec3& point : points)
    {
      KDSTREAM_TRY(this->Places->Append(point));
    }
  }
  return {};
}

// Skips the elements after the faces, so that a file truncated there is refused. If the header
// counts too few faces, the remaining ones follow the last one: they are not read, but reported.
// Blanks at the end of a file are ignored.
Status PlyReader::CheckBytesAfterEnd()
{
  this->CheckedBytesAfterEnd = true;
  const std::vector<PlyElement>& elements = this->Header.elements;
  const bool more =
    std::any_of(elements.begin() + static_cast<std::ptrdiff_t>(this->CurrentElement) + 1,
      elements.end(), [](const PlyElement& element) { return element.count > 0; });
  const std::size_t last = this->Faces.empty() ? this->VertexElement : this->Faces.back().element;
  const bool whole = this->CurrentRecord == elements[this->CurrentElement].count;
  if (this->CurrentElement != last || !whole)
  {
    return {};
  }
  if (more)
  {
    KDSTREAM_TRY(this->MoveTo(elements.size() - 1, elements.back().count));
  }
  constexpr std::uint64_t mostPadding = 4096;
  const std::uint64_t rest = this->Source.Remaining();
  const Result<std::string_view> bytes =
    this->Source.Peek(static_cast<std::size_t>(std::min(rest, mostPadding)));
  KDSTREAM_TRY(bytes);
  constexpr std::string_view padding(" \t\r\n\x1A\0", 6);
  const bool padded = rest <= mostPadding && bytes->find_first_not_of(padding) == bytes->npos;
  const std::uint64_t zeros =
    static_cast<std::uint64_t>(std::count(bytes->begin(), bytes->end(), '\0'));
  this->FileInfo.tolerance.Count(padded ? Lapse::PaddedEnd : Lapse::BytesAfterEnd,
    padded ? zeros : rest,
    "byte " + std::to_string(this->Source.Position()) + ", after the last " +
      elements[this->CurrentElement].name + " that the header counts");
  return {};
}

}
