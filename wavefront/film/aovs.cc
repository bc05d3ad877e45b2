#include "wavefront/film/aovs.h"

#include <algorithm>
#include <cmath>

namespace skywave {
namespace {

void Copy(const float* x, const float* y, const float* z, std::uint32_t n, const AovColumns& out) {
  std::copy_n(x, n, out[0]), std::copy_n(y, n, out[1]), std::copy_n(z, n, out[2]);
}

void ReadAlbedo(const FirstSurfaces& first, const AovColumns& out) {
  const SurfaceColumns& s = first.surfaces;
  Copy(s.color_r, s.color_g, s.color_b, first.count, out);
}

void ReadNormal(const FirstSurfaces& first, const AovColumns& out) {
  const SurfaceColumns& s = first.surfaces;
  Copy(s.ng_x, s.ng_y, s.ng_z, first.count, out);
}

void ReadShadingNormal(const FirstSurfaces& first, const AovColumns& out) {
  const SurfaceColumns& s = first.surfaces;
  Copy(s.ns_x, s.ns_y, s.ns_z, first.count, out);
}

// Reads where the surfaces are, from the place `from` of the scene.
void ReadPlaces(const FirstSurfaces& first, const glm::vec3& from, const AovColumns& out) {
  const SurfaceColumns& s = first.surfaces;
  for (std::uint32_t i = 0; i < first.count; ++i) {
    out[0][i] = s.org_x[i] - s.ng_x[i] * s.lift[i] - from.x;
    out[1][i] = s.org_y[i] - s.ng_y[i] * s.lift[i] - from.y;
    out[2][i] = s.org_z[i] - s.ng_z[i] * s.lift[i] - from.z;
  }
}

void ReadPosition(const FirstSurfaces& first, const AovColumns& out) {
  ReadPlaces(first, -first.geometry.origin(), out);
}

// Depth is along the axis for cameras with a plane film, else along the ray, as in Blender.
void ReadDepth(const FirstSurfaces& first, const AovColumns& out) {
  const SurfaceColumns& s = first.surfaces;
  const CameraView& camera = first.camera;
  if (!HasPlaneFilm(camera.kind)) {
    std::copy_n(s.t, first.count, out[0]);
    return;
  }
  const float* const f = camera.forward;
  const float scale = 1 / std::sqrt(f[0] * f[0] + f[1] * f[1] + f[2] * f[2]);
  ReadPlaces(first, glm::vec3(camera.origin[0], camera.origin[1], camera.origin[2]), out);
  for (std::uint32_t i = 0; i < first.count; ++i) {
    out[0][i] = scale * (out[0][i] * f[0] + out[1][i] * f[1] + out[2][i] * f[2]);
  }
}

void ReadDistance(const FirstSurfaces& first, const AovColumns& out) {
  std::copy_n(first.surfaces.t, first.count, out[0]);
}

// Axes as in OpenGL: x right, y up, z towards the camera.
void ReadCameraNormal(const FirstSurfaces& first, const AovColumns& out) {
  const SurfaceColumns& s = first.surfaces;
  const CameraView& camera = first.camera;
  const auto along = [&](const float* axis, float sign, float* values) {
    const float scale = sign / std::sqrt(axis[0] * axis[0] + axis[1] * axis[1] + axis[2] * axis[2]);
    for (std::uint32_t i = 0; i < first.count; ++i) {
      values[i] = scale * (s.ns_x[i] * axis[0] + s.ns_y[i] * axis[1] + s.ns_z[i] * axis[2]);
    }
  };
  along(camera.right, 1, out[0]), along(camera.down, -1, out[1]);
  along(camera.forward, -1, out[2]);
}

void ReadUv(const FirstSurfaces& first, const AovColumns& out) {
  const SurfaceColumns& s = first.surfaces;
  for (std::uint32_t i = 0; i < first.count; ++i) {
    const TriangleUvs& triangle = first.geometry.uvs()[s.triangle[i]];
    const float u = s.u[i], v = s.v[i], w = 1 - u - v;
    for (int axis = 0; axis < 2; ++axis) {
      out[axis][i] = w * triangle.uv[0][axis] + u * triangle.uv[1][axis] + v * triangle.uv[2][axis];
    }
    out[2][i] = 1;
  }
}

void ReadObjectId(const FirstSurfaces& first, const AovColumns& out) {
  for (std::uint32_t i = 0; i < first.count; ++i) {
    out[0][i] = float(first.geometry.MeshOf(first.surfaces.triangle[i]) + 1);
  }
}

void ReadMaterialId(const FirstSurfaces& first, const AovColumns& out) {
  for (std::uint32_t i = 0; i < first.count; ++i) {
    out[0][i] = float((first.surfaces.material[i] & kMaterialMask) + 1);
  }
}

template <std::optional<Moment> FrameMotion::*kThen>
void ReadFlow(const FirstSurfaces& first, const AovColumns& out) {
  FindFlow(first.geometry, first.camera, *(first.motion->*kThen), first.surfaces, first.count,
           out[0], out[1], out[2]);
}

void ReadHiddenId(const FirstSurfaces& first, const AovColumns& out) {
  FindHiddenObjects(*first.tracer, first.geometry, first.surfaces, first.count, first.nearest, out);
}

constexpr float kFarAway = 1e10f;  // as in Blender

constexpr Aov OfPart(std::string_view name, std::string_view channels, AovSum sum, LightPart part,
                     std::string_view help) {
  return {.name = name,
          .channels = channels,
          .sum = sum,
          .help = help,
          .of_composites = true,
          .part = part};
}

constexpr Aov kAovs[] = {
    {"albedo", "RGB", AovSum::kMeanOfHits, "reflectance, textures included", ReadAlbedo,
     AovRange::kColor},
    {"normal", "XYZ", AovSum::kMeanOfHits, "of the triangle, towards the camera, world space",
     ReadNormal},
    {"shading-normal", "XYZ", AovSum::kMeanOfHits,
     "interpolated from the vertices, bent by maps, world space", ReadShadingNormal},
    {"depth", "Z", AovSum::kMeanOfHits,
     "along the camera's axis (spherical cameras, fisheye: along the ray); 1e10: nothing hit",
     ReadDepth, AovRange::kWorld, kFarAway},
    {"distance", "Z", AovSum::kMeanOfHits, "along the ray; 1e10: nothing hit", ReadDistance,
     AovRange::kWorld, kFarAway},
    {"camera-normal", "XYZ", AovSum::kMeanOfHits,
     "the shading normal; x right, y up, z towards the camera", ReadCameraNormal},
    {"position", "XYZ", AovSum::kMeanOfHits, "world space", ReadPosition, AovRange::kWorld},
    {"uv", "UVA", AovSum::kNearestHit, "texture coordinates; A: 1 where something was hit", ReadUv},
    {"object-id", "V", AovSum::kNearestHit, "number of the mesh in the scene from 1 on; 0: none",
     ReadObjectId},
    {"material-id", "V", AovSum::kNearestHit, "number of the material from 1 on; 0: none",
     ReadMaterialId},
    {"coverage", "V", AovSum::kCoverage, "share of the samples that hit something"},
    {"samples", "V", AovSum::kSampleCount, "number of samples"},
    {"variance", "RGB", AovSum::kVariance, "of one sample of the beauty"},
    {"half", "RGBN", AovSum::kHalf, "the beauty of half of the samples; N: their number"},
    {"half-variance", "RGB", AovSum::kHalfVariance, "of one sample of that half"},
    {"direct", "RGB", AovSum::kDirect, "light that met at most one surface"},
    {"indirect", "RGB", AovSum::kIndirect, "the rest of the beauty"},
    {"lights", "RGB", AovSum::kLightGroups, "the beauty by lights: a layer lights-NAME a group"},
    {.name = "alpha",
     .channels = "A",
     .sum = AovSum::kAlpha,
     .help = "share of what is behind the scene that it hides, by itself and by its shadows",
     .of_composites = true},
    {.name = "shadow",
     .channels = "RGB",
     .sum = AovSum::kShadow,
     .help = "of catchers: their light with the objects over that without; 1 elsewhere",
     .of_composites = true},
    {.name = "difference",
     .channels = "RGB",
     .sum = AovSum::kDifference,
     .help = "of catchers: their light with the objects less that without",
     .of_composites = true},
    {.name = "foreground",
     .channels = "RGB",
     .sum = AovSum::kForeground,
     .help = "the beauty to put over a photograph by alpha",
     .of_composites = true},
    {.name = "backdrop",
     .channels = "RGB",
     .sum = AovSum::kBackdrop,
     .help = "what is behind the picture: the map on the ground and on the dome",
     .of_composites = true},
    OfPart("objects", "RGBA", AovSum::kPart, LightPart::kObjects,
           "light of objects; A: share of the pixel where they are seen"),
    OfPart("objects-variance", "RGB", AovSum::kVariance, LightPart::kObjects,
           "of one sample of objects"),
    OfPart("objects-half", "RGB", AovSum::kHalf, LightPart::kObjects,
           "objects in half of the samples"),
    OfPart("objects-half-variance", "RGB", AovSum::kHalfVariance, LightPart::kObjects,
           "of one sample of that half"),
    OfPart("clean", "RGBA", AovSum::kPart, LightPart::kClean,
           "light of catchers without the objects; A: share of the pixel where they are seen"),
    OfPart("clean-variance", "RGB", AovSum::kVariance, LightPart::kClean, "of one sample of clean"),
    OfPart("clean-half", "RGB", AovSum::kHalf, LightPart::kClean, "clean of half of the samples"),
    OfPart("clean-half-variance", "RGB", AovSum::kHalfVariance, LightPart::kClean,
           "of one sample of that half"),
    OfPart("difference-variance", "RGB", AovSum::kVariance, LightPart::kChange,
           "of one sample of the difference"),
    OfPart("difference-half", "RGB", AovSum::kHalf, LightPart::kChange,
           "the difference of half of the samples"),
    OfPart("difference-half-variance", "RGB", AovSum::kHalfVariance, LightPart::kChange,
           "of one sample of that half"),
    {.name = "crypto-object",
     .channels = "RGBA",
     .sum = AovSum::kMatte,
     .help = "Cryptomatte of the meshes, by name",
     .matte = MatteOf::kObjects},
    {.name = "crypto-material",
     .channels = "RGBA",
     .sum = AovSum::kMatte,
     .help = "Cryptomatte of the materials, by name",
     .matte = MatteOf::kMaterials},
    {.name = "flow",
     .channels = "XYA",
     .sum = AovSum::kNearestHit,
     .help = "to where the next --frame has what is seen [pixels, y down]; A: 1 where known",
     .read = ReadFlow<&FrameMotion::next>,
     .of_motion = true},
    {.name = "flow-back",
     .channels = "XYA",
     .sum = AovSum::kNearestHit,
     .help = "the same, to where the previous frame has it",
     .read = ReadFlow<&FrameMotion::previous>,
     .of_motion = true},
    {.name = "hidden-id",
     .channels = "1234567",
     .sum = AovSum::kNearestHit,
     .help = "numbers of the next meshes behind that of object-id, nearest first; 0: no more",
     .read = ReadHiddenId,
     .traces = true},
};
static_assert(std::size(kAovs) <= 8 * sizeof(AovSet));

// Returns the lines for which holds(line) is true.
template <class Predicate>
AovSet Those(const Predicate& holds) {
  AovSet aovs = 0;
  for (std::size_t i = 0; i < std::size(kAovs); ++i) aovs |= AovSet{holds(kAovs[i])} << i;
  return aovs;
}

// Layers that belong together have a name too.
constexpr std::string_view kDenoiser =
    "albedo,shading-normal,depth,coverage,samples,variance,half,half-variance";

std::optional<AovSet> ParseOne(std::string_view name) {
  if (name == "all") return AllAovs();
  if (name == "denoiser") return ParseAovs(kDenoiser);
  for (std::size_t i = 0; i < std::size(kAovs); ++i) {
    if (kAovs[i].name == name) return AovSet{1} << i;
  }
  return std::nullopt;
}

}  // namespace

std::span<const Aov> Aovs() { return kAovs; }

AovSet AllAovs() {
  return Those([](const Aov& aov) {
    return !aov.of_composites && !aov.of_motion && !aov.traces && aov.sum != AovSum::kMatte;
  });
}

AovSet AovsOf(AovSum sum) {
  return Those([&](const Aov& aov) { return aov.sum == sum && !aov.part; });
}

AovSet CatcherAovs() {
  return Those([](const Aov& aov) {
    return aov.of_composites && aov.sum != AovSum::kBackdrop && !aov.part;
  });
}

AovSet PartAovs() {
  return Those([](const Aov& aov) { return aov.part.has_value(); });
}

std::optional<AovSet> ParseAovs(std::string_view names) {
  AovSet aovs = 0;
  for (std::size_t begin = 0; begin <= names.size();) {
    const std::size_t end = std::min(names.find(',', begin), names.size());
    const std::optional<AovSet> one = ParseOne(names.substr(begin, end - begin));
    if (!one) return std::nullopt;
    aovs |= *one;
    begin = end + 1;
  }
  return aovs;
}

std::string ToString(AovSet aovs) {
  std::string text;
  for (std::size_t i = 0; i < std::size(kAovs); ++i) {
    if ((aovs >> i & 1) == 0) continue;
    text += (text.empty() ? "" : ",") + std::string(kAovs[i].name);
  }
  return text;
}

std::string LayerName(const Aov& aov, std::string_view group) {
  std::string name(aov.name);
  if (aov.sum == AovSum::kLightGroups) return name + "-" + std::string(group);
  if (aov.sum != AovSum::kMatte) return name;
  // Programs that read mattes know no hyphens.
  std::replace(name.begin(), name.end(), '-', '_');
  return name + std::string(group);
}

std::size_t ChannelCount(AovSet aovs, std::size_t light_groups) {
  std::size_t channels = 0;
  ForEachChannel(aovs, light_groups, [&](const Aov&, std::size_t, std::size_t) { ++channels; });
  return channels;
}

bool Sums(AovSet aovs, AovSum sum) { return (aovs & AovsOf(sum)) != 0; }

bool NeedsMotion(AovSet aovs) {
  return (aovs & Those([](const Aov& aov) { return aov.of_motion; })) != 0;
}

bool NeedsUvs(AovSet aovs) {
  return (aovs & Those([](const Aov& aov) { return aov.read == ReadUv; })) != 0;
}

bool ReadsHits(AovSet aovs) {
  const AovSet of_hits = Those([](const Aov& aov) {
    return aov.read != nullptr || aov.sum == AovSum::kCoverage || aov.sum == AovSum::kMatte ||
           aov.of_composites;
  });
  return (aovs & of_hits) != 0;
}

}  // namespace skywave
