#include "job/merge_films.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <tuple>
#include <utility>

#include "base/error.h"
#include "job/limits.h"

namespace skywave {
namespace {

// A part is a box of pixels and samples: [low, high) of columns, rows and samples.
struct Box {
  std::array<std::int64_t, 3> low, high;
};

Box BoxOf(const PicturePart& part) {
  const CropWindow& w = part.window;
  return {{w.x, w.y, part.samples.first},
          {std::int64_t{w.x} + w.width, std::int64_t{w.y} + w.height, part.samples.end}};
}

PicturePart PartOf(const Box& box) {
  const auto& [low, high] = box;
  return {{int(low[0]), int(low[1]), int(high[0] - low[0]), int(high[1] - low[1])},
          {std::uint32_t(low[2]), std::uint32_t(high[2])}};
}

bool Meet(const Box& a, const Box& b) {
  for (std::size_t axis = 0; axis < 3; ++axis) {
    if (a.low[axis] >= b.high[axis] || b.low[axis] >= a.high[axis]) return false;
  }
  return true;
}

bool Contains(const Box& outer, const Box& inner) {
  for (std::size_t axis = 0; axis < 3; ++axis) {
    if (inner.low[axis] < outer.low[axis] || inner.high[axis] > outer.high[axis]) return false;
  }
  return true;
}

// Makes one of two parts that lie side by side. Returns false if they do not.
bool Join(PicturePart& a, const PicturePart& b) {
  Box to = BoxOf(a);
  const Box from = BoxOf(b);
  std::size_t differing = 0, axis = 0;
  for (std::size_t i = 0; i < 3; ++i) {
    if (to.low[i] != from.low[i] || to.high[i] != from.high[i]) ++differing, axis = i;
  }
  if (differing != 1 || (to.high[axis] != from.low[axis] && from.high[axis] != to.low[axis])) {
    return false;
  }
  to.low[axis] = std::min(to.low[axis], from.low[axis]);
  to.high[axis] = std::max(to.high[axis], from.high[axis]);
  a = PartOf(to);
  return true;
}

void AddPart(std::vector<PicturePart>& parts, PicturePart part) {
  for (std::size_t i = 0; i < parts.size();) {
    if (Join(part, parts[i])) {
      parts.erase(parts.begin() + std::ptrdiff_t(i));
      i = 0;
    } else {
      ++i;
    }
  }
  parts.push_back(part);
}

// The corner of a film that all machines agree on.
auto FirstCorner(const FilmFile& file) {
  std::tuple<std::uint32_t, int, int> first = {~0u, 0, 0};
  for (const PicturePart& part : file.holds) {
    first = std::min(first, {part.samples.first, part.window.y, part.window.x});
  }
  return first;
}

// Throws InputError unless the film of `path` belongs to the picture of `other`.
void CheckBelongs(const std::string& path, const FilmFile& file, const std::string& other,
                  const FilmFile& picture) {
  const auto refuse = [&](const std::string& why) -> InputError {
    return InputError(InputPosition::File(path), why);
  };
  if (file.is_checkpoint) {
    throw refuse("is a checkpoint of a render that is not finished; finish it by --resume");
  }
  const std::string difference = Difference(file.identity, picture.identity);
  if (!difference.empty()) {
    throw refuse(fmt::format("is of another picture than {}: {}", other, difference));
  }
  if (file.layers != picture.layers) {
    throw refuse(fmt::format("has other layers than {}", other));
  }
}

// Has read one film after the other.
class Merger {
 public:
  Merger(const MergeRequest& request, const std::string& path, const FilmInFile& first)
      : first_path_(path), merged_(Begin(request, first)) {}

  void Add(const std::string& path, const FilmInFile& read) {
    const FilmFile& file = read.file;
    CheckBelongs(path, file, first_path_, merged_.file);
    for (const PicturePart& part : file.holds) {
      CheckWanted(path, part);
      if (read.film.layout().shared) CheckWholeWindow(path, part);
      CheckNew(path, part);
    }
    if (!merged_.film.SumsLike(read.film)) {
      throw InputError(InputPosition::File(path),
                       fmt::format("keeps its sums in other units or layers than {}", first_path_));
    }
    // A film may have room for more than it holds, and what it holds is wanted.
    const CropWindow& wanted = merged_.wanted.window;
    const CropWindow common = Intersection(file.window, wanted);
    if (common.width > 0 && common.height > 0) {
      const CropWindow inside = {common.x - file.window.x, common.y - file.window.y, common.width,
                                 common.height};
      merged_.film.AddPart(read.film.Cut(inside), common.x - wanted.x, common.y - wanted.y);
    }
    for (const PicturePart& part : file.holds) {
      held_.emplace_back(part, path);
      skywave::AddPart(merged_.file.holds, part);
      merged_.missing = Without(merged_.missing, part);
    }
    merged_.file.seconds += file.seconds;
    // Names of files may differ between machines: those of the first corner are recorded.
    if (const auto corner = FirstCorner(file); corner < corner_) {
      corner_ = corner;
      merged_.file.identity = file.identity;
    }
  }

  MergedFilm Take() { return std::move(merged_); }

 private:
  static MergedFilm Begin(const MergeRequest& request, const FilmInFile& first) {
    const PictureIdentity& identity = first.file.identity;
    const PicturePart wanted = {request.window.value_or(identity.film),
                                ChooseSamples({.samples = request.samples}, identity.samples)};
    if (!Contains(BoxOf({identity.film, wanted.samples}), BoxOf(wanted))) {
      throw OptionError("crop", "", "the part that is wanted is not on the film");
    }
    FilmLayout layout = first.film.layout();
    layout.area = {wanted.window.width,
                   wanted.window.height,
                   {0, 0, wanted.window.width, wanted.window.height}};
    return {.file = {.identity = identity,
                     .window = wanted.window,
                     .holds = {},
                     .layers = first.file.layers},
            .film = Film(layout),
            .wanted = wanted,
            .missing = {wanted}};
  }

  void CheckWanted(const std::string& path, const PicturePart& part) const {
    if (Contains(BoxOf(merged_.wanted), BoxOf(part))) return;
    throw InputError(InputPosition::File(path),
                     fmt::format("holds {}, which is not all within what is wanted: {}",
                                 ToString(part), ToString(merged_.wanted)));
  }

  // Light paths bring light to all pixels of the film that they were traced for.
  void CheckWholeWindow(const std::string& path, const PicturePart& part) const {
    if (part.window == merged_.wanted.window) return;
    throw InputError(InputPosition::File(path),
                     fmt::format("holds {}, but pictures with splats of light paths have parts by "
                                 "samples alone: each has to show {}",
                                 ToString(part), ToString(merged_.wanted)));
  }

  void CheckNew(const std::string& path, const PicturePart& part) const {
    for (const auto& [other, holder] : held_) {
      if (!Meet(BoxOf(part), BoxOf(other))) continue;
      throw InputError(InputPosition::File(path),
                       fmt::format("holds {}, of which {} holds {} too: their samples would count "
                                   "twice",
                                   ToString(part), holder, ToString(other)));
    }
  }

  std::string first_path_;
  MergedFilm merged_;
  std::vector<std::pair<PicturePart, std::string>> held_;  // by which film
  std::tuple<std::uint32_t, int, int> corner_ = {~0u, 0, 0};
};

}  // namespace

std::string ToString(const PicturePart& part) {
  const CropWindow& w = part.window;
  return fmt::format("crop {}x{}+{}+{} sample-range {}", w.width, w.height, w.x, w.y,
                     SampleRanges().print(part.samples));
}

std::vector<PicturePart> Without(const std::vector<PicturePart>& parts, const PicturePart& taken) {
  std::vector<PicturePart> left;
  const Box hole = BoxOf(taken);
  for (const PicturePart& part : parts) {
    Box box = BoxOf(part);
    if (!Meet(box, hole)) {
      left.push_back(part);
      continue;
    }
    // What lies below and above the hole is cut off, axis by axis; the rest is in the hole.
    for (std::size_t axis = 3; axis-- > 0;) {
      Box below = box, above = box;
      below.high[axis] = std::min(box.high[axis], hole.low[axis]);
      above.low[axis] = std::max(box.low[axis], hole.high[axis]);
      if (below.low[axis] < below.high[axis]) left.push_back(PartOf(below));
      if (above.low[axis] < above.high[axis]) left.push_back(PartOf(above));
      box.low[axis] = std::max(box.low[axis], hole.low[axis]);
      box.high[axis] = std::min(box.high[axis], hole.high[axis]);
    }
  }
  return left;
}

MergedFilm MergeFilms(const MergeRequest& request) {
  std::optional<Merger> merger;
  for (const std::string& path : request.films) {
    const FilmInFile read = ReadFilm(path);
    if (!merger) merger.emplace(request, path, read);
    merger->Add(path, read);
  }
  return merger->Take();
}

Picture ResolveMerged(const MergedFilm& merged) {
  const std::vector<PicturePart>& missing = merged.missing;
  if (!missing.empty()) {
    std::string names;
    for (std::size_t i = 0; i < std::min<std::size_t>(missing.size(), 3); ++i) {
      names += (i > 0 ? "; " : "") + ToString(missing[i]);
    }
    throw InputError(
        InputPosition::File(merged.file.identity.scene),
        fmt::format(
            "the picture is not complete: no film holds {}{}", names,
            missing.size() > 3 ? fmt::format(", and {} more parts", missing.size() - 3) : ""));
  }
  return ResolvePicture(merged.film, merged.wanted.samples.count(), merged.file.layers,
                        merged.file.identity, merged.wanted);
}

}  // namespace skywave
