#include "scene/obj/reader.h"

#include <fmt/format.h>
#include <tiny_obj_loader.h>

#include <algorithm>
#include <iterator>
#include <map>
#include <optional>
#include <span>
#include <sstream>
#include <utility>

#include "base/error.h"
#include "base/files.h"
#include "scene/named_files.h"
#include "scene/obj/check.h"
#include "scene/obj/meshes.h"
#include "scene/obj/mtl.h"

namespace skywave {
namespace {

constexpr std::size_t kMostWordsOfAName = 8;  // of one of several files of a statement

// Returns the file of a library; before the spaces of its name there may be backslashes.
std::optional<std::string> FindLibrary(const InputPosition& at, std::string name) {
  if (auto file = FindNamedFile(at, name)) return file;
  for (std::size_t i; (i = name.find("\\ ")) != name.npos;) name.erase(i, 1);
  return FindNamedFile(at, name);
}

// The first of several names between spaces, of which each may have some.
struct FirstName {
  std::optional<std::string> file;  // there may be none
  std::size_t words = 1;
};

// Takes the longest name that a file has, or else the shortest of one that was moved.
FirstName FindFirst(std::span<const std::string> words, const InputPosition& at,
                    Warnings& warnings) {
  const auto name = [&](std::size_t count) {
    return fmt::format("{}", fmt::join(words.first(count), " "));
  };
  const std::size_t most = std::min(words.size(), kMostWordsOfAName);
  for (std::size_t count = most; count > 0; --count) {
    if (auto file = FindLibrary(at, name(count))) return {std::move(file), count};
  }
  for (std::size_t count = 1; count <= most; ++count) {
    if (auto file = FindMovedFile(at, name(count), warnings)) return {std::move(file), count};
  }
  return {};
}

// Returns the files of one mtllib, which has one name or several.
std::vector<std::string> ResolveLibraries(const ObjName& library, const std::string& path,
                                          Warnings& warnings) {
  const auto at = InputPosition::Line(path, library.line);
  if (auto whole = FindLibrary(at, library.name)) return {*std::move(whole)};
  std::istringstream text(library.name);
  const std::vector<std::string> words{std::istream_iterator<std::string>(text), {}};
  std::vector<std::string> files;
  for (std::span<const std::string> rest = words; !rest.empty();) {
    FirstName first = FindFirst(rest, at, warnings);
    if (first.file) {
      files.push_back(*std::move(first.file));
    } else {
      AddMissing(warnings, at, "mtllib", InputError::NoSuchFile(at, rest.front()),
                 "its materials are grey Lambert");
    }
    rest = rest.subspan(first.words);
  }
  return files;
}

// Appends the materials of every library to the scene; returns their indices by name. If a name
// occurs twice, its first material counts.
std::map<std::string, int> ReadLibraries(const ObjStatements& statements, const std::string& path,
                                         Scene& scene, Warnings& warnings) {
  std::map<std::string, int> by_name;
  std::vector<std::string> done;
  TextureFiles textures{&scene};
  for (const ObjName& library : statements.libraries) {
    for (const std::string& file : ResolveLibraries(library, path, warnings)) {
      if (std::find(done.begin(), done.end(), file) != done.end()) continue;
      done.push_back(file);
      for (Material& material : ReadMtl(file, textures, warnings)) {
        by_name.try_emplace(material.name, static_cast<int>(scene.materials.size()));
        scene.materials.push_back(std::move(material));
      }
    }
  }
  return by_name;
}

// tinyobjloader cuts the names of libraries and of usemtl at spaces, so it is given the materials
// that the file uses under the names that it will look up.
class UsedMaterials : public tinyobj::MaterialReader {
 public:
  std::map<std::string, int> by_name;

  bool operator()(const std::string&, std::vector<tinyobj::material_t>*,
                  std::map<std::string, int>* map, std::string*, std::string*) override {
    *map = by_name;
    return true;
  }
};

UsedMaterials FindUsedMaterials(const ObjStatements& statements, const std::string& path,
                                const std::map<std::string, int>& known, Warnings& warnings) {
  UsedMaterials used;
  for (const ObjName& use : statements.materials) {
    const auto position = InputPosition::Line(path, use.line);
    const auto found = known.find(use.name);
    if (found == known.end()) {
      AddWarning(warnings, position,
                 fmt::format("no material \"{}\" is in a library: grey Lambert is used", use.name));
    }
    const int index = found == known.end() ? 0 : found->second;
    const std::string first_word = use.name.substr(0, use.name.find_first_of(" \t"));
    const auto [entry, is_new] = used.by_name.try_emplace(first_word, index);
    if (!is_new && entry->second != index) {
      throw InputError(position, fmt::format("the material \"{}\" differs from another one only "
                                             "after a space: rename it",
                                             use.name));
    }
  }
  return used;
}

// Moves all positions, so that `origin` is at (0, 0, 0), before tinyobjloader makes floats of them.
void MoveObjPositions(ObjLines& lines, const glm::dvec3& origin) {
  if (origin == glm::dvec3(0)) return;
  std::string moved;
  std::size_t done = 0;
  std::vector<std::string_view> words;
  lines.next = lines.joins_read = 0, lines.next_line = 1;
  while (NextStatement(lines, words)) {
    if (words[0] != "v") continue;
    const auto begin = std::size_t(words[1].data() - lines.text.data());
    const auto end = std::size_t(words[3].data() + words[3].size() - lines.text.data());
    moved.append(lines.text, done, begin - done);
    for (int axis = 0; axis < 3; ++axis) {
      const double place = ParseObjNumber(lines, words[std::size_t(axis + 1)]) - origin[axis];
      fmt::format_to(std::back_inserter(moved), "{}{}", axis == 0 ? "" : " ", float(place));
    }
    done = end;
  }
  lines.text = moved.append(lines.text, done);
}

}  // namespace

Scene ParseObj(std::string text, const std::string& path, const ReadOptions& options) {
  Scene scene;
  Warnings warnings = MakeWarnings(options);
  scene.materials.push_back({.name = "default"});
  ObjLines lines = MakeObjLines(std::move(text), path);
  const ObjStatements statements = CheckObj(lines, warnings);
  MoveObjPositions(lines, options.origin);
  const auto known = ReadLibraries(statements, path, scene, warnings);
  UsedMaterials materials = FindUsedMaterials(statements, path, known, warnings);

  tinyobj::attrib_t attributes;
  std::vector<tinyobj::shape_t> shapes;
  std::vector<tinyobj::material_t> ignored;
  std::string notes, errors;
  // The first mtllib makes the materials known before the file names any library.
  std::istringstream stream("mtllib used\n" + lines.text);
  if (!tinyobj::LoadObj(&attributes, &shapes, &ignored, &notes, &errors, &stream, &materials,
                        /*triangulate=*/true, /*default_vcols_fallback=*/false)) {
    throw InputError(InputPosition::File(path), "tinyobjloader cannot read it: " + errors);
  }
  if (options.vertex_colors == VertexColors::kOff) attributes.colors.clear();
  BuildObjMeshes(attributes, shapes, statements.has_smoothing, path, scene);
  BuildObjPoints(attributes, statements, options, path, scene, warnings);
  SetRemarks(warnings, scene);
  return scene;
}

Scene ReadObj(const std::string& path, const ReadOptions& options) {
  return ParseObj(ReadFile(path), path, options);
}

}  // namespace skywave
