// Every unusable OBJ or MTL file is refused with its line and the reason; none crashes.
#include <gtest/gtest.h>

#include <string>

#include "base/error.h"
#include "scene/obj/check.h"
#include "scene/obj/mtl.h"
#include "scene/obj/reader.h"
#include "tests/support/temporary_folder.h"

namespace skywave {
namespace {

struct Refusal {
  std::string message;  // empty if it was read
  int exit_code = 0;
};

template <typename Read>
Refusal Try(Read read) {
  try {
    read();
  } catch (const InputError& error) {
    return {error.what(), error.exit_code()};
  }
  return {};
}

Refusal TryObj(const std::string& text) {
  return Try([&] { ParseObj(text, "t.obj"); });
}
Refusal TryMtl(const std::string& text) {
  return Try([&] {
    Warnings warnings;
    Scene scene;
    TextureFiles textures{&scene};
    ParseMtl(text, "t.mtl", textures, warnings);
  });
}

struct BadText {
  std::string text;
  const char* place;
  const char* reason;
};

void ExpectRefused(const BadText& bad, const Refusal& refusal) {
  EXPECT_TRUE(refusal.message.starts_with(std::string(bad.place) + ": "))
      << bad.text << " -> " << refusal.message;
  EXPECT_NE(refusal.message.find(bad.reason), std::string::npos)
      << bad.text << " -> " << refusal.message;
  EXPECT_EQ(refusal.exit_code, kExitBadInput);
}

const std::string kTriangle = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";

TEST(BadObj, IsRefusedWithFileLineAndReason) {
  std::string polygon = "f";
  for (std::size_t i = 0; i <= kMaxObjCorners; ++i) polygon += " 1";
  const BadText cases[] = {
      {"v 0 0\n", "t.obj:1", "3 to 7 numbers, not 2"},
      {"v 0 0 0x\n", "t.obj:1", "'0x' is not a number"},
      {"v\n", "t.obj:1", "3 to 7 numbers, not 0"},
      {"vn 0 0\n", "t.obj:1", "takes 3 numbers"},
      {"vt a\n", "t.obj:1", "not a number"},
      {kTriangle + "f 1/1/1/1 2 3\n", "t.obj:4", "is no index"},
      {kTriangle + "f 1 2 x\n", "t.obj:4", "'x' is no index"},
      {kTriangle + "f 1 2 3.5\n", "t.obj:4", "is no index"},
      {kTriangle + "f 1 2 99999999999\n", "t.obj:4", "is no index"},
      {kTriangle + polygon, "t.obj:4", "1025 corners"},
      {"\xFE\xFF\0v", "t.obj", "UTF-16"},
      {"\xFF\xFEv\0", "t.obj", "UTF-16"},
  };
  for (const BadText& bad : cases) ExpectRefused(bad, TryObj(bad.text));
}

// Faces, points and lines of elements that the file does not have are left out, and no others.
TEST(BadObj, WhatNamesMissingElementsIsLeftOut) {
  const BadText cases[] = {
      {kTriangle + "f 1 2 4\n", "t.obj:4", "a face with indices beyond the vertices of the file"},
      {kTriangle + "\n# c\nf 1 2 \\\n 9\n", "t.obj:6", "a face with indices beyond"},
      {kTriangle + "f 1 2 -4\n", "t.obj:4", "'f' with vertex index -4 with 3 before it"},
      {kTriangle + "f 0 1 2\n", "t.obj:4", "'f' with vertex index 0, and OBJ counts from 1"},
      {kTriangle + "p 1 9\n", "t.obj:4", "points or lines of vertices that the file does not have"},
      {kTriangle + "l 1 2 9\n", "t.obj:4", "points or lines of vertices"},
      {kTriangle + "l 1 -4\n", "t.obj:4", "'l' with vertex index -4 with 3 before it"},
  };
  for (const BadText& bad : cases) {
    SCOPED_TRACE(bad.text);
    const Scene scene = ParseObj(bad.text + "f 1 2 3\n", "t.obj", {.point_size = 0.1f});
    ASSERT_EQ(scene.warnings.size(), 1u);
    EXPECT_TRUE(scene.warnings[0].starts_with(std::string(bad.place) + ": " + bad.reason))
        << scene.warnings[0];
    EXPECT_TRUE(scene.warnings[0].ends_with(": left out")) << scene.warnings[0];
    ASSERT_FALSE(scene.meshes.empty());
    EXPECT_EQ(scene.meshes[0].triangles.size(), 1u);
  }
}

// What a corner has besides its vertex is not needed for a face: the middle corner loses it here.
TEST(BadObj, FacesAreThereWithoutTheTextureVerticesAndNormalsThatAreNot) {
  const glm::vec3 given(0, 0.6f, 0.8f), computed(0, 0, 1);
  struct Lost {
    const char *face, *warning;
    glm::vec3 normal;
  };
  const Lost cases[] = {
      {"f 1/1/1 2/3/1 3/2/1",
       "faces have texture vertex indices, and the file has 2 of these: those beyond are ignored",
       given},
      {"f 1/1/1 2//2 3/2/1",
       "faces have normal indices, and the file has 1 of these: those beyond are ignored",
       computed},
      {"f 1/1 2/0 3/2", "'f' with texture vertex index 0, and OBJ counts from 1: ignored",
       computed},
      {"f 1/-2/1 2/-3/1 3/-1/1", "'f' with texture vertex index -3 with 2 before it: ignored",
       given},
      {"f 1/1/1 2//-2 3/2/1", "'f' with normal index -2 with 1 before it: ignored", computed},
  };
  for (const Lost& lost : cases) {
    SCOPED_TRACE(lost.face);
    const Scene scene =
        ParseObj(kTriangle + "vt 0.25 0.5\nvt 0.75 0.5\nvn 0 0.6 0.8\n" + lost.face, "t.obj");
    EXPECT_EQ(scene.warnings, std::vector{"t.obj:7: " + std::string(lost.warning)});
    ASSERT_EQ(scene.meshes.size(), 1u);
    const Mesh& mesh = scene.meshes[0];
    ASSERT_EQ(mesh.positions.size(), 3u);
    for (std::size_t i = 0; i < 3; ++i) {
      const glm::vec3 at = mesh.positions[i];
      EXPECT_EQ(mesh.uvs[i].x, at.x > 0 ? 0.0f : at.y > 0 ? 0.75f : 0.25f);
      EXPECT_NEAR(glm::dot(mesh.normals.at(i), lost.normal), 1, 1e-6);
    }
  }
}

// One vertex that is no place costs its faces, whichever way they name it.
TEST(BadObj, FacesOfVerticesThatAreNotFiniteAreLeftOut) {
  for (const char* const odd : {"nan", "-inf", "1e39", "1e999", "-1.#IND00", "1.#QNAN"}) {
    SCOPED_TRACE(odd);
    const Scene scene = ParseObj("f 1 2 4\n" + kTriangle + "v 1 " + odd +
                                     " 0\nf 1 2 3\nf 1 2 -1\nf 1 3 4\nv 1 1 0\nf 1 2 5\np 4\np 5\n",
                                 "t.obj", {.point_size = 0.1f});
    ASSERT_EQ(scene.warnings.size(), 1u);
    EXPECT_EQ(scene.warnings[0],
              "t.obj:5: 'v' with a number that is not finite: its faces are left out");
    std::size_t triangles = 0;
    for (const Mesh& mesh : scene.meshes)
      triangles += mesh.triangles.size() <= 2 ? mesh.triangles.size() : 0;
    EXPECT_EQ(triangles, 2u) << "of corners 1 2 3 and 1 2 5";
  }
  // A float that is too small is 0.
  EXPECT_TRUE(ParseObj("v 0 0 1e-999\nv 1 0 0\nv 0 1 0\nf 1 2 3\n", "t.obj").warnings.empty());
}

TEST(BadObj, NormalsThatAreNotFiniteAreThoseOfTheirTriangles) {
  const Scene scene = ParseObj(kTriangle + "vn 0 nan 1\nvt inf 0\nf 1/1/1 2/1/1 3/1/1\n", "t.obj");
  ASSERT_EQ(scene.warnings.size(), 2u);
  EXPECT_EQ(scene.warnings[0],
            "t.obj:4: 'vn' with a number that is not finite: the normal is that of its triangles");
  EXPECT_EQ(scene.warnings[1], "t.obj:5: 'vt' with a number that is not finite: 0 is taken");
  EXPECT_EQ(scene.meshes.at(0).normals.at(0), glm::vec3(0, 0, 1));
}

TEST(BadObj, BrokenLibrariesAreRefused) {
  const TemporaryFolder folder;
  folder.Write("bad.mtl", "newmtl a\nKd 1 x 1\n");
  const Refusal broken =
      Try([&] { ReadObj(folder.Write("b.obj", "mtllib bad.mtl\n" + kTriangle + "f 1 2 3\n")); });
  EXPECT_EQ(broken.message, folder.Path("bad.mtl") + ":2: 'x' is not a number");
  EXPECT_EQ(Try([&] { ReadObj(folder.Path("none.obj")); }).exit_code, kExitIo);
  folder.Write("two.mtl", "newmtl wood oak\nKd 1 1 1\nnewmtl wood pine\nKd 0 0 0\n");
  const Refusal alike = Try([&] {
    ReadObj(folder.Write("c.obj", "mtllib two.mtl\nusemtl wood oak\nusemtl wood pine\n"));
  });
  EXPECT_NE(alike.message.find("c.obj:3: "), std::string::npos) << alike.message;
}

TEST(BadMtl, IsRefusedWithFileLineAndReason) {
  const BadText cases[] = {
      {"Kd 1 1 1\n", "t.mtl:1", "before the first newmtl"},
      {"newmtl a\nKd\n", "t.mtl:2", "1 to 3 numbers, not 0"},
      {"newmtl a\nKd 1 1\n", "t.mtl:2", "one or three numbers"},
      {"newmtl a\nKd 1 -1 1\n", "t.mtl:2", "not negative"},
      {"newmtl a\nKd nan 1 1\n", "t.mtl:2", "not finite"},
      {"newmtl a\nKd spectral a.rfl\n", "t.mtl:2", "'spectral' is not a number"},
      {"newmtl a\n\nNs 1e999\n", "t.mtl:3", "not finite"},
      {"newmtl a\nd -halo 0.5\n", "t.mtl:2", "-halo"},
      {"newmtl a\nillum two\n", "t.mtl:2", "not a number"},
  };
  for (const BadText& bad : cases) ExpectRefused(bad, TryMtl(bad.text));
}

TEST(BadObj, TruncationsAndFlippedBytesAreReadOrRefused) {
  const std::string text =
      "o thing\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvt 0 0\nvn 0 0 1\ns 1\nusemtl a b\n"
      "f 1/1/1 2/1/1 3/1/1 4/1/1\ns off\nf -1//-1 -2//-1 -3//-1\ng x \\\n y\nf 1 2 3 4\n";
  EXPECT_EQ(TryObj(text).message, "");
  for (std::size_t size = 0; size < text.size(); ++size) {
    const std::string message = TryObj(text.substr(0, size)).message;
    EXPECT_TRUE(message.empty() || message.starts_with("t.obj:")) << message;
  }
  for (std::size_t i = 0; i < text.size(); ++i) {
    for (int change = 1; change < 256; change += 5) {
      std::string broken = text;
      broken[i] = static_cast<char>(broken[i] ^ change);
      const std::string message = TryObj(broken).message;
      EXPECT_TRUE(message.empty() || message.starts_with("t.obj")) << message;
    }
  }
}

TEST(BadMtl, TruncationsAndFlippedBytesAreReadOrRefused) {
  const std::string text =
      "# c\nnewmtl a b\n\tKd .5 .5 .5\nKs 1\nNs 10\nNi 1.5\nd 0.5\nillum 2\nmap_Kd -o 1 1 1 a.png\n"
      "map_bump -bm 2 b.png\nnewmtl c\nTr 0.1\nPr .3\nPm 1\nTf 1 1 1\nKe 1 1 1\n";
  EXPECT_EQ(TryMtl(text).message, "");
  for (std::size_t size = 0; size < text.size(); ++size) {
    const std::string message = TryMtl(text.substr(0, size)).message;
    EXPECT_TRUE(message.empty() || message.starts_with("t.mtl:")) << message;
  }
  for (std::size_t i = 0; i < text.size(); ++i) {
    for (int change = 1; change < 256; change += 5) {
      std::string broken = text;
      broken[i] = static_cast<char>(broken[i] ^ change);
      const std::string message = TryMtl(broken).message;
      EXPECT_TRUE(message.empty() || message.starts_with("t.mtl")) << message;
    }
  }
}

}  // namespace
}  // namespace skywave
