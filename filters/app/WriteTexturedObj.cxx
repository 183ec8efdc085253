// SPDX-License-Identifier: BSD-3-Clause
#include "filters/app/WriteTextured.h"

#include "filters/core/BitCast.h"
#include "filters/core/VectorMath.h"
#include "filters/meshio/OutputFile.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <unordered_map>

namespace kdstream
{
namespace
{

// Writes texture coordinates, each once, in the order in which faces need them. v goes up.
class TextureLines
{
public:
  explicit TextureLines(OutputFile& file)
    : File(file)
  {
  }

  // The number of the line, counted from 1; 0 if the corner has no coordinates.
  std::size_t LineOf(const TexturedMaterial& material, const PictureCoordinate& corner)
  {
    if (!std::isfinite(corner[0]) || !std::isfinite(corner[1]))
    {
      return 0;
    }
    const bool asIs = IsUpsideDown(material.transform);
    const auto turned = PictureCoordinateOf(material, corner);
    const std::array<double, 2> place = asIs ? std::array<double, 2>{ corner[0], corner[1] }
                                             : std::array<double, 2>{ turned[0], 1 - turned[1] };
    const auto [line, isNew] = this->Lines.try_emplace(place, this->Lines.size() + 1);
    if (isNew)
    {
      this->File.Write("vt ");
      this->WriteNumber(place[0]);
      this->File.Write(" ");
      this->WriteNumber(place[1]);
      this->File.Write("\n");
    }
    return line->second;
  }

private:
  struct Hash
  {
    std::size_t operator()(const std::array<double, 2>& place) const
    {
      return std::hash<double>()(place[0]) * 31 + std::hash<double>()(place[1]);
    }
  };

  // Writes a value that is a float as a float, because this is shorter.
  void WriteNumber(double value)
  {
    if (double(float(value)) == value)
    {
      this->File.WriteText(float(value));
    }
    else
    {
      this->File.WriteText(value);
    }
  }

  OutputFile& File;
  std::unordered_map<std::array<double, 2>, std::size_t, Hash> Lines;
};

std::string PictureFileOf(const std::filesystem::path& file, const PictureSource& picture)
{
  return file.stem().string() + "-" + picture.name + ".png";
}

// Files that did not exist before. They are removed unless Keep is called.
class NewFiles
{
public:
  NewFiles() = default;
  NewFiles(const NewFiles&) = delete;
  NewFiles& operator=(const NewFiles&) = delete;
  ~NewFiles()
  {
    std::error_code ignored;
    for (const std::filesystem::path& file : this->Made)
    {
      std::filesystem::remove(file, ignored);
    }
  }

  Status Finish(const std::filesystem::path& file, OutputFile& output)
  {
    std::error_code status;
    const bool isNew = !std::filesystem::exists(file, status);
    if (isNew)
    {
      // Stored before the file appears: afterwards there may be no memory.
      this->Made.push_back(file);
    }
    const Status finished = output.Finish();
    if (!finished && isNew)
    {
      this->Made.pop_back();
    }
    return finished;
  }
  void Keep() { this->Made.clear(); }

private:
  std::vector<std::filesystem::path> Made;
};

Status WritePictures(const std::filesystem::path& file, const TexturedMesh& textured,
  const Execution& execution, NewFiles& files)
{
  for (const PictureSource& picture : textured.pictures)
  {
    const std::filesystem::path name = file.parent_path() / PictureFileOf(file, picture);
    OutputFile output;
    KDSTREAM_TRY(OfFile(name.string(), output.Open(name, execution)));
    output.Write({ reinterpret_cast<const char*>(picture.bytes.data()), picture.bytes.size() });
    KDSTREAM_TRY(OfFile(name.string(), files.Finish(name, output)));
  }
  return {};
}

void WriteNumbers(OutputFile& output, std::string_view before, const double* begin, bool single)
{
  output.Write(before);
  for (std::size_t k = 0; k < 3; ++k)
  {
    output.Write(" ");
    if (single)
    {
      output.WriteText(static_cast<float>(begin[k]));
    }
    else
    {
      output.WriteText(begin[k]);
    }
  }
  output.Write("\n");
}

// For each material, whether a texture coordinate lies outside its picture.
std::vector<bool> MaterialsThatLeave(const TexturedMesh& textured)
{
  std::vector<bool> leave(textured.materials.size());
  for (std::size_t t = 0; t < textured.corners.size(); ++t)
  {
    const std::uint32_t material = textured.materialOf[t];
    for (const PictureCoordinate& corner : textured.corners[t])
    {
      const auto at = PictureCoordinateOf(textured.materials[material], corner);
      if (std::min(at[0], at[1]) < 0 || std::max(at[0], at[1]) > 1)
      {
        leave[material] = true;
      }
    }
  }
  return leave;
}

// Some readers take "-clamp on" as a part of the picture's name, so it is written only if it makes
// a difference.
Status WriteMaterials(const std::filesystem::path& file, const std::string& objName,
  const TexturedMesh& textured, NewFiles& files)
{
  const std::vector<bool> leave = MaterialsThatLeave(textured);
  OutputFile output;
  KDSTREAM_TRY(OfFile(file.string(), output.Open(file)));
  for (std::size_t i = 0; i < textured.materials.size(); ++i)
  {
    const TexturedMaterial& material = textured.materials[i];
    output.Write("newmtl " + material.name + "\n");
    Vec3 color{ 1, 1, 1 };
    for (std::size_t k = 0; k < 3 && material.picture == noPicture; ++k)
    {
      color[k] = FromLinear(material.color[k]);
    }
    WriteNumbers(output, "Kd", color.data(), true);
    if (material.picture == noPicture && !material.opaque && material.color[3] < 1)
    {
      output.Write("d ");
      output.WriteText(static_cast<float>(material.color[3]));
      output.Write("\n");
    }
    if (material.picture != noPicture)
    {
      const bool clamp = material.wrapU == TextureWrap::Clamp && leave[i];
      output.Write(std::string("map_Kd ") + (clamp ? "-clamp on " : "") +
                   PictureFileOf(objName, textured.pictures[material.picture]) + "\n");
    }
  }
  return OfFile(file.string(), files.Finish(file, output));
}

const Attribute* NormalsOf(const Mesh& mesh)
{
  const auto found = std::find_if(mesh.attributes.begin(), mesh.attributes.end(),
    [](const Attribute& attribute) { return RoleOf(attribute) == AttributeRole::Normals; });
  return found == mesh.attributes.end() ? nullptr : &*found;
}

void WriteVertices(OutputFile& output, const Mesh& mesh, const Attribute* normals)
{
  for (const Vec3& point : mesh.points)
  {
    WriteNumbers(output, "v", point.data(), mesh.scalarType == ScalarType::Float32);
  }
  for (std::size_t v = 0; normals && v < mesh.points.size(); ++v)
  {
    Vec3 normal{ normals->Get(v, 0), normals->Get(v, 1), normals->Get(v, 2) };
    normal = IsFinite(normal) ? normal : Vec3{};
    WriteNumbers(output, "vn", normal.data(), normals->type == AttributeType::Float32);
  }
}

void WriteFaces(OutputFile& output, const TexturedMesh& textured, bool normals)
{
  TextureLines lines(output);
  std::size_t material = textured.materials.size();
  for (const std::size_t t : TrianglesByMaterial(textured))
  {
    if (textured.materialOf[t] != material)
    {
      material = textured.materialOf[t];
      output.Write("usemtl " + textured.materials[material].name + "\n");
    }
    const TexturedMaterial& used = textured.materials[material];
    std::string face = "f";
    for (std::size_t k = 0; k < 3; ++k)
    {
      const std::size_t line = lines.LineOf(used, textured.corners[t][k]);
      const std::string vertex = std::to_string(std::uint64_t{ textured.mesh.triangles[t][k] } + 1);
      face += " " + vertex;
      if (line > 0 || normals)
      {
        face += "/" + (line > 0 ? std::to_string(line) : "") + (normals ? "/" + vertex : "");
      }
    }
    output.Write(face + "\n");
  }
}

}

std::array<double, 2> PictureCoordinateOf(
  const TexturedMaterial& material, const PictureCoordinate& corner)
{
  const auto along = [&](const std::array<double, 3>& row)
  { return row[0] * double(corner[0]) + row[1] * double(corner[1]) + row[2]; };
  return { along(material.transform.u), along(material.transform.v) };
}

bool IsIdentity(const TextureTransform& transform)
{
  return transform.u == TextureTransform{}.u && transform.v == TextureTransform{}.v;
}

bool IsUpsideDown(const TextureTransform& transform)
{
  return transform.u == upsideDown.u && transform.v == upsideDown.v;
}

std::vector<std::size_t> TrianglesByMaterial(const TexturedMesh& textured)
{
  std::vector<std::size_t> order(textured.mesh.triangles.size());
  std::iota(order.begin(), order.end(), std::size_t{ 0 });
  std::stable_sort(order.begin(), order.end(),
    [&](std::size_t a, std::size_t b) { return textured.materialOf[a] < textured.materialOf[b]; });
  return order;
}

Status WriteTexturedObj(
  const std::filesystem::path& file, const TexturedMesh& textured, const Execution& execution)
{
  NewFiles files;
  KDSTREAM_TRY(WritePictures(file, textured, execution, files));
  std::filesystem::path library = file;
  library.replace_extension(".mtl");
  KDSTREAM_TRY(WriteMaterials(library, file.filename().string(), textured, files));
  OutputFile output;
  KDSTREAM_TRY(output.Open(file, execution));
  output.Write("mtllib " + library.filename().string() + "\n");
  const Attribute* const normals = NormalsOf(textured.mesh);
  WriteVertices(output, textured.mesh, normals);
  WriteFaces(output, textured, normals != nullptr);
  KDSTREAM_TRY(output.Finish());
  files.Keep();
  return {};
}

}
