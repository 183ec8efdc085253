// SPDX-License-Identifier: BSD-3-Clause
// Writing a mesh: .ply (binary, little endian), .stl (binary), .obj, .vtp and .wrl.
#include "filters/meshio/MeshWriter.h"

#include "filters/core/UnitVector.h"
#include "filters/meshio/FileEnding.h"
#include "filters/meshio/OutputFile.h"
#include "filters/meshio/ply/PlyArrays.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

namespace kdstream
{

namespace
{

// Calls `write(value)` for every coordinate in the type of the mesh.
template <class Write>
void ForEachCoordinate(const Mesh& mesh, Write&& write)
{
  for (const Vec3& point : mesh.points)
  {
    for (double value : point)
    {
      if (mesh.scalarType == ScalarType::Float32)
      {
        write(static_cast<float>(value));
      }
      else
      {
        write(value);
      }
    }
  }
}

// The first attribute of a role, or null.
std::vector<const Attribute*> ArraysOf(const Mesh& mesh, AttributeAssociation association)
{
  std::vector<const Attribute*> arrays;
  for (const Attribute& attribute : mesh.attributes)
  {
    if (attribute.association == association)
    {
      arrays.push_back(&attribute);
    }
  }
  return arrays;
}

void WriteTuple(OutputFile& file, const std::vector<const Attribute*>& arrays, std::size_t tuple)
{
  for (const Attribute* array : arrays)
  {
    const std::size_t size = array->TupleSize();
    file.Write(
      std::string_view(reinterpret_cast<const char*>(array->values.data()) + tuple * size, size));
  }
}

// Writes the header's lines for the properties that hold the arrays. These come after the
// properties that `element` has already.
void WritePlyProperties(
  OutputFile& file, PlyElement element, const std::vector<const Attribute*>& arrays)
{
  const std::size_t first = element.properties.size();
  AddPlyProperties(arrays, element);
  for (std::size_t p = first; p < element.properties.size(); ++p)
  {
    file.Write("\nproperty ");
    file.Write(PlyTypeName(element.properties[p].type));
    file.Write(" " + element.properties[p].name);
  }
}

void WritePly(OutputFile& file, const Mesh& mesh)
{
  const bool single = mesh.scalarType == ScalarType::Float32;
  const auto points = ArraysOf(mesh, AttributeAssociation::Point);
  const auto cells = ArraysOf(mesh, AttributeAssociation::Cell);
  file.Write("ply\nformat binary_little_endian 1.0\nelement vertex ");
  file.WriteText(mesh.points.size());
  PlyElement vertices;
  for (const char* name : { "x", "y", "z" })
  {
    file.Write(std::string("\nproperty ") + (single ? "float " : "double ") + name);
    vertices.properties.push_back({ name });
  }
  WritePlyProperties(file, vertices, points);
  if (!mesh.triangles.empty())
  {
    file.Write("\nelement face ");
    file.WriteText(mesh.triangles.size());
    file.Write("\nproperty list uchar int vertex_indices");
    PlyElement faces;
    faces.properties.push_back({ "vertex_indices", AttributeType::Int32, true });
    WritePlyProperties(file, faces, cells);
  }
  file.Write("\nend_header\n");
  std::size_t values = 0;
  ForEachCoordinate(mesh,
    [&](auto value)
    {
      file.WriteLittleEndian(value);
      if (++values % 3 == 0)
      {
        WriteTuple(file, points, values / 3 - 1);
      }
    });
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i)
  {
    file.WriteLittleEndian(std::uint8_t{ 3 });
    for (VertexId corner : mesh.triangles[i])
    {
      file.WriteLittleEndian(corner);
    }
    WriteTuple(file, cells, i);
  }
}

// The unit normal of a triangle; zero if the triangle has none.
Vec3 NormalOf(const Vec3& a, const Vec3& b, const Vec3& c)
{
  return UnitVector(Cross(Minus(b, a), Minus(c, a)));
}

void WriteStl(OutputFile& file, const Mesh& mesh)
{
  // The header must not begin with "solid", by which programs recognize text files; VTK looks for a
  // byte that is not ASCII instead.
  std::string header = "binary STL written by KdStream";
  header.resize(80, '\xff');
  file.Write(header);
  file.WriteLittleEndian(static_cast<std::uint32_t>(mesh.triangles.size()));
  for (const Triangle& triangle : mesh.triangles)
  {
    const Vec3& a = mesh.points[triangle[0]];
    const Vec3& b = mesh.points[triangle[1]];
    const Vec3& c = mesh.points[triangle[2]];
    for (const Vec3& vector : { NormalOf(a, b, c), a, b, c })
    {
      for (double value : vector)
      {
        file.WriteLittleEndian(static_cast<float>(value));
      }
    }
    file.WriteLittleEndian(std::uint16_t{ 0 });
  }
}

// Writes one line for each point: `before`, "x y z", and what `after(point)` writes.
template <class After>
void WritePointLines(
  OutputFile& file, const Mesh& mesh, std::string_view before, const After& after)
{
  std::size_t values = 0;
  ForEachCoordinate(mesh,
    [&](auto value)
    {
      file.Write(values % 3 == 0 ? before : " ");
      file.WriteText(value);
      if (++values % 3 == 0)
      {
        after(values / 3 - 1);
        file.Write("\n");
      }
    });
}

// Writes red, green and blue from 0 to 1, each after a blank.
void WriteColor(OutputFile& file, const Attribute& colors, std::size_t tuple)
{
  for (std::size_t k = 0; k < 3; ++k)
  {
    file.Write(" ");
    file.WriteText(static_cast<float>(colors.Get(tuple, k)) / 255.0F);
  }
}

// Writes each tuple as a line of values. If text formats cannot hold a value of a tuple, the whole
// tuple becomes zeros.
void WriteTupleLines(OutputFile& file, const Attribute& array, std::string_view before)
{
  for (std::size_t i = 0; i < array.TupleCount(); ++i)
  {
    bool finite = true;
    for (std::size_t k = 0; k < array.components; ++k)
    {
      finite = finite && std::isfinite(array.Get(i, k));
    }
    for (std::size_t k = 0; k < array.components; ++k)
    {
      const double value = finite ? array.Get(i, k) : 0;
      file.Write(k == 0 ? before : " ");
      if (array.type == AttributeType::Float32)
      {
        file.WriteText(static_cast<float>(value));
      }
      else
      {
        file.WriteText(value);
      }
    }
    file.Write("\n");
  }
}

// Writes colours after the coordinates, as most programs write and read them.
void WriteObj(OutputFile& file, const Mesh& mesh)
{
  const Attribute* const colors = FindRole(mesh.attributes, AttributeRole::Colors);
  const Attribute* const normals = FindRole(mesh.attributes, AttributeRole::Normals);
  const Attribute* const texture = FindRole(mesh.attributes, AttributeRole::TextureCoordinates);
  WritePointLines(file, mesh, "v ",
    [&](std::size_t point)
    {
      if (colors)
      {
        WriteColor(file, *colors, point);
      }
    });
  if (texture)
  {
    WriteTupleLines(file, *texture, "vt ");
  }
  if (normals)
  {
    WriteTupleLines(file, *normals, "vn ");
  }
  for (const Triangle& triangle : mesh.triangles)
  {
    file.Write("f");
    for (VertexId corner : triangle)
    {
      const std::string number = std::to_string(std::uint64_t{ corner } + 1);
      file.Write(" " + number);
      if (texture || normals)
      {
        file.Write("/" + (texture ? number : "") + (normals ? "/" + number : ""));
      }
    }
    file.Write("\n");
  }
}

void WriteVrml(OutputFile& file, const Mesh& mesh)
{
  const bool cloud = mesh.triangles.empty();
  file.Write(
    "#VRML V2.0 utf8\nShape {\nappearance Appearance { material Material { } }\ngeometry ");
  file.Write(cloud ? "PointSet {\n" : "IndexedFaceSet {\nsolid FALSE\n");
  file.Write("coord Coordinate { point [\n");
  WritePointLines(file, mesh, "", [](std::size_t) {});
  file.Write("] }\n");
  if (const Attribute* colors = FindRole(mesh.attributes, AttributeRole::Colors))
  {
    file.Write("color Color { color [");
    for (std::size_t i = 0; i < mesh.points.size(); ++i)
    {
      file.Write("\n");
      WriteColor(file, *colors, i);
    }
    file.Write("\n] }\n");
  }
  const Attribute* const normals = FindRole(mesh.attributes, AttributeRole::Normals);
  if (normals && !cloud) // a PointSet has no normals
  {
    file.Write("normal Normal { vector [\n");
    WriteTupleLines(file, *normals, "");
    file.Write("] }\n");
  }
  if (!cloud)
  {
    file.Write("coordIndex [\n");
    for (const Triangle& triangle : mesh.triangles)
    {
      for (VertexId corner : triangle)
      {
        file.WriteText(corner);
        file.Write(" ");
      }
      file.Write("-1\n");
    }
    file.Write("]\n");
  }
  file.Write("}\n}\n");
}

std::string XmlText(std::string_view text)
{
  std::string escaped;
  for (const char c : text)
  {
    escaped += c == '&'   ? "&amp;"
               : c == '<' ? "&lt;"
               : c == '>' ? "&gt;"
               : c == '"' ? "&quot;"
                          : std::string(1, c);
  }
  return escaped;
}

// The name of a type in VTK's XML.
std::string VtpTypeName(AttributeType type)
{
  std::string name(NameOf(type)); // "uint8" is "UInt8"
  const std::size_t capitals = name[0] == 'u' ? 2 : 1;
  for (std::size_t i = 0; i < capitals; ++i)
  {
    name[i] = static_cast<char>(name[i] - 'a' + 'A');
  }
  return name;
}

// The arrays of a .vtp file. Their bytes lie in the appended block, each array's after its length.
class VtpArrays
{
public:
  // Returns the XML element for an array of `bytes` bytes.
  std::string Declare(
    const std::string& type, std::string_view name, int components, std::uint64_t bytes)
  {
    std::string text = "<DataArray type=\"" + type + "\" Name=\"" + XmlText(name) +
                       "\" NumberOfComponents=\"" + std::to_string(components) +
                       "\" format=\"appended\" offset=\"" + std::to_string(this->Offset) + "\"/>\n";
    this->Offset += sizeof(std::uint64_t) + bytes;
    return text;
  }

private:
  std::uint64_t Offset = 0;
};

// Writes the elements PointData or CellData; the first array of each role is the active one.
void DeclareAttributes(OutputFile& file, const Mesh& mesh, AttributeAssociation association,
  const std::string& section, VtpArrays& arrays)
{
  const auto list = ArraysOf(mesh, association);
  if (list.empty())
  {
    return;
  }
  file.Write("<" + section);
  for (const auto& [role, name] :
    { std::pair{ AttributeRole::Normals, "Normals" }, std::pair{ AttributeRole::Colors, "Scalars" },
      std::pair{ AttributeRole::TextureCoordinates, "TCoords" } })
  {
    const Attribute* const active = FindRole(mesh.attributes, role);
    if (active && active->association == association)
    {
      file.Write(std::string(" ") + name + "=\"" + XmlText(active->name) + "\"");
    }
  }
  file.Write(">\n");
  for (const Attribute* array : list)
  {
    file.Write(arrays.Declare(
      VtpTypeName(array->type), array->name, array->components, array->values.size()));
  }
  file.Write("</" + section + ">\n");
}

void WriteAttributes(OutputFile& file, const Mesh& mesh, AttributeAssociation association)
{
  for (const Attribute* array : ArraysOf(mesh, association))
  {
    file.WriteLittleEndian(std::uint64_t{ array->values.size() });
    file.Write(
      std::string_view(reinterpret_cast<const char*>(array->values.data()), array->values.size()));
  }
}

// Writes VTK's XML with raw appended data, which VTK and ParaView read bit for bit.
void WriteVtp(OutputFile& file, const Mesh& mesh)
{
  const bool cloud = mesh.triangles.empty();
  const bool single = mesh.scalarType == ScalarType::Float32;
  const std::uint64_t cells = cloud ? mesh.points.size() : mesh.triangles.size();
  const std::uint64_t corners = cloud ? 1 : 3;
  const std::uint64_t pointBytes =
    mesh.points.size() * 3 * (single ? sizeof(float) : sizeof(double));
  const std::uint64_t connectivityBytes = cells * corners * sizeof(std::int64_t);
  const std::uint64_t offsetBytes = cells * sizeof(std::int64_t);
  const std::string number = std::to_string(cells);
  const std::string section = cloud ? "Verts" : "Polys";

  VtpArrays arrays;
  file.Write("<?xml version=\"1.0\"?>\n<VTKFile type=\"PolyData\" version=\"1.0\" "
             "byte_order=\"LittleEndian\" header_type=\"UInt64\">\n<PolyData>\n");
  file.Write("<Piece NumberOfPoints=\"" + std::to_string(mesh.points.size()) +
             "\" NumberOfVerts=\"" + (cloud ? number : "0") +
             "\" NumberOfLines=\"0\" NumberOfStrips=\"0\" NumberOfPolys=\"" +
             (cloud ? "0" : number) + "\">\n");
  DeclareAttributes(file, mesh, AttributeAssociation::Point, "PointData", arrays);
  if (!cloud)
  {
    DeclareAttributes(file, mesh, AttributeAssociation::Cell, "CellData", arrays);
  }
  file.Write("<Points>\n" +
             arrays.Declare(single ? "Float32" : "Float64", "Points", 3, pointBytes) +
             "</Points>\n");
  // One declaration in each statement, because each declaration takes the next place in the
  // appended block.
  file.Write("<" + section + ">\n");
  file.Write(arrays.Declare("Int64", "connectivity", 1, connectivityBytes));
  file.Write(arrays.Declare("Int64", "offsets", 1, offsetBytes));
  file.Write("</" + section + ">\n");
  file.Write("</Piece>\n</PolyData>\n<AppendedData encoding=\"raw\">\n_");

  WriteAttributes(file, mesh, AttributeAssociation::Point);
  if (!cloud)
  {
    WriteAttributes(file, mesh, AttributeAssociation::Cell);
  }
  file.WriteLittleEndian(pointBytes);
  ForEachCoordinate(mesh, [&file](auto value) { file.WriteLittleEndian(value); });
  file.WriteLittleEndian(connectivityBytes);
  for (std::uint64_t i = 0; i < cells; ++i)
  {
    for (std::uint64_t k = 0; k < corners; ++k)
    {
      file.WriteLittleEndian(static_cast<std::int64_t>(cloud ? i : mesh.triangles[i][k]));
    }
  }
  file.WriteLittleEndian(offsetBytes);
  for (std::uint64_t i = 0; i < cells; ++i)
  {
    file.WriteLittleEndian(static_cast<std::int64_t>((i + 1) * corners));
  }
  file.Write("\n</AppendedData>\n</VTKFile>\n");
}

using WriteFormat = void (*)(OutputFile&, const Mesh&);

WriteFormat FormatOf(const std::string& ending)
{
  return ending == ".ply"   ? WritePly
         : ending == ".stl" ? WriteStl
         : ending == ".obj" ? WriteObj
         : ending == ".vtp" ? WriteVtp
         : ending == ".wrl" ? WriteVrml
                            : nullptr;
}

Status CheckMesh(const Mesh& mesh, bool isStl)
{
  constexpr std::uint64_t mostPoints =
    std::uint64_t{ std::numeric_limits<std::int32_t>::max() } + 1;
  constexpr std::uint64_t mostStlTriangles = std::numeric_limits<std::uint32_t>::max();
  if (mesh.points.size() > mostPoints)
  {
    return Error{ ErrorCode::LimitExceeded, std::to_string(mesh.points.size()) +
                                              " points: more than " + std::to_string(mostPoints) +
                                              ", which the format can number" };
  }
  if (isStl && mesh.triangles.empty() && !mesh.points.empty())
  {
    return Error{ ErrorCode::InvalidArgument,
      "STL holds only triangles, and there are none; .ply, .vtp, .obj and .wrl hold points" };
  }
  if (isStl && mesh.triangles.size() > mostStlTriangles)
  {
    return Error{ ErrorCode::LimitExceeded,
      std::to_string(mesh.triangles.size()) + " triangles: more than " +
        std::to_string(mostStlTriangles) + ", which STL can count" };
  }
  KDSTREAM_TRY(CheckAttributes(mesh.attributes, mesh.points.size(), mesh.triangles.size()));
  for (std::size_t i = 0; i < mesh.attributes.size(); ++i)
  {
    if (!IsAttributeName(mesh.attributes[i].name))
    {
      return Error{ ErrorCode::InvalidInput,
        "attribute " + std::to_string(i) + " has a name that is not text" };
    }
  }
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i)
  {
    for (VertexId corner : mesh.triangles[i])
    {
      if (corner >= mesh.points.size())
      {
        return Error{ ErrorCode::InvalidInput,
          "triangle " + std::to_string(i) + ": index " + std::to_string(corner) +
            " out of range (" + std::to_string(mesh.points.size()) + " vertices)" };
      }
    }
  }
  return {};
}

// Whether floats would be coarse: the step between two floats is more than 1e-5 of the longest
// side.
bool IsFarFromZero(const Mesh& mesh)
{
  constexpr double stepOfFloats = 1. / (1 << 23), coarse = 1e-5;
  Box box;
  for (const Vec3& point : mesh.points)
  {
    box.Add(point);
  }
  double farthest = 0, longest = 0;
  for (std::size_t k = 0; k < 3 && !box.Empty(); ++k)
  {
    farthest = std::max({ farthest, std::abs(box.lo[k]), std::abs(box.hi[k]) });
    longest = std::max(longest, box.hi[k] - box.lo[k]);
  }
  return farthest * stepOfFloats > coarse * longest && longest > 0;
}

}

Status WriteMesh(const std::filesystem::path& file, const Mesh& mesh, const Execution& execution)
{
  const std::string ending = FileEnding(file);
  const WriteFormat write = FormatOf(ending);
  if (write == nullptr)
  {
    return Error{ ErrorCode::InvalidArgument,
      "the ending '" + ending +
        "' names no format that can be written (.ply, .stl, .obj, .vtp, .wrl)" };
  }
  KDSTREAM_TRY(CheckMesh(mesh, ending == ".stl"));
  OutputFile output;
  KDSTREAM_TRY(output.Open(file, execution));
  write(output, mesh);
  return output.Finish();
}

bool IsWritable(const std::filesystem::path& file)
{
  return FormatOf(FileEnding(file)) != nullptr;
}

std::vector<std::string> AttributesLeftOut(const std::filesystem::path& file, const Mesh& mesh)
{
  const std::string ending = FileEnding(file);
  std::vector<std::string> names;
  for (const Attribute& attribute : mesh.attributes)
  {
    const AttributeRole role = RoleOf(attribute);
    const bool known =
      role != AttributeRole::Other && FindRole(mesh.attributes, role) == &attribute;
    const bool kept = ending == ".ply" || ending == ".vtp" || (ending == ".obj" && known) ||
                      (ending == ".wrl" && known && role != AttributeRole::TextureCoordinates);
    if (!kept)
    {
      names.push_back(attribute.name);
    }
  }
  return names;
}

std::vector<std::string> LossesOfFormat(const std::filesystem::path& file, const Mesh& mesh)
{
  std::vector<std::string> losses;
  std::string names;
  for (const std::string& name : AttributesLeftOut(file, mesh))
  {
    names += (names.empty() ? "" : ", ") + name;
  }
  if (!names.empty())
  {
    losses.push_back("this format cannot hold these attributes: " + names);
  }
  const bool stl = FileEnding(file) == ".stl";
  if (stl && mesh.scalarType == ScalarType::Float64)
  {
    losses.push_back("STL holds floats; the coordinates were doubles and are rounded");
  }
  if (FileEnding(file) == ".wrl" && mesh.scalarType == ScalarType::Float64 && IsFarFromZero(mesh))
  {
    losses.push_back("VRML has floats: readers round these coordinates, which are doubles far from "
                     "0; subtract an offset, or use .ply or .vtp");
  }
  return losses;
}

}
