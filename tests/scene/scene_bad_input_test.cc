// Every unusable scene file is refused with the position and the reason; none crashes.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <string>
#include <tuple>
#include <vector>

#include "base/error.h"
#include "scene/pbrt/reader.h"
#include "scene/reader.h"
#include "scene/shapes/ply.h"

namespace skywave {
namespace {

// Returns the message of the InputError, or "" if there was none.
template <typename Read>
std::string ErrorOf(Read read) {
  try {
    read();
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

std::string PbrtError(const std::string& text) {
  return ErrorOf([&] { ParsePbrt(text, "t.pbrt"); });
}
std::string PlyError(const std::string& bytes) {
  return ErrorOf([&] { ParsePly(bytes, "t.ply"); });
}

bool Contains(const std::string& text, const std::string& part) {
  return text.find(part) != std::string::npos;
}

struct BadText {
  const char* text;
  const char* place;
  const char* reason;
};

class TemporaryFolder {
 public:
  TemporaryFolder()
      : path_(std::filesystem::path(testing::TempDir()) /
              ("skywave_bad_" +
               std::string(testing::UnitTest::GetInstance()->current_test_info()->name()))) {
    std::filesystem::create_directories(path_);
  }
  ~TemporaryFolder() { std::filesystem::remove_all(path_); }
  std::string Write(const std::string& name, const std::string& text) const {
    std::ofstream(path_ / name, std::ios::binary) << text;
    return (path_ / name).string();
  }

 private:
  std::filesystem::path path_;
};

TEST(BadPbrt, IsRefusedWithFileLineAndReason) {
  const BadText cases[] = {
      {"\n\nFrobnicate 1 2", "t.pbrt:3", "unknown directive 'Frobnicate'"},
      {"\n[", "t.pbrt:2", "a directive is expected"},
      {"Shape \"sphere\" \"float radius\" [1\n", "t.pbrt:2", "']' of"},
      {"Shape \"sphere\" \"float radius\" [[1]]", "t.pbrt:1", "']' of"},
      {"Shape \"sphere\" \"float radius\" 1 2", "t.pbrt:1", "unknown directive '2'"},
      {"Shape \"sphere\" \"float radius\" [1 2]", "t.pbrt:1", "takes one value, not 2"},
      {"Shape \"sphere\" \"float radius\" []", "t.pbrt:1", "takes one value, not 0"},
      {"Shape \"sphere\" \"float radius\" \"1\"", "t.pbrt:1", "a number is expected"},
      {"Shape \"sphere\" \"float radius\" 1x", "t.pbrt:1", "a number is expected"},
      {"Shape \"sphere\" \"float radius\" -1", "t.pbrt:1", "radius is -1"},
      {"Shape \"sphere\" \"float radius\" nan", "t.pbrt:1", "not finite"},
      {"Shape \"sphere\" \"float radius\" 1e39", "t.pbrt:1", "not finite"},
      {"Shape \"sphere\" \"float radius\" 1e999", "t.pbrt:1", "not finite"},
      {"Shape \"sphere\" \"flaot radius\" 1", "t.pbrt:1", "\"flaot\" is not a parameter type"},
      {"Shape \"sphere\" \"radius\" 1", "t.pbrt:1", "a parameter \"type name\""},
      {"Shape \"sphere\" \"float radius x\" 1", "t.pbrt:1", "a parameter \"type name\""},
      {"Shape sphere", "t.pbrt:1", "in quotes is expected"},
      {"Shape \"sph\nere\"", "t.pbrt:1", "without closing quote"},
      {"Shape \"sph", "t.pbrt:1", "without closing quote"},
      {"Shape \"sph\\", "t.pbrt:1", "without closing quote"},
      {"Shape \"sph\\qere\"", "t.pbrt:1", "unknown escape"},
      {"Material \"metal\" \"bool remaproughness\" \"maybe\"", "t.pbrt:1", "true or false"},
      {"Film \"rgb\" \"integer xresolution\" 1.5", "t.pbrt:1", "an integer is expected"},
      {"Film \"rgb\" \"integer xresolution\" 9999999999", "t.pbrt:1", "an integer is expected"},
      {"Film \"rgb\" \"integer xresolution\" 0", "t.pbrt:1", "\"xresolution\" is 0"},
      {"Sampler \"halton\" \"integer pixelsamples\" -4", "t.pbrt:1", "\"pixelsamples\" is -4"},
      {"Integrator \"path\" \"integer maxdepth\" -1", "t.pbrt:1", "\"maxdepth\" is -1"},
      {"Camera \"perspective\" \"float fov\" 180", "t.pbrt:1", "between 0 and 180"},
      {"PixelFilter \"box\" \"float xradius\" 0", "t.pbrt:1", "radius is not positive"},
      {"WorldBegin\nCamera \"perspective\"", "t.pbrt:2", "before WorldBegin"},
      {"WorldBegin\nWorldBegin", "t.pbrt:2", "a second WorldBegin"},
      {"WorldEnd", "t.pbrt:1", "WorldEnd without WorldBegin"},
      {"Translate 1 2", "t.pbrt:1", "takes 3 numbers; after 2"},
      {"Translate [1 2 3 4]", "t.pbrt:1", "']' is expected"},
      {"Translate 1 2 inf", "t.pbrt:1", "not finite"},
      {"\nScale 1 0 1\nCamera \"perspective\"", "t.pbrt:3", "singular since the Scale of t.pbrt:2"},
      {"Rotate 30 0 0 0", "t.pbrt:1", "length zero"},
      {"LookAt 0 0 0  0 0 0  0 1 0", "t.pbrt:1", "singular"},
      {"LookAt 0 0 0  0 1 0  0 1 0", "t.pbrt:1", "singular"},
      {"Transform [1 0 0 0 0 1 0 0 1 0 0 0 0 0 0 1]\nCamera \"perspective\"", "t.pbrt:2",
       "singular since the Transform of t.pbrt:1"},
      {"Transform [1 0 0 1 0 1 0 0 0 0 1 0 0 0 0 1]\nCamera \"perspective\"", "t.pbrt:2",
       "projective since the Transform of t.pbrt:1"},
      {"Transform [1 0 0 0]", "t.pbrt:1", "takes 16 numbers"},
      {"CoordSysTransform \"nowhere\"", "t.pbrt:1", "no coordinate system"},
      {"ActiveTransform Sometimes", "t.pbrt:1", "All, StartTime or EndTime"},
      {"\nAttributeBegin\n\n", "t.pbrt:2", "AttributeBegin is never closed"},
      {"WorldBegin ObjectBegin \"a\"\nAttributeEnd", "t.pbrt:2",
       "cannot close the ObjectBegin of t.pbrt:1"},
      {"AttributeEnd", "t.pbrt:1", "AttributeEnd without AttributeBegin"},
      {"TransformEnd", "t.pbrt:1", "TransformEnd without TransformBegin"},
      {"ObjectEnd", "t.pbrt:1", "ObjectEnd without ObjectBegin"},
      {"AttributeBegin\nWorldBegin", "t.pbrt:2", "inside the AttributeBegin"},
      {"ObjectBegin \"a\"\nObjectBegin \"b\"", "t.pbrt:2", "inside another object"},
      {"ObjectBegin \"a\"\nObjectInstance \"a\"", "t.pbrt:2", "inside an object"},
      {"ObjectInstance \"a\"", "t.pbrt:1", "no object \"a\""},
      {"WorldBegin Texture \"c\" \"spectrum\" \"marble\" Material \"matte\" \"texture Kd\" \"c\" "
       "Scale 1e30 1 1\nShape \"trianglemesh\" \"point3 P\" [1e30 0 0 1 0 0 0 1 0]",
       "t.pbrt:2", "vertex 0 is not finite"},
      {"MakeNamedMaterial \"a\"", "t.pbrt:1", "needs a \"string type\""},
      {"Material \"matte\" \"rgb Kd\" [1 2]", "t.pbrt:1", "not a multiple of 3"},
      {"Material \"matte\" \"rgb Kd\" [1 1 1 1 1 1]", "t.pbrt:1", "three values"},
      {"Material \"matte\" \"spectrum Kd\" [400 1 500]", "t.pbrt:1", "pairs"},
      {"Material \"glass\" \"float eta\" 0", "t.pbrt:1", "index of refraction is 0"},
      {"Material \"metal\" \"rgb k\" [-1 0 0]", "t.pbrt:1", "negative"},
      {"Material \"metal\" \"float roughness\" -1", "t.pbrt:1", "negative"},
      {"LightSource \"infinite\" \"rgb L\" [-1 0 0]", "t.pbrt:1", "negative radiance"},
      {"Shape \"plymesh\"", "t.pbrt:1", "needs a \"string filename\""},
      {"Shape \"trianglemesh\" \"integer indices\" [0 1 2]", "t.pbrt:1", "needs vertices"},
      {"Shape \"trianglemesh\" \"point P\" [0 0 0 1 1]", "t.pbrt:1", "not a multiple of 3"},
      {"Shape \"trianglemesh\" \"point P\" [0 0 0 1 0 0 0 1 0 1 1 1]", "t.pbrt:1",
       "needs \"integer"},
      {"Shape \"trianglemesh\"\n\"point P\" [0 0 0 1 0 0 0 1 0]\n\"integer indices\" [0 1 3]",
       "t.pbrt:3", "index 3 (number 2) is not in 0..2"},
      {"Shape \"trianglemesh\" \"point P\" [0 0 0 1 0 0 0 1 0] \"integer indices\" [0 1 -1]",
       "t.pbrt:1", "index -1"},
      {"Shape \"trianglemesh\" \"point P\" [0 0 0 1 0 0 0 1 0] \"integer indices\" [0 1]",
       "t.pbrt:1", "2 indices are no triangles"},
      {"Shape \"trianglemesh\" \"integer indices\" [0 1 2]\n\"point P\" [0 0 0 1 nan 0 0 1 0]",
       "t.pbrt:2", "not finite"},
      {"Shape \"trianglemesh\" \"point P\" [0 0 0 1 0 0 0 1 0] \"normal N\" [0 0 1]", "t.pbrt:1",
       "1 \"N\" for 3 vertices"},
      {"Scale 1e30 1e30 1e30\nShape \"sphere\" \"float radius\" 1e30", "t.pbrt:2",
       "not finite after"},
      {"Shape \"loopsubdiv\" \"integer levels\" 40 \"integer indices\" [0 1 2] \"point P\" "
       "[0 0 0 1 0 0 0 1 0]",
       "t.pbrt:1", "40 levels"},
      {"Shape \"loopsubdiv\" \"integer levels\" -1 \"integer indices\" [0 1 2] \"point P\" "
       "[0 0 0 1 0 0 0 1 0]",
       "t.pbrt:1", "-1 levels"},
      {"\nShape \"curve\"", "t.pbrt:2", "needs vertices"},
      {"Shape \"curve\" \"point3 P\" [0 0 0 1 0 0 2 0 0 3 0 0 4 0 0]", "t.pbrt:1",
       "5 points \"P\" are no Bezier segments of degree 3"},
      {"Shape \"curve\" \"point3 P\" [0 0 0 1 0 0] \"integer degree\" 2 \"string basis\" "
       "\"bspline\"",
       "t.pbrt:1", "2 points \"P\" are no B-spline of degree 2"},
      {"Shape \"curve\" \"point3 P\" [0 0 0 1 0 0 2 0 0 3 0 0]\n\"integer degree\" 4", "t.pbrt:2",
       "the degree is 4"},
      {"Shape \"curve\" \"point3 P\" [0 0 0 1 0 0 2 0 0 3 0 0]\n\"string basis\" \"nurbs\"",
       "t.pbrt:2", "no basis \"nurbs\""},
      {"Shape \"curve\" \"point3 P\" [0 0 0 1 0 0 2 0 0 3 0 0]\n\"string type\" \"round\"",
       "t.pbrt:2", "no type \"round\""},
      {"Shape \"curve\" \"point3 P\" [0 0 0 1 0 0 2 0 0 3 0 0] \"float width1\" -1", "t.pbrt:1",
       "widths of 1 and -1"},
      {"Shape \"curve\" \"point3 P\" [0 0 0 1 0 0 2 0 0 3 0 0] \"float width\" 0", "t.pbrt:1",
       "widths of 0 and 0"},
      {"Shape \"curve\" \"point3 P\" [0 0 0 1 0 0 2 0 0 3 0 0] \"string type\" \"ribbon\"",
       "t.pbrt:1", "0 normals \"N\" for 1 segments"},
      {"Shape \"curve\" \"point3 P\" [0 0 0 1 0 0 2 0 0 3 0 0] \"string type\" "
       "\"ribbon\"\n\"normal N\" "
       "[0 0 1 0 0 0]",
       "t.pbrt:2", "normal 1 is no direction"},
  };
  for (const BadText& bad : cases) {
    const std::string error = PbrtError(bad.text);
    EXPECT_TRUE(error.starts_with(std::string(bad.place) + ": ")) << bad.text << " -> " << error;
    EXPECT_TRUE(Contains(error, bad.reason)) << bad.text << " -> " << error;
  }
}

TEST(BadPbrt, EveryTruncationIsReadOrRefused) {
  const std::string text =
      "LookAt 0 0 5 0 0 0 0 1 0 Camera \"perspective\" \"float fov\" [40]\nWorldBegin\n"
      "AttributeBegin Material \"metal\" \"spectrum eta\" \"metal-Cu-eta\"\n"
      "Shape \"trianglemesh\" \"integer indices\" [0 1 2] \"point P\" [0 0 0 1 0 0 0 1 0]\n"
      "AttributeEnd ObjectBegin \"o\" Shape \"loopsubdiv\" \"integer levels\" 1 \"integer "
      "indices\" "
      "[0 1 2] \"point P\" [0 0 0 1 0 0 0 1 0] ObjectEnd ObjectInstance \"o\" WorldEnd\n";
  EXPECT_EQ(PbrtError(text), "");
  for (std::size_t size = 0; size < text.size(); ++size) {
    const std::string error = PbrtError(text.substr(0, size));
    EXPECT_TRUE(error.empty() || error.starts_with("t.pbrt:")) << error;
  }
}

TEST(BadPbrt, EveryFlippedByteIsReadOrRefused) {
  const std::string text =
      "WorldBegin\nAttributeBegin Material \"metal\" \"float roughness\" 0.1\n"
      "Shape \"trianglemesh\" \"integer indices\" [0 1 2] \"point P\" [0 0 0 1 0 0 0 1 0]\n"
      "AttributeEnd # end\nRotate 4 1 0 0 LightSource \"infinite\" \"rgb L\" [1 1 1]\n";
  for (std::size_t i = 0; i < text.size(); ++i) {
    for (const int change : {1, 2, 16, 32, 128, 255}) {
      std::string broken = text;
      broken[i] = static_cast<char>(broken[i] ^ change);
      const std::string error = PbrtError(broken);
      EXPECT_TRUE(error.empty() || error.starts_with("t.pbrt:")) << error;
    }
  }
}

TEST(BadPbrt, NestingAndGrowthAreBounded) {
  std::string scopes;
  for (int i = 0; i < 100000; ++i) scopes += "AttributeBegin\n";
  EXPECT_EQ(PbrtError(scopes), "t.pbrt:4097: scopes are nested more than 4096 deep");

  std::string parameters = "Shape \"sphere\"";
  for (int i = 0; i < 1000; ++i) parameters += " \"float p" + std::to_string(i) + "\" 1";
  EXPECT_TRUE(Contains(PbrtError(parameters), "more than 256 parameters"));

  // 4^13 triangles exceed the limit of subdivision, so the shape is refused before any level is
  // made.
  EXPECT_TRUE(Contains(PbrtError("Shape \"loopsubdiv\" \"integer levels\" 13 \"integer indices\" "
                                 "[0 1 2] \"point P\" [0 0 0 1 0 0 0 1 0]"),
                       "13 levels"));
}

TEST(BadPbrt, IncludesDoNotRecur) {
  const TemporaryFolder folder;
  const std::string self = folder.Write("self.pbrt", "\nInclude \"self.pbrt\"\n");
  const std::string error = ErrorOf([&] { ReadScene(self); });
  EXPECT_TRUE(Contains(error, "self.pbrt:2: ") && Contains(error, "includes itself")) << error;

  folder.Write("b.pbrt", "Include \"./a.pbrt\"");
  const std::string cycle = folder.Write("a.pbrt", "Include \"b.pbrt\"");
  EXPECT_TRUE(Contains(ErrorOf([&] { ReadScene(cycle); }), "b.pbrt:1: "));

  for (int i = 0; i < 20; ++i) {
    folder.Write("deep" + std::to_string(i) + ".pbrt",
                 "Include \"deep" + std::to_string(i + 1) + ".pbrt\"");
  }
  folder.Write("deep20.pbrt", "WorldBegin");
  EXPECT_TRUE(
      Contains(ErrorOf([&] { ReadScene(folder.Write("m.pbrt", "Include \"deep0.pbrt\"")); }),
               "nested more than 16 deep"));
  EXPECT_EQ(ErrorOf([&] { ReadScene(folder.Write("m.pbrt", "Include \"deep6.pbrt\"")); }), "");

  // Three small files produce 10^6 includes.
  std::string hundred[3];
  for (int i = 0; i < 100; ++i) {
    for (int level = 0; level < 3; ++level) {
      hundred[level] += "Include \"h" + std::to_string(level + 1) + ".pbrt\"\n";
    }
  }
  for (int level = 0; level < 3; ++level) {
    folder.Write("h" + std::to_string(level) + ".pbrt", hundred[level]);
  }
  folder.Write("h3.pbrt", "Identity");
  EXPECT_TRUE(Contains(ErrorOf([&] { ReadScene(folder.Write("m.pbrt", "Include \"h0.pbrt\"")); }),
                       "more than 100000 includes"));

  // An imported file stands in a scope of its own.
  const std::string import = "WorldBegin AttributeBegin\nImport \"part.pbrt\" AttributeEnd";
  for (const auto& [part, place, reason] :
       {std::tuple("\nAttributeEnd", "part.pbrt:2: ", "cannot close the Import"),
        {"\n\nAttributeBegin", "part.pbrt:3: ", "is never closed"},
        {"\nWorldBegin", "part.pbrt:2: ", "a second WorldBegin"}}) {
    folder.Write("part.pbrt", part);
    const std::string fault = ErrorOf([&] { ReadScene(folder.Write("m.pbrt", import)); });
    EXPECT_TRUE(Contains(fault, place) && Contains(fault, reason)) << fault;
  }
  const std::string early =
      ErrorOf([&] { ReadScene(folder.Write("m.pbrt", "\nImport \"part.pbrt\"\nWorldBegin")); });
  EXPECT_TRUE(Contains(early, "m.pbrt:2: ") && Contains(early, "after WorldBegin")) << early;

  folder.Write("bad.pbrt", "\n\nTranslate 1 x 1");
  const std::string inner =
      ErrorOf([&] { ReadScene(folder.Write("m.pbrt", "Include \"bad.pbrt\"")); });
  EXPECT_TRUE(Contains(inner, "bad.pbrt:3: ")) << inner;

  folder.Write("bad.ply", "ply\nformat ascii 1.0\nelement vertex x\n");
  const std::string ply = ErrorOf([&] {
    ReadScene(folder.Write("m.pbrt", "\nShape \"plymesh\" \"string filename\" \"bad.ply\""),
              {.missing = MissingFiles::kRefuse});
  });
  EXPECT_TRUE(Contains(ply, "m.pbrt:2: ") && Contains(ply, "bad.ply:3: ")) << ply;
}

TEST(BadScene, UnknownNamesAndEndingsAreRefused) {
  const TemporaryFolder folder;
  const std::string blend = folder.Write("a.blend", "BLENDER");
  EXPECT_TRUE(Contains(ErrorOf([&] { ReadScene(blend); }), ".pbrt, .obj, .gltf, .glb or .ply"));
  const std::string error = ErrorOf([] { ReadScene("galery"); });
  EXPECT_TRUE(Contains(error, "galery") && Contains(error, "gallery")) << error;
  EXPECT_NE(ErrorOf([&] { ReadScene(folder.Write("e.ply", "")); }), "");
}

// The following tests read PLY files.

std::string PlyHeaderText(const std::string& format, const std::string& vertices = "3",
                          const std::string& faces = "1") {
  return "ply\nformat " + format + " 1.0\nelement vertex " + vertices +
         "\nproperty float x\nproperty float y\nproperty float z\nelement face " + faces +
         "\nproperty list uchar int vertex_indices\nend_header\n";
}

template <typename Value>
void Append(std::string& bytes, Value value, bool big_endian) {
  char raw[sizeof(Value)];
  std::memcpy(raw, &value, sizeof raw);
  if (big_endian) {
    for (std::size_t i = 0; i < sizeof raw / 2; ++i) std::swap(raw[i], raw[sizeof raw - 1 - i]);
  }
  bytes.append(raw, sizeof raw);
}

std::string BinaryPly(bool big_endian, float x = 0, std::int32_t index = 2,
                      std::uint8_t corners = 3) {
  std::string bytes = PlyHeaderText(big_endian ? "binary_big_endian" : "binary_little_endian");
  for (const float v : {x, 0.f, 0.f, 1.f, 0.f, 0.f, 0.f, 1.f, 0.f}) Append(bytes, v, big_endian);
  bytes += static_cast<char>(corners);
  for (const std::int32_t i : {0, 1, index}) Append(bytes, i, big_endian);
  return bytes;
}

TEST(Ply, FormatsTypesAndExtras) {
  for (const bool big_endian : {false, true}) {
    const Mesh mesh = ParsePly(BinaryPly(big_endian, 0.25f), "t.ply");
    ASSERT_EQ(mesh.positions.size(), 3u);
    EXPECT_EQ(mesh.positions[0], glm::vec3(0.25f, 0, 0));
    EXPECT_EQ(mesh.triangles.at(0), glm::uvec3(0, 1, 2));
  }
  // Quads become fans, unknown properties and elements are skipped, and normals determine the
  // winding.
  const Mesh quad = ParsePly(
      "ply\r\nformat ascii 1.0\r\ncomment c\r\nobj_info o\r\nelement material 1\r\n"
      "property list int float a\r\nproperty uchar b\r\nelement vertex 4\r\nproperty double x\r\n"
      "property int16 y\r\nproperty float z\r\nproperty uchar red\r\nproperty float nx\r\n"
      "property float ny\r\nproperty float nz\r\nproperty float s\r\nproperty float t\r\n"
      "element face 1\r\nproperty uchar flags\r\nproperty list uint8 uint32 vertex_index\r\n"
      "end_header\r\n2 0.5 0.5 7\r\n0 0 0 255 0 0 -2 0 0\r\n1 0 0 255 0 0 -2 1 0\r\n"
      "1 1 0 255 0 0 0 1 1\r\n0 1 0 255 0 0 -2 0 1\r\n0 4 0 1 2 3\r\n",
      "t.ply");
  ASSERT_EQ(quad.triangles.size(), 2u);
  EXPECT_EQ(quad.triangles[0], glm::uvec3(0, 2, 1));
  EXPECT_EQ(quad.triangles[1], glm::uvec3(0, 3, 2));
  EXPECT_EQ(quad.normals.at(0), glm::vec3(0, 0, -1));
  EXPECT_NEAR(glm::length(quad.normals.at(2)), 1, 1e-6);  // a normal of length zero is replaced
  EXPECT_EQ(quad.uvs.at(2), glm::vec2(1, 1));
}

// Exporters have four pairs of names for the same coordinates.
TEST(Ply, EveryPropertyGoesToItsPlace) {
  const std::pair<const char*, const char*> pairs[] = {
      {"u", "v"}, {"s", "t"}, {"texture_u", "texture_v"}, {"texture_s", "texture_t"}};
  for (const auto& [u, v] : pairs) {
    SCOPED_TRACE(u);
    const Mesh mesh = ParsePly(
        std::string("ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\n"
                    "property float z\nproperty float nx\nproperty float ny\nproperty float nz\n"
                    "property float ") +
            u + "\nproperty float " + v +
            "\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n"
            "1 2 3 .6 0 .8 .25 .75\n4 2 3 0 .6 .8 .5 .125\n1 6 3 0 -.6 .8 1 0\n3 0 1 2\n",
        "t.ply");
    ASSERT_EQ(mesh.uvs.size(), 3u);
    EXPECT_EQ(mesh.positions[0], glm::vec3(1, 2, 3));
    EXPECT_LT(glm::length(mesh.normals.at(0) - glm::vec3(0.6f, 0, 0.8f)), 1e-6f);
    EXPECT_LT(glm::length(mesh.normals.at(1) - glm::vec3(0, 0.6f, 0.8f)), 1e-6f);
    EXPECT_EQ(mesh.uvs[0], glm::vec2(0.25f, 0.75f));
    EXPECT_EQ(mesh.uvs[1], glm::vec2(0.5f, 0.125f));
  }
}

TEST(BadPly, EveryTruncationIsRefused) {
  for (const bool big_endian : {false, true}) {
    const std::string bytes = BinaryPly(big_endian);
    EXPECT_EQ(PlyError(bytes), "");
    for (std::size_t size = 0; size < bytes.size(); ++size) {
      const std::string error = PlyError(bytes.substr(0, size));
      EXPECT_TRUE(error.starts_with("t.ply")) << size << " " << error;
    }
  }
  // In ascii, only the loss of the last digit may go unnoticed.
  const std::string text = PlyHeaderText("ascii") + "0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n";
  for (std::size_t size = 0; size + 1 < text.size(); ++size) {
    EXPECT_NE(PlyError(text.substr(0, size)), "") << size;
  }
}

TEST(BadPly, EveryFlippedByteIsReadOrRefused) {
  const std::string bytes = BinaryPly(false);
  for (std::size_t i = 0; i < bytes.size(); ++i) {
    for (int change = 1; change < 256; change += 7) {
      std::string broken = bytes;
      broken[i] = static_cast<char>(broken[i] ^ change);
      const std::string error = PlyError(broken);
      EXPECT_TRUE(error.empty() || error.starts_with("t.ply")) << error;
    }
  }
}

TEST(BadPly, IsRefusedWithPlaceAndReason) {
  const std::string data = "0 0 0\n1 0 0\n0 1 0\n";
  const struct {
    std::string bytes, place, reason;
  } cases[] = {
      {"", "t.ply:1", "not a PLY file"},
      {"\x1f\x8b\x08", "t.ply", "gunzip"},
      {"ply\nformat ascii 2.0\n", "t.ply:2", "format"},
      {"ply\nformat ascii 1.0\nelement vertex -1\n", "t.ply:3", "no count"},
      {"ply\nformat ascii 1.0\nelement vertex 99999999999999999999\n", "t.ply:3", "no count"},
      {"ply\nformat ascii 1.0\nproperty float x\n", "t.ply:3", "before the first element"},
      {"ply\nformat ascii 1.0\nelement vertex 1\nproperty half x\n", "t.ply:4", "not a PLY type"},
      {"ply\nformat ascii 1.0\nelement face 1\nproperty list float int a\n", "t.ply:4", "integer"},
      {"ply\nformat ascii 1.0\nend_header\n", "t.ply", "no element 'vertex'"},
      {"ply\nformat ascii 1.0\nelement vertex 0\nproperty float x\nproperty float y\nelement face "
       "0\n"
       "end_header\n",
       "t.ply", "without x, y and z"},
      {PlyHeaderText("ascii", "4000000000"), "t.ply:9", "do not fit"},
      {PlyHeaderText("ascii", "18446744073709551615", "18446744073709551615"), "t.ply:9",
       "do not fit"},
      {PlyHeaderText("binary_little_endian", "3", "100000000000"), "t.ply:9", "do not fit"},
      {PlyHeaderText("ascii") + "0 0 0\n1 nan 0\n0 1 0\n3 0 1 2\n", "t.ply:11", "'y' of vertex 1"},
      {PlyHeaderText("ascii") + "0 0 0\n1 1e99 0\n0 1 0\n3 0 1 2\n", "t.ply:11", "'y' of vertex 1"},
      {PlyHeaderText("ascii") + "0 0 0\n1 a 0\n0 1 0\n3 0 1 2\n", "t.ply:11",
       "'a' is not a number"},
      {PlyHeaderText("ascii") + data + "3 0 1 3\n", "t.ply:13", "index 3 is not in 0..2"},
      {PlyHeaderText("ascii") + data + "3 0 1 -1\n", "t.ply:13", "index -1"},
      {PlyHeaderText("ascii") + data + "3 0 1 .5\n", "t.ply:13", "no integer"},
      {PlyHeaderText("ascii") + data + "255 0 1 2\n", "t.ply:13", "does not fit"},
      {BinaryPly(true, 0, 3), "t.ply (byte ", "index 3"},
      {BinaryPly(false, 0, -1), "t.ply (byte ", "index -1"},
      {BinaryPly(false, 0, 2, 200), "t.ply (byte ", "does not fit"},
      {BinaryPly(false, NAN), "t.ply (byte ", "not finite"},
  };
  for (const auto& bad : cases) {
    const std::string error = PlyError(bad.bytes);
    EXPECT_TRUE(error.starts_with(bad.place)) << bad.bytes << " -> " << error;
    EXPECT_TRUE(Contains(error, bad.reason)) << bad.bytes << " -> " << error;
  }
}

}  // namespace
}  // namespace skywave
