#include "job/film_file.h"

#include <fmt/format.h>
#include <xxhash.h>

#include <bit>
#include <cstring>
#include <memory>
#include <nlohmann/json.hpp>
#include <utility>

#include "base/error.h"
#include "base/files.h"
#include "base/json.h"
#include "wavefront/film/aovs.h"

namespace skywave {
namespace {

using Json = nlohmann::ordered_json;

static_assert(std::endian::native == std::endian::little,
              "films are written as they lie in memory");

constexpr std::string_view kMagic = "SKYWFILM";
constexpr int kFormat = 2;
constexpr std::size_t kMostBytes = std::size_t{1} << 40;
constexpr std::size_t kHeaderBytes = kMagic.size() + sizeof(std::uint64_t);
// No film has more values than this, so that sizes of a torn manifest do not exhaust the memory.
constexpr int kMostPixelsASide = 1 << 20;

Json ToJson(const CropWindow& w) { return {w.x, w.y, w.width, w.height}; }
Json ToJson(const SampleRange& r) { return {r.first, r.end}; }

// A 32-bit float as the number of its bits, which JSON keeps.
Json Bits(float value) { return std::bit_cast<std::uint32_t>(value); }

Json ToJson(const PictureIdentity& identity) {
  Json json = {{"software", identity.software},
               {"scene", identity.scene},
               {"scene_hash", fmt::format("{:016x}", identity.scene_hash)},
               {"map_hash", fmt::format("{:016x}", identity.map_hash)},
               {"film", ToJson(identity.film)},
               {"samples", identity.samples},
               {"seed", identity.seed},
               {"repeatable", identity.repeatable},
               {"backplate", identity.backplate},
               {"options", Json::array()}};
  for (const RecordedOption& option : identity.options) {
    json["options"].push_back(
        {{"name", option.name}, {"words", option.words}, {"is_input", option.is_input}});
  }
  return json;
}

// Returns numbers as pairs of one and how often it follows itself.
Json RunsOf(const std::vector<std::uint32_t>& numbers) {
  Json runs = Json::array();
  for (std::size_t i = 0; i < numbers.size();) {
    const std::size_t first = i;
    while (i < numbers.size() && numbers[i] == numbers[first]) ++i;
    runs.push_back(numbers[first]);
    runs.push_back(i - first);
  }
  return runs;
}

// Names of meshes and of materials; null where no matte is kept.
Json ToJson(const std::shared_ptr<const Mattes>& mattes) {
  if (!mattes) return nullptr;
  return {{"meshes", (*mattes)[std::size_t(MatteOf::kObjects)].names},
          {"materials", (*mattes)[std::size_t(MatteOf::kMaterials)].names}};
}

Json Manifest(const FilmFile& file, const Film& film) {
  const FilmLayout& layout = film.layout();
  Json json = {{"format", kFormat},
               {"picture", ToJson(file.identity)},
               {"window", ToJson(file.window)},
               {"layers", ToString(file.layers)},
               {"seconds", file.seconds},
               {"sums",
                {{"layers", ToString(layout.aovs)},
                 {"brightest_bits", Bits(layout.brightest_radiance)},
                 {"extent_bits", Bits(layout.world_extent)},
                 {"light_groups", layout.light_groups},
                 {"mattes", ToJson(layout.mattes)},
                 {"splats", layout.shared},
                 {"signs", layout.has_signs},
                 {"bytes", film.packed_bytes()}}},
               {"holds", Json::array()}};
  for (const PicturePart& part : file.holds) {
    json["holds"].push_back({{"window", ToJson(part.window)}, {"samples", ToJson(part.samples)}});
  }
  if (file.is_checkpoint) {
    json["checkpoint"] = {{"samples", ToJson(file.samples)},
                          {"step", ToJson(file.state.step)},
                          {"tile_side", file.state.tile_side},
                          {"rows", file.state.rows},
                          {"ended", RunsOf(file.state.ended)}};
  }
  return json;
}

// Returns a whole number that T can hold.
template <class T>
T Whole(const Json& json) {
  const bool fits = json.is_number_unsigned()
                        ? std::in_range<T>(json.get<std::uint64_t>())
                        : json.is_number_integer() && std::in_range<T>(json.get<std::int64_t>());
  if (!fits) throw std::runtime_error(JsonText(json) + " is not a number that can stand there");
  return json.get<T>();
}

CropWindow WindowFrom(const Json& json) {
  const CropWindow window = {Whole<int>(json.at(0)), Whole<int>(json.at(1)), Whole<int>(json.at(2)),
                             Whole<int>(json.at(3))};
  const auto fits = [](int first, int count) {
    return first >= 0 && count > 0 && first < kMostPixelsASide && count <= kMostPixelsASide;
  };
  if (!fits(window.x, window.width) || !fits(window.y, window.height)) {
    throw std::runtime_error("a window is not on a film");
  }
  return window;
}

SampleRange RangeFrom(const Json& json) {
  const SampleRange range = {Whole<std::uint32_t>(json.at(0)), Whole<std::uint32_t>(json.at(1))};
  if (range.first > range.end) throw std::runtime_error("a range of samples ends before it begins");
  return range;
}

AovSet LayersFrom(const Json& json) {
  const std::string names = json.get<std::string>();
  if (names.empty()) return 0;
  const std::optional<AovSet> layers = ParseAovs(names);
  if (!layers) throw std::runtime_error("unknown layers " + names);
  return *layers;
}

std::vector<std::uint32_t> NumbersFrom(const Json& runs) {
  constexpr std::size_t kMostNumbers = std::size_t{1} << 26;  // no film has more blocks
  std::vector<std::uint32_t> numbers;
  for (std::size_t i = 0; i < runs.size(); i += 2) {
    const auto more = Whole<std::uint32_t>(runs.at(i + 1));
    if (numbers.size() + more > kMostNumbers) throw std::runtime_error("a run is too long");
    numbers.insert(numbers.end(), more, Whole<std::uint32_t>(runs.at(i)));
  }
  return numbers;
}

PictureIdentity IdentityFrom(const Json& json) {
  const auto hash = [](const Json& text) {
    return std::stoull(text.get<std::string>(), nullptr, 16);
  };
  PictureIdentity identity = {.software = json.at("software"),
                              .scene = json.at("scene"),
                              .scene_hash = hash(json.at("scene_hash")),
                              .map_hash = hash(json.at("map_hash")),
                              .film = WindowFrom(json.at("film")),
                              .samples = Whole<std::uint32_t>(json.at("samples")),
                              .seed = Whole<std::uint32_t>(json.at("seed")),
                              .repeatable = json.at("repeatable"),
                              .options = {},
                              .backplate = json.value("backplate", "")};
  for (const Json& option : json.at("options")) {
    identity.options.push_back({.name = option.at("name"),
                                .words = option.at("words"),
                                .is_input = option.at("is_input")});
  }
  return identity;
}

FilmFile FileFrom(const Json& json) {
  FilmFile file = {.identity = IdentityFrom(json.at("picture")),
                   .window = WindowFrom(json.at("window")),
                   .holds = {},
                   .layers = LayersFrom(json.at("layers")),
                   .seconds = json.at("seconds")};
  for (const Json& part : json.at("holds")) {
    file.holds.push_back({WindowFrom(part.at("window")), RangeFrom(part.at("samples"))});
  }
  if (const auto found = json.find("checkpoint"); found != json.end()) {
    file.is_checkpoint = true;
    file.samples = RangeFrom(found->at("samples"));
    file.state = {.step = RangeFrom(found->at("step")),
                  .tile_side = Whole<std::uint32_t>(found->at("tile_side")),
                  .rows = {},
                  .ended = {}};
    if (const auto ended = found->find("ended"); ended != found->end()) {
      file.state.ended = NumbersFrom(*ended);
    }
    for (const Json& rows : found->at("rows")) {
      file.state.rows.push_back(Whole<std::uint64_t>(rows));
    }
  }
  return file;
}

// Throws unless all that a manifest speaks of lies within what it lies in, so that nobody who uses
// the film has to ask.
void CheckWithin(const FilmFile& file, AovSet kept) {
  const auto check = [](const CropWindow& inner, const CropWindow& outer) {
    const auto fits = [](int first, int count, int all_first, int all) {
      return first >= all_first && first + count <= all_first + all;
    };
    if (!fits(inner.x, inner.width, outer.x, outer.width) ||
        !fits(inner.y, inner.height, outer.y, outer.height)) {
      throw std::runtime_error("a window is not within the one around it");
    }
  };
  check(file.window, file.identity.film);
  for (const PicturePart& part : file.holds) {
    check(part.window, file.window);
    if (part.samples.end > file.identity.samples) {
      throw std::runtime_error("a part has samples that the picture does not have");
    }
  }
  if ((LayersToResolve(file.layers, file.identity) & ~kept) != 0)
    throw std::runtime_error("a layer is to be shown but not kept");
}

std::shared_ptr<const Mattes> MattesFrom(const Json& sums) {
  const auto found = sums.find("mattes");
  if (found == sums.end() || found->is_null()) return nullptr;
  const auto names = [&](const char* of) {
    return MakeMatteNames(found->at(of).get<std::vector<std::string>>());
  };
  return std::make_shared<Mattes>(Mattes{names("meshes"), names("materials")});
}

FilmLayout LayoutFrom(const Json& sums, const CropWindow& window) {
  return {
      .area = {window.width, window.height, {0, 0, window.width, window.height}},
      .brightest_radiance = std::bit_cast<float>(Whole<std::uint32_t>(sums.at("brightest_bits"))),
      .aovs = LayersFrom(sums.at("layers")),
      .world_extent = std::bit_cast<float>(Whole<std::uint32_t>(sums.at("extent_bits"))),
      .shared = sums.at("splats"),
      .light_groups = sums.at("light_groups").get<std::vector<std::string>>(),
      .has_signs = sums.at("signs"),
      .mattes = MattesFrom(sums)};
}

// Returns the packed size of a film without making it: a file that is not what it says does not
// exhaust the memory.
double PackedBytes(FilmLayout layout) {
  const double pixels = double(layout.area.width) * layout.area.height;
  layout.area = {1, 1, {0, 0, 1, 1}};
  return pixels * double(Film(std::move(layout)).packed_bytes());
}

void Append(std::string& bytes, std::uint64_t number) {
  bytes.append(reinterpret_cast<const char*>(&number), sizeof number);
}

std::uint64_t NumberAt(std::string_view bytes, std::size_t offset) {
  std::uint64_t number = 0;
  std::memcpy(&number, bytes.data() + offset, sizeof number);
  return number;
}

}  // namespace

void WriteFilm(const std::string& path, const FilmFile& file, const Film& film) {
  const std::string manifest = JsonText(Manifest(file, film), 1);
  const std::unique_ptr<XXH64_state_t, decltype(&XXH64_freeState)> hash(XXH64_createState(),
                                                                        &XXH64_freeState);
  if (!hash) throw std::bad_alloc();
  XXH64_reset(hash.get(), 0);
  WriteFileInPieces(path, [&](const PieceWriter& out) {
    const auto write = [&](std::string_view bytes) {
      XXH64_update(hash.get(), bytes.data(), bytes.size());
      out(bytes);
    };
    std::string start(kMagic);
    Append(start, manifest.size());
    write(start);
    write(manifest);
    film.PackPicture(write);
    std::string end;
    Append(end, XXH64_digest(hash.get()));
    out(end);
  });
  SyncFolderOf(path);
}

FilmInFile ReadFilm(const std::string& path) { return ParseFilm(ReadFile(path, kMostBytes), path); }

FilmInFile ParseFilm(std::string_view bytes, const std::string& path) {
  const auto refuse = [&](std::size_t offset, const std::string& why) -> InputError {
    return InputError(InputPosition::Byte(path, offset), why);
  };
  if (!bytes.starts_with(kMagic)) throw refuse(0, "is not a film of skywave");
  if (bytes.size() < kHeaderBytes + sizeof(std::uint64_t)) {
    throw refuse(bytes.size(), "the film ends too early");
  }
  const std::size_t body = bytes.size() - sizeof(std::uint64_t);
  if (NumberAt(bytes, body) != XXH64(bytes.data(), body, 0)) {
    throw refuse(body, "the film is torn or was changed: its checksum is another one");
  }
  const std::uint64_t manifest_bytes = NumberAt(bytes, kMagic.size());
  if (manifest_bytes > body - kHeaderBytes) throw refuse(kMagic.size(), "the manifest is too long");
  const std::size_t sums = kHeaderBytes + std::size_t(manifest_bytes);
  try {
    const Json json = ParseOrderedJson(bytes.substr(kHeaderBytes, sums - kHeaderBytes));
    if (json.at("format") != kFormat) {
      throw refuse(kHeaderBytes, fmt::format("is a film of format {}, and this program knows {}",
                                             JsonText(json.at("format")), kFormat));
    }
    FilmFile file = FileFrom(json);
    if (json.at("sums").at("bytes") != body - sums) {
      throw refuse(sums, "the film has another number of sums than its manifest says");
    }
    FilmLayout layout = LayoutFrom(json.at("sums"), file.window);
    CheckWithin(file, layout.aovs);
    if (Sums(layout.aovs, AovSum::kMatte) && !layout.mattes) {
      throw std::runtime_error("mattes without names");
    }
    if (PackedBytes(layout) != double(body - sums)) {
      throw refuse(sums, "the film has another number of sums than its window and layers need");
    }
    Film film(std::move(layout));
    film.UnpackPicture(bytes.substr(sums, body - sums));
    return {std::move(file), std::move(film)};
  } catch (const InputError&) {
    throw;
  } catch (const std::exception& error) {
    throw refuse(kHeaderBytes, fmt::format("the manifest cannot be used: {}", error.what()));
  }
}

}  // namespace skywave
