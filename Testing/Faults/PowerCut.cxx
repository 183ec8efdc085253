// SPDX-License-Identifier: BSD-3-Clause
// Steps:
// 1. replay all actions before the cut, in order, on files and folders that remember changes that
//    were not made durable
// 2. choose some of these changes
// 3. the result is the tree that can be reached from the folder.
#include "Testing/Faults/PowerCut.h"

#include <sys/stat.h>

#include <algorithm>
#include <functional>
#include <memory>
#include <sstream>

namespace kdstream::fixtures
{
namespace
{

constexpr std::size_t sector = 512;

struct Node;
using Shared = std::shared_ptr<Node>;

struct DataChange
{
  std::uint64_t offset = 0;
  std::string data;
  bool isSize = false; // a change of the size; else a write
};

// A file or a folder, with the content that is certainly on the disk.
struct Node
{
  bool isFolder = false;
  std::string bytes;
  std::vector<DataChange> pending;
};

// A name in a folder is added, removed, or both (a rename).
struct NameChange
{
  struct Entry
  {
    Node* folder = nullptr;
    std::string name;
    Shared node; // null: the name is removed
  };
  std::vector<Entry> entries;
  bool isDurable = false;
};

struct Coin
{
  std::mt19937 random;
  double chance;
  bool operator()() { return double(this->random()) / 4294967296.0 < this->chance; }
};

// Replays the actions.
struct Disk
{
  std::map<std::uint64_t, Shared> byInode;
  // As the program sees them; relative, without '/' at the end.
  std::map<std::string, Shared> byPath;
  std::vector<NameChange> names;
  Shared root = std::make_shared<Node>();

  static std::string ParentOf(const std::string& path)
  {
    const auto slash = path.rfind('/');
    return slash == path.npos ? "" : path.substr(0, slash);
  }
  static std::string NameOf(const std::string& path)
  {
    const auto slash = path.rfind('/');
    return slash == path.npos ? path : path.substr(slash + 1);
  }
  NameChange::Entry EntryOf(const std::string& path, Shared node) const
  {
    const auto folder = this->byPath.find(ParentOf(path));
    return { folder == this->byPath.end() ? nullptr : folder->second.get(), NameOf(path),
      std::move(node) };
  }
  void Change(std::vector<NameChange::Entry> entries, bool isDurable = false)
  {
    this->names.push_back({ std::move(entries), isDurable });
  }
  void Make(const std::string& path, std::uint64_t inode, bool isFolder, const std::string& bytes,
    bool isDurable)
  {
    auto node = std::make_shared<Node>();
    node->isFolder = isFolder;
    node->bytes = bytes;
    this->byInode[inode] = node;
    this->Change({ this->EntryOf(path, node) }, isDurable);
    this->byPath[path] = node;
  }
  void Move(const std::string& from, const std::string& to)
  {
    const auto node = this->byPath[from];
    this->Change({ this->EntryOf(from, nullptr), this->EntryOf(to, node) });
    std::map<std::string, Shared> moved;
    for (auto each = this->byPath.begin(); each != this->byPath.end();)
    {
      const bool isIn = each->first == from || each->first.starts_with(from + "/");
      if (isIn)
      {
        moved[to + each->first.substr(from.size())] = each->second;
      }
      each = isIn ? this->byPath.erase(each) : std::next(each);
    }
    for (auto& [path, each] : moved)
    {
      this->byPath[path] = each;
    }
  }
  void Sync(const Shared& node)
  {
    for (const auto& change : node->pending)
    {
      Apply(change, node->bytes);
    }
    node->pending.clear();
    for (auto& change : this->names)
    {
      change.isDurable |= std::any_of(change.entries.begin(), change.entries.end(),
        [&](const auto& entry) { return entry.folder == node.get(); });
    }
  }
  static void Apply(const DataChange& change, std::string& bytes)
  {
    if (change.isSize)
    {
      bytes.resize(change.offset);
      return;
    }
    bytes.resize(std::max<std::size_t>(bytes.size(), change.offset + change.data.size()));
    std::copy(change.data.begin(), change.data.end(),
      bytes.begin() + static_cast<std::ptrdiff_t>(change.offset));
  }
};

// The content of a file after the cut.
std::string Left(const Node& node, Coin& coin, bool garbage)
{
  std::string bytes = node.bytes;
  const auto grow = [&](std::size_t size)
  {
    if (bytes.size() < size)
    {
      bytes.resize(size, garbage ? '\xA5' : '\0');
    }
  };
  for (const DataChange& change : node.pending)
  {
    if (change.isSize)
    {
      if (coin())
      {
        grow(change.offset);
        bytes.resize(change.offset);
      }
      continue;
    }
    const std::size_t end = change.offset + change.data.size();
    if (coin()) // the size may be on the disk before the bytes are
    {
      grow(end);
    }
    for (std::size_t at = change.offset; at < end;)
    {
      const std::size_t next = std::min(end, (at / sector + 1) * sector);
      if (coin())
      {
        grow(next);
        std::copy_n(change.data.begin() + static_cast<std::ptrdiff_t>(at - change.offset),
          next - at, bytes.begin() + static_cast<std::ptrdiff_t>(at));
      }
      at = next;
    }
  }
  return bytes;
}

}

std::map<std::string, std::uint64_t> ReadInodes(const std::filesystem::path& folder)
{
  std::map<std::string, std::uint64_t> inodes;
  const auto inodeOf = [](const std::filesystem::path& path)
  {
    struct stat state = {};
    ::stat(path.c_str(), &state);
    return state.st_ino;
  };
  inodes[""] = inodeOf(folder);
  for (const auto& entry : std::filesystem::recursive_directory_iterator(folder))
  {
    inodes[entry.path().lexically_relative(folder).string()] = inodeOf(entry.path());
  }
  return inodes;
}

PowerCut::PowerCut(const std::filesystem::path& record, const std::filesystem::path& folder,
  const FileTree& before, const std::map<std::string, std::uint64_t>& inodes)
  : Folder(folder)
  , Before(before)
  , Inodes(inodes)
{
  std::ifstream input(record, std::ios::binary);
  const auto text = [&](std::size_t bytes)
  {
    std::string read(bytes, '\0');
    input.read(read.data(), static_cast<std::streamsize>(bytes));
    return read;
  };
  // The path relative to the folder; "" if it is not in the folder.
  const auto place = [&](const std::string& path)
  {
    const auto relative =
      std::filesystem::path(path).lexically_normal().lexically_relative(this->Folder).string();
    return relative.starts_with("..") || relative == "." ? "" : relative;
  };
  for (FileRecord each; input.read(reinterpret_cast<char*>(&each), sizeof(each));)
  {
    Action action{ each, {}, {}, {} };
    action.path = text(each.pathBytes);
    action.path2 = text(each.path2Bytes);
    action.data = text(each.dataBytes);
    const bool isNamed = !action.path.empty();
    action.path = isNamed ? place(action.path) : "";
    action.path2 = action.path2.empty() ? "" : place(action.path2);
    if (!isNamed || !action.path.empty())
    {
      this->Actions.push_back(std::move(action));
    }
  }
}

FileTree PowerCut::After(std::size_t actions, std::uint32_t seed) const
{
  Disk disk;
  disk.root->isFolder = true;
  disk.byPath[""] = disk.root;
  disk.byInode[this->Inodes.at("")] = disk.root;
  for (const auto& [name, content] : this->Before) // a folder comes before its content
  {
    const bool isFolder = name.ends_with('/');
    const auto path = isFolder ? name.substr(0, name.size() - 1) : name;
    disk.Make(path, this->Inodes.at(path), isFolder, content, true);
  }
  for (std::size_t i = 0; i < actions; ++i)
  {
    const Action& action = this->Actions[i];
    const auto known = disk.byInode.find(action.record.inode);
    const auto node = known == disk.byInode.end() ? nullptr : known->second;
    switch (action.record.action)
    {
      case FileAction::Make:
      case FileAction::MakeFolder:
        disk.Make(action.path, action.record.inode, action.record.action == FileAction::MakeFolder,
          "", false);
        break;
      case FileAction::Write:
      case FileAction::Size:
        if (node)
        {
          node->pending.push_back(
            { action.record.offset, action.data, action.record.action == FileAction::Size });
        }
        break;
      case FileAction::Rename:
        disk.Move(action.path, action.path2);
        break;
      case FileAction::Link:
        disk.Change({ disk.EntryOf(action.path2, node) });
        disk.byPath[action.path2] = node;
        break;
      case FileAction::Remove:
        disk.Change({ disk.EntryOf(action.path, nullptr) });
        disk.byPath.erase(action.path);
        break;
      case FileAction::Sync:
        if (node)
        {
          disk.Sync(node);
        }
        break;
    }
  }

  constexpr std::array<double, 3> chances{ 0.1, 0.5, 0.9 };
  const double extreme = seed == 0 ? -1 : 2;
  std::mt19937 seeds(seed);
  const auto chance = [&] { return seed < 2 ? extreme : chances[seeds() % chances.size()]; };
  Coin ofNames{ std::mt19937(seed * 2), chance() }, ofData{ std::mt19937(seed * 2 + 1), chance() };
  const bool garbage = seed % 2 == 1;
  std::map<const Node*, std::map<std::string, Shared>> folders;
  for (const NameChange& change : disk.names)
  {
    if (!change.isDurable && !ofNames())
    {
      continue;
    }
    for (const auto& entry : change.entries)
    {
      if (entry.node)
      {
        folders[entry.folder][entry.name] = entry.node;
      }
      else
      {
        folders[entry.folder].erase(entry.name);
      }
    }
  }
  FileTree tree;
  const std::function<void(const Node&, const std::string&)> walk =
    [&](const Node& folder, const std::string& prefix)
  {
    for (const auto& [name, node] : folders[&folder])
    {
      if (node->isFolder)
      {
        tree[prefix + name + "/"];
        walk(*node, prefix + name + "/");
      }
      else
      {
        tree[prefix + name] = Left(*node, ofData, garbage);
      }
    }
  };
  walk(*disk.root, "");
  return tree;
}

std::string PowerCut::Describe(std::size_t actions) const
{
  constexpr const char* words[] = { "make", "make folder", "write", "size", "rename", "link",
    "remove", "sync" };
  std::ostringstream text;
  for (std::size_t i = actions < 12 ? 0 : actions - 12; i < actions; ++i)
  {
    const Action& action = this->Actions[i];
    text << i << ": " << words[static_cast<std::size_t>(action.record.action)] << " " << action.path
         << " " << action.path2 << " inode " << action.record.inode << " at "
         << action.record.offset << ", " << action.data.size() << " bytes\n";
  }
  return text.str();
}

}
