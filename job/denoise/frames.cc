#include "job/denoise/frames.h"

#include <fmt/format.h>
#include <tbb/enumerable_thread_specific.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

#include "base/error.h"
#include "job/denoise/candidate.h"
#include "kernels/cross_filter.h"

namespace skywave {
namespace {

// How far from where it began flow there and back may end [pixels], and how much more by its
// length. Flow is that of the sample nearest to the middle of a pixel.
constexpr float kAstray = 0.5f, kAstrayByLength = 0.05f;

constexpr float kLost = std::numeric_limits<float>::quiet_NaN();

// Where another frame shows what pixels of this one see [pixels of its film, from the top left],
// by pixel; kLost: nowhere.
struct Places {
  std::vector<float> x, y;
};

std::size_t PixelAt(const PlaneShape& shape, float x, float y) {
  return std::size_t(y) * std::size_t(shape.width) + std::size_t(x);
}

bool IsInside(const PlaneShape& shape, float x, float y) {
  return x >= 0 && y >= 0 && x < float(shape.width) && y < float(shape.height);
}

Places PlacesHere(const PlaneShape& shape) {
  const std::size_t pixels = std::size_t(shape.width) * std::size_t(shape.height);
  Places places = {std::vector<float>(pixels), std::vector<float>(pixels)};
  for (std::size_t pixel = 0; pixel < pixels; ++pixel) {
    places.x[pixel] = float(pixel % std::size_t(shape.width)) + 0.5f;
    places.y[pixel] = float(pixel / std::size_t(shape.width)) + 0.5f;
  }
  return places;
}

// Goes one frame further, by the flow of the frame that the places are in, which is led back by
// that of the next one.
void Follow(const PlaneShape& shape, const FrameFlow& flow, const FrameFlow& back, Places& places) {
  if (flow.known.empty()) return;
  ForEachPixel(shape, [&](std::size_t pixel, std::size_t) {
    float &x = places.x[pixel], &y = places.y[pixel];
    if (std::isnan(x)) return;
    const std::size_t from = PixelAt(shape, x, y);
    const float dx = flow.x[from], dy = flow.y[from];
    x += dx, y += dy;
    bool is_known = flow.known[from] > 0 && IsInside(shape, x, y);
    if (is_known) {
      const std::size_t to = PixelAt(shape, x, y);
      const float astray = std::hypot(dx + back.x[to], dy + back.y[to]);
      is_known = back.known[to] > 0 && astray <= kAstray + kAstrayByLength * std::hypot(dx, dy);
    }
    if (!is_known) x = y = kLost;
  });
}

// The values of a plane between the centres of four pixels.
struct Between {
  Between(const PlaneShape& shape, float x, float y) : pitch(shape.pitch()) {
    const float left = std::clamp(x - 0.5f, 0.0f, float(shape.width - 1));
    const float top = std::clamp(y - 0.5f, 0.0f, float(shape.height - 1));
    at = shape.at(int(left), int(top));
    u = left - std::floor(left), v = top - std::floor(top);
  }
  float Of(const float* plane) const {
    const float* const corner = plane + at;
    const float above = corner[0] + u * (corner[1] - corner[0]);
    const float below = corner[pitch] + u * (corner[pitch + 1] - corner[pitch]);
    return above + v * (below - above);
  }

  std::size_t at, pitch;
  float u, v;
};

constexpr PlaneShape kTileShape = {FilterTile::kWidth, FilterTile::kHeight};

// What other frames show of the tile that a thread is at.
struct BroughtTiles {
  std::vector<BroughtTile> tiles;

  void Resize(std::size_t frames) {
    const auto rows = std::uint32_t(kTileShape.size());
    for (std::size_t i = tiles.size(); i < frames; ++i) {
      const FeaturePlanes of_features = features.emplace_back(rows);
      const HalfPlanes first = halves.emplace_back(rows), second = halves.emplace_back(rows);
      tiles.push_back({kTileShape, of_features, {first, second}});
    }
  }

 private:
  // Their memory.
  std::vector<soa::Table<FeaturePlanes>> features;
  std::vector<soa::Table<HalfPlanes>> halves;
};

// What an other frame shows, and where.
struct OtherFrame {
  const CleanFrame* frame;
  Places places;
};

// Writes what another frame shows of a tile of `here`, and one pixel around it.
void Bring(const CleanFrame& here, const OtherFrame& other, const FilterTile& tile,
           const BroughtTile& to) {
  const CleanFrame& frame = *other.frame;
  const Places& places = other.places;
  const PlaneShape& shape = here.planes.shape;
  // The light of each frame is in units of its own brightness.
  const float scale = frame.planes.brightness / here.planes.brightness;
  const std::vector<float*> features = ColumnsOf(frame.planes.features.columns());
  const std::vector<float*> brought = ColumnsOf(to.features);
  for (int y = -1; y <= tile.height; ++y) {
    for (int x = -1; x <= tile.width; ++x) {
      const std::size_t there = kTileShape.at(x, y);
      const int px = std::clamp(tile.x + x, 0, shape.width - 1);
      const int py = std::clamp(tile.y + y, 0, shape.height - 1);
      const std::size_t pixel = std::size_t(py) * std::size_t(shape.width) + std::size_t(px);
      if (std::isnan(places.x[pixel])) {
        to.features.coverage[there] = kNoCoverage;
        // For the tests of the pixels around, it is what it is here.
        for (int h = 0; h < 2; ++h) {
          const HalfPlanes &own = here.halves[h], &half = to.halves[h];
          const std::size_t at = shape.at(px, py);
          half.r[there] = own.r[at], half.g[there] = own.g[at], half.b[there] = own.b[at];
          half.noise[there] = own.noise[at];
        }
        continue;
      }
      const Between between(shape, places.x[pixel], places.y[pixel]);
      for (std::size_t i = 0; i < features.size(); ++i) {
        brought[i][there] = between.Of(features[i]);
      }
      // Things may come nearer; that they are the same is known from the way back.
      if (!here.next.known.empty()) {
        to.features.depth[there] = here.planes.features->depth[shape.at(px, py)];
      }
      for (int h = 0; h < 2; ++h) {
        const HalfPlanes &from = frame.halves[h], &half = to.halves[h];
        half.r[there] = scale * between.Of(from.r);
        half.g[there] = scale * between.Of(from.g);
        half.b[there] = scale * between.Of(from.b);
        half.noise[there] = scale * scale * between.Of(from.noise);
      }
    }
  }
}

// Returns the mean of the excess of outliers, as far as frames show the same.
OutlierExcess AverageExcess(const CleanFrame& here, const std::vector<OtherFrame>& others) {
  const PlaneShape& shape = here.planes.shape;
  OutlierExcess mean = {.outliers = here.outliers.outliers, .spread = {}};
  std::vector<const OtherFrame*> with;
  for (const OtherFrame& other : others) {
    if (other.frame->outliers.outliers != 0) with.push_back(&other);
  }
  if (mean.outliers == 0 && with.empty()) return mean;
  mean.spread = soa::Table<TexturePlanes>(std::uint32_t(shape.size()));
  const TexturePlanes &to = mean.spread, &own = here.outliers.spread;
  ForEachPixel(shape, [&](std::size_t pixel, std::size_t at) {
    float count = 1;
    for (const OtherFrame& other : others) count += float(!std::isnan(other.places.x[pixel]));
    if (own.r != nullptr) to.r[at] = own.r[at], to.g[at] = own.g[at], to.b[at] = own.b[at];
    for (const OtherFrame* other : with) {
      if (std::isnan(other->places.x[pixel])) continue;
      const Between between(shape, other->places.x[pixel], other->places.y[pixel]);
      const TexturePlanes& from = other->frame->outliers.spread;
      to.r[at] += between.Of(from.r);
      to.g[at] += between.Of(from.g);
      to.b[at] += between.Of(from.b);
    }
    to.r[at] /= count, to.g[at] /= count, to.b[at] /= count;
  });
  return mean;
}

// Returns the mean of clean halves with its error. With less noise left than in one frame, bias is
// more of it, and too small to be seen in few pixels.
Candidate WithWideError(const DenoiserPlanes& planes, const HalfTables& halves) {
  Candidate mean = WithError(planes, {halves[0].columns(), halves[1].columns()});
  const soa::Table<ErrorPlanes> wide(std::uint32_t(planes.shape.size()), soa::Touch::kLater);
  EstimateWide(planes, halves, wide);
  const std::vector<float*> errors = ColumnsOf(mean.squared_error.columns());
  const std::vector<float*> least = ColumnsOf(wide.columns());
  for (std::size_t c = 0; c < errors.size(); ++c) {
    ForEachPixel(planes.shape, [&](std::size_t, std::size_t at) {
      errors[c][at] = std::max(errors[c][at], least[c][at]);
    });
  }
  return mean;
}

// Replaces the noise of clean halves by thrice what they differ by around, where that is more.
// Pixels that were averaged with the same ones share their noise, which they do not know of each
// other, and so share the distance from other frames: that of 3 x 3 pixels is that of one, whose
// squares vary. No pixel gets much of what a highlight beside it brings.
void MeasureNoise(const PlaneShape& shape, const HalfTables& halves) {
  constexpr int kAround = 3;        // pixels on each side
  constexpr float kMostShared = 8;  // times the noise that a pixel knows of
  const HalfPlanes &a = halves[0], &b = halves[1];
  std::vector<float> noise(shape.size());
  for (std::size_t at = 0; at < shape.size(); ++at) {
    const float dr = a.r[at] - b.r[at], dg = a.g[at] - b.g[at], db = a.b[at] - b.b[at];
    noise[at] = 1.5f * (dr * dr + dg * dg + db * db);
  }
  AverageAround(shape, kAround, noise);
  for (const HalfPlanes& half : {a, b}) {
    ForEachPixel(shape, [&](std::size_t, std::size_t at) {
      half.noise[at] = std::max(half.noise[at], std::min(noise[at], kMostShared * half.noise[at]));
    });
    RepeatEdge(shape, half.noise);
  }
}

// Returns the flow of a frame to the next one and to the previous one. Throws InputError where only
// some of its channels are there.
std::pair<FrameFlow, FrameFlow> FlowOf(const std::string& name, std::size_t pixels,
                                       std::span<const NamedChannel> layers) {
  std::vector<std::vector<float>> values;
  std::string missing;
  for (const std::string& channel : FlowChannels()) {
    const auto found = std::find_if(layers.begin(), layers.end(), [&](const NamedChannel& layer) {
      return layer.name == channel;
    });
    if (found != layers.end() && found->values.size() == pixels) {
      values.push_back(found->values);
    } else {
      missing = channel;
    }
  }
  if (values.empty()) return {};
  if (!missing.empty()) {
    throw InputError(InputPosition::File(name),
                     fmt::format("has some of the channels of flow and flow-back, and not {}; "
                                 "frames need all of them, or none",
                                 missing));
  }
  return {{values[0], values[1], values[2]}, {values[3], values[4], values[5]}};
}

void CheckAlike(const CleanFrame& frame, const CleanFrame& other) {
  const PlaneShape &a = frame.planes.shape, &b = other.planes.shape;
  if (a.width != b.width || a.height != b.height) {
    throw InputError(InputPosition::File(other.name),
                     fmt::format("has {}x{} pixels, and the frame {} has {}x{}", b.width, b.height,
                                 frame.name, a.width, a.height));
  }
  if (frame.next.known.empty() != other.next.known.empty()) {
    const bool has = !other.next.known.empty();
    throw InputError(InputPosition::File(other.name),
                     fmt::format("has {}, and the frame {} has {}; give all frames the layers flow "
                                 "and flow-back, or none",
                                 has ? "flow" : "no flow", frame.name, has ? "none" : "it"));
  }
}

// Follows what `here` sees through successive frames, `step` apart.
void FollowAll(std::span<const CleanFrame* const> frames, std::size_t here, int step,
               std::vector<OtherFrame>& others) {
  Places places = PlacesHere(frames[here]->planes.shape);
  const auto end = std::ptrdiff_t(frames.size());
  for (auto i = std::ptrdiff_t(here); i + step >= 0 && i + step < end; i += step) {
    const CleanFrame &a = *frames[std::size_t(i)], &b = *frames[std::size_t(i + step)];
    CheckAlike(*frames[here], b);
    Follow(a.planes.shape, step > 0 ? a.next : a.previous, step > 0 ? b.previous : b.next, places);
    others.push_back({&b, places});
  }
}

}  // namespace

std::vector<std::string> FlowChannels() {
  std::vector<std::string> names;
  for (const char* layer : {"flow", "flow-back"}) {
    for (const char letter : {'X', 'Y', 'A'}) names.push_back(fmt::format("{}.{}", layer, letter));
  }
  return names;
}

CleanFrame CleanFrameOf(const std::string& name, const Image& image,
                        std::span<const NamedChannel> layers) {
  const DenoiserInput input = FindInput(name, image, layers);
  auto [next, previous] = FlowOf(name, image.rgb.size() / 3, layers);
  CleanFrame frame = {.name = name,
                      .planes = ReadPlanes(input),
                      .outliers = {},
                      .halves = {},
                      .next = std::move(next),
                      .previous = std::move(previous)};
  frame.outliers = TakeOutliers(input, frame.planes);
  SmoothNoises(input, frame.planes);
  frame.halves = FilterHalves(frame.planes);
  MeasureNoise(frame.planes.shape, frame.halves);
  return frame;
}

Denoised Steady(std::span<const CleanFrame* const> frames, std::size_t here) {
  const CleanFrame& frame = *frames[here];
  const PlaneShape& shape = frame.planes.shape;
  std::vector<OtherFrame> others;
  FollowAll(frames, here, -1, others);
  FollowAll(frames, here, 1, others);

  HalfTables steady = {NewHalf(shape), NewHalf(shape)};
  tbb::enumerable_thread_specific<BroughtTiles> of_threads;
  ForEachTile(shape, [&](const FilterTile& tile) {
    BroughtTiles& brought = of_threads.local();
    brought.Resize(others.size());
    for (std::size_t k = 0; k < others.size(); ++k) {
      Bring(frame, others[k], tile, brought.tiles[k]);
    }
    AverageFrames(shape, frame.planes.features, {frame.halves[0], frame.halves[1]}, brought.tiles,
                  tile, {steady[0].columns(), steady[1].columns()});
  });
  for (const soa::Table<HalfPlanes>& half : steady) RepeatEdges(shape, half);
  const Candidate clean = WithWideError(frame.planes, steady);
  return PictureOf(frame.planes, AverageExcess(frame, others), clean, /*with_error=*/true);
}

}  // namespace skywave
