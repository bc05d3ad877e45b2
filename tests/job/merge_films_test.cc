// Tests that films of parts add up to the bytes of one render, and that what does not belong
// together is refused.
#include "job/merge_films.h"

#include <gtest/gtest.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <unistd.h>
#include <xxhash.h>

#include <algorithm>
#include <cstring>
#include <map>
#include <nlohmann/json.hpp>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "base/error.h"
#include "base/files.h"
#include "base/version.h"
#include "job/session.h"
#include "tests/support/painted_scene.h"
#include "tests/support/render_scenes.h"
#include "tests/support/temporary_folder.h"
#include "wavefront/records/photon_map.h"

namespace {

std::vector<bool> flushed_are_folders;

}  // namespace

// Takes the place of the C library's, to know what is flushed to disk, and in which order.
extern "C" int fsync(int file) {
  struct stat status = {};
  flushed_are_folders.push_back(::fstat(file, &status) == 0 && S_ISDIR(status.st_mode));
  return int(::syscall(SYS_fsync, file));
}

namespace skywave {
namespace {

using Json = nlohmann::ordered_json;

constexpr int kWidth = 29, kHeight = 22;
constexpr std::uint32_t kSamples = 6;

JobRequest Request(Integrator integrator, const char* layers) {
  JobRequest request = SmallRequest(kWidth, kHeight, kSamples);
  request.integrator = integrator;
  request.max_depth = 3;
  request.options.aovs = *ParseAovs(layers);
  request.options.of<PhotonOptions>().indirect = request.options.of<PhotonOptions>().caustic = 500;
  return request;
}

RenderJob JobOf(const JobRequest& request) {
  Scene scene = PaintedScene();
  scene.lights = {SlantingSpot()};
  return RenderJob(std::move(scene), request);
}

PicturePart Whole() { return {{0, 0, kWidth, kHeight}, {0, kSamples}}; }

using Bytes = std::pair<std::string, std::string>;  // of the EXR and the PNG

Bytes BytesOf(const TemporaryFolder& folder, const Picture& picture) {
  WriteExr(folder.Path("picture.exr"), picture);
  return {ReadFile(folder.Path("picture.exr")), EncodePng(picture)};
}

// Renders parts of one picture.
class Parts {
 public:
  Parts(const TemporaryFolder& folder, JobRequest request)
      : folder_(folder), request_(std::move(request)) {}

  // Returns the name of the film of a part.
  std::string Render(const PicturePart& part) {
    JobRequest request = request_;
    request.crop = part.window;
    request.options.threads = 1 + films_ % 2;
    const RenderJob job = JobOf(request);
    const PictureIdentity identity = IdentityOf(job, exposure_, true);
    const RenderedFilm rendered = RunSession(job, identity, {.limits = {.samples = part.samples}});
    const std::string path = folder_.Path("part" + std::to_string(films_++) + ".film");
    WriteFilm(path, identity, job.options().aovs, rendered);
    return path;
  }

  Bytes OneRender() const {
    const RenderJob job = JobOf(request_);
    const PictureIdentity identity = IdentityOf(job, exposure_, true);
    const RenderedFilm rendered = RunSession(job, identity, {});
    return BytesOf(folder_, ResolvePicture(rendered.film, rendered.part.samples.count(),
                                           job.options().aovs, identity, rendered.part));
  }

  // Adds some films to one.
  std::string Merge(const std::vector<std::string>& films) {
    const MergedFilm merged = MergeFilms({.films = films});
    const std::string path = folder_.Path("part" + std::to_string(films_++) + ".film");
    WriteFilm(path, merged.file, merged.film);
    return path;
  }

 private:
  const TemporaryFolder& folder_;
  JobRequest request_;
  ExposureRequest exposure_ = {.exposure = ExposureChoice{.automatic = true},
                               .curve = ToneCurve::kFilmic};
  int films_ = 0;
};

// Cuts `parts` once more at a random place; windows stay whole if `samples_only`.
void CutOne(std::vector<PicturePart>& parts, std::mt19937& random, bool samples_only) {
  const std::size_t i = random() % parts.size();
  PicturePart &low = parts[i], high = low;
  const auto at = [&](auto count) { return decltype(count)(1 + random() % (count - 1)); };
  const unsigned axis = samples_only ? 2 : random() % 3;
  if (axis == 0 && low.window.width > 1) {
    low.window.width = at(low.window.width);
    high.window.x += low.window.width, high.window.width -= low.window.width;
  } else if (axis == 1 && low.window.height > 1) {
    low.window.height = at(low.window.height);
    high.window.y += low.window.height, high.window.height -= low.window.height;
  } else if (low.samples.count() > 1) {
    low.samples.end = high.samples.first = low.samples.first + at(low.samples.count());
  } else {
    return;
  }
  parts.push_back(high);
}

// Expects the bytes of one render from `splits` random splits into parts that come in any order,
// some of them as a film of several.
void ExpectBytesOfOneRender(const JobRequest& request, int splits, bool samples_only) {
  const TemporaryFolder folder;
  Parts parts(folder, request);
  const Bytes expected = parts.OneRender();
  std::mt19937 random(5);
  for (int split = 0; split < splits; ++split) {
    std::vector<PicturePart> cut = {Whole()};
    while (cut.size() < std::size_t(2 + split / 2)) CutOne(cut, random, samples_only);
    std::vector<std::string> films;
    for (const PicturePart& part : cut) films.push_back(parts.Render(part));
    std::shuffle(films.begin(), films.end(), random);
    if (films.size() > 2) {
      const std::size_t some = 2 + random() % (films.size() - 2);
      const std::vector<std::string> first(films.begin(), films.begin() + std::ptrdiff_t(some));
      films.erase(films.begin(), films.begin() + std::ptrdiff_t(some));
      films.insert(films.begin() + std::ptrdiff_t(random() % (films.size() + 1)),
                   parts.Merge(first));
    }
    const Bytes merged = BytesOf(folder, ResolveMerged(MergeFilms({.films = films})));
    EXPECT_TRUE(merged.first == expected.first) << "EXR of split " << split;
    EXPECT_TRUE(merged.second == expected.second) << "PNG of split " << split;
  }
}

// A farm renders no part twice that was reported as there, so neither bytes nor name may be lost
// with the power.
TEST(MergeFilms, AFilmIsFlushedBeforeItsName) {
  const TemporaryFolder folder;
  Parts parts(folder, Request(Integrator::kDirect, "depth"));
  flushed_are_folders.clear();
  parts.Render(Whole());
  EXPECT_EQ(flushed_are_folders, (std::vector<bool>{false, true}));
}

// A file of Latin-1's age has such a name, and its render is not lost for it.
TEST(MergeFilms, AFilmOfAFileWhoseNameIsNotUtf8IsWritten) {
  const TemporaryFolder folder;
  JobRequest request = Request(Integrator::kPath, "normal");
  request.scene = "caf\xe9.ply";
  Parts parts(folder, request);
  const FilmInFile film = ReadFilm(parts.Render(Whole()));
  EXPECT_NE(film.file.identity.scene.find("caf\xef\xbf\xbd.ply"), std::string::npos);
}

TEST(MergeFilms, MergedPartsEqualTheWholePicture) {
  ExpectBytesOfOneRender(Request(Integrator::kPath, "all,crypto-object,crypto-material"), 10,
                         false);
}

constexpr char kOfHits[] = "albedo,normal,depth,uv,object-id,coverage,samples";

TEST(MergeFilms, PicturesOfLightPathsAreSplitBySamples) {
  for (const Integrator integrator : {Integrator::kLight, Integrator::kBdpt, Integrator::kVcm}) {
    SCOPED_TRACE(ToString(integrator));
    ExpectBytesOfOneRender(Request(integrator, kOfHits), 4, true);
  }
}

TEST(MergeFilms, PassesOfPhotonsAreThoseOfTheWholePicture) {
  for (const std::uint32_t passes : {1u, 4u}) {
    JobRequest request = Request(Integrator::kPhoton, kOfHits);
    request.options.of<PhotonOptions>().passes = passes;
    SCOPED_TRACE(passes);
    ExpectBytesOfOneRender(request, 5, false);
  }
}

TEST(MergeFilms, FilmsOfDenoisedPicturesKeepWhatTheDenoiserReads) {
  const TemporaryFolder folder;
  JobRequest request = Request(Integrator::kPath, "depth");
  request.denoise = Denoiser::kStatistics;
  request.samples_per_pixel = 16;
  Parts parts(folder, request);
  const Bytes expected = parts.OneRender();
  CropWindow left = Whole().window, right = left;
  left.width /= 2, right.x += left.width, right.width -= left.width;
  const std::vector<std::string> films = {
      parts.Render({right, {0, 16}}), parts.Render({left, {3, 16}}), parts.Render({left, {0, 3}})};
  const MergedFilm merged = MergeFilms({.films = films});
  const Bytes bytes = BytesOf(folder, ResolveMerged(merged));
  EXPECT_TRUE(bytes == expected);
  const Picture clean = ResolveMerged(merged);
  std::vector<std::string> names;
  for (const NamedChannel& channel : clean.layers) names.push_back(channel.name);
  EXPECT_EQ(names, (std::vector<std::string>{"depth.Z", "error.R", "error.G", "error.B"}));
  request.denoise = Denoiser::kNone;
  EXPECT_FALSE(Parts(folder, request).OneRender() == expected);
}

// Expects `merge` to be refused with all of `words` in the message.
template <class Merge>
void ExpectRefused(const Merge& merge, const std::vector<std::string>& words) {
  try {
    merge();
    ADD_FAILURE() << "not refused: " << words[0];
  } catch (const InputError& error) {
    for (const std::string& word : words) {
      EXPECT_NE(std::string(error.what()).find(word), std::string::npos)
          << "no '" << word << "' in: " << error.what();
    }
  }
}

PicturePart SampleOf(std::uint32_t first, std::uint32_t end) {
  return {Whole().window, {first, end}};
}

TEST(MergeFilms, PartsOfOtherPicturesAreRefusedWithTheDifference) {
  const TemporaryFolder folder;
  const JobRequest request = Request(Integrator::kPath, "albedo");
  const std::string ours = Parts(folder, request).Render(SampleOf(0, 3));
  const std::string a = folder.Path("a.film");
  std::filesystem::rename(ours, a);
  const auto expect = [&](const std::string& theirs, std::vector<std::string> words) {
    words.insert(words.end(), {theirs, a});
    ExpectRefused([&] { MergeFilms({.films = {a, theirs}}); }, words);
  };
  const auto other = [&](auto change) {
    JobRequest changed = request;
    change(changed);
    return Parts(folder, changed).Render(SampleOf(3, 6));
  };
  expect(other([](JobRequest& r) { r.options.seed = 7; }), {"`seed` is 7 here and 0 there"});
  expect(other([](JobRequest& r) { r.samples_per_pixel = 8; }), {"`spp` is 8 here and 6 there"});
  expect(other([](JobRequest& r) { r.max_depth = 8; }), {"`max-depth` is 8 here and 3 there"});
  expect(other([](JobRequest& r) { r.options.mis = false; }),
         {"`mis` is --no-mis here and not given there"});
  expect(other([](JobRequest& r) { r.options.aovs = *ParseAovs("depth"); }),
         {"`aovs` is depth here and albedo there"});
  const auto edited = [&](auto change) {
    FilmInFile film = ReadFilm(a);
    film.file.holds[0].samples = {3, 6};
    change(film.file);
    WriteFilm(folder.Path("b.film"), film.file, film.film);
    return folder.Path("b.film");
  };
  expect(edited([](FilmFile& f) { f.identity.software = "skywave 0.0.9"; }),
         {"it is of skywave " + std::string(Version()) + ", and this is skywave 0.0.9"});
  expect(edited([](FilmFile& f) { f.identity.map_hash ^= 1; }), {"the illumination maps differ"});
  expect(edited([](FilmFile& f) { f.identity.scene_hash ^= 1; }), {"the scenes differ"});
  expect(edited([](FilmFile& f) { f.identity.options.pop_back(); }), {"is of another picture"});
  expect(edited([](FilmFile& f) { f.layers = 0; }), {"has other layers than"});
  ExpectRefused(
      [&] { MergeFilms({.films = {edited([](FilmFile& f) { f.is_checkpoint = true; })}}); },
      {"b.film", "is a checkpoint"});
  // Unchanged, it belongs to the picture; the name of the scene does not matter.
  const std::string same = edited([](FilmFile& f) { f.identity.scene = "elsewhere"; });
  EXPECT_TRUE(MergeFilms({.films = {a, same}}).missing.empty());
}

TEST(MergeFilms, PartsThatOverlapOrAreMissingAreNamed) {
  const TemporaryFolder folder;
  Parts parts(folder, Request(Integrator::kPath, "albedo"));
  const std::string a = parts.Render(SampleOf(0, 3));
  const std::string corner = parts.Render({{28, 21, 1, 1}, {2, 6}});
  ExpectRefused([&] { MergeFilms({.films = {a, a}}); }, {a, "holds", "too", "sample-range 0:3"});
  ExpectRefused(
      [&] {
        MergeFilms({.films = {a, corner}});
      },
      {corner + ": holds crop 1x1+28+21 sample-range 2:6", a, "crop 29x22+0+0"});
  ExpectRefused([&] { ResolveMerged(MergeFilms({.films = {a}})); },
                {"no film holds crop 29x22+0+0 sample-range 3:6"});
  // What touches a part does not overlap it.
  const std::string rest = parts.Render({{28, 21, 1, 1}, {3, 6}});
  const MergedFilm merged = MergeFilms({.films = {rest, a}});
  ExpectRefused([&] { ResolveMerged(merged); },
                {"crop 29x21+0+0 sample-range 3:6; crop 28x1+0+21 sample-range 3:6"});
  // Some of the picture may be all that is wanted; what is beyond it is refused.
  const PicturePart pixel = {{28, 21, 1, 1}, {3, 6}};
  const MergeRequest only = {.films = {rest}, .window = pixel.window, .samples = pixel.samples};
  EXPECT_TRUE(MergeFilms(only).missing.empty());
  MergeRequest beyond = only;
  beyond.films = {a, rest};
  ExpectRefused([&] { MergeFilms(beyond); }, {a, "not all within what is wanted"});
  // A film with room for the whole picture gives the part of it that is wanted.
  const MergedFilm roomy = MergeFilms({.films = {rest}});
  WriteFilm(folder.Path("roomy.film"), roomy.file, roomy.film);
  MergeRequest of_roomy = only;
  of_roomy.films = {folder.Path("roomy.film")};
  EXPECT_TRUE(MergeFilms(of_roomy).film.PackPicture() == ReadFilm(rest).film.PackPicture());
  MergeRequest off = only;
  off.window = CropWindow{20, 0, 10, 1};
  ExpectRefused([&] { MergeFilms(off); }, {"crop", "is not on the film"});
  off = only;
  off.samples = SampleRange{3, 7};
  ExpectRefused([&] { MergeFilms(off); }, {"sample-range 3:7"});
}

TEST(MergeFilms, CropsOfPicturesWithSplatsAreRefused) {
  const TemporaryFolder folder;
  Parts parts(folder, Request(Integrator::kBdpt, "albedo"));
  const std::string left = parts.Render({{0, 0, 15, kHeight}, {0, kSamples}});
  const std::string right = parts.Render({{15, 0, 14, kHeight}, {0, kSamples}});
  ExpectRefused(
      [&] {
        MergeFilms({.films = {left, right}});
      },
      {left, "crop 15x22+0+0", "parts by samples alone"});
}

// Returns a film file of these parts with a checksum that fits.
std::string Sealed(const std::string& manifest, const std::string& sums) {
  const auto append = [](std::string& bytes, std::uint64_t number) {
    bytes.append(reinterpret_cast<const char*>(&number), sizeof number);
  };
  std::string bytes = "SKYWFILM";
  append(bytes, manifest.size());
  bytes += manifest + sums;
  append(bytes, XXH64(bytes.data(), bytes.size(), 0));
  return bytes;
}

class TornFilm : public testing::Test {
 protected:
  static constexpr PicturePart kPart = {{0, 0, 8, 4}, {1, 4}};

  TornFilm() {
    JobRequest request = Request(Integrator::kDirect, "albedo,uv,variance,lights,crypto-object");
    request.width = 8, request.height = 8;
    const std::string path = Parts(folder_, request).Render(kPart);
    bytes_ = ReadFile(path);
    std::uint64_t size = 0;
    std::memcpy(&size, bytes_.data() + 8, sizeof size);
    manifest_ = Json::parse(bytes_.substr(16, size));
    sums_ = bytes_.substr(16 + size, bytes_.size() - 24 - size);
  }

  // Reads and uses a film of these bytes. Returns whether it was refused by InputError; whatever
  // else is thrown ends the test.
  bool IsRefused(const std::string& bytes) {
    std::filesystem::remove(folder_.Path("torn.film"));  // overwriting waits for the disk
    const std::string path = folder_.Write("torn.film", bytes);
    try {
      ResolveMerged(
          MergeFilms({.films = {path}, .window = kPart.window, .samples = kPart.samples}));
      return false;
    } catch (const InputError&) {
      return true;
    }
  }

  TemporaryFolder folder_;
  std::string bytes_, sums_;
  Json manifest_;
};

TEST_F(TornFilm, AFilmThatIsTornOrChangedIsRefused) {
  ASSERT_FALSE(IsRefused(bytes_));
  ASSERT_FALSE(IsRefused(Sealed(manifest_.dump(), sums_)));
  for (std::size_t size = 0; size < bytes_.size(); size += size < 40 ? 1 : 97) {
    EXPECT_TRUE(IsRefused(bytes_.substr(0, size))) << size;
  }
  for (std::size_t i = 0; i < bytes_.size(); i += i < 40 || i > bytes_.size() - 40 ? 1 : 61) {
    std::string flipped = bytes_;
    flipped[i] = char(flipped[i] ^ (1 << i % 8));
    EXPECT_TRUE(IsRefused(flipped)) << i;
  }
  EXPECT_TRUE(IsRefused(bytes_ + "x"));
}

TEST_F(TornFilm, AManifestThatDisagreesWithTheDataIsRefused) {
  const std::vector<std::pair<const char*, Json>> lies = {
      {"/format", 1},
      {"/window", {0, 0, 8, 5}},
      {"/window", {0, 0, 8, 3}},
      {"/window", {0, -1, 8, 4}},
      {"/window", {0, 5, 8, 4}},
      {"/window", {0, 0, 1 << 20, 1 << 20}},
      {"/window", {0, 0, 4294967304, 4}},
      {"/window", {0, 0, 8.5, 4}},
      {"/window", {0, 0, 8}},
      {"/window", "8x4"},
      {"/picture/film", {0, 0, 7, 8}},
      {"/picture/film", {0, 0, 0, 0}},
      {"/picture/samples", 3},
      {"/picture/samples", -1},
      {"/picture/samples", 4294967302},
      {"/picture/samples", 1e300},
      {"/picture/scene_hash", "none"},
      {"/picture/options", 7},
      {"/picture/options/0/name", 7},
      {"/holds/0/window", {0, 0, 8, 5}},
      {"/holds/0/window", {1, 0, 8, 4}},
      {"/holds/0/samples", {4, 1}},
      {"/holds/0/samples", {1, 7}},
      {"/layers", "albedo,shine"},
      {"/layers", "depth"},
      {"/sums/bytes", 0},
      {"/sums/layers", "albedo"},
      {"/sums/layers", ""},
      {"/sums/light_groups", {"environment", "spot", "more"}},
      {"/sums/light_groups", {1}},
      {"/sums/mattes", nullptr},
      {"/sums/mattes/meshes", {1}},
      {"/sums/mattes/materials", 7},
      {"/sums/extent_bits", -1},
      {"/sums/splats", "no"},
  };
  for (const auto& [pointer, value] : lies) {
    Json lie = manifest_;
    ASSERT_TRUE(lie.contains(Json::json_pointer(pointer))) << pointer;
    lie[Json::json_pointer(pointer)] = value;
    EXPECT_TRUE(IsRefused(Sealed(lie.dump(), sums_))) << pointer << " " << value;
  }
  for (const auto& [name, value] : manifest_.items()) {
    Json without = manifest_;
    without.erase(name);
    EXPECT_TRUE(IsRefused(Sealed(without.dump(), sums_))) << name;
  }
  EXPECT_TRUE(IsRefused(Sealed(manifest_.dump(), sums_ + "12345678")));
  EXPECT_TRUE(IsRefused(Sealed("", "")));
  EXPECT_TRUE(IsRefused(Sealed(std::string(100000, '['), sums_)));
}

// Whatever the manifest says under a checksum that fits, nothing but InputError comes of it.
TEST_F(TornFilm, RandomManifestsDoNotCrash) {
  std::mt19937 random(9);
  const std::string manifest = manifest_.dump();
  const std::string digits = "0123456789-.,[]{}\"e";
  int refused = 0;
  for (int i = 0; i < 1500; ++i) {
    std::string changed = manifest;
    for (unsigned changes = 0; changes < 1 + random() % 2; ++changes) {
      std::size_t at = random() % changed.size();
      if (random() % 4 != 0) at = std::min(changed.find_first_of("0123456789", at), at + 200);
      if (at < changed.size()) changed[at] = digits[random() % digits.size()];
    }
    refused += IsRefused(Sealed(changed, sums_)) ? 1 : 0;
  }
  EXPECT_GT(refused, 500);
  EXPECT_LT(refused, 1500);
}

}  // namespace
}  // namespace skywave
