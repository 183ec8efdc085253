// SPDX-License-Identifier: BSD-3-Clause
#include "filters/adapter/SharedArrays.h"

#include "filters/core/BitCast.h"
#include "filters/core/MixBits.h"

#include <vtkDataArray.h>
#include <vtkIdList.h>
#include <vtkIdTypeArray.h>
#include <vtkNew.h>
#include <vtkSmartPointer.h>
#include <vtkVariant.h>

#include <algorithm>

namespace kdstream
{
namespace
{

bool IsGhosts(vtkAbstractArray& array)
{
  return array.GetName() && std::string(array.GetName()) == vtkDataSetAttributes::GhostArrayName();
}

// Finds the same array in another part: by name, or if it has none, by its role.
vtkAbstractArray* FindLike(vtkAbstractArray& array, const PartData& of, const PartData& in)
{
  if (array.GetName())
  {
    return in.data->GetAbstractArray(array.GetName());
  }
  for (int type = 0; type < vtkDataSetAttributes::NUM_ATTRIBUTES; ++type)
  {
    vtkAbstractArray* const like = in.data->GetAbstractAttribute(type);
    if (of.data->GetAbstractAttribute(type) == &array && like && !like->GetName())
    {
      return like;
    }
  }
  return nullptr;
}

bool IsAlike(vtkAbstractArray& array, vtkAbstractArray* other, vtkIdType tuples)
{
  return other && other->GetDataType() == array.GetDataType() &&
         other->GetNumberOfComponents() == array.GetNumberOfComponents() &&
         other->GetNumberOfTuples() == tuples;
}

void LeaveOut(vtkAbstractArray& array, const std::string& kind, const std::string& why,
  std::vector<std::string>& leftOut)
{
  const std::string what = kind + " array \"" + (array.GetName() ? array.GetName() : "") + "\": ";
  if (std::none_of(leftOut.begin(), leftOut.end(),
        [&](const std::string& other) { return other.compare(0, what.size(), what) == 0; }))
  {
    leftOut.push_back(what + why);
  }
}

// Why an array cannot be used; empty if it can.
std::string WhyUnusable(vtkAbstractArray& array, const PartData& part, const std::string& kind)
{
  if (array.GetNumberOfTuples() != part.tuples)
  {
    return "has " + std::to_string(array.GetNumberOfTuples()) + " tuples for " +
           std::to_string(part.tuples) + " " + kind + "s";
  }
  return IsGhosts(array) && !FindGhosts(part) ? "is not one unsigned char for each " + kind : "";
}

template <class Visit>
void ForEachArray(const PartData& part, const Visit& visit)
{
  for (int i = 0; part.tuples > 0 && i < part.data->GetNumberOfArrays(); ++i)
  {
    visit(*part.data->GetAbstractArray(i));
  }
}

// The array in all parts that count; empty if one does not have it.
std::vector<vtkAbstractArray*> InAllParts(
  vtkAbstractArray& array, const PartData& of, std::span<const PartData> parts)
{
  std::vector<vtkAbstractArray*> found;
  for (const PartData& part : parts)
  {
    found.push_back(part.tuples > 0 ? FindLike(array, of, part) : nullptr);
    if (part.tuples > 0 && !IsAlike(array, found.back(), part.tuples))
    {
      return {};
    }
  }
  return found;
}

// The roles (types of attributes) for which the array is active in all parts.
std::vector<int> AttributesOf(
  const std::vector<vtkAbstractArray*>& ofPart, std::span<const PartData> parts)
{
  std::vector<int> attributes;
  for (int type = 0; type < vtkDataSetAttributes::NUM_ATTRIBUTES; ++type)
  {
    bool isActive = true;
    for (std::size_t p = 0; p < parts.size(); ++p)
    {
      isActive = isActive && (!ofPart[p] || parts[p].data->GetAbstractAttribute(type) == ofPart[p]);
    }
    if (isActive)
    {
      attributes.push_back(type);
    }
  }
  return attributes;
}

std::uint64_t HashOfValues(vtkDataArray& array, vtkIdType tuple)
{
  std::uint64_t hash = 0;
  const auto size = static_cast<std::size_t>(array.GetNumberOfComponents()) *
                    static_cast<std::size_t>(array.GetDataTypeSize());
  if (array.HasStandardMemoryLayout() && size > 0)
  {
    const auto* const bytes =
      static_cast<const std::uint8_t*>(array.GetVoidPointer(0)) + std::size_t(tuple) * size;
    for (std::size_t i = 0; i < size; ++i)
    {
      hash = MixBits(hash ^ bytes[i]);
    }
    return hash;
  }
  for (int c = 0; c < array.GetNumberOfComponents(); ++c)
  {
    hash = MixBits(hash ^ BitCast<std::uint64_t>(array.GetComponent(tuple, c)));
  }
  return hash;
}

}

bool SharedArray::Is(int attribute) const
{
  return std::find(this->attributes.begin(), this->attributes.end(), attribute) !=
         this->attributes.end();
}

vtkUnsignedCharArray* FindGhosts(const PartData& part)
{
  auto* const ghosts = vtkUnsignedCharArray::SafeDownCast(
    part.data->GetAbstractArray(vtkDataSetAttributes::GhostArrayName()));
  return ghosts && ghosts->GetNumberOfValues() == part.tuples ? ghosts : nullptr;
}

// If other parts lack an array, it is listed once, by the first part that has it.
std::vector<SharedArray> FindSharedArrays(
  std::span<const PartData> parts, const std::string& kind, std::vector<std::string>& leftOut)
{
  for (const PartData& part : parts)
  {
    ForEachArray(part,
      [&](vtkAbstractArray& array)
      {
        const std::string why = WhyUnusable(array, part, kind);
        if (!why.empty())
        {
          LeaveOut(array, kind, why, leftOut);
        }
      });
  }
  std::vector<SharedArray> shared;
  const PartData* first = nullptr; // the first part that counts
  for (const PartData& part : parts)
  {
    first = !first && part.tuples > 0 ? &part : first;
    ForEachArray(part,
      [&](vtkAbstractArray& array)
      {
        if (IsGhosts(array))
        {
          return;
        }
        std::vector<vtkAbstractArray*> ofPart =
          InAllParts(array, part, first == &part ? parts : std::span(first, 1));
        if (ofPart.empty())
        {
          LeaveOut(array, kind, "not all parts have it", leftOut);
        }
        else if (first == &part)
        {
          std::vector<int> attributes = AttributesOf(ofPart, parts);
          shared.push_back({ std::move(ofPart), std::move(attributes) });
        }
      });
  }
  return shared;
}

const SharedArray* FindGlobalIds(std::span<const SharedArray> arrays)
{
  const auto found = std::find_if(arrays.begin(), arrays.end(),
    [](const SharedArray& array) { return array.Is(vtkDataSetAttributes::GLOBALIDS); });
  return found != arrays.end() ? &*found : nullptr;
}

std::int64_t IdOf(const SharedArray& ids, TupleOfPart tuple)
{
  vtkAbstractArray* const array = ids.ofPart[tuple.part];
  auto* const plain = vtkIdTypeArray::SafeDownCast(array);
  return plain ? plain->GetValue(tuple.tuple) : array->GetVariantValue(tuple.tuple).ToTypeInt64();
}

void RemoveUnusableArrays(
  const PartData& part, const std::string& kind, std::vector<std::string>& leftOut)
{
  for (int i = part.data->GetNumberOfArrays() - 1; i >= 0; --i)
  {
    vtkAbstractArray& array = *part.data->GetAbstractArray(i);
    const std::string why = WhyUnusable(array, part, kind);
    if (!why.empty())
    {
      LeaveOut(array, kind, why, leftOut);
      part.data->RemoveArray(i);
    }
  }
}

std::uint64_t HashOfTuple(std::span<const SharedArray> arrays, TupleOfPart tuple)
{
  std::uint64_t hash = 0;
  for (const SharedArray& array : arrays)
  {
    if (auto* const numbers = vtkDataArray::SafeDownCast(array.ofPart[tuple.part]))
    {
      hash = MixBits(hash + HashOfValues(*numbers, tuple.tuple));
    }
  }
  return hash;
}

void CopySharedArrays(std::span<const SharedArray> arrays, std::span<const TupleOfPart> tuples,
  vtkDataSetAttributes& output)
{
  if (arrays.empty())
  {
    return;
  }
  struct Ids
  {
    vtkNew<vtkIdList> from, to;
  };
  std::vector<Ids> ofPart(arrays[0].ofPart.size());
  for (std::size_t i = 0; i < tuples.size(); ++i)
  {
    ofPart[tuples[i].part].from->InsertNextId(tuples[i].tuple);
    ofPart[tuples[i].part].to->InsertNextId(static_cast<vtkIdType>(i));
  }
  for (const SharedArray& array : arrays)
  {
    vtkAbstractArray* const like = *std::find_if(array.ofPart.begin(), array.ofPart.end(),
      [](const vtkAbstractArray* each) { return each != nullptr; });
    const auto joined =
      vtkSmartPointer<vtkAbstractArray>::Take(vtkAbstractArray::CreateArray(like->GetDataType()));
    joined->SetName(like->GetName());
    joined->SetNumberOfComponents(like->GetNumberOfComponents());
    joined->CopyComponentNames(like);
    joined->SetNumberOfTuples(static_cast<vtkIdType>(tuples.size()));
    for (std::size_t p = 0; p < ofPart.size(); ++p)
    {
      if (ofPart[p].from->GetNumberOfIds() > 0)
      {
        joined->InsertTuples(ofPart[p].to, ofPart[p].from, array.ofPart[p]);
      }
    }
    const int index = output.AddArray(joined);
    for (const int type : array.attributes)
    {
      output.SetActiveAttribute(index, type);
    }
  }
}

}
