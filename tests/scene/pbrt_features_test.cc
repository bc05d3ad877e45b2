// Compares docs/pbrt.md with the reader, and renders its examples, alone and in pairs.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <random>
#include <set>
#include <sstream>
#include <string>
#include <vector>

#include "base/error.h"
#include "base/files.h"
#include "image/image.h"
#include "scene/pbrt/reader.h"
#include "scene/reader.h"
#include "scene/shapes/shapes.h"
#include "tests/support/paths.h"
#include "tests/support/program.h"
#include "tests/support/render_scenes.h"
#include "tests/support/temporary_folder.h"
#include "wavefront/render.h"

namespace skywave {
namespace {

struct Example {
  std::string text;   // directives
  std::string state;  // rendered, approximated, reported
};

// Reads the rows "| `directives` | state | ... |" of the table.
std::vector<Example> Examples() {
  std::istringstream lines(ReadFile(SourcePath("docs/pbrt.md")));
  std::vector<Example> examples;
  for (std::string line; std::getline(lines, line);) {
    if (!line.starts_with("| `")) continue;
    const std::size_t end = line.find("` | ");
    const std::size_t state = end + 4;
    examples.push_back(
        {line.substr(3, end - 3), line.substr(state, line.find(' ', state) - state)});
  }
  return examples;
}

// Returns true if the example has to come before WorldBegin.
bool IsOption(const Example& example) {
  static const std::set<std::string> kOptions = {"Camera",     "Film",       "PixelFilter",
                                                 "Sampler",    "Integrator", "Accelerator",
                                                 "ColorSpace", "Option"};
  return kOptions.contains(example.text.substr(0, example.text.find(' ')));
}

// Returns a scene with one line per example, from the second line on.
std::string SceneOf(const std::vector<Example>& examples) {
  std::string options, world;
  for (const Example& example : examples) {
    (IsOption(example) ? options : world) += example.text + "\n";
  }
  return "LookAt .3 .2 -5 0 0 0 0 1 0 Film \"rgb\" \"integer xresolution\" 8 \"integer "
         "yresolution\" 8\n" +
         options + "WorldBegin\n" + world +
         "Shape \"trianglemesh\" \"point3 P\" [-9 -9 3 9 -9 3 0 9 3] \"point2 uv\" [0 0 3 0 0 3]\n";
}

Image RenderPicture(const RenderJob& job) {
  Film film = job.MakeFilm();
  RenderFrame(job.frame(), film);
  return film.Resolve(job.options().samples_per_pixel);
}

class PbrtFeatures : public testing::Test {
 protected:
  PbrtFeatures() {
    const std::string ply =
        "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\n"
        "property float z\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n"
        "0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n";
    folder_.Write("mesh.ply", ply);
    // A gzip file of one stored block needs no compressor: RFC 1951, 3.2.4.
    folder_.Write("mesh.ply.gz", StoredGzip(ply));
    folder_.Write("cu.eta.spd", "# Cu\n400 1.2\n550 1.0\n600 .3\n700 .2\n");
    folder_.Write("part.pbrt", "Shape \"disk\"\n");
    Image image(2, 2);
    image.rgb = {1, 0, 0, 0, 1, 0, 0, 0, 1, .5f, .5f, .5f};
    WritePfm(folder_.Path("image.pfm"), image);
    Image square(4, 4);
    std::fill(square.rgb.begin(), square.rgb.end(), 0.5f);
    WritePfm(folder_.Path("square.pfm"), square);
    folder_.Write("lens.dat", "40 4 1.5 20\n-40 2 1 20\n0 30 0 8\n");
  }

  static std::string StoredGzip(const std::string& text) {
    std::uint32_t crc = ~0u;
    for (const char c : text) {
      crc ^= static_cast<unsigned char>(c);
      for (int bit = 0; bit < 8; ++bit) crc = crc >> 1 ^ (crc & 1 ? 0xEDB88320u : 0);
    }
    const auto little = [](std::uint32_t value, int bytes) {
      std::string out;
      for (int i = 0; i < bytes; ++i) out += char(value >> (8 * i));
      return out;
    };
    const auto size = std::uint32_t(text.size());
    return std::string("\x1f\x8b\x08\0\0\0\0\0\0\xff\x01", 11) + little(size, 2) +
           little(~size, 2) + text + little(~crc, 4) + little(size, 4);
  }

  Scene Parse(const std::string& text, const ReadOptions& options = {}) const {
    return ParsePbrt(text, folder_.Path("t.pbrt"), options);
  }

  // Renders the scene with a few samples per pixel; every channel must be finite.
  static Image Render(Scene scene) {
    if (scene.environments.empty()) SetConstantLight(scene, 1);
    // Few of the paths from lights are seen.
    JobRequest request = SmallRequest(8, 8, scene.settings.integrator == "light" ? 16 : 2);
    request.options.threads = 1;
    request.options.wave = 64;
    if (scene.settings.crop)
      request.width = scene.settings.width, request.height = scene.settings.height;
    return RenderPicture(RenderJob(std::move(scene), request));
  }

  // The picture of a scene is finite, has no negative values, and is not black.
  void ExpectPicture(const std::string& text) const {
    SCOPED_TRACE(text);
    const Scene parsed = Parse(text);
    const Image image = Render(parsed);
    // Beside bright pixels, filters with negative weights make negative ones.
    const bool signs = parsed.settings.filter && HasSigns(*parsed.settings.filter);
    EXPECT_TRUE(std::all_of(image.rgb.begin(), image.rgb.end(), [&](float value) {
      return std::isfinite(value) && (signs || value >= 0);
    }));
    EXPECT_TRUE(
        std::any_of(image.rgb.begin(), image.rgb.end(), [](float value) { return value > 0; }));
  }

  TemporaryFolder folder_;
};

TEST_F(PbrtFeatures, TheDocumentedTableMatchesTheReader) {
  const std::vector<Example> examples = Examples();
  ASSERT_GE(examples.size(), 50u);
  for (const Example& example : examples) {
    SCOPED_TRACE(example.text);
    const std::string text = SceneOf({example});
    const std::string place = folder_.Path("t.pbrt") + (IsOption(example) ? ":2: " : ":3: ");
    const Scene scene = Parse(text);
    std::string refusal;
    try {
      Parse(text, {.strict = true});
    } catch (const InputError& error) {
      refusal = error.what();
      EXPECT_EQ(error.exit_code(), kExitBadInput);
    }
    if (example.state == "rendered") {
      EXPECT_EQ(refusal, "");
    } else {
      EXPECT_TRUE(example.state == "approximated" || example.state == "reported");
      EXPECT_TRUE(refusal.starts_with(place)) << refusal;
      ASSERT_FALSE(scene.warnings.empty());
      EXPECT_TRUE(scene.warnings[0].starts_with(place)) << scene.warnings[0];
    }
  }
}

TEST_F(PbrtFeatures, EachFeatureIsRendered) {
  for (const Example& example : Examples()) ExpectPicture(SceneOf({example}));
}

TEST_F(PbrtFeatures, PairsOfFeaturesAreRendered) {
  const std::vector<Example> examples = Examples();
  std::vector<std::vector<Example>> pairs;
  for (std::size_t i = 0; i < examples.size(); ++i) {
    for (std::size_t j = 0; j < examples.size(); ++j) {
      if (i != j) pairs.push_back({examples[i], examples[j]});
    }
  }
  std::mt19937 random(20240607);
  std::shuffle(pairs.begin(), pairs.end(), random);
  pairs.resize(300);
  for (const auto& pair : pairs) ExpectPicture(SceneOf(pair));
}

TEST_F(PbrtFeatures, AFileWithoutShapesShowsItsLight) {
  const std::string text =
      "Film \"rgb\" \"integer xresolution\" 8 \"integer yresolution\" 8\n"
      "Camera \"perspective\"\nWorldBegin\nLightSource \"infinite\" \"rgb L\" [.25 .5 2]\n";
  for (const Integrator integrator : ValuesOf<Integrator>()) {
    SCOPED_TRACE(ToString(integrator));
    JobRequest request = SmallRequest(8, 8, 2);
    request.integrator = integrator;
    const Image image = RenderPicture(RenderJob(Parse(text, {.strict = true}), request));
    for (std::size_t i = 0; i < image.rgb.size(); ++i) {
      EXPECT_NEAR(image.rgb[i], (std::array{.25f, .5f, 2.0f}[i % 3]), 1e-6f) << i;
    }
  }
  EXPECT_THROW(RenderJob(Parse("WorldBegin LightSource \"point\""), SmallRequest(8, 8, 1)),
               InputError);
}

// The text of an example, cut anywhere, is either read or refused with a position and an exit code.
TEST_F(PbrtFeatures, TruncatedFeaturesAreReadOrRefused) {
  int refused = 0;
  for (const Example& example : Examples()) {
    const std::string text = SceneOf({example});
    for (std::size_t size = 0; size < text.size(); size += 7) {
      try {
        Parse(text.substr(0, size));
      } catch (const InputError& error) {
        ++refused;
        EXPECT_NE(std::string(error.what()).find(".pbrt:"), std::string::npos) << error.what();
        EXPECT_TRUE(error.exit_code() == kExitBadInput || error.exit_code() == kExitIo);
      }
    }
  }
  EXPECT_GT(refused, 500);
}

// Returns a bumpy ball that replaces the model.
std::string StandIn() {
  Mesh mesh = Sphere(90, 6);
  Displace(mesh,
           [](const glm::vec3& p) { return 15 * std::sin(0.1f * p.x) * std::cos(0.08f * p.y); });
  std::ostringstream text;
  text << "Shape \"trianglemesh\" \"integer indices\" [";
  for (const glm::uvec3& t : mesh.triangles) text << t.x << ' ' << t.y << ' ' << t.z << ' ';
  text << "] \"point P\" [";
  for (const glm::vec3& p : mesh.positions) text << p.x << ' ' << p.y << ' ' << p.z << ' ';
  text << "]\n";
  return text.str();
}

TEST_F(PbrtFeatures, KillerooIsTheSamePictureInBothVersions) {
  folder_.Write("killeroo.pbrt", StandIn());
  std::array<Image, 2> pictures;
  for (const int version : {3, 4}) {
    const std::string name = "killeroo_v" + std::to_string(version) + ".pbrt";
    Scene scene = Parse(ReadFile(SourcePath("tests/data/" + name)));
    ASSERT_EQ(scene.meshes.size(), 5u);
    // The gloss of version 3 lies beside the body, and that of version 4 over it.
    for (Material& material : scene.materials) {
      if (material.bsdf == BsdfKind::kLambert) continue;
      EXPECT_EQ(material.bsdf, version == 4 ? BsdfKind::kCoatedDiffuse : BsdfKind::kGlossyDiffuse);
      material.bsdf = BsdfKind::kMetallicRoughness;
      material.ior = 1.5f;
    }
    EXPECT_EQ(scene.settings.width, 700);
    EXPECT_EQ(scene.settings.samples_per_pixel, 64);
    if (scene.environments.empty()) SetConstantLight(scene, 1);
    JobRequest request = SmallRequest(48, 48, 4);
    pictures[std::size_t(version - 3)] = RenderPicture(RenderJob(std::move(scene), request));
  }
  EXPECT_EQ(pictures[0].rgb, pictures[1].rgb);
  const auto [low, high] = std::minmax_element(pictures[0].rgb.begin(), pictures[0].rgb.end());
  EXPECT_LT(*low + 0.1f, *high);  // something is visible
}

using MalformedPbrt = Program;

TEST_F(MalformedPbrt, EndsWithItsPlaceAndExitCode65) {
  std::string deep;
  for (int i = 0; i < 5000; ++i) deep += "AttributeBegin ";
  Put("cycle_b.pbrt", "Include \"cycle_a.pbrt\"");
  Put("bad.ply", "ply\nformat ascii 1.0\nelement vertex x\n");
  Put("bad.ply.gz", "\x1f\x8b\x08 cut");
  Put("bad.spd", "400 1 300 2\n");
  const struct {
    const char *name, *text, *place;
  } files[] = {
      {"cut_string.pbrt", "Shape \"sph", "cut_string.pbrt:1: "},
      {"cut_list.pbrt", "\nShape \"sphere\" \"float radius\" [1", "cut_list.pbrt:2: "},
      {"cut_scope.pbrt", "WorldBegin\nAttributeBegin\n", "cut_scope.pbrt:2: "},
      {"word.pbrt", "WorldBegin\nShpae \"sphere\"", "word.pbrt:2: "},
      {"binary.pbrt", "\x80\xff\x01", "binary.pbrt:1: "},
      {"deep.pbrt", deep.c_str(), "deep.pbrt:1: "},
      {"cycle_a.pbrt", "Include \"cycle_b.pbrt\"", "cycle_b.pbrt:1: "},
      {"ply.pbrt", "Shape \"plymesh\" \"string filename\" \"bad.ply\"", "bad.ply:3: "},
      {"gz.pbrt", "Shape \"plymesh\" \"string filename\" \"bad.ply.gz\"", "bad.ply.gz (byte "},
      {"spd.pbrt", "Material \"metal\" \"spectrum k\" \"bad.spd\"", "bad.spd:1: "},
      {"kind.pbrt", "Attribute \"camera\" \"float fov\" 3", "kind.pbrt:1: "},
      {"mix.pbrt", "Material \"mix\" \"string materials\" [\"a\" \"b\"]", "mix.pbrt:1: "},
      {"disk.pbrt", "Shape \"disk\" \"float innerradius\" 2", "disk.pbrt:1: "},
      {"zmin.pbrt", "Shape \"cylinder\" \"float zmin\" 1", "zmin.pbrt:1: "},
      {"phi.pbrt", "Shape \"sphere\" \"float phimax\" 0", "phi.pbrt:1: "},
      {"patch.pbrt", "Shape \"bilinearmesh\" \"point3 P\" [0 0 0]", "patch.pbrt:1: "},
      {"kelvin.pbrt", "LightSource \"infinite\" \"blackbody L\" 0", "kelvin.pbrt:1: "},
      {"bounds.pbrt", "Film \"rgb\" \"integer pixelbounds\" [4 4 0 1]", "bounds.pbrt:1: "},
      {"gamma.pbrt",
       "Texture \"t\" \"color\" \"imagemap\" \"string filename\" \"bad.ply\" \"string encoding\" "
       "\"gamma x\"",
       "gamma.pbrt:1: "},
  };
  for (const auto& file : files) {
    Put(file.name, file.text);
    const Result result = Run(std::string("info --missing refuse ") + file.name);
    EXPECT_EQ(result.exit_code, 65) << file.name << result.err;
    EXPECT_NE(result.err.find(file.place), std::string::npos) << file.name << " -> " << result.err;
  }
}

TEST_F(MalformedPbrt, CopiesOfInstancesAreBounded) {
  std::string text = "WorldBegin ObjectBegin \"o\" Shape \"sphere\" ObjectEnd\n";
  for (int i = 0; i < 10; ++i) text += "ObjectInstance \"o\"\n";
  Put("many.pbrt", text);
  EXPECT_EQ(Run("info many.pbrt").exit_code, 0);
  const Result result = Run("info many.pbrt --instances copy --max-triangles 100000");
  EXPECT_EQ(result.exit_code, 65);
  EXPECT_NE(result.err.find("many.pbrt: "), std::string::npos) << result.err;
  EXPECT_NE(result.err.find("max-triangles"), std::string::npos) << result.err;
  // Shared, the object has 20480 triangles.
  const Result shared = Run("info many.pbrt --max-triangles 100000");
  EXPECT_EQ(shared.exit_code, 0) << shared.err;
  EXPECT_NE(shared.out.find("10 of 1 objects"), std::string::npos) << shared.out;
  EXPECT_EQ(Run("info many.pbrt --max-triangles 20000").exit_code, 65);
}

TEST_F(MalformedPbrt, StrictRefusesWhatEveryReaderReports) {
  Put("a.pbrt", "WorldBegin Shape \"sphere\"\nShape \"nurbs\"\n");
  Put("a.mtl", "newmtl m\nKd 1 1 1\nmap_bump no.png\n");
  Put("a.obj", "mtllib a.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl m\nf 1 2 3\n");
  Put("a.gltf",
      "{\"asset\":{\"version\":\"2.0\"},\"scene\":0,\"scenes\":[{\"nodes\":[0]}],\"nodes\":[{"
      "\"mesh\":0}],\"meshes\":[{\"primitives\":[{\"attributes\":{}}]}]}");
  for (const char* name : {"a.pbrt", "a.obj", "a.gltf"}) {
    EXPECT_EQ(Run(std::string("info ") + name).exit_code, 0) << name;
    const Result strict = Run(std::string("info --strict ") + name);
    EXPECT_EQ(strict.exit_code, 65) << name;
    EXPECT_NE(strict.err.find("--strict"), std::string::npos) << strict.err;
    EXPECT_EQ(Run(std::string("render --strict -o x.exr ") + name).exit_code, 65) << name;
  }
  EXPECT_EQ(Files().count("x.exr"), 0u);
}

TEST_F(MalformedPbrt, StrictRefusesAFilterThatLightPathsApproximate) {
  Put("f.pbrt",
      "Integrator \"bdpt\" PixelFilter \"mitchell\"\nWorldBegin Shape \"sphere\"\n"
      "LightSource \"infinite\"\n");
  const std::string render = "render f.pbrt --size 8x8 --spp 1 -o f.exr ";
  const std::string note = "the filter mitchell has negative weights";
  const Result loose = Run(render);
  EXPECT_EQ(loose.exit_code, 0) << loose.err;
  EXPECT_NE(loose.err.find("f.pbrt: " + note), std::string::npos) << loose.err;
  const Result strict = Run(render + "--strict");
  EXPECT_EQ(strict.exit_code, 65);
  EXPECT_NE(strict.err.find("f.pbrt: " + note), std::string::npos) << strict.err;
  EXPECT_NE(strict.err.find("refused by --strict"), std::string::npos) << strict.err;
  // Whoever chooses another filter gets what they ask for.
  for (const char* choice : {"--filter triangle", "--integrator path"}) {
    const Result chosen = Run(render + "--strict " + choice);
    EXPECT_EQ(chosen.exit_code, 0) << chosen.err;
    EXPECT_EQ(chosen.err.find(note), std::string::npos) << chosen.err;
  }
}

}  // namespace
}  // namespace skywave
