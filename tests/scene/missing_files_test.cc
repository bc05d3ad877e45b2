// Tests what becomes of scenes that name files which are missing or broken, in every format.
#include <gtest/gtest.h>

#include <fstream>
#include <string>

#include "base/error.h"
#include "scene/reader.h"
#include "tests/support/temporary_folder.h"

namespace skywave {
namespace {

class FilesOfScenes : public testing::Test {
 protected:
  // A scene is read without the file, is refused strictly, and is refused where that is asked for.
  void ExpectSkippedOrRefused(const std::string& name, const std::string& text,
                              const std::string& said) {
    SCOPED_TRACE(name);
    const std::string path = folder_.Write(name, text);
    const Scene scene = ReadScene(path);
    ASSERT_EQ(scene.warnings.size(), 1u);
    EXPECT_NE(scene.warnings[0].find(said), std::string::npos) << scene.warnings[0];
    EXPECT_THROW(ReadScene(path, {.strict = true}), InputError);
    try {
      ReadScene(path, {.missing = MissingFiles::kRefuse});
      ADD_FAILURE() << "not refused";
    } catch (const InputError& error) {
      EXPECT_NE(std::string(error.what()).find("--missing refuse"), std::string::npos);
      EXPECT_NE(std::string(error.what()).find(said), std::string::npos) << error.what();
    }
  }
  TemporaryFolder folder_;
};

constexpr const char* kTriangle = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";

TEST_F(FilesOfScenes, ThatAreMissingAreLeftOutOrRefuseTheScene) {
  ExpectSkippedOrRefused("a.obj", std::string("mtllib none.mtl\n") + kTriangle, "none.mtl");
  folder_.Write("b.mtl", "newmtl b\nmap_Kd none.png\n");
  ExpectSkippedOrRefused("b.obj", std::string("mtllib b.mtl\nusemtl b\n") + kTriangle, "none.png");
  ExpectSkippedOrRefused("c.pbrt",
                         "WorldBegin Shape \"sphere\"\n"
                         "Shape \"plymesh\" \"string filename\" \"none.ply\"",
                         "c.pbrt:2: Shape \"plymesh\": there is no file \"none.ply\": left out");
  ExpectSkippedOrRefused("d.pbrt",
                         "WorldBegin Shape \"sphere\"\n"
                         "Texture \"t\" \"spectrum\" \"imagemap\" \"string filename\" \"none.png\"",
                         "there is no file \"none.png\": its users take their default");
  ExpectSkippedOrRefused("e.pbrt",
                         "WorldBegin Material \"diffuse\" \"string normalmap\" "
                         "\"none.png\" Shape \"sphere\"",
                         "normalmap: there is no file \"none.png\": left out");
}

// A light without its image shines as if it had none.
TEST_F(FilesOfScenes, ThatLightsLackLeaveThemPlain) {
  const std::string ball = " Shape \"sphere\"";
  for (const auto& [light, file] : {std::pair("infinite", "none.exr"),
                                    {"goniometric", "none.png"},
                                    {"projection", "none.png"}}) {
    const std::string text = std::string("WorldBegin LightSource \"") + light +
                             "\" \"string filename\" \"" + file + "\"" + ball;
    ExpectSkippedOrRefused("a.pbrt", text,
                           std::string("LightSource \"") + light + "\": there is no file \"" +
                               file + "\": it shines without an image");
    const Scene scene = ReadScene(folder_.Path("a.pbrt"));
    EXPECT_EQ(scene.environments.size() + scene.lights.size(), 1u);
    if (light == std::string("projection")) {
      EXPECT_NEAR(scene.lights[0].form->half_size.x, 1, 1e-6) << "90 degrees, as in version 4";
    }
  }
  ExpectSkippedOrRefused("b.pbrt",
                         "WorldBegin AreaLightSource \"diffuse\" \"string filename\" "
                         "\"none.png\"" +
                             ball,
                         "it shines without an image");
}

// Missing files are one line for each kind of thing, and textures that lack theirs are not named
// once more where they are used.
TEST_F(FilesOfScenes, ThatAreMissingAreOneLineOfEachKind) {
  std::string text = "WorldBegin Shape \"sphere\"\n";
  for (const char* const name : {"a.ply", "b.ply", "b.ply", "c.ply", "d.ply", "e.ply"}) {
    text += std::string("Shape \"plymesh\" \"string filename\" \"") + name + "\"\n";
  }
  text +=
      "Texture \"t\" \"spectrum\" \"imagemap\" \"string filename\" \"t.png\"\n"
      "Material \"diffuse\" \"texture reflectance\" \"t\" Shape \"sphere\"";
  const std::string path = folder_.Write("a.pbrt", text);
  EXPECT_EQ(ReadScene(path).warnings,
            (std::vector<std::string>{
                path + ":2: Shape \"plymesh\": there are no files \"a.ply\", \"b.ply\", "
                       "\"c.ply\" and 2 more: left out (6 times)",
                path + ":8: Texture \"imagemap\": there is no file \"t.png\": its users take their "
                       "default"}));
}

TEST_F(FilesOfScenes, ThatAreBrokenAreTakenForMissing) {
  folder_.Write("broken.ply", "ply\nformat ascii 1.0\nelement vertex 3\n");
  folder_.Write("broken.png", "no picture");
  ExpectSkippedOrRefused("a.pbrt",
                         "WorldBegin Shape \"sphere\"\n"
                         "Shape \"plymesh\" \"string filename\" \"broken.ply\"",
                         "broken.ply");
  ExpectSkippedOrRefused("b.pbrt",
                         "WorldBegin Shape \"sphere\"\n"
                         "Texture \"t\" \"float\" \"imagemap\" \"string filename\" \"broken.png\"",
                         "broken.png");
}

// An exponent that is none is not a matter of files.
TEST_F(FilesOfScenes, AreNotToBlameForWrongParameters) {
  folder_.Write("a.pfm", std::string("PF\n1 1\n-1\n") + std::string(12, '\0'));
  EXPECT_THROW(
      ReadScene(folder_.Write("a.pbrt",
                              "WorldBegin Texture \"t\" \"float\" \"imagemap\" \"string filename\" "
                              "\"a.pfm\" \"string encoding\" \"gamma x\"")),
      InputError);
}

TEST_F(FilesOfScenes, LoseTheColoursOfVerticesOnDemandMayBeTurnedOff) {
  const std::string obj =
      folder_.Write("a.obj", "v 0 0 0 1 0 0\nv 1 0 0 0 1 0\nv 0 1 0 0 0 1\nf 1 2 3\n");
  const std::string ply = folder_.Write(
      "a.ply",
      "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\n"
      "property float z\nproperty uchar red\nproperty uchar green\nproperty uchar blue\n"
      "element face 1\nproperty list uchar int vertex_indices\nend_header\n"
      "0 0 0 255 0 0\n1 0 0 0 255 0\n0 1 0 0 0 255\n3 0 1 2\n");
  for (const std::string& path : {obj, ply}) {
    EXPECT_EQ(ReadScene(path).meshes.at(0).colors.size(), 3u) << path;
    const Scene plain = ReadScene(path, {.vertex_colors = VertexColors::kOff});
    EXPECT_TRUE(plain.meshes.at(0).colors.empty()) << path;
    EXPECT_LT(plain.materials.at(0).reflectance.x, 1) << "the default grey";
  }
}

}  // namespace
}  // namespace skywave
