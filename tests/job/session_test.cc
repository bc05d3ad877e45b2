// Tests sessions: what ends them, what they keep, and that going on from it gives the same bytes.
#include "job/session.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <memory>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "base/error.h"
#include "base/files.h"
#include "tests/support/painted_scene.h"
#include "tests/support/render_scenes.h"
#include "tests/support/temporary_folder.h"
#include "wavefront/records/photon_map.h"

namespace skywave {
namespace {

constexpr std::uint32_t kSamples = 6;

JobRequest Request() {
  JobRequest request = SmallRequest(37, 29, kSamples);
  request.max_depth = 3;
  request.options.aovs = *ParseAovs("albedo,uv,coverage");
  request.options.wave = 64;  // many small tiles
  return request;
}

RenderJob JobOf(const JobRequest& request) { return RenderJob(PaintedScene(), request); }

PictureIdentity IdentityOf(const RenderJob& job) { return IdentityOf(job, {}, true); }

RenderedFilm Rendered(const JobRequest& request, const SessionRequest& session) {
  const RenderJob job = JobOf(request);
  return RunSession(job, IdentityOf(job), session);
}

// Makes a render take longer than it takes to be watched.
void Rest() { std::this_thread::sleep_for(std::chrono::milliseconds(20)); }

class Session : public testing::Test {
 protected:
  std::string path() const { return folder_.Path("a.checkpoint"); }
  SessionRequest Resuming() const { return {.checkpoint = {.path = path(), .resume = true}}; }
  // Leaves the checkpoint of a render that has ended after some tiles.
  void Interrupt(const JobRequest& request, SessionRequest session, int tiles = 3) {
    session.checkpoint.path = path();
    std::atomic<int> left = tiles;
    session.on_tile = [&left](const Film&, const Tile&, const SampleCounts&) {
      if (--left <= 0) throw std::runtime_error("enough");
    };
    EXPECT_THROW(Rendered(request, session), std::runtime_error);
    ASSERT_TRUE(std::filesystem::exists(path()));
  }
  // Expects that going on is refused with these words, and that the checkpoint stays.
  void ExpectRefused(const JobRequest& request, const SessionRequest& session,
                     const std::string& words) {
    const std::string before = ReadFile(path());
    try {
      Rendered(request, session);
      ADD_FAILURE() << "not refused: " << words;
    } catch (const InputError& error) {
      EXPECT_NE(std::string(error.what()).find(words), std::string::npos) << error.what();
      EXPECT_NE(std::string(error.what()).find(path()), std::string::npos) << error.what();
    }
    EXPECT_TRUE(ReadFile(path()) == before);
  }
  void ExpectRefused(const std::string& words, void (*change)(JobRequest&)) {
    JobRequest request = Request();
    change(request);
    ExpectRefused(request, Resuming(), words);
  }

  TemporaryFolder folder_;
};

TEST_F(Session, RefusesACheckpointOfAnotherPicture) {
  Interrupt(Request(), {});
  const FilmInFile saved = ReadFilm(path());
  ASSERT_FALSE(saved.file.state.rows.empty());
  ExpectRefused("`seed` is 3 here and 0 there", [](JobRequest& r) { r.options.seed = 3; });
  ExpectRefused("`spp` is 7 here and 6 there", [](JobRequest& r) { r.samples_per_pixel = 7; });
  ExpectRefused("`size` is 37x30 here and 37x29 there", [](JobRequest& r) { r.height = 30; });
  ExpectRefused("`integrator` is direct here",
                [](JobRequest& r) { r.integrator = Integrator::kDirect; });
  ExpectRefused("`aovs` is not given here", [](JobRequest& r) { r.options.aovs = 0; });
  ExpectRefused("another part of the film", [](JobRequest& r) {
    r.crop = CropWindow{0, 0, 36, 29};
  });
  SessionRequest of_range = Resuming();
  of_range.limits.samples = SampleRange{0, 5};
  ExpectRefused(Request(), of_range, "samples 0:6, not 0:5");
  SessionRequest of_noise = Resuming();
  of_noise.limits.noise = 0.1;
  ExpectRefused(Request(), of_noise, "other layers");

  const auto expect_edited = [&](const std::string& words, auto change) {
    FilmFile file = saved.file;
    change(file);
    WriteFilm(path(), file, saved.film);
    ExpectRefused(Request(), Resuming(), words);
  };
  expect_edited("it is of skywave 0.0.9",
                [](FilmFile& f) { f.identity.software = "skywave 0.0.9"; });
  expect_edited("the scenes differ", [](FilmFile& f) { f.identity.scene_hash ^= 1; });
  expect_edited("the illumination maps differ", [](FilmFile& f) { f.identity.map_hash ^= 1; });
  expect_edited("finished film", [](FilmFile& f) { f.is_checkpoint = false; });
  const std::string place = "its position does not exist in this render";
  expect_edited(place, [](FilmFile& f) { f.state.rows.pop_back(); });
  expect_edited(place, [](FilmFile& f) { f.state.rows[0] += 1; });
  expect_edited(place, [](FilmFile& f) { f.state.rows[0] = 1u << 20; });
  expect_edited(place, [](FilmFile& f) { f.state.tile_side = 12; });
  expect_edited(place, [](FilmFile& f) { f.state.tile_side = 0; });
  expect_edited(place, [](FilmFile& f) { f.state.step.end = 7; });
  expect_edited(place, [](FilmFile& f) { f.state.ended = {0}; });
  expect_edited(place, [](FilmFile& f) { f.state.ended.assign(10 * 15, 5); });
  WriteFilm(path(), saved.file, saved.film);
  EXPECT_EQ(Rendered(Request(), Resuming()).part.samples, (SampleRange{0, kSamples}));
}

TEST_F(Session, AStoppedSessionIsFinishedByAnotherToTheSameBytes) {
  const RenderJob job = JobOf(Request());
  const PictureIdentity identity = IdentityOf(job);
  const RenderedFilm whole = RunSession(job, identity, {});
  const auto bytes = [&](const RenderedFilm& rendered) {
    WriteExr(folder_.Path("a.exr"), ResolvePicture(rendered.film, rendered.part.samples.count(),
                                                   job.options().aovs, identity, rendered.part));
    return ReadFile(folder_.Path("a.exr"));
  };
  SessionRequest stopped = {.checkpoint = {.path = path()}};
  stopped.tell = [](double) { return false; };
  stopped.on_tile = [](const Film&, const Tile&, const SampleCounts&) { Rest(); };
  EXPECT_THROW(RunSession(job, identity, stopped), RenderCanceled);
  const FilmInFile saved = ReadFilm(path());
  EXPECT_TRUE(saved.file.is_checkpoint);
  EXPECT_FALSE(saved.film.PackPicture() == whole.film.PackPicture());

  JobRequest other = Request();
  other.options.threads = 1, other.options.wave = 2048;
  const RenderJob other_job = JobOf(other);
  EXPECT_EQ(Difference(IdentityOf(other_job), identity), "");
  const RenderedFilm finished = RunSession(other_job, IdentityOf(other_job), Resuming());
  EXPECT_TRUE(bytes(finished) == bytes(whole));
  EXPECT_EQ(RepeatCommand(IdentityOf(other_job), finished.part),
            RepeatCommand(identity, whole.part));
  EXPECT_GT(finished.seconds, saved.file.seconds);
  EXPECT_TRUE(std::filesystem::exists(path())) << "it is the caller's to remove";
}

TEST_F(Session, ResumesACompleteCheckpoint) {
  // A step of path has 20 tiles; each of the six of vcm has 6.
  for (const auto& [integrator, all] :
       {std::pair(Integrator::kPath, 20), std::pair(Integrator::kVcm, 36)}) {
    SCOPED_TRACE(ToString(integrator));
    JobRequest request = Request();
    request.integrator = integrator;
    // It is stopped while the last tile is reported.
    SessionRequest stopped = {.checkpoint = {.path = path()}};
    stopped.tell = [](double done) { return done < 1; };
    std::atomic<int> tiles = all;
    stopped.on_tile = [&tiles](const Film&, const Tile&, const SampleCounts&) {
      if (--tiles == 0) std::this_thread::sleep_for(std::chrono::milliseconds(300));
    };
    EXPECT_THROW(Rendered(request, stopped), RenderCanceled);
    EXPECT_EQ(ReadFilm(path()).file.state.step, (SampleRange{kSamples, kSamples}));
    const RenderedFilm resumed = Rendered(request, Resuming());
    EXPECT_EQ(resumed.part.samples, (SampleRange{0, kSamples}));
    EXPECT_TRUE(resumed.film.PackPicture() == Rendered(request, {}).film.PackPicture());
  }
}

TEST_F(Session, KeepsCheckpointsAndShowsSnapshotsMeanwhile) {
  SessionRequest session = {.checkpoint = {.path = path(), .seconds = 0.001}};
  int seen = 0, shown = 0;
  session.tell = [&](double) {
    if (std::filesystem::exists(path())) seen += ReadFilm(path()).file.is_checkpoint;
    return true;
  };
  session.wants_snapshot = [] { return true; };
  session.show = [&](const Film& film, const SampleCounts& samples) {
    ++shown;
    // A pixel's samples are at least as many as those that hit something.
    const Film part = film;
    for (const NamedChannel& channel : part.ResolveAovs(samples)) {
      if (channel.name != "coverage.V") continue;
      EXPECT_LE(*std::max_element(channel.values.begin(), channel.values.end()), 1);
    }
  };
  session.on_tile = [](const Film&, const Tile&, const SampleCounts&) { Rest(); };
  const RenderedFilm rendered = Rendered(Request(), session);
  EXPECT_GE(seen, 1);
  EXPECT_GE(shown, 1);
  EXPECT_TRUE(rendered.film.PackPicture() == Rendered(Request(), {}).film.PackPicture());
}

TEST_F(Session, ContinuesWhenACheckpointCannotBeWritten) {
  SessionRequest session = {
      .checkpoint = {.path = folder_.Path("missing/a.checkpoint"), .seconds = 0.001}};
  session.tell = [](double) { return true; };
  session.on_tile = [](const Film&, const Tile&, const SampleCounts&) { Rest(); };
  const RenderedFilm rendered = Rendered(Request(), session);
  ASSERT_EQ(rendered.notes.size(), 1u) << "many of them say the same";
  EXPECT_NE(rendered.notes[0].find("missing/a.checkpoint"), std::string::npos);
  EXPECT_TRUE(rendered.film.PackPicture() == Rendered(Request(), {}).film.PackPicture());
  // Whoever stops it has to know.
  session.tell = [](double) { return false; };
  EXPECT_THROW(Rendered(Request(), session), InputError);
}

TEST_F(Session, AnErrorIsReportedEvenIfNoCheckpointCanBeWritten) {
  SessionRequest session = {.checkpoint = {.path = folder_.Path("missing/a.checkpoint")}};
  session.on_tile = [](const Film&, const Tile&, const SampleCounts&) {
    throw std::logic_error("enough");
  };
  EXPECT_THROW(Rendered(Request(), session), std::logic_error);
}

TEST_F(Session, AnErrorBeforeTheFirstWaveLeavesNoCheckpoint) {
  JobRequest request = Request();
  request.integrator = Integrator::kPhoton;
  request.options.of<PhotonOptions>().indirect =
      20'000'000;  // traced for seconds before anything is seen
  SessionRequest session = {.checkpoint = {.path = path()}};
  session.tell = [](double) -> bool { throw std::logic_error("enough"); };
  EXPECT_THROW(Rendered(request, session), std::logic_error);
  EXPECT_FALSE(std::filesystem::exists(path()));
}

TEST_F(Session, EndsByTimeWithSamplesThatACommandRepeats) {
  JobRequest request = Request();
  request.samples_per_pixel = 1000000;
  const RenderJob job = JobOf(request);
  const PictureIdentity identity = IdentityOf(job);
  const RenderedFilm rendered = RunSession(job, identity, {.limits = {.seconds = 0.05}});
  const std::uint32_t samples = rendered.part.samples.end;
  EXPECT_GT(samples, 0u);
  EXPECT_LT(samples, 1000000u);
  const std::string range = "0:" + std::to_string(samples);
  EXPECT_NE(RepeatCommand(identity, rendered.part).find(" --sample-range " + range),
            std::string::npos);
  const SessionRequest again = {.limits = {.samples = SampleRanges().parse(range)}};
  EXPECT_TRUE(RunSession(job, identity, again).film.PackPicture() == rendered.film.PackPicture());
}

TEST_F(Session, EndsByNoiseAfterTheSameSamplesForAllThreads) {
  JobRequest request = Request();
  request.samples_per_pixel = 500;
  const auto film_of = [&](std::uint32_t samples) {
    JobRequest with_variance = request;
    with_variance.options.aovs |= *ParseAovs("variance");
    return Rendered(with_variance, {.limits = {.samples = SampleRange{0, samples}}}).film;
  };
  const Film of16 = film_of(16), of32 = film_of(32);
  ASSERT_GT(of16.Noise(16), of32.Noise(32));
  const SessionRequest limited = {.limits = {.noise = 0.5 * (of16.Noise(16) + of32.Noise(32))}};
  for (const int threads : {2, 1}) {
    request.options.threads = threads;
    const RenderedFilm rendered = Rendered(request, limited);
    EXPECT_EQ(rendered.part.samples, (SampleRange{0, 32}));
    EXPECT_TRUE(rendered.film.PackPicture() == of32.PackPicture());
  }
  // An interruption makes no difference, and neither does where the range begins.
  Interrupt(request, limited, 45);
  EXPECT_EQ(ReadFilm(path()).file.state.step, (SampleRange{16, 32}));
  SessionRequest resumed = Resuming();
  resumed.limits = limited.limits;
  EXPECT_TRUE(Rendered(request, resumed).film.PackPicture() == of32.PackPicture());
  SessionRequest of_range = limited;
  of_range.limits.samples = SampleRange{3, 20};
  of_range.limits.noise = 1e-6;
  EXPECT_EQ(Rendered(request, of_range).part.samples, (SampleRange{3, 20}));
}

// Rows of 600 pixels are longer than pages of memory.
TEST_F(Session, FreesTheFilmOfResolvedRows) {
  JobRequest request = SmallRequest(601, 61, 8);
  request.max_depth = 1;
  request.options.aovs = AllAovs();
  request.options.wave = 64;
  request.denoise = Denoiser::kStatistics;
  request.crop = CropWindow{3, 1, 595, 59};
  const RenderJob job = JobOf(request);
  const PictureIdentity identity = IdentityOf(job);
  const RenderedFilm kept = RunSession(job, identity, {});
  ASSERT_TRUE(kept.has_film);
  const Picture whole =
      ResolvePicture(kept.film, kept.samples, request.options.aovs, identity, kept.part);

  const auto render = [&](SessionRequest session, PictureRows& rows) {
    session.on_rows = [&](const Film& film, const SampleCounts& samples, int first, int end) {
      rows.Add(film, samples, first, end);
    };
    return RunSession(job, identity, session);
  };
  PictureRows rows(request.options.aovs, identity);
  const RenderedFilm forgotten = render({}, rows);
  EXPECT_FALSE(forgotten.has_film);
  EXPECT_EQ(forgotten.noise, kept.noise);
  EXPECT_TRUE(kept.noise.has_value());
  const auto sums = forgotten.film.sums();
  EXPECT_LT(std::count_if(sums.begin(), sums.end(), [](std::uint64_t sum) { return sum != 0; }),
            std::ptrdiff_t(sums.size() / 10));
  const Picture picture =
      FinishPicture(rows.Take(), request.options.aovs, identity, forgotten.part);
  EXPECT_EQ(picture.image.rgb, whole.image.rgb);
  ASSERT_EQ(picture.layers.size(), whole.layers.size());
  for (std::size_t i = 0; i < picture.layers.size(); ++i) {
    EXPECT_EQ(picture.layers[i].name, whole.layers[i].name);
    EXPECT_EQ(picture.layers[i].values, whole.layers[i].values) << picture.layers[i].name;
  }

  // A checkpoint needs the film.
  PictureRows again(request.options.aovs, identity);
  const RenderedFilm checked = render({.checkpoint = {.path = path()}}, again);
  EXPECT_TRUE(checked.has_film);
  EXPECT_EQ(again.Take().image.rgb, kept.film.Resolve(kept.samples).rgb);
}

// A look at a picture shows rows that the film has forgotten, too.
TEST_F(Session, ResolvesTheOtherRowsOfAPictureFromTheFilm) {
  const RenderJob job = JobOf(Request());
  const PictureIdentity identity = IdentityOf(job);
  RenderedFilm rendered = RunSession(job, identity, {});
  const Image whole = rendered.film.Resolve(rendered.samples);
  PictureRows rows(0, identity);
  EXPECT_EQ(rows.With(rendered.film, rendered.samples).image.rgb, whole.rgb);
  rows.Add(rendered.film, rendered.samples, 4, 9);
  EXPECT_EQ(rows.With(Film(rendered.film.layout()), rendered.samples).image.Pixel(0, 4)[0],
            whole.Pixel(0, 4)[0]);
  EXPECT_EQ(rows.With(rendered.film, rendered.samples).image.rgb, whole.rgb);
}

TEST_F(Session, NoiseIsThatOfTheSamplesThemselves) {
  JobRequest request = Request();
  request.crop = CropWindow{3, 1, 21, 17};
  request.options.aovs = *ParseAovs("variance");
  const Film film = Rendered(request, {}).film;
  const CropWindow& picture = film.layout().area.picture;
  std::vector<double> values, squares;
  for (std::uint32_t sample = 0; sample < kSamples; ++sample) {
    const Film one =
        Rendered(request, {.limits = {.samples = SampleRange{sample, sample + 1}}}).film;
    std::size_t i = 0;
    for (int y = picture.y; y < picture.y + picture.height; ++y) {
      for (int x = 3 * picture.x; x < 3 * (picture.x + picture.width); ++x, ++i) {
        const double value =
            double(one.sums()[std::size_t(3 * y * film.layout().area.width + x)]) * one.unit();
        values.resize(std::max(values.size(), i + 1));
        squares.resize(values.size());
        values[i] += value;
        squares[i] += value * value;
      }
    }
  }
  ASSERT_EQ(values.size(), 21u * 17 * 3);
  double variance = 0, mean = 0;
  for (std::size_t i = 0; i < values.size(); ++i) {
    const double of_pixel = values[i] / kSamples;
    variance += (squares[i] / kSamples - of_pixel * of_pixel) / (kSamples - 1);
    mean += of_pixel;
  }
  const double n = double(values.size());
  EXPECT_NEAR(film.Noise(kSamples), std::sqrt(variance / n) / (mean / n), 1e-9);
}

TEST(Limits, StepsFollowNoiseAndTime) {
  const Film film(1, 1, 1, *ParseAovs("variance"));
  double elapsed = 0;
  const auto rule = [&](const RenderLimits& limits) {
    return StopRule(limits, {100, 1100}, film, [&elapsed] { return elapsed; });
  };
  const auto by_time = rule({.seconds = 10});
  EXPECT_EQ(by_time(100), 101u);
  elapsed = 0.01;
  EXPECT_EQ(by_time(101), 102u) << "one sample more doubles them";
  elapsed = 4;
  EXPECT_EQ(by_time(200), 300u);
  elapsed = 8;
  EXPECT_EQ(by_time(500), 600u) << "a quarter of the time is left";
  elapsed = 10.1;
  EXPECT_EQ(by_time(600), 600u);
  elapsed = 1;
  EXPECT_EQ(by_time(900), 1100u) << "all samples";
  // A black film has no noise, but the noise is not checked before there are eight samples.
  const auto by_noise = rule({.noise = 0.1});
  EXPECT_EQ(by_noise(100), 108u);
  EXPECT_EQ(by_noise(107), 108u);
  EXPECT_EQ(by_noise(108), 108u);
  EXPECT_EQ(by_noise(109), 116u);
  // Those of an adaptive picture are at its least samples and their doubles.
  const auto adaptively = rule({.adaptive = 0.1, .adaptive_min = 5});
  EXPECT_EQ(adaptively(100), 105u);
  EXPECT_EQ(adaptively(105), 110u);
  EXPECT_EQ(adaptively(110), 120u);
  EXPECT_EQ(adaptively(113), 120u);
  EXPECT_EQ(adaptively(740), 1100u) << "all samples";
}

TEST(Limits, InvalidLimitsAreRefused) {
  EXPECT_EQ(SampleRanges().parse("3:9"), (SampleRange{3, 9}));
  for (const char* const text :
       {"", "4", ":", "1:", ":4", "3:3", "4:2", "-1:2", "0:4x", " 0:4", "0:4294967296", "0:1:2"}) {
    EXPECT_FALSE(SampleRanges().parse(text)) << text;
  }
  EXPECT_THROW(ChooseSamples({.samples = SampleRange{0, 7}}, 6), OptionError);
  EXPECT_EQ(ChooseSamples({.samples = SampleRange{5, 6}}, 6), (SampleRange{5, 6}));
  EXPECT_EQ(ChooseSamples({}, 6), (SampleRange{0, 6}));
  for (const Integrator integrator : ValuesOf<Integrator>()) {
    if (Describe(integrator).has_splats) {
      EXPECT_THROW(LayersForLimits({.noise = 0.1}, integrator), OptionError);
    } else {
      EXPECT_EQ(LayersForLimits({.noise = 0.1}, integrator), *ParseAovs("variance"));
    }
    EXPECT_EQ(LayersForLimits({.seconds = 1}, integrator), 0u);
  }
  const auto limits = std::make_shared<RenderLimits>();
  std::vector<BoundOption> bound;
  for (const OptionOf<RenderLimits>& option : LimitOptions()) bound.push_back(Bind(option, limits));
  for (const std::string name : {"time", "noise"}) {
    for (const std::string value : {"0", "-1", "nan", "inf", "1s", "", "1e10"}) {
      EXPECT_THROW(SetOption(bound, name, value), InputError) << name << " " << value;
    }
  }
  SetOption(bound, "noise", "0.01");
  EXPECT_EQ(limits->noise, 0.01);
}

}  // namespace
}  // namespace skywave
