// Tests renders whose blocks of pixels end apart: which bits they have, and that no block is too
// dark because it ended where its samples happened to look good.
#include "wavefront/adaptive.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <bit>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <limits>
#include <set>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "base/error.h"
#include "job/limits.h"
#include "job/session.h"
#include "tests/support/painted_scene.h"
#include "tests/support/render_scenes.h"
#include "tests/support/temporary_folder.h"

namespace skywave {
namespace {

constexpr double kError = 0.05;
constexpr std::uint32_t kMost = 128, kLeast = 8;

RenderLimits Limits(double error = kError) { return {.adaptive = error, .adaptive_min = kLeast}; }

JobRequest Request() {
  JobRequest request = SmallRequest(61, 43, kMost);
  request.max_depth = 3;
  request.options.aovs = *ParseAovs("coverage,samples,variance");
  request.options.wave = 256;
  return request;
}

RenderedFilm Rendered(const JobRequest& request, const SessionRequest& session) {
  const RenderJob job(PaintedScene(), request);
  return RunSession(job, IdentityOf(job, {}, true, session.limits), session);
}

std::vector<std::uint32_t> CountsOf(const RenderedFilm& rendered) {
  const FilmArea& area = rendered.film.layout().area;
  std::vector<std::uint32_t> counts;
  for (int i = 0; i < area.width * area.height; ++i) {
    counts.push_back(std::uint32_t(rendered.samples[std::size_t(i)]));
  }
  return counts;
}

TEST(Adaptive, PicturesDoNotDependOnThreadsWavesAndSteps) {
  const RenderedFilm first = Rendered(Request(), {.limits = Limits()});
  const std::vector<std::uint32_t> counts = CountsOf(first);
  EXPECT_GE(std::set(counts.begin(), counts.end()).size(), 4u) << "blocks end at different looks";
  EXPECT_EQ(*std::min_element(counts.begin(), counts.end()), kLeast);
  EXPECT_LE(*std::max_element(counts.begin(), counts.end()), kMost);
  for (const std::uint32_t wave : {16u, 2048u}) {
    JobRequest request = Request();
    request.options.wave = wave, request.options.threads = 1;
    const RenderedFilm other = Rendered(request, {.limits = Limits()});
    EXPECT_TRUE(other.film.PackPicture() == first.film.PackPicture()) << wave;
    EXPECT_EQ(CountsOf(other), counts);
  }
}

TEST(Adaptive, StepsBetweenTheLooksDoNotMatter) {
  const RenderJob job(PaintedScene(), Request());
  const FrameView frame = job.frame();
  std::string expected;
  for (const bool more : {false, true}) {
    Film film = job.MakeFilm();
    RenderControl control;
    control.end_blocks = [&](RenderState& state) {
      EndBlocks(Limits(), {0, kMost}, frame, film, state);
    };
    control.next_stop = [&](std::uint32_t done) {
      return done < kLeast ? kLeast : more ? done + std::bit_floor(done) / 2 : 2 * done;
    };
    RenderFrame(frame, film, control);
    if (!more) expected = film.PackPicture();
    EXPECT_TRUE(film.PackPicture() == expected);
  }
}

TEST(Adaptive, PixelsHaveTheFirstSamplesOfThePicture) {
  const RenderedFilm adaptive = Rendered(Request(), {.limits = Limits()});
  double in_mean = 0;
  for (const std::uint32_t count : {kLeast, 4 * kLeast, kMost}) {
    JobRequest request = Request();
    const RenderedFilm plain = Rendered(request, {.limits = {.samples = SampleRange{0, count}}});
    std::size_t pixels = 0;
    for (std::size_t i = 0; i < plain.film.sums().size(); ++i) {
      if (adaptive.samples[i / 3] != count) continue;
      ++pixels;
      ASSERT_EQ(adaptive.film.sums()[i], plain.film.sums()[i]) << count << ", " << i;
    }
    EXPECT_GT(pixels, 0u);
  }
  // The layer `samples` has the pixel's own number, by which its values have been divided.
  const std::vector<NamedChannel> layers = adaptive.film.ResolveAovs(adaptive.samples);
  for (const NamedChannel& layer : layers) {
    if (layer.name == "coverage.V") {
      EXPECT_LE(*std::max_element(layer.values.begin(), layer.values.end()), 1);
    }
    if (layer.name != "samples.V") continue;
    for (const float n : layer.values) in_mean += n;
    in_mean /= double(layer.values.size());
  }
  EXPECT_NEAR(adaptive.frame.mean_samples_per_pixel, in_mean, 1e-4);
  EXPECT_EQ(adaptive.frame.stats.samples, std::uint64_t(std::llrint(in_mean * 61 * 43)));
  EXPECT_GT(adaptive.frame.ended_blocks, 0);
  EXPECT_LT(adaptive.frame.ended_blocks, 1);
}

TEST(Adaptive, GoesOnFromACheckpointToTheSameBytes) {
  const TemporaryFolder folder;
  for (const auto& crop : {std::optional<CropWindow>(), std::optional(CropWindow{7, 5, 46, 33})}) {
    JobRequest request = Request();
    request.crop = crop;
    std::atomic<int> tiles = 0;
    SessionRequest counting = {.limits = Limits()};
    counting.on_tile = [&](const Film&, const Tile&, const SampleCounts&) { ++tiles; };
    const RenderedFilm whole = Rendered(request, counting);
    std::set<std::size_t> ended;
    for (const double share : {0.1, 0.4, 0.7, 0.9}) {
      const std::string path = folder.Path("a.checkpoint");
      std::filesystem::remove(path);
      SessionRequest session = {.limits = Limits(), .checkpoint = {.path = path, .resume = true}};
      std::atomic<int> left = int(share * tiles);
      session.on_tile = [&](const Film&, const Tile&, const SampleCounts&) {
        if (--left == 0) throw std::runtime_error("enough");
      };
      EXPECT_THROW(Rendered(request, session), std::runtime_error) << share;
      const RenderState state = ReadFilm(path).file.state;
      ended.insert(std::size_t(
          std::count_if(state.ended.begin(), state.ended.end(), [](auto n) { return n != 0; })));
      session.on_tile = {};
      JobRequest other = request;
      other.options.threads = 1, other.options.wave = 1024;
      const RenderedFilm resumed = Rendered(other, session);
      EXPECT_TRUE(resumed.film.PackPicture() == whole.film.PackPicture()) << share;
      EXPECT_EQ(CountsOf(resumed), CountsOf(whole));
      EXPECT_EQ(resumed.part.samples, whole.part.samples);
    }
    EXPECT_GE(ended.size(), 3u) << "it is stopped between different looks";
  }
}

TEST(Adaptive, TilesAreReportedWithTheSamplesOfTheirPixels) {
  SessionRequest session = {.limits = Limits()};
  JobRequest request = Request();
  request.options.aovs = *ParseAovs("coverage");
  std::atomic<int> wrong = 0, mixed = 0;
  session.on_tile = [&](const Film& film, const Tile& tile, const SampleCounts& samples) {
    const FilmArea& area = film.layout().area;
    const CropWindow window =
        Intersection({int(tile.x), int(tile.y), int(tile.width), int(tile.height)}, area.picture);
    const SampleCounts counts = samples.Cut(window, area.width);
    const Film cut = film.Cut(window);
    const std::vector<float> shares = cut.ResolveAovs(counts, *ParseAovs("coverage"))[0].values;
    const std::vector<float> numbers = cut.ResolveAovs(counts, *ParseAovs("samples"))[0].values;
    // The floor is seen in the lower half of the picture, and in every sample.
    for (int y = std::max(24 - window.y, 0); y < window.height; ++y) {
      for (int x = 0; x < window.width; ++x)
        wrong += shares[std::size_t(y * window.width + x)] != 1;
    }
    mixed += std::set(numbers.begin(), numbers.end()).size() > 1;
  };
  Rendered(request, session);
  EXPECT_EQ(wrong, 0);
  EXPECT_GT(mixed, 0);
}

TEST(Adaptive, EndsAtTheRequestedError) {
  double before = 0;
  for (const double error : {0.4, 0.2, 0.1}) {
    JobRequest request = Request();
    request.samples_per_pixel = 1u << 20;
    const RenderedFilm rendered = Rendered(request, {.limits = Limits(error)});
    EXPECT_EQ(rendered.frame.ended_blocks, 1);
    EXPECT_GT(rendered.frame.mean_samples_per_pixel, before);
    before = rendered.frame.mean_samples_per_pixel;
    EXPECT_LT(*rendered.noise, 2 * error);
  }
}

TEST(Adaptive, UnsuitableIntegratorsAndMergedFilmsAreRefused) {
  for (const Integrator integrator : ValuesOf<Integrator>()) {
    SCOPED_TRACE(ToString(integrator));
    if (integrator == Integrator::kPath || integrator == Integrator::kDirect) {
      EXPECT_EQ(LayersForLimits(Limits(), integrator), *ParseAovs("variance"));
    } else {
      EXPECT_THROW(LayersForLimits(Limits(), integrator), OptionError);
    }
  }
  const TemporaryFolder folder;
  const RenderJob job(PaintedScene(), Request());
  const PictureIdentity identity = IdentityOf(job, {}, true, Limits());
  const RenderedFilm rendered = RunSession(job, identity, {.limits = Limits()});
  EXPECT_THROW(WriteFilm(folder.Path("a.film"), identity, 0, rendered), InputError);
  EXPECT_NE(RepeatCommand(identity, rendered.part).find(" --adaptive 0.05 --adaptive-min 8"),
            std::string::npos);
  EXPECT_NE(Difference(identity, IdentityOf(job, {}, true)), "");
}

// The fewest samples for an error, by the formula of the header: every pixel has two samples, m (1
// + d) and m (1 - d), whose variance is 2 (m d)^2.
TEST(WantedSamples, AreTheFewestForTheError) {
  constexpr int kWidth = 256, kHeight = 96, kAcross = kWidth / 4, kDown = kHeight / 2;
  // The left half is bright and the right half is not, and the lower half is noisier.
  const auto mean_at = [](int x) { return x < kWidth / 2 ? 1.0f : 0.01f; };
  const auto spread_at = [](int y) { return y < kHeight / 2 ? 0.25f : 0.75f; };
  Film film(kWidth, kHeight, 4, *ParseAovs("variance"), 1);
  const soa::Table<PathColumns> paths(kWidth * kHeight);
  RenderStats stats;
  for (const float sign : {-1.0f, 1.0f}) {
    for (int i = 0; i < kWidth * kHeight; ++i) {
      const float value = mean_at(i % kWidth) * (1 + sign * spread_at(i / kWidth));
      paths->pixel[i] = std::uint32_t(i), paths->sample[i] = sign > 0;
      paths->r[i] = paths->g[i] = paths->b[i] = value;
    }
    film.Add(paths, kWidth * kHeight, stats);
  }
  const std::vector<double> wanted = WantedSamples(film, 2, 0.1);
  ASSERT_EQ(wanted.size(), std::size_t(kAcross * kDown));
  // Both colours have as many blocks of each kind.
  const double darkest = 0.1 * (1 + 0.01) / 2;
  const auto relative = [&](int x, int y) {
    const double mean = mean_at(4 * x), deviation = std::sqrt(2.0) * mean * spread_at(2 * y);
    return deviation / std::sqrt(mean * mean + darkest * darkest);
  };
  double sum = 0;
  for (int y = 0; y < kDown; ++y) {
    for (int x = 0; x < kAcross; ++x) sum += relative(x, y) / (kAcross * kDown);
  }
  for (int y = 0; y < kDown; ++y) {
    for (int x = 0; x < kAcross; ++x) {
      // Blocks at the borders of the halves see both, and weigh a few percent in
      // the sum.
      if (x == kAcross / 2 - 1 || x == kAcross / 2 || std::abs(2 * y + 1 - kDown) < 5) continue;
      const double expected = relative(x, y) * sum / (0.1 * 0.1);
      EXPECT_NEAR(wanted[std::size_t(y * kAcross + x)] / expected, 1, 0.07) << x << ", " << y;
    }
  }
}

// What a block should have is a matter of the blocks of the other colour alone, in the whole
// picture too: blocks of its own colour may be brighter and noisier, and nothing changes.
TEST(WantedSamples, DoNotDependOnBlocksOfTheSameColour) {
  constexpr int kWidth = 32, kHeight = 24, kAcross = kWidth / 4;
  const auto wanted_with = [](int changed, float factor) {
    Film film(kWidth, kHeight, 64, *ParseAovs("variance"), 1);
    const soa::Table<PathColumns> paths(kWidth * kHeight);
    RenderStats stats;
    for (const std::uint32_t sample : {0u, 1u}) {
      for (int i = 0; i < kWidth * kHeight; ++i) {
        const int x = i % kWidth, y = i / kWidth, color = (x / 4 + y / 2) % 2;
        const float level = x < kWidth / 2 ? 0.05f : 1.0f;
        float value = level * (1 + 0.5f * float((i + 3 * int(sample)) % 7));
        if (color == changed && sample == 1) value *= factor;
        paths->pixel[i] = std::uint32_t(i), paths->sample[i] = sample;
        paths->r[i] = paths->g[i] = paths->b[i] = value;
      }
      film.Add(paths, kWidth * kHeight, stats);
    }
    return WantedSamples(film, 2, 0.1);
  };
  const std::vector<double> before = wanted_with(0, 1);
  for (const int changed : {0, 1}) {
    const std::vector<double> after = wanted_with(changed, 9);
    for (std::size_t i = 0; i < before.size(); ++i) {
      const int color = int(i % kAcross + i / kAcross) % 2;
      if (color == changed) {
        ASSERT_EQ(after[i], before[i]) << i;
      } else {
        ASSERT_NE(after[i], before[i]) << i;
      }
    }
  }
}

// A floor that fills the picture. Directions come from its BSDF alone, so the sun, which gives most
// of the light, is met by about one in 700 samples.
RenderJob Floor(bool spiky, std::string_view strategy, std::uint32_t seed, std::uint32_t samples) {
  Scene scene;
  Place(scene, Quad(4), AddLambert(scene, "floor", glm::vec3(0.5f)), {0, 0, 0}, 0);
  scene.camera = LookAtCamera({0, 1, 0}, {0, 0, 0}, {0, 0, 1}, 60, false);
  SetLight(scene, SkyWithSun(128, 64, spiky ? 500 : 1, spiky ? 0.06 : 0.4));
  JobRequest request = SmallRequest(32, 24, samples);
  request.integrator = Integrator::kDirect;
  request.strategy = strategy;
  request.options.seed = seed;
  return RenderJob(std::move(scene), request);
}

double MeanOf(const Image& image) {
  double sum = 0;
  for (const float x : image.rgb) sum += x;
  return sum / double(image.rgb.size());
}

// A rule that ends blocks (RenderControl::end_blocks).
using Rule = std::function<void(const FrameView& frame, const Film& film, RenderState& state)>;

// Looks after `least` samples and whenever they have doubled.
bool IsLook(std::uint32_t done, std::uint32_t least) {
  return done >= least && std::has_single_bit(done / least) && done % least == 0;
}

// Ends blocks once what is within `reach` blocks of them, themselves included, looks good enough.
Rule JudgingThemselves(double error, std::uint32_t least, int reach) {
  return [=](const FrameView& frame, const Film& film, RenderState& state) {
    const std::uint32_t done = state.step.first;
    if (!IsLook(done, least)) return;
    state.ended.resize(CountBlocks(frame.camera));
    const SampleCounts samples = SamplesByPixel(frame, state);
    const int across = film.layout().area.width / 4;
    for (int i = 0; i < int(state.ended.size()); ++i) {
      const int x = i % across - reach, y = i / across - reach, side = 2 * reach + 1;
      const NoiseSums sums = film.SumNoise({4 * x, 2 * y, 4 * side, 2 * side}, samples);
      const double of_samples = std::sqrt(sums.variance * sums.values) / sums.mean;
      std::uint32_t& ended = state.ended[std::size_t(i)];
      if (ended == 0 && of_samples / std::sqrt(done) <= error) ended = done;
    }
  };
}

Rule Ours(double error) {
  return [error](const FrameView& frame, const Film& film, RenderState& state) {
    EndBlocks(Limits(error), {0, 1024}, frame, film, state);
  };
}

// How many standard errors the mean of the pictures of many seeds is off, and how large that is.
struct Bias {
  double relative = 0, standard_errors = 0, samples = 0;
};

Bias Measure(bool spiky, const Rule& rule, std::uint32_t seeds) {
  const RenderJob exact = Floor(spiky, "importance", 1, 4096);
  Film film = exact.MakeFilm();
  RenderFrame(exact.frame(), film);
  const double reference = MeanOf(film.Resolve(std::uint64_t{4096}));
  double sum = 0, squares = 0, samples = 0;
  for (std::uint32_t seed = 0; seed < seeds; ++seed) {
    const RenderJob job = Floor(spiky, "bsdf", 100 + seed, 1024);
    Film of_seed = job.MakeFilm(*ParseAovs("variance"));
    const FrameView frame = job.frame();
    RenderState state;
    RenderControl control;
    control.end_blocks = [&](RenderState& at) { rule(frame, of_seed, at); };
    control.next_stop = [](std::uint32_t done) { return std::max(2 * done, 4u); };
    samples += RenderFrame(frame, of_seed, state, control).mean_samples_per_pixel / seeds;
    const double mean = MeanOf(of_seed.Resolve(SamplesByPixel(frame, state))) / reference - 1;
    sum += mean, squares += mean * mean;
  }
  const double mean = sum / seeds, variance = (squares / seeds - mean * mean) / (seeds - 1);
  return {.relative = mean, .standard_errors = mean / std::sqrt(variance), .samples = samples};
}

constexpr std::uint32_t kSeeds = 48;

TEST(Adaptive, HasNoBiasThatManyRunsCouldFind) {
  for (const bool spiky : {false, true}) {
    SCOPED_TRACE(spiky ? "spiky" : "flat");
    const Bias bias = Measure(spiky, Ours(spiky ? 1 : 0.05), kSeeds);
    EXPECT_LT(std::abs(bias.standard_errors), 3) << bias.relative;
    EXPECT_LT(bias.samples, 256) << "blocks do end";
    EXPECT_GT(bias.samples, 2 * kLeast) << "and not all at once";
  }
}

// It is not chance that keeps the test above green: it is red for blocks that go by what they have
// seen themselves. More samples before the first look and neighbours do not mend that.
TEST(Adaptive, TheSameRunsFindTheBiasOfBlocksThatJudgeThemselves) {
  for (const auto& [least, reach] : {std::pair(4u, 0), std::pair(16u, 1)}) {
    const Bias bias = Measure(true, JudgingThemselves(1, least, reach), kSeeds);
    EXPECT_LT(bias.standard_errors, -6) << bias.relative;
    EXPECT_LT(bias.samples, 512);
  }
}

// With an error that everything has, all blocks end at their first look.
TEST(Adaptive, BlocksEndAtTheLeastSamplesRequested) {
  for (const std::uint32_t least : {5u, 12u}) {
    const RenderedFilm rendered =
        Rendered(Request(), {.limits = {.adaptive = 1000, .adaptive_min = least}});
    const std::vector<std::uint32_t> counts = CountsOf(rendered);
    EXPECT_EQ(std::set(counts.begin(), counts.end()), std::set<std::uint32_t>{least});
    EXPECT_EQ(rendered.frame.ended_blocks, 1);
  }
}

TEST(Adaptive, MeansOfCropsAreThoseOfTheirPixels) {
  JobRequest request = Request();
  request.crop = CropWindow{7, 5, 46, 33};
  const RenderedFilm rendered = Rendered(request, {.limits = Limits()});
  double in_mean = 0;
  std::size_t pixels = 0;
  for (const NamedChannel& layer : rendered.film.ResolveAovs(rendered.samples)) {
    if (layer.name != "samples.V") continue;
    pixels = layer.values.size();
    for (const float n : layer.values) in_mean += n / double(pixels);
  }
  ASSERT_EQ(pixels, 46u * 33);
  EXPECT_NEAR(rendered.frame.mean_samples_per_pixel, in_mean, 1e-4);
  EXPECT_EQ(rendered.frame.stats.samples, std::uint64_t(std::llrint(in_mean * 46 * 33)));
}

}  // namespace
}  // namespace skywave
